"""By what lateness grew, between two times of a set that were planned: by itself, or because it waited for others.

Growth between an arrival or departure and the next is put down, in this order, to what was drawn for that stop (late to
the portal, passengers, doors), to waiting for what another train had (secondary, knock-on delay), and to what failed of
the train, until it runs in the system again, or beside the track meanwhile (primary, too). What is left is driving, and
a plan of whole minutes. Of a set that turns back late the next train grows no later by that: it was late before. Spare
time takes growth back, so that the sum of all is more than what trains are late in the end. A train that never comes to
its end counts as coming when the run ends whatever happens; of that, what was not spent waiting for others is primary.
A train that the dispatcher cuts grows, for others, to the lateness that is stated, from what it was late before.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from network.clock import first_given
from network.timetable import AtPortal, CallKind
from onboard.notes import PositionFault, Resumed
from simulation.events import MANAGER, CameLate, DoorsHeld, Entered, EventType, JournalEntry, PowerOff
from simulation.faults.script import ScriptedFault
from simulation.result import RunResult, StopRecord
from simulation.setup import STEPS_PER_S, Setup
from study.measures.register_holds import is_of_crossing
from wayside.said import Accepted, Granted, Refused

SIGNS_ON_S: Final = 5.0  # so soon a train at its portal is on the line, if nothing stands in its way
# Events that a journal must have kept.
READS: Final[tuple[EventType, ...]] = (
    Accepted,
    CameLate,
    DoorsHeld,
    Entered,
    Granted,
    PositionFault,
    PowerOff,
    Refused,
    Resumed,
)
Span = tuple[float, float]


@dataclass(frozen=True, slots=True)
class LatenessGrowth:
    """By how much a set's lateness grew until `at_s`, when `number` arrived at or left a station, s."""

    stock_id: str
    number: str
    station_id: str
    at_s: float
    grown_s: float
    primary_s: float
    secondary_s: float

    @property
    def other_s(self) -> float:
        """What neither a disturbance nor another train explains."""
        return self.grown_s - self.primary_s - self.secondary_s


def _spans() -> dict[str, list[Span]]:
    return defaultdict(list)


@dataclass(slots=True)
class _JournalFacts:
    """What the journal says of all stocks: by stock, train, or train and station."""

    stock_ids: frozenset[str]
    waits: dict[str, list[Span]] = field(default_factory=_spans)  # refused for another
    failed: dict[str, list[Span]] = field(default_factory=_spans)  # until it ran in the system again
    beside: list[Span] = field(default_factory=list[Span])  # faults of what all use
    held: dict[tuple[str, str], DoorsHeld] = field(default_factory=dict[tuple[str, str], DoorsHeld])
    came_late_s: dict[str, float] = field(default_factory=dict[str, float])
    entered_s: dict[str, float] = field(default_factory=dict[str, float])
    refused_s: dict[str, float] = field(default_factory=dict[str, float])  # open still, since
    blind_s: dict[str, float] = field(default_factory=dict[str, float])

    def take(self, entry: JournalEntry) -> None:
        """A line of the journal."""
        match entry.event:
            case Refused(unit_id=unit, other_id=other) if entry.who == MANAGER and other:
                self.refused_s.setdefault(unit, entry.t_s)
            case Granted(unit_id=unit) | Accepted(unit_id=unit) if unit in self.refused_s:
                self.waits[unit].append((self.refused_s.pop(unit), entry.t_s))
            case DoorsHeld(train=number, station=station) as held:
                self.held[number, station] = held
            case CameLate(train=number, late_s=late_s):
                self.came_late_s[number] = late_s
            case Entered(train=number):
                self.entered_s[number] = entry.t_s
            case PowerOff(device_id=unit) if unit in self.stock_ids:
                self.blind_s.setdefault(unit, entry.t_s)
            case PositionFault():
                self.blind_s.setdefault(entry.who, entry.t_s)
            case Resumed() if entry.who in self.blind_s:
                self.failed[entry.who].append((self.blind_s.pop(entry.who), entry.t_s))
            case _:
                pass

    def fault(self, target: str, span: Span) -> None:
        """A fault is of the stocks that it names (a link may name one), or of what all use."""
        own = self.stock_ids.intersection(target.split())
        for stock_id in own:
            self.failed[stock_id].append(span)
        if not own:
            self.beside.append(span)

    def close(self, end_s: float) -> None:
        """The run is over."""
        for spans, open_s in ((self.waits, self.refused_s), (self.failed, self.blind_s)):
            for unit, from_s in open_s.items():
                spans[unit].append((from_s, end_s))


