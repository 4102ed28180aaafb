"""A day of a sweep is the day of `branchline run`, whatever ran in its process before."""

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any, Final

import numpy as np
import pytest

from network.errors import InputError
from scenario.scenario import Scenario, load_scenario, shipped_scenarios, with_seed
from simulation.carriers.plain_track import PlainTrack
from simulation.carriers.sumo import SumoCarrier
from simulation.events import Danger, Left, Unsafe
from simulation.journal import Journal
from simulation.judge.checkers import Checker, Violation
from simulation.result import Ending, RunResult, Waiting
from simulation.setup import Setup
from study.drilling.drill import find_drill
from study.runner.run import CarrierKind, PartyLink, execute
from study.sweep.day import ProcessCache, outcome_of_day, run_day, scenario_of
from study.sweep.records import DayOutcome, DaySpec

SCENARIO: Final = "rtri_test_line"
SUMO, PLAIN = CarrierKind.SUMO.value, CarrierKind.PLAIN.value


def spec(seed: int, carrier: str = PLAIN, scenario: str = SCENARIO) -> DaySpec:
    return DaySpec(scenario, "", (), seed, carrier)


@pytest.fixture
def warm() -> Iterator[ProcessCache]:
    with ProcessCache() as kept:
        yield kept


@pytest.fixture(scope="module")
def result() -> RunResult:
    return execute(load_scenario(SCENARIO), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN).result


@pytest.mark.parametrize("carrier", [SUMO, PLAIN])
def test_a_day_is_the_run_of_its_seed_whatever_ran_before(warm: ProcessCache, carrier: str) -> None:
    for seed in (1, 7, 1):
        run = execute(load_scenario(SCENARIO, seed), PartyLink.SIMULATED)
        record = run_day(spec(seed, carrier), 3, warm)
        assert (record.digest, record.motion_digest) == (run.summary["digest"], run.summary["motion_digest"])
        assert (record.outcome, record.why, record.index) == (DayOutcome.GOOD, "", 3)
        assert record.figures is not None
        assert record.figures.arrived_trains == run.summary["trains_arrived"]


def test_a_day_on_sumo_carries_the_roads_of_its_crossings(warm: ProcessCache) -> None:
    """In the drill a vehicle stalls on one; on plain track, which this process has run before, none does."""
    drill = str(find_drill("rtri/109_crossing_obstacle"))
    plain, sumo = (run_day(spec(1, carrier, drill), 0, warm) for carrier in (PLAIN, SUMO))
    run = execute(load_scenario(drill, 1), PartyLink.SIMULATED)
    assert sumo.digest == run.summary["digest"] != plain.digest


def test_a_scenario_is_loaded_once_and_its_net_read_once() -> None:
    loaded: list[DaySpec] = []

    def of(wanted: DaySpec) -> Scenario:
        loaded.append(wanted)
        return scenario_of(wanted)

    with ProcessCache(of) as kept:
        records = [run_day(spec(seed), 0, kept) for seed in (1, 2)]
        assert (
            kept.net(kept.scenario(spec(3)).setup.line)[1] is kept.net(kept.scenario(spec(4)).setup.line)[1]
        )
    assert len(loaded) == 1
    assert records[0].digest != records[1].digest


