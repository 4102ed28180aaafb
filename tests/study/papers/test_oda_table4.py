from __future__ import annotations

import numpy as np
import pytest

from onboard.driving.tasc import Verdict
from study.papers.oda_table4 import (
    CASES,
    Case,
    best_gain_per_s,
    controller,
    impossible_stops,
    passes,
    reproduce,
    stop_of,
)
from study.papers.reproduction import Options, Reproduction, reproduction
from study.papers.single_stop import Rows

GAIN_PER_S = 0.6


@pytest.fixture(scope="module")
def result() -> Reproduction:
    return reproduce(Options())


def test_there_are_22_runs_with_the_papers_figures() -> None:
    assert len(CASES) == 22
    assert [case.paper_m for case in CASES if case.paper_m > 1.0] == [6.11, 3.41]
    assert len({case.name for case in CASES}) == 22


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_cell_has_the_papers_verdict(case: Case) -> None:
    outcome, _ = controller(GAIN_PER_S).one(stop_of(case))
    if case.paper_m > 1.0:
        assert outcome.error_m > 1.0
        assert abs(outcome.error_m - case.paper_m) <= 0.4 * case.paper_m
        assert outcome.verdict is Verdict.BRAKE_TOO_WEAK
    else:
        assert abs(outcome.error_m) <= 0.25
        assert outcome.verdict is Verdict.POSSIBLE


@pytest.mark.parametrize(("name", "expected", "stop"), impossible_stops(), ids=lambda value: str(value)[:20])
def test_impossible_stops_are_told_and_stay_within_the_limit(
    name: str, expected: Verdict, stop: Rows
) -> None:
    outcome, _ = controller(GAIN_PER_S).one(stop)
    assert outcome.verdict is expected
    assert outcome.within_limit


def test_the_gain_comes_from_stops_without_position_error() -> None:
    assert best_gain_per_s() == GAIN_PER_S


def test_a_cell_passes_only_with_the_papers_verdict() -> None:
    good, bad = Case(2, True, 20.0, 0.19), Case(1, False, 20.0, 6.11)
    assert passes(good, -0.25)
    assert not passes(good, 0.26)
    assert passes(bad, 3.7)
    assert not passes(bad, 3.6)
    assert not passes(bad, 0.2)


def test_everything_passes_and_names_its_origins(result: Reproduction) -> None:
    assert result.passed, [row for row in result.rows if not row.passed]
    assert len(result.rows) == 22 + 1 + 3
    assert all(parameter.origin for parameter in result.parameters)
    assert any("opposite sign the verdicts are the same" in remark for remark in result.remarks)
    assert reproduction("oda-table4") is reproduce


def test_the_bounds_hold_the_truth_and_no_fix_is_refused() -> None:
    outcomes, _ = controller(GAIN_PER_S).run(np.concatenate([stop_of(case) for case in CASES]))
    assert (outcomes["out_of_bounds_m"] <= 0.0).all()
    assert (outcomes["refused"] == 0).all()
