"""A late day of a scenario as a dispatching problem, from the program's own blocking times.

A leg of a set, from one place where it may stand to the next, is a row of operations: first it claims sections where it
stands, then it runs, with a new operation at each instant at which it claims or gives back something on the way; then
it stands. What it gives back after it has come to a stand has a release time. A leg that claims its way before it is in
the place where it begins (it runs through) claims it there at the soonest. Its way may be claimed as soon as units ask
for it, and takes what it takes to be set: where a train waits for it, it leaves then, and the stand before is no longer
for it.

Late are trains that come late to their portal, passengers who take longer and doors that do not close, as drawn for the
scenario's seed; failures and dead zones are no part of it. Times are whole seconds after midnight. A train costs what
it comes later to its last stop than printed. What a halt takes longer is time on the way.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

from network.errors import InputError
from plan.dispatching.instance import Instance, OperationDelay, ResourceUsage, Solution, Train, TrainOperation
from simulation.late.entry import entry_late_s
from simulation.late.settings import Late
from simulation.late_day import DrawnStay, late_day
from simulation.setup import Setup
from study.capacity.legs import SetLeg, follows_on, legs_of, places_of, stand_of
from study.capacity.occupation import OccupationPart
from study.capacity.rules import AS_UNITS, Rules
from study.capacity.theory import occupations
from study.feasibility.planned import planned_day
from study.runner.journeys import journeys_of

ON_TIME: Final = DrawnStay()
FAST: Final = Rules(unslowed=True)
SET_LATE: Final = Rules(unslowed=True, late=True)
CLAIMS_COUNT = True  # a way is claimed before the departure; for tests alone
HALTS_COUNT = True  # off: what is drawn for a halt costs no time
SET_IN_A_STAND = (
    True  # off: a way is set when the stand is over, and takes as long as units ask for it before
)


@dataclass(frozen=True, slots=True)
class DispatchedDay:
    """The problem. `legs`: of each train of it, which is one set, its legs; `departs`: the operation with which each of
    these sets out.
    """

    instance: Instance
    legs: tuple[tuple[SetLeg, ...], ...]
    departs: tuple[tuple[int, ...], ...]

    def order(self, solution: Solution) -> tuple[SetLeg, ...]:
        """All legs in the order in which a solution has them set out."""
        by_operation = {
            (train, operation): leg
            for train, (own, departs) in enumerate(zip(self.legs, self.departs, strict=True))
            for leg, operation in zip(own, departs, strict=True)
        }
        events = ((event.train, event.operation) for event in solution.events)
        return tuple(by_operation[event] for event in events if event in by_operation)


def day_of(setup: Setup) -> DispatchedDay:
    """The problem of a setup's day, by its seed."""
    planned = _legs(setup, AS_UNITS)
    day = _LateTrains(setup)
    fast, set_late = (
        {_name(leg): leg for legs in _legs(setup, rules).values() for leg in legs}
        for rules in (FAST, SET_LATE)
    )
    sets_s = {name: leg.departs_s - _claimed_s(leg) for name, leg in set_late.items()}
    rows = [
        _SetOperations(
            day, [_DrivenLeg(leg, fast.get(_name(leg), leg), sets_s.get(_name(leg))) for leg in legs]
        )
        for legs in planned.values()
    ]
    delays = tuple(delay for index, row in enumerate(rows) for delay in row.delays(index))
    instance = Instance(tuple(row.train() for row in rows), delays)
    return DispatchedDay(instance, tuple(planned.values()), tuple(tuple(row.departs) for row in rows))


def _name(leg: SetLeg) -> tuple[str, str, str]:
    """Which leg it is, however it is driven."""
    return leg.number, "" if leg.start is None else leg.start.section_id, leg.occupations[-1].section_id


def _claimed_s(leg: SetLeg) -> float:
    """When a leg's way is claimed, s."""
    return min((one.begin_s for one in leg.occupations if math.isfinite(one.begin_s)), default=leg.departs_s)


def _legs(setup: Setup, rules: Rules) -> dict[str, tuple[SetLeg, ...]]:
    """The legs of each set on a punctual day."""
    found: dict[str, list[SetLeg]] = defaultdict(list)
    for leg in legs_of(occupations(replace(setup, late=Late()), rules), places_of(setup.line)):
        found[leg.stock_id].append(leg)
    return {stock_id: tuple(legs) for stock_id, legs in sorted(found.items())}


