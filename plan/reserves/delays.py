"""How late trains are on a day: what is drawn, and what follows from it with the order of trains as planned.

A time comes no sooner than planned, and no sooner than so long after another one: running times, shortest stands with
what people take, turning back, sections of others.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from graphlib import TopologicalSorter
from typing import Final

import numpy as np
from numpy.typing import NDArray

from plan.reserves.problem import PlanEvent, ReserveProblem, ReserveTrain
from plan.reserves.sampled import SampledDay
from simulation.late_day import DrawnStay

PlannedTimes = Mapping[PlanEvent, int]
_NOTHING: Final = DrawnStay()


@dataclass(frozen=True, slots=True)
class TimeRule:
    """On a day the one time comes at least so long after the other, s."""

    before: PlanEvent
    after: PlanEvent
    least_s: float


def time_rules(problem: ReserveProblem, day: SampledDay) -> Iterator[TimeRule]:
    """All rules of a day, in the same order for each day."""
    for train in problem.trains.values():
        yield from _own_rules(train, day)
        if train.follows is not None:
            last = PlanEvent(train.follows, len(problem.trains[train.follows].stops) - 1, departs=False)
            turn_s = train.turn_s + _drawn(train, 0, day).doors_s
            yield TimeRule(last, PlanEvent(train.number, 0, departs=True), turn_s)
    for wait in problem.waits:
        yield TimeRule(wait.before, wait.after, wait.least_s)


def _own_rules(train: ReserveTrain, day: SampledDay) -> Iterator[TimeRule]:
    for index, stop in enumerate(train.stops):
        arrives = PlanEvent(train.number, index, departs=False)
        if index:
            yield TimeRule(PlanEvent(train.number, index - 1, departs=True), arrives, stop.run_s)
        if index and stop.departure_s is not None:
            drawn = _drawn(train, index, day)
            stay_s = stop.stay_s + drawn.people_s + drawn.doors_s
            yield TimeRule(arrives, PlanEvent(train.number, index, departs=True), stay_s)


def held_s(problem: ReserveProblem, day: SampledDay, event: PlanEvent) -> float:
    """By how much a time is late on a day whatever else, s: doors, late at the portal; an arrival may be early."""
    if not event.departs:
        return -problem.early_s
    train = problem.trains[event.number]
    late_s = 0.0
    if event.stop == 0 and train.entry_slack_s is not None:
        late_s = max(day.entries_s.get(train.number, 0.0) - train.entry_slack_s, 0.0)
    return late_s + _drawn(train, event.stop, day).doors_s


def _drawn(train: ReserveTrain, stop: int, day: SampledDay) -> DrawnStay:
    return day.stays.get((train.number, train.stops[stop].station_id), _NOTHING)


def events_of(problem: ReserveProblem) -> Iterator[PlanEvent]:
    """All times of all trains, each train's in order."""
    for train in problem.trains.values():
        for index, stop in enumerate(train.stops):
            if index:
                yield PlanEvent(train.number, index, departs=False)
            if stop.departure_s is not None:
                yield PlanEvent(train.number, index, departs=True)


def planned_times(problem: ReserveProblem) -> PlannedTimes:
    """The times as the timetable has them."""
    return {event: problem.planned_s(event) for event in events_of(problem)}


class SampledDelays:
    """Delays on sampled days, for any times of a problem."""

    def __init__(self, problem: ReserveProblem, days: Sequence[SampledDay]) -> None:
        """Raises ValueError where trains each wait for the other."""
        self._events: Final = tuple(events_of(problem))
        at = {event: index for index, event in enumerate(self._events)}
        self._held: Final = np.array(
            [[held_s(problem, day, event) for day in days] for event in self._events]
        )
        rules = [tuple(time_rules(problem, day)) for day in days]
        self._least: Final = np.array([[rule.least_s for rule in same] for same in zip(*rules, strict=True)])
        into: dict[int, list[tuple[int, int]]] = defaultdict(list)
        for index, rule in enumerate(rules[0]):
            into[at[rule.after]].append((at[rule.before], index))
        self._into: Final = dict(into)
        order: TopologicalSorter[int] = TopologicalSorter(
            {after: [before for before, _ in own] for after, own in into.items()}
        )
        self._order: Final = tuple(order.static_order())
        self._counted: Final = [
            at[event]
            for event in self._events
            if not event.departs and problem.trains[event.number].stops[event.stop].counted
        ]

    def mean_s(self, times: PlannedTimes) -> float:
        """The mean delay of an arrival that counts, over all days, s; an early one is on time."""
        if not self._counted:
            return math.nan
        return float(np.maximum(self.late_s(times)[self._counted], 0.0).mean())

    def late_s(self, times: PlannedTimes) -> NDArray[np.float64]:
        """By how much each time of `events_of` is late on each day, s; shape (times, days)."""
        planned = np.array([float(times[event]) for event in self._events])
        so = planned[:, None] + self._held
        for after in self._order:
            for before, rule in self._into.get(after, ()):
                so[after] = np.maximum(so[after], so[before] + self._least[rule])
        late: NDArray[np.float64] = so - planned[:, None]
        return late
