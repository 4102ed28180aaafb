"""Every second of the test line's runs: single faults of every kind, every drill, every tenth of each departure."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import pytest

from scenario.scenario import Scenario, load_scenario
from simulation.faults.devices import PowerCut, Restart
from simulation.faults.script import ActKind, ScriptedFault, Trigger
from simulation.setup import STEPS_PER_S
from study.drilling.drill import find_drill, run_drill, shipped_drills
from study.drilling.every_instant import InstantWindow, Variation
from study.drilling.moving import single_faults, staffed, what_is_moved
from study.runner.run import PartyLink
from tests.scenario.own import own_scenario
from tests.system.conftest import SWITCHES
from wayside.said import Leaving

Sweeps = Callable[[Scenario, Sequence[Variation], InstantWindow], list[str]]

pytestmark = [pytest.mark.nightly, pytest.mark.timeout(6 * 3600)]

WORDS: Final = frozenset({ActKind.CONFIRM_OUTSIDE, ActKind.CONFIRM_HOLDING, ActKind.ENTER_SECTION})


def _is_movable(name: str, scenario: Scenario) -> bool:
    """Whether something fails in a drill, and nobody says, or must say, what is true at its own time alone.

    Where manager and units fail together (row 14), persons must say what a unit holds that stands before no tag. A
    vehicle that stalls close before a train (row 109) is struck.
    """
    script = scenario.setup.script
    words = WORDS.isdisjoint(act.kind for act in script.acts)
    return bool(script.faults) and words and not name.startswith(("rtri/14", "rtri/109"))


@pytest.fixture
def two_trains(tmp_path: Path) -> Scenario:
    return own_scenario(tmp_path, 'timetable = "rtri_two_trains"\n', "rtri_test_line")


def test_single_faults_of_every_kind_at_every_second(two_trains: Scenario, bad_in: Sweeps) -> None:
    scenario = staffed(two_trains)
    assert bad_in(scenario, single_faults(scenario.setup), InstantWindow(1.0)) == []


@pytest.mark.parametrize("name", [name for name in shipped_drills() if name.startswith("rtri/")])
def test_every_drill_at_every_second(name: str, bad_in: Sweeps) -> None:
    scenario = load_scenario(find_drill(name))
    if not _is_movable(name, scenario):
        pytest.skip("nothing fails in it, or somebody says what is true at its own time alone")
    assert bad_in(scenario, (what_is_moved(scenario).variation,), InstantWindow(1.0)) == []


def test_a_vehicle_that_stalls_is_struck_inside_braking_distance_alone(bad_in: Sweeps) -> None:
    """At 10:00:47 the front is 37 m before the vehicle at 7.2 m/s, and takes 34 m: 1 s until the brake is commanded,
    0.9 s until it acts, then 20 m. A second later it has 30 m. From 10:00:59 on its rear is beyond.
    """
    scenario = load_scenario(find_drill("rtri/109_crossing_obstacle"))
    bad = bad_in(scenario, (what_is_moved(scenario).variation,), InstantWindow(1.0))
    assert [int(found.split("1 at 10:00:")[1][:2]) for found in bad] == list(range(48, 59))


@pytest.mark.parametrize("departure_s", [36_000.0, 36_300.0, 36_420.0])
def test_a_unit_without_power_at_every_tenth_of_a_departure(
    two_trains: Scenario, departure_s: float, bad_in: Sweeps
) -> None:
    """Restarts, and power off for half a second, 2 s and 30 s, from the order to 3 s after it."""
    failures = [
        failure
        for unit in ("K1", "K2")
        for failure in (
            ScriptedFault(Restart(target=unit), Trigger()),
            *(ScriptedFault(PowerCut(target=unit), Trigger(), duration_s) for duration_s in (0.5, 2.0, 30.0)),
        )
    ]
    variations = tuple(
        Variation(
            f"{f.fault.kind} {f.fault.target} {f.duration_s}", ((0, f),), (), frozenset({f.fault.target})
        )
        for f in failures
    )
    window = InstantWindow(1.0 / STEPS_PER_S, departure_s, departure_s + 3.0)
    assert bad_in(two_trains, variations, window) == []


@pytest.mark.parametrize("frees", [False, True])
def test_a_unit_without_power_at_every_tenth_round_its_sign_off_in_a_portal(
    frees: bool, bad_in: Sweeps, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Drill 58b at 31 instants: its portal is leaving until it says or is seen to have gone."""
    if frees:
        SWITCHES["frees_a_portal_at_the_sign_off"](monkeypatch)
    scenario = staffed(load_scenario(find_drill("rtri/58b_portal_unit_power")))
    moved = what_is_moved(scenario).variation
    events = run_drill("rtri/58b_portal_unit_power", PartyLink.SIMULATED).run.result.journal.entries
    leaves_s = next(e.t_s for e in events if isinstance(e.event, Leaving))
    window = InstantWindow(1.0 / STEPS_PER_S, leaves_s - 1.5, leaves_s + 1.5)
    assert (len(bad_in(scenario, (moved,), window)) > 0) is frees
