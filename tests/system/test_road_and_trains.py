"""Whole runs with a road: trains know nothing of it but by obstacles and contact, and plain track has none."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import pytest

from scenario.scenario import load_scenario
from simulation.agenda import AgendaKind
from simulation.carriers.road import Road
from simulation.events import VehicleStruck
from simulation.faults.crossing_road import StalledVehicle
from simulation.faults.script import Script, ScriptedFault, Trigger
from simulation.foreseen import ForeseenStretch, Stretches
from simulation.result import Ending, RunResult
from simulation.setup import STEPS_PER_S, Setup
from simulation.world.trains import CarrierDisagrees
from study.collect.road import road_table
from study.evaluate.road_queueing import Closures, RoadByList
from study.runner.run import CarrierKind, PartyLink, execute, simulation_of
from sumo_cfg.road_net import RoadAt
from tests.simulation.carriers.roads import CROSSING, Detected, road_of

SCENARIO: Final = "rtri_test_line"
TEN_S: Final = 36_000.0  # T1's departure
ON_THE_WAY: Final = RoadAt(CROSSING, "6", 700.0, road_of(vehicles_per_h=(1200.0,)))
ROUND: Final = road_of(vehicles_per_h=(900.0,), half_barriers=True, round_share=1.0, round_after_s=2.0)
BEYOND: Final = RoadAt(CROSSING, "11", 1200.0, ROUND, has_detector=True)


@pytest.fixture(scope="module")
def setup() -> Setup:
    return load_scenario(SCENARIO).setup


@dataclass
class RoadOfRun:
    """How a run's road is made."""

    at: RoadAt
    closures: Sequence[tuple[float, float]]
    setup: Setup

    def __call__(self, folder: Path) -> Road:
        made = RoadByList(self.setup.line, [self.at], folder, seed=1, end_s=self.setup.latest_end_s)
        made.closures = Closures(self.closures)
        return made


def run_with(road: RoadOfRun, detectors: Detected | None = None) -> RunResult:
    with simulation_of(road.setup, road, detectors) as simulation:
        return simulation.run()


def digests(result: RunResult) -> tuple[str, str]:
    return result.digest, result.motion_digest


@pytest.fixture(scope="module")
def alone(setup: Setup) -> RunResult:
    """The run on SUMO without a road."""
    with simulation_of(setup) as simulation:
        return simulation.run()


def test_trains_run_as_without_a_road(setup: Setup, alone: RunResult) -> None:
    busy = run_with(RoadOfRun(ON_THE_WAY, [(TEN_S - 20.0, TEN_S + 300.0)], setup))
    assert digests(busy) == digests(alone)
    on_plain_track = execute(load_scenario(SCENARIO), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)
    assert digests(on_plain_track.result) == digests(alone)
    table = road_table(busy.road)
    assert table["crossing"].unique().to_list() == [CROSSING]
    assert table["passages"].sum() > 60
    assert table["queue"].max() >= 15  # in 129 s 21 come in each lane, on average
    # some sixty stand there for a minute on average, who have not passed
    assert table["waited_h"].sum() > 0.8
    assert on_plain_track.tables.road.is_empty()


def test_a_stalled_vehicle_is_struck_and_the_run_is_over(setup: Setup) -> None:
    """It stands there from T1's departure on; nobody tells the train."""
    fault = ScriptedFault(StalledVehicle(target=CROSSING), Trigger(at_s=TEN_S))
    with_fault = replace(setup, script=Script(faults=(fault,)))
    closed = [(TEN_S - 60.0, TEN_S + 600.0)]
    result = run_with(RoadOfRun(replace(ON_THE_WAY, road=road_of()), closed, with_fault))
    (entry,) = [each for each in result.journal.entries if isinstance(each.event, VehicleStruck)]
    assert result.ended_because is Ending.COLLISION
    assert result.violations[0].checker == "sumo-collision"
    assert isinstance(entry.event, VehicleStruck)
    before = result.trace[result.trace["step"] <= round(entry.t_s * STEPS_PER_S)][-1]
    assert 3.6 * abs(entry.event.speed_mps - float(before["speed_mps"])) < 0.5
    assert entry.event.speed_mps > 5.0


def test_on_plain_track_nothing_stalls(setup: Setup, alone: RunResult) -> None:
    fault = ScriptedFault(StalledVehicle(target=CROSSING), Trigger(at_s=TEN_S))
    scenario = load_scenario(SCENARIO)
    with_fault = replace(scenario, setup=replace(setup, script=Script(faults=(fault,))))
    result = execute(with_fault, PartyLink.SIMULATED, carrier=CarrierKind.PLAIN).result
    assert result.motion_digest == alone.motion_digest
    assert result.trains_arrived == alone.trains_arrived == ("T1",)


def noticed(setup: Setup) -> tuple[RunResult, list[int]]:
    """A run with drivers who go round barriers where no train comes, and the steps at which the detector changed."""
    detected = Detected()
    closed = [(TEN_S - 30.0, TEN_S + 70.0)]
    result = run_with(RoadOfRun(BEYOND, closed, setup), detected)
    return result, [step for _, step, _ in detected.told]


def test_a_stretch_is_cut_where_the_detector_changes(setup: Setup, alone: RunResult) -> None:
    """As if something had been due at that step when the stretch began."""
    result, steps = noticed(setup)
    while_it_runs = [step for step in steps if TEN_S + 5.0 < step / STEPS_PER_S < TEN_S + 60.0]
    assert len(while_it_runs) > 2
    with simulation_of(setup) as simulation:
        simulation.begin()
        for step in steps:
            simulation._agenda.put(step, AgendaKind.PROCEDURE, "looks")
        due = simulation.finish()
    assert digests(result) == digests(due)
    assert result.digest != alone.digest


def test_a_stretch_that_is_not_cut_parts_trains_and_carrier(
    setup: Setup, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What makes the test above hold is that the kernel runs the stretch again."""

    def whole(_stretches: Stretches, ahead: ForeseenStretch, _step: int, _end_step: int) -> ForeseenStretch:
        return ahead

    monkeypatch.setattr(Stretches, "again", whole)
    with pytest.raises(CarrierDisagrees):
        noticed(setup)
