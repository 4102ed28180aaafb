"""Trains that are to come in at one station, of which one must stand before the other comes in (不同時進入).

Each needs leave from where it would have to brake for its arrival points, with the time that these take to be thrown,
until it stands and has said so. Times are those of the plan; the way to the braking point is that of `RunTimes`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Final

import numpy as np

from network.clock import clock
from network.graph import overlaps_coming_in
from network.model import TagPurpose
from onboard.driving.room import Room
from simulation.setup import Setup, behaviour_row
from study.feasibility.finding import Finding, FindingKind, length_of_time, minute, severity_of
from study.feasibility.fixes import measured_growth
from study.feasibility.planned import PlannedDay, PlannedNode, PlannedTrain
from study.feasibility.run_times import RunTimes

EVERY_M: Final = 5.0  # the braking point is looked for at steps so long
LOOKED_M: Final = 800.0  # assumed: no train brakes for longer than that before points
KNOWN_M: Final = 300.0  # assumed: how far the last tag before points lies from them


@dataclass(frozen=True, slots=True)
class ComingIn:
    """A train that comes in by a route: what it must have alone from `needs_s` on until `stands_s`, s, and where.

    `asks_s`: when its unit asks for that.
    """

    train: PlannedTrain
    node: PlannedNode
    overlaps: tuple[str, ...]
    asks_s: float
    needs_s: float
    stands_s: float


class Entries:
    """How long before its stand a train needs leave to come in; see the module."""

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._times = RunTimes(setup)

    @property
    def report_s(self) -> float:
        """From its stand until the manager has its report, s."""
        return self._setup.radio_on_average.delay_s

    def leads_s(self, train: PlannedTrain, node: int) -> tuple[float, float]:
        """How long before it stands at this node, or is there, a train asks for leave, and needs it, s."""
        setup, route, mission = self._setup, train.routes[node - 1], train.duty.mission
        spans = [span for span in mission.spans if span.section_id in route.entry]
        throws_s = max(
            setup.line.points[points_id].throw_time_s for span in spans for points_id, *_ in span.points
        )
        joint_m, there_m = spans[0].start_m, train.nodes[node].position_m
        marks_m = [stand.target.mark_m for stand in train.stands]
        from_m = max(mark_m for mark_m in marks_m if mark_m < joint_m)
        tags_m = [tag.position_m for tag in mission.tags if tag.purpose is TagPurpose.APPROACH]
        tag_m = min((at_m for at_m in tags_m if from_m < at_m < joint_m), default=joint_m)
        begin_m = min(max(from_m + EVERY_M, joint_m - LOOKED_M), tag_m)
        looked_m = (*np.arange(begin_m, joint_m, EVERY_M).tolist(), joint_m)
        to_m = next(mark_m for mark_m in marks_m if mark_m >= there_m)
        passed_m = (tag_m, *looked_m, *((there_m,) if there_m < to_m else ()))
        at_s = self._times.times_s(train.stock_id, mission.path, from_m, to_m, passed_m)
        there_s = at_s[len(looked_m) + 1]
        # leave asked for and had, points commanded, and their proof
        set_s = 4.0 * setup.radio_on_average.delay_s + throws_s
        needs_s = there_s - self._brakes_s(train, looked_m, at_s[1 : len(looked_m) + 1]) + set_s
        return max(there_s - at_s[0], needs_s), needs_s

    def _brakes_s(self, train: PlannedTrain, looked_m: Sequence[float], at_s: Sequence[float]) -> float:
        """When it would have to brake to stop where the last of these places is."""
        room, spare_m = self._room(train), math.inf
        for (here_m, next_m), (here_s, next_s) in zip(pairwise(looked_m), pairwise(at_s), strict=True):
            speed_mps = np.array([(next_m - here_m) / max(next_s - here_s, 1e-6)])
            left_m = looked_m[-1] - next_m - float(room.needed_m(speed_mps, self._bound_m)[0])
            if left_m < 0.0:
                share = spare_m / (spare_m - left_m) if math.isfinite(spare_m) else 0.0
                return here_s + share * (next_s - here_s)
            spare_m = left_m
        return at_s[-1]

    @property
    def _bound_m(self) -> float:
        unit = self._setup.unit
        return unit.tag_accuracy_m + measured_growth(unit) * KNOWN_M

    def _room(self, train: PlannedTrain) -> Room:
        row = self._setup.believed_train(train.stock_id).row
        kind = row.view(np.recarray)[0]
        behaviour = behaviour_row(self._setup.driving, row[0]).reshape(1).view(np.recarray)[0]
        return Room(behaviour, float(kind.brake_dead_time_s + kind.brake_lag_s), self._setup.unit.standoff_m)


def entries_of(setup: Setup, day: PlannedDay) -> Iterator[Finding]:
    """Every two trains of which the plan has one come in before the other stands."""
    entries = Entries(setup)
    found = [one for train in day.all() for one in _of_train(day, train, entries)]
    found.sort(key=_stands_s)
    for first, second in combinations(found, 2):
        short_s = first.stands_s - second.needs_s
        same_set = first.train.stock_id == second.train.stock_id
        if short_s > 0.0 and not same_set and set(first.overlaps) & set(second.overlaps):
            yield _finding(day, first, second, short_s)


def _stands_s(one: ComingIn) -> tuple[float, float]:
    return one.stands_s, one.asks_s


def _of_train(day: PlannedDay, train: PlannedTrain, entries: Entries) -> Iterator[ComingIn]:
    for index, route in enumerate(train.routes, start=1):
        if route.entry:
            node = train.nodes[index]
            asks_s, needs_s = (node.arrives_s - lead_s for lead_s in entries.leads_s(train, index))
            overlaps = overlaps_coming_in(day.line, route)
            yield ComingIn(train, node, overlaps, asks_s, needs_s, node.arrives_s + entries.report_s)


def _finding(day: PlannedDay, first: ComingIn, second: ComingIn, short_s: float) -> Finding:
    numbers = first.train.number, second.train.number
    station_id = day.line.sections[second.node.section_id].station_id or ""
    text = (
        f"{numbers[1]} is to come in at {day.line.stations[station_id].name} at {minute(second.node.arrives_s)}, and"
        f" needs leave for that at {clock(math.floor(second.needs_s))}; {numbers[0]} stands there at"
        f" {clock(math.ceil(first.stands_s))}"
    )
    at = clock(math.ceil(second.node.arrives_s + short_s))
    remedy = f"{numbers[1]} comes {length_of_time(short_s)} later, at {at}"
    severity = severity_of(short_s, first.node.arrives_s, second.node.arrives_s)
    at_s = second.node.arrives_s
    return Finding(FindingKind.COMING_IN, severity, numbers, station_id, at_s, text, remedy, short_s)
