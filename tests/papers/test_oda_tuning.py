import math

import numpy as np
import pytest

from onboard.driving.tuning import OFFSET_STEP_MPS2, Learned
from papers import oda_tuning
from papers.oda_tuning import (
    FULL_SHARE,
    PATTERN_MPS2,
    RUNS,
    WET_BRAKE,
    WET_SHARE,
    HiddenBrake,
    TunedBy,
    TunedTrain,
    a_stop,
    by_the_mean,
    hidden_train,
    interval_reaches,
    is_full,
    is_right,
    reproduce,
    stop_rows,
    tune,
    untuned,
)
from papers.reproduction import Options, Reproduction
from papers.table4_stops import oda_train
from radio.chance import generator


@pytest.fixture(scope="module")
def result() -> Reproduction:
    return reproduce(Options(seed=5, quick=True))


@pytest.mark.nightly
def test_every_criterion_holds_on_a_small_fleet(result: Reproduction) -> None:
    assert result.passed, [row for row in result.rows if not row.passed]
    assert "short slice" in result.remarks[-1]


@pytest.mark.nightly
def test_the_same_seed_gives_the_same_figures(result: Reproduction) -> None:
    assert reproduce(Options(seed=5, quick=True)).as_dict() == result.as_dict()


def test_the_hidden_offset_is_that_at_the_patterns_deceleration() -> None:
    hidden = HiddenBrake(1.0, 0.2, 0.1)
    assert (PATTERN_MPS2 - 0.1) * hidden.brake_factor == pytest.approx(PATTERN_MPS2)


def test_the_delay_of_a_lag_in_steps_is_the_area_over_its_response() -> None:
    lag_s, step_s = 0.25, 0.1
    area_s = sum(step_s * math.exp(-k * step_s / lag_s) for k in range(1, 200))
    assert HiddenBrake(0.8, lag_s, 0.0).delay_s == pytest.approx(0.8 + area_s)


def test_a_train_that_learns_from_no_stop_is_never_right(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(oda_tuning, "learned_after_stop", lambda learned, *_: learned)
    assert tune(oda_train(), 3, "train 1").settled_after > RUNS


def test_a_train_learns_for_itself_and_stops_better_on_days_that_it_has_not_seen() -> None:
    tuned = tune(oda_train(), 3, "train 1")
    assert is_right(tuned.by_approximation, tuned.hidden)
    assert tuned.by_approximation.stops + tuned.by_approximation.left_out == RUNS
    before, after = (
        np.abs(tuned.held_out_m[tuning][tuned.ordinary]).mean() for tuning in (TunedBy.NONE, TunedBy.MODE)
    )
    assert after < before
    assert tuned.hidden != tune(oda_train(), 3, "train 2").hidden


@pytest.mark.parametrize(("delivered_m", "fails"), [(0.4, True), (0.3, False)])
def test_the_null_method_fails_by_its_stops_and_not_because_it_is_held_against_itself(
    delivered_m: float, fails: bool
) -> None:
    errors_m = {tuning: np.full(RUNS, 0.1) for tuning in TunedBy} | {TunedBy.NONE: np.full(RUNS, delivered_m)}
    new = Learned("A", 1.0)
    train = TunedTrain(HiddenBrake(1.0, 0.1, 0.0), new, {}, errors_m, np.ones(RUNS, dtype=bool), 0, 0)
    (row,) = reproduce.null.rows(stop_rows([untuned(train)]))
    assert row.passed is fails


def test_held_out_stops_are_others_than_those_learned_from() -> None:
    hidden = hidden_train(generator(3, "oda-tuning", "train 1", "hidden"))
    days = [
        a_stop(generator(3, "oda-tuning", "train 1", day), hidden)["speed_mps"][0]
        for day in ("stops", "held out")
    ]
    assert days[0] != days[1]


def test_the_days_are_disturbed_enough_to_tell_mode_and_mean_apart() -> None:
    rng = generator(1, "test", "days")
    stops = np.concatenate([a_stop(rng, HiddenBrake(1.0, 0.1, 0.0)) for _ in range(2000)])
    wet = stops["adhesion_factor"] < 1.0
    assert is_full(stops).mean() == pytest.approx(FULL_SHARE, abs=0.04)
    assert wet.mean() == pytest.approx(WET_SHARE, abs=0.04)
    # the mean of what counts is off by the wet stops' share of their weaker brake: nearly a step of the grid
    assert WET_SHARE * (1.0 - WET_BRAKE) * PATTERN_MPS2 > 0.8 * OFFSET_STEP_MPS2
    dry = stops["brake_factor"][~wet & ~is_full(stops)]
    assert dry.mean() == pytest.approx(1.0, abs=0.005)


def test_the_mean_of_what_was_learned() -> None:
    counts = tuple({8: 3, 20: 1}.get(index, 0) for index in range(21))
    learned = Learned("A", 1.0, counts, counts)
    assert learned.dead_time_s == pytest.approx(0.8)
    assert by_the_mean(learned).dead_time_s == pytest.approx(1.1)  # (3 * 8 + 20) / 4
    assert by_the_mean(learned).stops == learned.stops
    assert by_the_mean(Learned("A", 1.0)) == Learned("A", 1.0)


def test_counts_of_trains_are_judged_by_their_interval() -> None:
    """Of 100 trains 90 may be 95 % (interval to 0.951), 89 not; all of 12 may."""
    assert interval_reaches(90, 100)
    assert not interval_reaches(89, 100)
    assert interval_reaches(12, 12)


def test_right_means_within_one_step_of_the_grid() -> None:
    hidden = HiddenBrake(1.0, 0.01, 2.0 * OFFSET_STEP_MPS2)
    counts = tuple(int(index == 11) for index in range(21))
    assert is_right(Learned("A", 1.0, counts, counts), hidden)
    far = tuple(int(index == 14) for index in range(21))
    assert not is_right(Learned("A", 1.0, counts, far), hidden)
    assert not is_right(Learned("A", 1.0, far, counts), hidden)
    assert not is_right(Learned("A", 1.0), hidden)