class _LateTrains:
    """What is late on a day, and what is printed."""

    def __init__(self, setup: Setup) -> None:
        self.dwell_min_s: Final = setup.unit.dwell_min_s
        self._trains = setup.timetable.trains
        self._stays = late_day(setup).stays
        self._halts = {station.id for station in setup.line.stations.values() if station.is_halt}
        self._station = {section.id: section.station_id or "" for section in setup.line.sections.values()}
        self._entry_s = {
            number: entry_late_s(setup.late, setup.seed, setup.today, train)
            for number, train in self._trains.items()
        }

    def entry_s(self, number: str) -> float:
        """How much later a train comes to its portal, s."""
        return self._entry_s[number]

    def stay(self, number: str, section_id: str) -> DrawnStay:
        """What passengers and doors of a train take longer at a place."""
        return self._stays.get((number, self._station[section_id]), ON_TIME)

    def halts(self, leg: SetLeg) -> list[tuple[float, float]]:
        """When a leg's train leaves each halt on its way, s, and what passengers and doors take longer there."""
        calls = self._trains[leg.number].calls
        order = {call.station_id: at for at, call in enumerate(calls)}
        first = -1 if leg.start is None else order.get(self._station[leg.start.section_id], -1)
        last = order.get(self._station[leg.occupations[-1].section_id], len(calls))
        drawn = [
            self._stays.get((leg.number, call.station_id), ON_TIME)
            for call in calls[first + 1 : last]
            if call.stops and call.station_id in self._halts
        ]
        way = (one for one in leg.occupations if one is not leg.end)
        dwells = (s.end_s for one in way for s in one.slices if s.part is OccupationPart.DWELL)
        return [(at_s, stay.people_s + stay.doors_s) for at_s, stay in zip(dwells, drawn, strict=False)]

    def ends_at(self, number: str, section_id: str) -> bool:
        """Whether a train's last stop is there; it may go on to its portal."""
        return self._trains[number].calls[-1].station_id == self._station[section_id]

    def due_s(self, number: str) -> int | None:
        """When a train with passengers is to be at its last stop, as printed; None: it is not said, or has none."""
        train = self._trains[number]
        return train.calls[-1].arrival_s if train.revenue else None


@dataclass(frozen=True, slots=True)
class _DrivenLeg:
    """A leg as planned and as fast as it is driven; how long its way takes to be set, s (None: nobody knows)."""

    planned: SetLeg
    fast: SetLeg
    sets_s: float | None

    @property
    def held(self) -> list[tuple[str, float, float]]:
        """What it has, from when until when, s after it leaves: until it goes on where it comes to stand."""
        from_s, place = self.fast.departs_s, self.fast.start
        own = [
            (o.section_id, o.begin_s - from_s, math.inf if o is self.fast.end else o.end_s - from_s)
            for o in self.fast.occupations
        ]
        return own if place is None else [*own, (place.section_id, -math.inf, place.end_s - from_s)]

    @property
    def claims_s(self) -> float:
        """When it claims its way at the soonest, s after it leaves: not before it is in the place where it begins."""
        from_s, place = self.fast.departs_s, self.fast.start
        soonest_s = -math.inf if place is None else max(stand_of(place).arrives_s, place.begin_s) - from_s
        begins_s = min(_claimed_s(self.fast) - from_s, 0.0) if CLAIMS_COUNT else 0.0
        return max(begins_s, min(soonest_s, 0.0))

    @property
    def setting_s(self) -> float:
        """How long its way takes to be set, s."""
        known = self.sets_s is not None and SET_IN_A_STAND
        return min(-self.claims_s, self.sets_s or 0.0) if known else -self.claims_s


@dataclass(slots=True)
class _OperationDraft:
    """An operation that is being made up."""

    lasts_s: float
    sections: dict[str, float]
    earliest_s: float = 0.0
    goes_on: bool = False  # with a leg, whose seconds are rounded up together


