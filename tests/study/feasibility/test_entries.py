"""Two trains that are to come in at once: how long one keeps the other out, by hand and as `headway`, `check` say."""

from pathlib import Path

import pytest

from scenario.scenario import Scenario, load_scenario
from study.capacity.headway import HeadwayKind, visits_at
from study.capacity.headway import headways_of as between
from study.capacity.legs import legs_of, places_of
from study.capacity.orders import DayOfLegs
from study.capacity.rules import Rules
from study.capacity.theory import Theory
from study.feasibility.check import feasibility
from study.feasibility.entries import Entries
from study.feasibility.finding import FindingKind
from study.feasibility.planned import planned_day

MEET = """extends = "rtri_test_line"
id = "meet"
name = "A meet at B"
timetable = "rtri_meet"
operation.portal_lead_s = 80.0
patch.line.set = { "line.overlap_m" = OVERLAP }
"""
# T1 into B, track 1: it runs at 45 km/h less the 1.2 m/s by which trains stay under a limit. It brakes at 0.6 m/s2
# for a stop 15 m before points 7, of which 0.9 s pass; its mark lies 140 m beyond where they begin.
RUNS_MPS = 45.0 / 3.6 - 1.2
BRAKES_M = RUNS_MPS**2 / (2.0 * 0.6)
BEFORE_M = 15.0 + 0.9 * RUNS_MPS + BRAKES_M
FROM_BRAKE_S = (BEFORE_M + 140.0 - BRAKES_M) / RUNS_MPS + RUNS_MPS / 0.6
# leave asked for and had, points commanded and proven, 0.1 s each; points thrown in 6 s
NEEDS_S = 4 * 0.1 + 6.0 + FROM_BRAKE_S
REPORT_S = 0.1
SOFT_END_S = 0.3**2 / (2.0 * 0.6 * 0.6)  # TASC eases to 0.3 m/s2 at 0.6 m/s3


def _meet(tmp_path: Path, overlap_m: float) -> Scenario:
    path = tmp_path / "meet.toml"
    path.write_text(MEET.replace("OVERLAP", str(overlap_m)), "utf-8")
    return load_scenario(str(path))


def test_by_hand_a_train_needs_leave_40_s_before_it_stands() -> None:
    assert pytest.approx(39.85, abs=0.005) == NEEDS_S


def test_the_least_time_between_two_arrivals_is_that_and_the_report_of_the_first(tmp_path: Path) -> None:
    setup = _meet(tmp_path, 100.0).setup
    theory = Theory(setup, Rules(late=True, throws=True, unslowed=True))
    legs = legs_of(theory.of_day(theory.journeys()), places_of(setup.line))
    visits = {visit.number: visit for visit in visits_at(legs, frozenset({"8", "9"}))}
    found = {one.kind: one for one in between(visits["T2"], visits["T1"], known=DayOfLegs(20.0))}
    assert found[HeadwayKind.COMING_IN].least_s == pytest.approx(NEEDS_S + SOFT_END_S + REPORT_S, abs=0.1)


def test_check_reckons_the_same(tmp_path: Path) -> None:
    setup = _meet(tmp_path, 100.0).setup
    train = next(train for train in planned_day(setup).all() if train.number == "T1")
    _, needs_s = Entries(setup).leads_s(train, 1)
    assert needs_s == pytest.approx(NEEDS_S, abs=0.1)


@pytest.mark.parametrize(("overlap_m", "told"), [(100.0, True), (20.0, False), (0.0, False)])
def test_check_tells_of_two_that_are_to_come_in_at_once(tmp_path: Path, overlap_m: float, told: bool) -> None:
    """The points begin 30 m beyond each mark."""
    found = feasibility(_meet(tmp_path, overlap_m).setup).findings
    (one,) = [f for f in found if f.kind is FindingKind.COMING_IN] or [None]
    assert (one is not None) is told
    if one is not None:
        assert one.short_s == pytest.approx(NEEDS_S + REPORT_S, abs=1.0)
        assert set(one.trains) == {"T1", "T2"}