@dataclass(frozen=True, slots=True)
class _Moment:
    """A planned time as it came: an arrival or a departure, s. `drawn_s`: what was drawn for the stop or the entry.

    `ready_s`: from when on waiting for others counts; `comes_s`: when a train that enters stood before its portal.
    `never`: it never came; the time is when the run ends whatever happens. `unbegun`: it was cut before it began.
    """

    stop: StopRecord
    at_s: float
    late_s: float
    drawn_s: float
    ready_s: float = -math.inf
    comes_s: float | None = None
    never: bool = False
    unbegun: bool = False


def delays_of(result: RunResult, setup: Setup) -> tuple[LatenessGrowth, ...]:
    """Every growth of lateness of a run, by stock and time."""
    seen, end_s = (
        _JournalFacts(frozenset(result.stock_ids)),
        max(setup.latest_end_s, result.end_step / STEPS_PER_S),
    )
    for entry in result.journal.entries:
        if not is_of_crossing(entry.event):
            seen.take(entry)
    for course in result.courses:
        if isinstance(course.item, ScriptedFault):
            to_s = end_s if course.over_s is None else course.over_s
            seen.fault(str(course.item.fault.target), (course.begun_s, max(to_s, course.begun_s + 1.0)))
    seen.close(end_s)
    by_stock: dict[str, list[StopRecord]] = defaultdict(list)
    for stop in result.stops:
        by_stock[stop.stock_id].append(stop)
    for diagram in setup.timetable.diagrams:
        by_stock.setdefault(diagram.stock_id, [])
    return tuple(
        delay
        for stock_id, stops in by_stock.items()
        for delay in _of_stock(stock_id, stops, seen, setup, result.cut)
    )


def _of_stock(
    stock_id: str, stops: Sequence[StopRecord], seen: _JournalFacts, setup: Setup, cut: Collection[str]
) -> Iterator[LatenessGrowth]:
    """Walks through a set's day; lateness goes on from train to train, and ends where the set leaves the line."""
    late_s, since_s = 0.0, -math.inf
    for moment in (*_moments(stops, seen, setup), *_never_came(stock_id, stops, seen, setup, cut)):
        if moment.comes_s is not None:
            late_s, since_s = 0.0, moment.comes_s
        grown_s = moment.late_s - (0.0 if moment.unbegun else max(late_s, 0.0))
        if grown_s > 0.0:
            yield _split(moment, grown_s, since_s, seen)
        if not moment.stop.cancelled:  # else the set is as late as it was
            late_s, since_s = moment.late_s, moment.at_s


def _moments(stops: Iterable[StopRecord], seen: _JournalFacts, setup: Setup) -> Iterator[_Moment]:
    number, cut = "", False
    for stop in stops:
        begins, number = stop.number != number, stop.number
        if stop.cancelled and (begins or not cut):  # all that is cut of it, once
            planned_s = first_given(stop.planned_arrival_s, stop.planned_departure_s, 0.0)
            late_s = stop.stated_late_s or 0.0
            yield _Moment(stop, planned_s + late_s, late_s, 0.0, unbegun=begins)
        cut = stop.cancelled
        if cut:
            continue
        comes_s, entry_s = _enters(number, seen, setup) if begins else (None, 0.0)
        if stop.arrival_s is not None and stop.planned_arrival_s is not None:
            arrived_late_s = stop.arrival_s - stop.planned_arrival_s
            yield _Moment(stop, stop.arrival_s, arrived_late_s, entry_s, comes_s=comes_s)
            comes_s, entry_s = None, 0.0
        if stop.departure_s is not None and stop.planned_departure_s is not None:
            held = seen.held.get((number, stop.station_id))
            drawn_s = entry_s + (0.0 if held is None else held.people_s + held.doors_s)
            ready_s = -math.inf if comes_s is not None else _ready_s(stop, held, setup)
            left_late_s = stop.departure_s - stop.planned_departure_s
            yield _Moment(stop, stop.departure_s, left_late_s, drawn_s, ready_s, comes_s)


