"""What is drawn: the same for the same seed, of every kind there is, within every bound, and always over in time."""

from collections import Counter
from pathlib import Path
from typing import Any, Final

import pytest
from pydantic import Field

from network.timetable import seconds_of
from scenario.scenario import load_scenario
from simulation.faults.chargers import ChargerDead
from simulation.faults.lidar import MarkerMissing
from simulation.faults.points import PointsFault
from simulation.faults.script import ScriptedFault
from simulation.faults.table import FAULTS, KINDS
from tests.nightly import others_nightly
from tests.system.chaos.case import Case
from tests.system.chaos.draw import Draw
from tests.system.chaos.families import LINES, TIMETABLES, Family, ground_of
from tests.system.chaos.fault_fields import RANGES, bounds_of, fields_of
from tests.system.chaos.generator import BEFORE_S, DURATION_S, FAULTS_MAX, WINDOW_S, case_of
from tests.system.chaos.run_one import Verdict, outcome_of, undisturbed
from tests.system.chaos.wide import WIDE

# Of a third of its timetables, each of which runs once undisturbed; all of them run by night.
SEEDS: Final = [seed for seed in range(450) if seed % TIMETABLES < TIMETABLES // 3]


@pytest.fixture(scope="module")
def cases(nets: Path) -> list[Case]:
    """Cases of the test line."""
    return [case_of(Family.TEST_LINE, seed, nets) for seed in SEEDS]


def test_a_case_follows_from_its_seed(nets: Path, cases: list[Case]) -> None:
    assert case_of(Family.TEST_LINE, 7, nets) == cases[7]
    assert len({case.text for case in cases}) == len(cases)


def test_every_kind_and_every_number_of_faults_is_drawn(cases: list[Case]) -> None:
    drawn = Counter(str(fault["kind"]) for case in cases for fault in case.faults)
    # The test line has no charger, no markers and no level crossing.
    nothing_there = {ChargerDead.kind, MarkerMissing.kind} | {
        kind.kind for kind in KINDS if kind.aims_at == "level crossing"
    }
    assert set(drawn) == {kind.kind for kind in KINDS} - nothing_there
    assert {len(case.faults) for case in cases} == set(range(1, FAULTS_MAX + 1))


def test_what_lasts_is_over(cases: list[Case]) -> None:
    for fault in (fault for case in cases for fault in case.faults):
        momentary = FAULTS[str(fault["kind"])].momentary
        assert ("duration_s" in fault) is not momentary
        assert momentary or DURATION_S[0] <= float(fault["duration_s"]) <= DURATION_S[1]


def test_faults_begin_within_six_minutes_in_which_trains_move(nets: Path, cases: list[Case]) -> None:
    for case in cases:
        _, course = undisturbed(case.ground, nets)
        at_s = dict(map(reversed, course.events))  # type: ignore[arg-type]
        starts = [str(fault["start"]) for fault in case.faults]
        begins_s = [at_s[s] if s in at_s else seconds_of("", "", s.partition(".")[0], None) for s in starts]
        assert max(begins_s) - min(begins_s) <= WINDOW_S + 1.0
        assert course.moving_s[0] - BEFORE_S <= min(begins_s) <= max(begins_s) <= course.moving_s[-1]
        from_s, to_s = max(begins_s) - WINDOW_S, min(begins_s) + WINDOW_S
        assert any(from_s <= moving_s <= to_s for moving_s in course.moving_s)


def test_the_program_reads_what_is_drawn(tmp_path: Path, cases: list[Case]) -> None:
    """As a drill: kinds, targets, fields and words are those of files."""
    for case in cases[:40]:
        script = load_scenario(str(case.write(tmp_path / case.name))).setup.script
        assert [f.fault.kind for f in script.faults] == [fault["kind"] for fault in case.faults]
        assert all(isinstance(f, ScriptedFault) for f in script.faults)


@pytest.mark.parametrize(("kind", "name"), RANGES, ids=["-".join(key) for key in RANGES])
def test_a_range_lies_within_its_schema(kind: str, name: str) -> None:
    low, high = bounds_of(FAULTS[kind], name)
    least, greatest, why = RANGES[kind, name]
    assert low <= least < greatest <= high
    assert why


def test_a_kind_of_tomorrow_is_drawn_from_its_schema() -> None:
    class Sluggish(PointsFault):
        kind = "sluggish"
        share: float = Field(ge=0.25, le=0.5)
        times: int = Field(ge=2, le=3)
        noisy: bool = False

    from simulation.faults.fault import Names

    drawn: list[dict[str, Any]] = [fields_of(Sluggish, Names(), Draw(seed, ("x",))) for seed in range(50)]
    assert {d["times"] for d in drawn} == {2, 3}
    assert {d["noisy"] for d in drawn} == {True, False}
    assert all(0.25 <= d["share"] <= 0.5 for d in drawn)
    assert max(d["share"] for d in drawn) - min(d["share"] for d in drawn) > 0.15


GROUNDS: Final = (
    *((Family.TEST_LINE, number) for number in range(TIMETABLES)),
    (Family.HOUR, 0),
    *((Family.LINES, number) for number in range(0, 2 * LINES, 3)),
    *((Family.WIDE, number) for number in range(WIDE)),
)


@pytest.mark.parametrize(
    "ground", others_nightly(GROUNDS, GROUNDS[::24]), ids=lambda one: f"{one[0].value}-{one[1]}"
)
def test_a_ground_runs_when_nothing_fails(ground: tuple[Family, int], nets: Path) -> None:
    """Else a case would say nothing of its faults."""
    _, course = undisturbed(ground_of(*ground), nets)
    assert len(course.moving_s) > 100
    assert len(course.events) > 15


SHORT: Final = {"limits": {"time_limit_s": 600.0}}


def test_a_train_that_waits_outside_for_ever_is_no_success(nets: Path) -> None:
    """Its place is no section."""
    off = {"kind": "power_off", "target": "block-manager", "start": "09:59:00"}
    outcome = outcome_of(Case("waits_outside", ground_of(Family.TEST_LINE, 0), SHORT, (off,)), nets)
    assert outcome.verdict is Verdict.NOT_ARRIVED
    assert "(outside, last " in outcome.kind


def test_a_train_that_never_heals_is_no_success(nets: Path) -> None:
    """The judgement can fail: without its duration a fault of power leaves a train where it is."""
    ground = ground_of(Family.TEST_LINE, 0)
    off = {"kind": "power_off", "target": "K1", "start": "10:00:20"}
    outcome = outcome_of(Case("never_heals", ground, SHORT, (off,)), nets)
    assert outcome.verdict is Verdict.NOT_ARRIVED
    assert any("K1" in detail for detail in outcome.details)
