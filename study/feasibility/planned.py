"""The day as planned on the missions that the run draws up: where each train is to be when, and by which routes.

Tracks are those of `simulation.world.roster.draw_up`, so an unnamed track is the one that the run takes. Where a plan
gives no arrival, it is that of a train that runs without delay, which is how units drive to a stop without one. A train
from a portal is to be there in time for its first call; it may come earlier, by the lead that the operation gives it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

from network.clock import first_given
from network.model import Direction, Line, Route
from network.timetable import Diagram
from onboard.mission import Mission, NoWay, Target
from simulation.setup import Setup
from simulation.world.roster import Duty, drawn_up
from study.feasibility.run_times import RunTimes

NO_ROUTE: Final = (NoWay, ValueError)  # the latter: a train that begins at a halt, where no route does
SIGNS_S: Final = 2.0  # assumed: telegrams of signing on or off, or of a route asked for and granted


@dataclass(frozen=True, slots=True)
class PlannedNode:
    """A track or portal on a train's way; `target` is its stop there, None where it runs through.

    `arrives_s` and `departs_s` are of the plan, inferred where that has none, at `position_m` of the path.
    """

    section_id: str
    position_m: float
    arrives_s: float
    departs_s: float
    target: Target | None


@dataclass(frozen=True, slots=True)
class PlannedStop:
    """A stop of a train, halts included, with its running time from the stop before, s (0 for the first).

    `passes_s`: the running time to each station passed on the way, s.
    """

    target: Target
    arrives_s: float
    departs_s: float
    run_s: float
    passes_s: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class PlannedTrain:
    """One train of the day. `routes[k]` leads from `nodes[k]` to `nodes[k + 1]`."""

    stock_id: str
    duty: Duty
    nodes: tuple[PlannedNode, ...]
    stands: tuple[PlannedStop, ...]

    @property
    def number(self) -> str:
        """Its number."""
        return self.duty.train.number

    @property
    def direction(self) -> Direction:
        """Its direction of travel."""
        return self.duty.mission.direction

    @property
    def routes(self) -> tuple[Route, ...]:
        """Its routes, in order."""
        return self.duty.mission.routes


@dataclass(frozen=True, slots=True)
class WayMissing:
    """A train for which the line has no way; the trains of its set that come after it are not looked at."""

    number: str
    why: str


@dataclass(frozen=True, slots=True)
class PlannedDay:
    """All trains by stock, in order; `missing` are those that cannot be drawn up."""

    line: Line
    trains: Mapping[str, tuple[PlannedTrain, ...]]
    missing: tuple[WayMissing, ...]

    def all(self) -> Iterator[PlannedTrain]:
        """Every train, by stock."""
        for trains in self.trains.values():
            yield from trains


def planned_day(setup: Setup) -> PlannedDay:
    """The day of a setup."""
    times = RunTimes(setup)
    trains: dict[str, tuple[PlannedTrain, ...]] = {}
    missing: list[WayMissing] = []
    for diagram in setup.timetable.diagrams:
        duties, lacking = _duties_of(setup, diagram)
        trains[diagram.stock_id] = tuple(_planned(setup, duty, times) for duty in duties)
        missing += lacking
    return PlannedDay(setup.believed_line, trains, tuple(missing))


def _duties_of(setup: Setup, diagram: Diagram) -> tuple[tuple[Duty, ...], list[WayMissing]]:
    """The duties of one set, up to the first that has no way."""

    def first_duties(count: int) -> tuple[Duty, ...]:
        part = replace(diagram, train_numbers=diagram.train_numbers[:count])
        day = replace(setup, timetable=replace(setup.timetable, diagrams=(part,)))
        return drawn_up(day, setup.believed_line)[diagram.stock_id]

    try:
        return first_duties(len(diagram.train_numbers)), []
    except NO_ROUTE:
        before: tuple[Duty, ...] = ()
        for count, number in enumerate(diagram.train_numbers, start=1):
            try:
                before = first_duties(count)
            except NO_ROUTE as why:
                return before, [WayMissing(number, str(why))]
        raise


def _planned(setup: Setup, duty: Duty, times: RunTimes) -> PlannedTrain:
    mission = duty.mission
    stands = _stands(setup, duty, times)
    sections = [mission.spans[0].section_id, *(route.to_section for route in mission.routes)]
    nodes = tuple(_node(mission, stands, section_id) for section_id in sections)
    return PlannedTrain(duty.stock_id, duty, nodes, stands)


def _stands(setup: Setup, duty: Duty, times: RunTimes) -> tuple[PlannedStop, ...]:
    """The stops of a train in order, with planned or inferred times."""
    mission = duty.mission
    stands: list[PlannedStop] = []
    for before, there in pairwise((None, *mission.targets)):
        if there is None:
            continue
        if before is None:
            begins_s = duty.enter_s if duty.enters else float(duty.train.calls[0].last_s)
            arrives_s = begins_s if there.arrival_s is None else there.arrival_s
            stands.append(PlannedStop(there, arrives_s, first_given(there.departure_s, begins_s), 0.0))
            continue
        passing_m = tuple(passing.position_m for passing in there.passings)
        *passes_s, run_s = times.times_s(duty.stock_id, mission.path, before.mark_m, there.mark_m, passing_m)
        last = stands[-1]
        if duty.enters and len(stands) == 1:
            stands[0] = last = _comes_in(setup, duty, last, there, run_s)
        arrives_s = last.departs_s + run_s
        if there.arrival_s is not None:
            arrives_s = there.arrival_s
        elif there.departure_s is not None:
            arrives_s = max(min(arrives_s, there.departure_s), last.departs_s)
        departs_s = arrives_s if there.departure_s is None else there.departure_s
        stands.append(PlannedStop(there, arrives_s, departs_s, run_s, tuple(passes_s)))
    return tuple(stands)


def due_s(target: Target, dwell_min_s: float) -> float:
    """When a train is to be at a stop at the latest: that of the plan, or in time to stay for its shortest stop."""
    if target.arrival_s is not None:
        return target.arrival_s
    dwell_s = dwell_min_s if target.passengers else 0.0
    return (target.departure_s or 0.0) - dwell_s


def _comes_in(setup: Setup, duty: Duty, portal: PlannedStop, there: Target, run_s: float) -> PlannedStop:
    """A train in its portal: it leaves that in time for its first call, not before the lead lets it come."""
    latest_s = due_s(there, setup.unit.dwell_min_s) - run_s
    leaves_s = max(duty.enter_s + SIGNS_S, latest_s)
    return PlannedStop(portal.target, leaves_s - SIGNS_S, leaves_s, 0.0)


def _node(mission: Mission, stands: tuple[PlannedStop, ...], section_id: str) -> PlannedNode:
    """A track or portal of the way: as the train stands there, or as it runs through."""
    here = [stand for stand in stands if stand.target.section_id == section_id]
    if here:
        first, last = here[0], here[-1]
        return PlannedNode(section_id, first.target.mark_m, first.arrives_s, last.departs_s, first.target)
    span = mission.spans[mission.span_index(section_id)]
    for target in mission.targets:
        for passing in target.passings:
            if span.start_m <= passing.position_m < span.end_m:
                return PlannedNode(section_id, passing.position_m, passing.time_s, passing.time_s, None)
    middle_m = (span.start_m + span.end_m) / 2.0
    passes_s = _between(stands, mission, middle_m)
    return PlannedNode(section_id, middle_m, passes_s, passes_s, None)


def _between(stands: tuple[PlannedStop, ...], mission: Mission, position_m: float) -> float:
    """When the train is somewhere on its way, by even speed between the times known on either side, s."""
    known = [(s.target.mark_m, s.arrives_s, s.departs_s) for s in stands]
    known += [(p.position_m, p.time_s, p.time_s) for target in mission.targets for p in target.passings]
    known.sort()
    for (from_m, _, leaves_s), (to_m, comes_s, _) in pairwise(known):
        if from_m <= position_m <= to_m and to_m > from_m:
            return leaves_s + (comes_s - leaves_s) * (position_m - from_m) / (to_m - from_m)
    return known[0][2] if position_m < known[0][0] else known[-1][1]
