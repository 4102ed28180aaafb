"""By what lateness grew, between two times of a set that were planned: by itself, or because it waited for others.

Growth between an arrival or departure and the next is put down, in this order, to what was drawn for that stop (late to
the portal, passengers, doors), to waiting for what another train had (secondary, knock-on delay), and to what failed of
the train or beside the track meanwhile (primary, too). What is left is driving, and a plan of whole minutes. Of a set
that turns back late the next train grows no later by that: it was late before. Spare time takes growth back, so that
the sum of all is more than what trains are late in the end.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final

from network.timetable import AtPortal
from simulation.events import MANAGER, CameLate, DoorsHeld, Entered
from simulation.faults.script import Failure
from simulation.result import RunResult, StopRecord
from simulation.setup import STEPS_PER_S, Setup
from wayside.said import Accepted, Granted, Refused

SIGNS_ON_S: Final = (
    5.0  # a train that comes to its portal is on the line so soon, if nothing stands in its way
)
READS: Final = (
    Accepted,
    CameLate,
    DoorsHeld,
    Entered,
    Granted,
    Refused,
)  # events that a journal must have kept
Span = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Delay:
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


@dataclass(slots=True)
class _Seen:
    """What the journal says of all stocks."""

    stock_ids: frozenset[str]
    waits: dict[str, list[Span]] = field(
        default_factory=lambda: defaultdict(list)
    )  # refused for another, by stock
    held: dict[tuple[str, str], DoorsHeld] = field(default_factory=dict[tuple[str, str], DoorsHeld])
    came_late_s: dict[str, float] = field(default_factory=dict[str, float])  # by train
    entered_s: dict[str, float] = field(default_factory=dict[str, float])
    faults: list[tuple[str, Span]] = field(default_factory=list[tuple[str, Span]])  # by target


def delays_of(result: RunResult, setup: Setup) -> tuple[Delay, ...]:
    """Every growth of lateness of a run, by stock and time."""
    seen = _seen(result)
    by_stock: dict[str, list[StopRecord]] = defaultdict(list)
    for stop in result.stops:
        by_stock[stop.stock_id].append(stop)
    return tuple(delay for stops in by_stock.values() for delay in _of_stock(stops, seen, setup))


def _seen(result: RunResult) -> _Seen:
    seen, end_s = _Seen(frozenset(result.stock_ids)), result.end_step / STEPS_PER_S
    refused_s: dict[str, float] = {}
    for entry in result.journal.entries:
        match entry.event:
            case Refused(unit_id=unit, other_id=other) if entry.who == MANAGER and other:
                refused_s.setdefault(unit, entry.t_s)
            case Granted(unit_id=unit) | Accepted(unit_id=unit) if unit in refused_s:
                seen.waits[unit].append((refused_s.pop(unit), entry.t_s))
            case DoorsHeld(train=number, station=station):
                seen.held[number, station] = entry.event
            case CameLate(train=number, late_s=late_s):
                seen.came_late_s[number] = late_s
            case Entered(train=number):
                seen.entered_s[number] = entry.t_s
            case _:
                pass
    for unit, from_s in refused_s.items():
        seen.waits[unit].append((from_s, end_s))
    for course in result.courses:
        if isinstance(course.item, Failure):
            to_s = end_s if course.over_s is None else course.over_s
            seen.faults.append(
                (str(course.item.fault.target), (course.begun_s, max(to_s, course.begun_s + 1.0)))
            )
    return seen


@dataclass(frozen=True, slots=True)
class _Moment:
    """A planned time as it came: an arrival or a departure, s. `drawn_s`: what was drawn for the stop or the entry.

    `ready_s`: from when on waiting for others counts; `comes_s`: when a train that enters stood before its portal.
    """

    stop: StopRecord
    at_s: float
    late_s: float
    drawn_s: float
    ready_s: float
    comes_s: float | None = None


def _of_stock(stops: Iterable[StopRecord], seen: _Seen, setup: Setup) -> Iterator[Delay]:
    """Walks through a set's day; lateness goes on from train to train, and ends where the set leaves the line."""
    late_s = since_s = 0.0
    for moment in _moments(stops, seen, setup):
        if moment.comes_s is not None:
            late_s, since_s = 0.0, moment.comes_s
        grown_s = moment.late_s - max(late_s, 0.0)
        if grown_s > 0.0:
            yield _split(moment, grown_s, since_s, seen)
        late_s, since_s = moment.late_s, moment.at_s


