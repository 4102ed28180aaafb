from __future__ import annotations

import math

import numpy as np
import pytest

from onboard.driving.tuning import OFFSET_STEP_MPS2, Learned
from study.papers.oda_tuning import PATTERN_MPS2, RUNS, Hidden, is_right, reproduce, tune
from study.papers.reproduction import Options, Reproduction, reproduction
from study.papers.table4_stops import oda_train


@pytest.fixture(scope="module")
def result() -> Reproduction:
    return reproduce(Options(seed=5, quick=True))


def test_every_criterion_holds_on_a_small_fleet(result: Reproduction) -> None:
    assert result.passed, [row for row in result.rows if not row.passed]
    assert "short slice" in result.remarks[-1]
    assert reproduction("oda-tuning") is reproduce


def test_the_same_seed_gives_the_same_figures(result: Reproduction) -> None:
    assert reproduce(Options(seed=5, quick=True)).as_dict() == result.as_dict()


def test_the_hidden_offset_is_that_at_the_patterns_deceleration() -> None:
    hidden = Hidden(1.0, 0.2, 0.1)
    assert (PATTERN_MPS2 - 0.1) * hidden.brake_factor == pytest.approx(PATTERN_MPS2)


def test_the_delay_of_a_lag_in_steps_is_the_area_over_its_response() -> None:
    lag_s, step_s = 0.25, 0.1
    area_s = sum(step_s * math.exp(-k * step_s / lag_s) for k in range(1, 200))
    assert Hidden(0.8, lag_s, 0.0).delay_s == pytest.approx(0.8 + area_s)


def test_a_train_learns_for_itself_and_stops_better_for_it() -> None:
    tuned = tune(oda_train(), 3, "train 1")
    assert is_right(tuned.by_approximation, tuned.hidden)
    assert tuned.by_approximation.stops + tuned.by_approximation.left_out == RUNS
    kept = ~tuned.slid
    assert np.abs(tuned.after_m[kept]).mean() < np.abs(tuned.before_m[kept]).mean()
    assert tuned.hidden != tune(oda_train(), 3, "train 2").hidden


def test_right_means_within_one_step_of_the_grid() -> None:
    hidden = Hidden(1.0, 0.01, 2.0 * OFFSET_STEP_MPS2)
    counts = tuple(int(index == 11) for index in range(21))
    assert is_right(Learned("A", 1.0, counts, counts), hidden)
    far = tuple(int(index == 14) for index in range(21))
    assert not is_right(Learned("A", 1.0, counts, far), hidden)
    assert not is_right(Learned("A", 1.0, far, counts), hidden)
    assert not is_right(Learned("A", 1.0), hidden)
