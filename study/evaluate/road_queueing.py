"""What the road at a level crossing waits in SUMO, against deterministic queueing: a crossing on the scenario's line
whose barriers move by a list of times.

Vehicles come to the stop line at their own times; each passes as it comes, or 1/s behind the one before it, or as the
closure ends: the curves of arrivals and departures of Newell (Applications of Queueing Theory, 1982, chapter 2). With
even arrivals a closure costs q r^2 / (2 (1 - q/s)) a way: q and s are the flows of arrival and of discharge, r the time
for which nobody is let in; chance, by which many or few come in two dozen closures, makes another figure of that. s,
and what is lost as a queue starts, are measured in the same net at a queue that does not end in time. All drive alike
here: slow ones before fast ones cost time without any barrier.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeVar

from host.scratch import scratch
from network.files.crossing_road import CrossingRoad
from network.model import Line
from simulation.carriers.road import Road
from simulation.carriers.road_of_run import roads_at
from simulation.carriers.road_shown import OPEN, CrossingShown, ObstacleDetectors
from simulation.carriers.sumo_road import SumoRoadCarrier
from simulation.events import BarrierState
from simulation.setup import STEP_S, STEPS_PER_S
from study.evaluate.afresh import budget_of
from study.evaluate.crossings_bench import crossed
from sumo_cfg.build import net_for
from sumo_cfg.road_net import RoadAt, RoadPart, RoadWay
from sumo_cfg.road_traffic import RoadVehicle

_Found = TypeVar("_Found")

WARNING_S, LOWERING_S, RISING_S = 5.0, 7.0, 6.0
BRAKES_MPS2: Final = 4.5  # drivers at a yellow signal brake no harder: SUMO's `decel`
SHUT_S: Final = 50.0
EVERY_S: Final = 300.0
CLOSURES: Final = 24
FLOWS_PER_H: Final = (600.0, 1200.0, 1800.0)  # both ways: of what lanes discharge a seventh to two fifths
SATURATED_PER_H: Final = 3000.0
DIFFERENCE_MAX: Final = 0.10
LOOK_STEPS: Final = 5
_FIRST, _LAST = 3, 23  # in a queue: it discharges evenly from the fourth vehicle on


@dataclass(frozen=True, slots=True)
class Closures:
    """Barriers that are to be shut in some times, s from midnight: before, lamps flash and they come down."""

    times_s: Sequence[tuple[float, float]]

    def shown(self, now_s: float) -> CrossingShown:
        """What drivers see then."""
        for shut_s, until_s in self.times_s:
            if shut_s - LOWERING_S - WARNING_S <= now_s < shut_s - LOWERING_S:
                return CrossingShown(BarrierState.RAISED, lamps=True)
            if shut_s - LOWERING_S <= now_s < shut_s:
                return CrossingShown(BarrierState.LOWERING, lamps=True)
            if shut_s <= now_s < until_s:
                return CrossingShown(BarrierState.LOWERED, lamps=True)
            if until_s <= now_s < until_s + RISING_S:
                return CrossingShown(BarrierState.RISING, lamps=False)
        return OPEN


SATURATED: Final = Closures(((120.0, 300.0),))
REPEATED: Final = Closures(
    tuple((EVERY_S * k + 100.0, EVERY_S * k + 100.0 + SHUT_S) for k in range(CLOSURES))
)


class RoadByList(Road):
    """A road whose crossings show what a list of times says, at each look; `alike`: all drive as fast as they may."""

    closures = Closures(())
    alike = False
    _all: tuple[RoadVehicle, ...] = ()

    def over(self) -> set[str]:
        """Vehicles with their front between the stop lines."""
        over = (lanes for (_, _, part), lanes in self._lanes.items() if part is RoadPart.OVER)
        there = self._sumo.lane.getLastStepVehicleIDs
        return {vehicle_id for lanes in over for lane in lanes for vehicle_id in there(lane)}

    def arrivals_s(self, way: RoadWay) -> list[float]:
        """When each vehicle of a way would be at the stop line if nothing hindered it, s."""
        come = (vehicle for vehicle in self._all if vehicle.way is way)
        return sorted(
            vehicle.depart_s + (vehicle.at.road.approach_m - vehicle.length_m) / vehicle.free_mps
            for vehicle in come
        )

    def _comers(self, begin_s: float) -> tuple[RoadVehicle, ...]:
        drawn = super()._comers(begin_s)
        self._all = tuple(replace(vehicle, speed_share=1.0) for vehicle in drawn) if self.alike else drawn
        return self._all

    def _look(self) -> None:
        for at in self.roads:
            self.show(at.crossing_id, self.closures.shown(self._step * STEP_S))
        super()._look()


@dataclass
class RoadRun:
    """A carrier with a road from midnight on, and who hears of what its detectors see."""

    road: RoadByList
    carrier: SumoRoadCarrier
    detectors: ObstacleDetectors | None = None
    steps: int = 0

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> None:
        """Run so many steps, whatever happens between."""
        done = 0
        while done < steps:
            left = [(unit_id, speeds[done:]) for unit_id, speeds in columns]
            done += self.carrier.run(left, steps - done) or steps - done
            self.road.tell(self.detectors)
        self.steps += steps

    def entries(self, end_s: float) -> list[tuple[float, str]]:
        """When each vehicle comes over its stop line until then, s, to half a second, and which."""
        found: list[tuple[float, str]] = []
        before: set[str] = set()
        while self.steps * STEP_S < end_s:
            self.run([], LOOK_STEPS)
            now = self.road.over()
            found += [(self.steps * STEP_S, vehicle_id) for vehicle_id in sorted(now - before)]
            before = now
        return found


@contextmanager
def road_run(
    line: Line,
    at: RoadAt,
    folder: Path,
    closures: Closures,
    *,
    seed: int,
    end_s: float = CLOSURES * EVERY_S - 1.0,
) -> Generator[RoadRun]:
    """SUMO with one road alone, whose drivers are alike and come until `end_s`."""
    road = RoadByList(line, [at], folder, seed=seed, end_s=end_s)
    road.closures, road.alike = closures, True
    carrier = SumoRoadCarrier(net_for(line, folder, [at]), 0.0, road)
    try:
        yield RoadRun(road, carrier)
    finally:
        carrier.close()


@dataclass(frozen=True, slots=True)
class Discharge:
    """How a queue in one lane begins to drive: its flow, vehicles/s, and what is lost before that, s."""

    flow_per_s: float
    lost_s: float


@dataclass(frozen=True, slots=True)
class RoadDelay:
    """What closures cost a road of a lane each way: arrivals, vehicles/s a way; how long nobody is let in, s a closure;
    vehicle-seconds in SUMO, by queueing of the vehicles as they came, and if they had come evenly; the longest queue.
    """

    arrival_per_s: float
    shut_s: float
    sumo_s: float
    queueing_s: float
    even_s: float
    queue: int

    @property
    def difference(self) -> float:
        """Of SUMO's waiting from that of queueing, as a share of the latter."""
        return self.sumo_s / self.queueing_s - 1.0