def _enters(number: str, seen: _JournalFacts, setup: Setup) -> tuple[float | None, float]:
    """When a train that enters over a portal stands before it, s, and how late that was drawn; else None."""
    train = setup.timetable.trains[number]
    if not isinstance(train.begins, AtPortal):
        return None, 0.0
    entry_s = seen.came_late_s.get(number, 0.0)
    return train.calls[0].first_s - setup.operation.portal_lead_s + entry_s, entry_s


def _never_came(
    stock_id: str, stops: Sequence[StopRecord], seen: _JournalFacts, setup: Setup, cut: Collection[str]
) -> Iterator[_Moment]:
    """Of each train of a set that did not come to its end, the first arrival from where on it never came; of one that
    calls but once, its departure.
    """
    ran = {stop.number for stop in stops if not stop.cancelled}
    came = {
        (stop.number, stop.station_id) for stop in stops if (stop.arrival_s, stop.departure_s) != (None, None)
    }
    numbers = (d.train_numbers for d in setup.timetable.diagrams if d.stock_id == stock_id)
    for number in (number for each in numbers for number in each):
        train = setup.timetable.trains[number]
        if (number, train.calls[-1].station_id) in came or number in cut:
            continue
        reached = max(
            (k for k, call in enumerate(train.calls) if (number, call.station_id) in came), default=0
        )
        arrivals = (c for c in train.calls[reached + 1 :] if c.stops and c.arrival_s is not None)
        call = next(arrivals, train.calls[-1])
        planned_s, end_s = float(call.first_s), setup.latest_end_s
        stop = StopRecord(stock_id, number, train.revenue, call.station_id, call.track or "", planned_s, None)
        comes_s, entry_s = (None, 0.0) if number in ran else _enters(number, seen, setup)
        yield _Moment(stop, end_s, end_s - planned_s, entry_s, comes_s=comes_s, never=True)


def _ready_s(stop: StopRecord, held: DoorsHeld | None, setup: Setup) -> float:
    """When a train at a stop could leave but for its route, s."""
    dwell_s = setup.unit.dwell_min_s if stop.kind is CallKind.STOP else 0.0
    dwelt_s = 0.0 if stop.arrival_s is None else stop.arrival_s + dwell_s
    return max(stop.planned_departure_s or 0.0, dwelt_s, 0.0 if held is None else held.until_s)


def _split(moment: _Moment, grown_s: float, since_s: float, seen: _JournalFacts) -> LatenessGrowth:
    """Put growth down to what was drawn, to others, to what failed."""
    stop = moment.stop
    if stop.cancelled:
        return LatenessGrowth(stop.stock_id, stop.number, stop.station_id, moment.at_s, grown_s, 0.0, grown_s)
    from_s = max(since_s, moment.ready_s)
    waited_s = _overlap_s(seen.waits[stop.stock_id], from_s, moment.at_s)
    if moment.comes_s is not None:
        until_s = seen.entered_s.get(stop.number, moment.at_s)
        # its own failure keeps it outside
        off_s = _overlap_s(seen.failed[stop.stock_id], moment.comes_s, until_s)
        waited_s += max(until_s - moment.comes_s - SIGNS_ON_S - off_s, 0.0)
    # Of a train that failed all is its failure's; of points or radio, for as long as they did.
    own = _overlap_s(seen.failed[stop.stock_id], since_s, moment.at_s) > 0.0
    failed_s = grown_s if own or moment.never else _overlap_s(seen.beside, from_s, moment.at_s)
    primary_s = min(grown_s, moment.drawn_s)
    secondary_s = min(grown_s - primary_s, waited_s)
    primary_s += min(grown_s - primary_s - secondary_s, failed_s)
    return LatenessGrowth(
        stop.stock_id, stop.number, stop.station_id, moment.at_s, grown_s, primary_s, secondary_s
    )


def _overlap_s(spans: Iterable[Span], from_s: float, to_s: float) -> float:
    """How much of a time spans cover, each moment once, s."""
    total_s, at_s = 0.0, from_s
    for begins_s, ends_s in sorted(spans):
        counted_s = min(ends_s, to_s) - max(begins_s, at_s)
        if counted_s > 0.0:
            total_s, at_s = total_s + counted_s, min(ends_s, to_s)
    return total_s