def _moments(stops: Iterable[StopRecord], seen: _Seen, setup: Setup) -> Iterator[_Moment]:
    number = ""
    for stop in stops:
        begins, number = stop.number != number, stop.number
        train, comes_s, entry_s = setup.timetable.trains[number], None, 0.0
        if begins and isinstance(train.begins, AtPortal):
            entry_s = seen.came_late_s.get(number, 0.0)
            comes_s = train.calls[0].first_s - setup.operation.portal_lead_s + entry_s
        if stop.arrival_s is not None and stop.planned_arrival_s is not None:
            arrived_late_s = stop.arrival_s - stop.planned_arrival_s
            yield _Moment(stop, stop.arrival_s, arrived_late_s, entry_s, 0.0, comes_s)
            comes_s, entry_s = None, 0.0
        if stop.departure_s is not None and stop.planned_departure_s is not None:
            held = seen.held.get((number, stop.station_id))
            drawn_s = entry_s + (0.0 if held is None else held.people_s + held.doors_s)
            ready_s = 0.0 if comes_s is not None else _ready_s(stop, held, setup)
            left_late_s = stop.departure_s - stop.planned_departure_s
            yield _Moment(stop, stop.departure_s, left_late_s, drawn_s, ready_s, comes_s)


def _ready_s(stop: StopRecord, held: DoorsHeld | None, setup: Setup) -> float:
    """When a train at a stop could leave but for its route, s."""
    dwell_s = setup.unit.dwell_min_s if stop.passengers else 0.0
    dwelt_s = 0.0 if stop.arrival_s is None else stop.arrival_s + dwell_s
    return max(stop.planned_departure_s or 0.0, dwelt_s, 0.0 if held is None else held.until_s)


def _split(moment: _Moment, grown_s: float, since_s: float, seen: _Seen) -> Delay:
    """Put growth down to what was drawn, to others, to what failed."""
    stop = moment.stop
    from_s = max(since_s, moment.ready_s)
    waited_s = _overlap_s(seen.waits[stop.stock_id], from_s, moment.at_s)
    if moment.comes_s is not None:
        outside_s = seen.entered_s.get(stop.number, moment.at_s) - moment.comes_s - SIGNS_ON_S
        waited_s += max(outside_s, 0.0)
    failed_s = _overlap_s(
        (span for target, span in seen.faults if _concerns(target, stop.stock_id, seen)), since_s, moment.at_s
    )
    primary_s = min(grown_s, moment.drawn_s)
    secondary_s = min(grown_s - primary_s, waited_s)
    primary_s += min(grown_s - primary_s - secondary_s, failed_s)
    return Delay(stop.stock_id, stop.number, stop.station_id, moment.at_s, grown_s, primary_s, secondary_s)


def _concerns(target: str, stock_id: str, seen: _Seen) -> bool:
    """Whether a fault is the stock's own, or of what all use; a link is of the stock that it names."""
    words = target.split()
    return stock_id in words or not any(word in seen.stock_ids for word in words)


def _overlap_s(spans: Iterable[Span], from_s: float, to_s: float) -> float:
    """How much of a time spans cover, each moment once, s."""
    total_s, at_s = 0.0, from_s
    for begins_s, ends_s in sorted(spans):
        counted_s = min(ends_s, to_s) - max(begins_s, at_s)
        if counted_s > 0.0:
            total_s, at_s = total_s + counted_s, min(ends_s, to_s)
    return total_s