def discharge_of(saturated: RoadRun) -> Discharge:
    """From a road of more vehicles than pass, closed once (`SATURATED`)."""
    until_s = SATURATED.times_s[0][1]
    here = f".{RoadWay.RIGHT.value}."
    times_s = [
        t_s for t_s, vehicle_id in saturated.entries(until_s + 100.0) if t_s > until_s and here in vehicle_id
    ]
    flow_per_s = (_LAST - _FIRST) / (times_s[_LAST] - times_s[_FIRST])
    return Discharge(flow_per_s, times_s[_FIRST] - (until_s + RISING_S) - (_FIRST + 1) / flow_per_s)


def queueing_s(arrivals_s: Sequence[float], shut: Sequence[tuple[float, float]], flow_per_s: float) -> float:
    """What vehicles of one lane wait together, s: `arrivals_s` at the stop line and `shut` in the order of time."""
    waited_s, free_s = 0.0, -math.inf
    for at_s in arrivals_s:
        passes_s = max(at_s, free_s)
        passes_s = next((until_s for from_s, until_s in shut if from_s <= passes_s < until_s), passes_s)
        waited_s, free_s = waited_s + passes_s - at_s, passes_s + 1.0 / flow_per_s
    return waited_s


def delay_of(run: RoadRun, discharge: Discharge) -> RoadDelay:
    """From a road that is closed every five minutes for two hours (`REPEATED`)."""
    end_s = CLOSURES * EVERY_S
    run.run([], round((end_s + EVERY_S) * STEPS_PER_S))
    (at,), totals = run.road.roads, run.road.totals.of.values()
    arrival_per_s = sum(total.passages for total in totals) / len(RoadWay) / end_s
    # As the lamps begin, those still go who would have to brake harder than drivers do.
    goes_on_s = at.road.speed_mps / (2.0 * BRAKES_MPS2)
    before_s, after_s = WARNING_S + LOWERING_S - goes_on_s, RISING_S + discharge.lost_s
    shut = [(from_s - before_s, until_s + after_s) for from_s, until_s in REPEATED.times_s]
    shut_s = before_s + SHUT_S + after_s
    each_s = arrival_per_s * shut_s**2 / (2.0 * (1.0 - arrival_per_s / discharge.flow_per_s))
    return RoadDelay(
        arrival_per_s,
        shut_s,
        sum(total.waited_s for total in totals),
        sum(queueing_s(run.road.arrivals_s(way), shut, discharge.flow_per_s) for way in RoadWay),
        len(RoadWay) * CLOSURES * each_s,
        max(total.queue for total in totals),
    )


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """Each flow of `FLOWS_PER_H` on a crossing of the scenario's line, in each round with other vehicles: medians."""
    from scenario.scenario import load_scenario

    setup = crossed(load_scenario(scenario).setup, 1, SATURATED_PER_H)
    (at,), rows = roads_at(setup), list[dict[str, Any]]()
    with scratch("branchline-") as folder:

        def measured(per_h: float, closures: Closures, measure: Callable[[RoadRun], _Found]) -> list[_Found]:
            found: list[_Found] = []
            for seed in range(1, rounds + 1):
                with road_run(setup.line, alike(at, per_h), folder, closures, seed=seed) as run:
                    found.append(measure(run))
            return found

        queues = measured(SATURATED_PER_H, SATURATED, discharge_of)
        flow_per_s = statistics.median(each.flow_per_s for each in queues)
        discharge = Discharge(flow_per_s, statistics.median(each.lost_s for each in queues))
        said = f"a lane discharges {3600.0 * flow_per_s:.0f} vehicles/h and loses {discharge.lost_s:.1f} s before"
        tell(f"{scenario}: {said}")
        for per_h in FLOWS_PER_H:
            rows.append(
                _row(per_h, measured(per_h, REPEATED, lambda run: delay_of(run, discharge)), discharge)
            )
            tell(f"{scenario}: {rows[-1]['flow']}: {rows[-1]['difference_pct']:+.1f} %")
    worst = max(abs(row["difference_pct"]) for row in rows)
    limit = 100.0 * DIFFERENCE_MAX
    budgets = [budget_of("SUMO's waiting from that of deterministic queueing, %", limit, worst)]
    return {"scenario": scenario, "rounds": rounds, "rows": rows, "budgets": budgets}


def alike(at: RoadAt, per_h: float) -> RoadAt:
    """The place with a road of so many cars an hour both ways, and nothing else."""
    return replace(at, road=CrossingRoad(vehicles_per_h=(per_h,), heavy_share=0.0))


def _row(per_h: float, found: Sequence[RoadDelay], discharge: Discharge) -> dict[str, Any]:
    def median(value: Callable[[RoadDelay], float], digits: int = 1) -> float:
        return round(statistics.median(value(each) for each in found), digits)

    return {
        "flow": f"{per_h:.0f} vehicles/h, {CLOSURES} x {SHUT_S:.0f} s",
        "of_saturation": median(lambda each: each.arrival_per_s / discharge.flow_per_s, 3),
        "shut_s": median(lambda each: each.shut_s),
        "sumo_waited_h": median(lambda each: each.sumo_s / 3600.0, 3),
        "queueing_h": median(lambda each: each.queueing_s / 3600.0, 3),
        "even_h": median(lambda each: each.even_s / 3600.0, 3),
        "difference_pct": median(lambda each: 100.0 * each.difference),
        "queue": median(lambda each: each.queue, 0),
    }