class _SetOperations:
    """The operations of one set."""

    def __init__(self, day: _LateTrains, legs: Sequence[_DrivenLeg]) -> None:
        self._day = day
        self._pieces: list[_OperationDraft] = []
        self.departs: list[int] = []
        self._arrives: dict[str, int] = {}
        for index, leg in enumerate(legs):
            joined = index > 0 and follows_on(legs[index - 1].planned, leg.planned)
            number = leg.planned.number
            self._stand(leg, joined=joined)
            self._run(leg, 0.0 if joined else day.entry_s(number))
            if day.ends_at(number, leg.planned.occupations[-1].section_id):
                self._arrives[number] = len(self._pieces)
        last = legs[-1].planned
        stays = last.end is not None and not math.isfinite(last.end.leaves_s)
        self._pieces.append(_OperationDraft(0.0, {last.end.section_id: 0.0} if stays and last.end else {}))

    def _stand(self, leg: _DrivenLeg, *, joined: bool) -> None:
        place = leg.planned.start
        if place is None:
            return
        stand, drawn = (
            stand_of(place, self._day.dwell_min_s),
            self._day.stay(leg.planned.number, place.section_id),
        )
        least_s = stand.least_s + drawn.people_s + drawn.doors_s if joined else 0.0
        set_s = leg.setting_s if SET_IN_A_STAND else 0.0
        self._pieces.append(
            _OperationDraft(max(0.0, least_s - set_s), {place.section_id: 0.0} if joined else {})
        )

    def _run(self, leg: _DrivenLeg, late_s: float) -> None:
        """Claims, then pieces of the way, not before it is planned and so much later; times against the departure."""
        held, begins_s, place = leg.held, leg.claims_s, leg.fast.start
        arrives_s = max(leg.fast.arrives_s - leg.fast.departs_s, 0.0)
        times = {begins_s, 0.0, arrives_s}
        times |= {t for _, begin, end in held for t in (begin, end) if begins_s < t < arrives_s}
        drawn = self._day.stay(leg.planned.number, place.section_id) if place is not None else ON_TIME
        earliest_s = leg.planned.departs_s + drawn.doors_s + late_s
        self.departs.append(len(self._pieces))
        longer = self._day.halts(leg.fast) if HALTS_COUNT else []
        faster = leg.setting_s / -begins_s if begins_s else 1.0  # it may be claimed sooner than it must
        for one_s, other_s in list(pairwise(sorted(times))) or [(0.0, 0.0)]:
            sections = {s: 0.0 for s, begin, end in held if max(begin, begins_s) <= one_s < end}
            if other_s == arrives_s:
                after = ((s, end - arrives_s) for s, _, end in held if s in sections and math.isfinite(end))
                sections |= {s: max(0.0, left_s) for s, left_s in after}
            halts_s = sum(stays_s for at_s, stays_s in longer if one_s < at_s - leg.fast.departs_s <= other_s)
            lasts_s = (other_s - one_s) * (faster if other_s <= 0.0 else 1.0) + halts_s
            earliest = earliest_s + one_s if one_s <= 0.0 else 0.0
            self._pieces.append(_OperationDraft(lasts_s, sections, earliest, goes_on=one_s > 0.0))

    def train(self) -> Train:
        """As the problem has it. Times are rounded up to whole seconds, those of one way all together: it has as many
        operations as there are instants at which it claims or gives back something, and is no longer for that.
        """
        count, lasts_s = len(self._pieces), self._whole_seconds()
        return tuple(
            TrainOperation(
                lasts_s[place],
                (place + 1,) if place + 1 < count else (),
                tuple(ResourceUsage(s, math.ceil(late_s - 1e-6)) for s, late_s in piece.sections.items()),
                start_lb=max(0, math.ceil(piece.earliest_s - 1e-6)),
            )
            for place, piece in enumerate(self._pieces)
        )

    def _whole_seconds(self) -> list[int]:
        """How long each operation is, s."""
        found: list[int] = []
        over_s = 0.0  # by how much what stands already is longer than it need be
        for piece in self._pieces:
            over_s = over_s if piece.goes_on else 0.0
            found.append(max(0, math.ceil(piece.lasts_s - over_s - 1e-6)))
            over_s += found[-1] - piece.lasts_s
        return found

    def delays(self, index: int) -> Iterator[OperationDelay]:
        """What each train's arrival at its last stop costs."""
        for number, operation in self._arrives.items():
            due_s = self._day.due_s(number)
            if due_s is not None:
                yield OperationDelay("op_delay", index, operation, threshold=int(due_s), coeff=1)


def moves_of(setup: Setup, legs: Iterable[SetLeg]) -> tuple[str, ...]:
    """The sets in the order in which the manager has them make their moves: a leg is one by a route, and a set comes
    onto the line just before the leg that it then makes.

    Raises InputError where a set has other legs than moves.
    """
    left = {stock.unit_id: list(stock.moves) for stock in journeys_of(setup, planned_day(setup))}
    found: list[str] = []
    for leg in legs:
        own = left[leg.stock_id]
        while own and not own[0].route_id:
            found.append(leg.stock_id)
            own.pop(0)
        if own:
            found.append(leg.stock_id)
            own.pop(0)
    if over := [stock_id for stock_id, own in left.items() if own]:
        raise InputError("solution", "events", over[0], "a departure of each leg of each set of the scenario")
    return tuple(found)