def same(one: Any, other: Any) -> bool:  # noqa: ANN401
    if isinstance(one, np.ndarray):
        return bool(np.array_equal(one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if hasattr(one, "__dataclass_fields__"):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    return bool(one == other)


@pytest.mark.parametrize("name", shipped_scenarios())
def test_another_seed_is_loaded_as_if_from_the_files(name: str) -> None:
    """What would be drawn as a scenario is read could not be left as it is when only the seed changes."""
    fresh, changed = load_scenario(name, 7), with_seed(load_scenario(name), 7)
    assert changed.inputs.as_json() == fresh.inputs.as_json()
    for f in fields(Setup):
        assert same(getattr(changed.setup, f.name), getattr(fresh.setup, f.name)), f.name
    assert replace(changed, setup=fresh.setup, inputs=fresh.inputs) == fresh


def test_a_seed_that_is_none_is_bad_input() -> None:
    with pytest.raises(InputError):
        with_seed(load_scenario(SCENARIO), -1)


@pytest.mark.parametrize(("carrier", "kind"), [(SUMO, SumoCarrier), (PLAIN, PlainTrack)])
def test_a_bug_is_a_crashed_day_and_the_next_day_is_good(
    warm: ProcessCache, carrier: str, kind: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(kind, "truth", lambda *_: {}["nowhere"])
        record = run_day(spec(5, carrier), 0, warm)
    assert record.outcome is DayOutcome.CRASHED
    assert record.figures is None
    assert "KeyError: 'nowhere'" in record.why
    assert f"branchline run {SCENARIO} --seed 5 --carrier {carrier}" in record.why
    assert run_day(spec(5, carrier), 0, warm).outcome is DayOutcome.GOOD


def test_a_bug_before_the_first_step_leaves_no_sumo_behind(
    warm: ProcessCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    """libsumo is one a process: what was begun must be ended."""
    with monkeypatch.context() as patch:
        patch.setattr("simulation.loop.checkers_of", lambda *_: {}["nothing"])
        assert run_day(spec(1, SUMO), 0, warm).outcome is DayOutcome.CRASHED
    assert run_day(spec(1, SUMO), 0, warm).outcome is DayOutcome.GOOD


def test_what_the_machine_lacks_and_bad_input_are_raised(
    warm: ProcessCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError):
        run_day(spec(1, scenario="nowhere"), 0, warm)
    with pytest.raises(InputError, match="point"):
        run_day(DaySpec(SCENARIO, "", (("air.loss", 0.1),), 1, PLAIN), 0, warm)

    def full(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(PlainTrack, "truth", full)
    with pytest.raises(MemoryError):
        run_day(spec(1), 0, warm)


WAITS = Waiting("V1", "1M", "track 3", "route 3>4")
DEAD = Violation(30.0, Checker.NO_DEAD_STATE.value, "V1 stands in 3 and waits for nothing")
UNSAFE = Violation(60.0, Checker.ONE_TRAIN_A_SECTION.value, "V1 and V2 are in 3")


@pytest.mark.parametrize(
    ("changes", "outcome", "word"),
    [
        ({}, DayOutcome.GOOD, ""),
        ({"violations": (DEAD, UNSAFE), "ended_because": Ending.STALLED}, DayOutcome.BROKEN, "V1 and V2"),
        ({"collisions": ("collision head-on",)}, DayOutcome.BROKEN, "collision head-on"),
        ({"violations": (DEAD,)}, DayOutcome.DEADLOCK, "waits for nothing"),
        ({"ended_because": Ending.STALLED, "waiting": [WAITS]}, DayOutcome.DEADLOCK, "waits for route 3>4"),
        ({"trains_arrived": (), "waiting": [WAITS]}, DayOutcome.NOT_ARRIVED, "did not arrive"),
        ({"ended_because": Ending.TIME_LIMIT}, DayOutcome.NOT_ARRIVED, "time limit"),
    ],
)
def test_what_became_of_a_day_is_the_gravest(
    result: RunResult, changes: dict[str, Any], outcome: DayOutcome, word: str
) -> None:
    found, why = outcome_of_day(replace(result, **changes))
    assert found is outcome
    assert word in why


def test_of_the_journal_only_what_is_asked_for_stays() -> None:
    kept, whole = Journal(kept=(Unsafe,)), Journal()
    seen: list[object] = []
    kept.watch(seen.append)
    for journal in (kept, whole):
        journal.write(1.0, "world", Unsafe(unit_id="V1", danger=Danger.END_OF_TRACK))
        journal.write(2.0, "world", Left(unit_id="V1"))
    assert kept.digest() == whole.digest()
    assert [type(entry.event) for entry in kept.entries] == [Unsafe]
    assert len(seen) == len(whole.entries) == 2


@pytest.mark.nightly
@pytest.mark.parametrize("name", shipped_scenarios())
def test_plain_track_carries_every_shipped_scenario_as_sumo_does(name: str, warm: ProcessCache) -> None:
    on_sumo, on_plain = (run_day(spec(1, carrier, name), 0, warm) for carrier in (SUMO, PLAIN))
    assert on_plain.digest == on_sumo.digest
    assert on_plain.motion_digest == on_sumo.motion_digest
