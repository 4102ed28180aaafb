"""Where every stock is in its day, as the block manager can know it: from what it granted and what is held.

Fixed data: the moves of each stock's day (`wayside.config.Journey`). What the register adds: how many of them were
granted. A move counts as made when it is granted, since its train can always run what it holds; one that is given back
is to be made again. A stock that asks for what is not in its day is astray until it asks for something that is: nothing
is known of where it goes, so nobody is held for it, and it is held for nobody.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, Final

from wayside.certificate import Found, Move, Train
from wayside.config import JourneyMove, ManagerConfig, Order

if TYPE_CHECKING:
    from wayside.register import Register

LOST: Final = -1  # nobody knows how far a stock is in its day


@dataclass(frozen=True, slots=True)
class Hop:
    """A move with what it means. As bits: sections where it begins and ends, and those of open line on its way."""

    train: str
    route_id: str
    section_id: str
    leaves: bool
    departs_s: float
    arrives_s: float
    stays_s: float
    move: Move
    start: int
    end: int
    line: int


@dataclass(frozen=True, slots=True)
class Days:
    """Fixed data, indexed: the day of each stock, and the rules by which routes are given."""

    unit_ids: tuple[str, ...]
    hops: tuple[tuple[Hop, ...], ...]
    moves: tuple[tuple[Move, ...], ...]
    index: Mapping[str, int]
    bits: Mapping[str, int]
    queues: Mapping[str, int]
    certificate: bool
    order: Order
    late_s: float
    hold_s_max: float
    overtaken_max: int


@dataclass(frozen=True, slots=True)
class Trip:
    """How far a stock is in its day. `done`: moves granted. `late_s`: how late it asked for the last of them.

    `asked_s`: since when it asks for the next one in vain; `held_s`: since when the order of trains holds it back;
    `overtaken`: how many were let on over its way meanwhile. `said`: what the journal said of it last.
    """

    done: int = 0
    late_s: float = 0.0
    asked_s: float | None = None
    held_s: float | None = None
    overtaken: int = 0
    astray: bool = False
    said: str = ""


@dataclass(frozen=True, slots=True)
class Kept:
    """The order of the last certificate, and the places and holdings of all stock from which it leads.

    `until_s`: it has the moves planned to begin before that, as the whole day has no order.
    """

    at: tuple[int, ...]
    holds: tuple[int, ...]
    order: tuple[int, ...]
    until_s: float = inf

    def leads_from(self, stands: Stands) -> bool:
        """Whether it is of these places."""
        return (self.at, self.holds) == (stands.at, stands.holds)


@dataclass(frozen=True, slots=True)
class Sought:
    """The last search that found no order of the whole day: from which places, with how many steps, what it found
    instead, until when that is taken as it is, s, and what the journal was told.
    """

    at: tuple[int, ...]
    holds: tuple[int, ...]
    found: Found
    steps: int
    again_s: float
    said: str = ""

    def at_places(self, stands: Stands) -> bool:
        """Whether it was from these places."""
        return (self.at, self.holds) == (stands.at, stands.holds)

    def lasts(self, now_s: float) -> bool:
        """Whether it is not yet time to look again."""
        return now_s < self.again_s


@dataclass(frozen=True, slots=True)
class Stands:
    """All stock with a day: how many moves each has made, and what it holds once it has run what it was granted."""

    at: tuple[int, ...]
    holds: tuple[int, ...]

    def trains(self, days: Days, until_s: float = inf) -> list[Train]:
        """As the search takes them; of their moves those planned to begin before that."""
        places = zip(self.holds, days.moves, self.at, strict=True)
        return [Train(held, _before(moves, done, until_s)) for held, moves, done in places]

    def after(self, days: Days, index: int) -> Stands:
        """With one stock a move further."""
        done = self.at[index]
        at = (*self.at[:index], done + 1, *self.at[index + 1 :])
        keeps = days.moves[index][done].keeps
        return Stands(at, (*self.holds[:index], keeps, *self.holds[index + 1 :]))


def _before(moves: tuple[Move, ...], done: int, until_s: float) -> tuple[Move, ...]:
    return moves[done : max(done, bisect_left(moves, until_s, key=_due_s))]


def _due_s(move: Move) -> float:
    return move.due_s


NEW: Final = Trip()
UNKNOWN: Final = Trip(LOST)


def days_of(config: ManagerConfig) -> Days | None:
    """The fixed data; None where nothing but the register decides."""
    given = config.dispatch
    if not given.weighs:
        return None
    bits = {section.section_id: 1 << index for index, section in enumerate(config.sections)}
    portals = [section.section_id for section in config.sections if section.portal]
    queues = {portal: 1 << (len(bits) + index) for index, portal in enumerate(portals)}
    line = sum(bits[section.section_id] for section in config.sections if section.open_line)
    routes = {route.route_id: route for route in config.routes}

    def hop_of(given: JourneyMove) -> Hop:
        route, end = routes.get(given.route_id), bits[given.section_id]
        start = 0 if route is None else bits[route.from_section]
        needs = (
            end | queues[given.section_id] if route is None else sum(bits[s] for s in set(route.section_ids))
        )
        move = Move(needs, 0 if given.leaves else end, given.departs_s)
        times = given.departs_s, given.arrives_s, given.stays_s
        name = given.train, given.route_id, given.section_id
        return Hop(*name, given.leaves, *times, move, start, end, needs & line)

    hops = tuple(tuple(map(hop_of, journey.moves)) for journey in given.journeys)
    unit_ids = tuple(journey.unit_id for journey in given.journeys)
    return Days(
        unit_ids,
        hops,
        tuple(tuple(hop.move for hop in each) for each in hops),
        {unit_id: index for index, unit_id in enumerate(unit_ids)},
        bits,
        queues,
        given.certificate,
        given.order,
        given.late_s,
        given.hold_s_max,
        given.overtaken_max,
    )


def stands_of(register: Register, days: Days) -> Stands:
    """Where all stock is, from the register. What is astray holds nothing here: it is in its own way."""
    held = dict.fromkeys(days.unit_ids, 0)
    for section_id, unit_id in register.holders.items():
        if unit_id in held:
            held[unit_id] |= days.bits[section_id]
    at: list[int] = []
    holds: list[int] = []
    for index, unit_id in enumerate(days.unit_ids):
        done, mask = _place(register, days, index, held[unit_id])
        at.append(done)
        holds.append(mask)
    return Stands(tuple(at), tuple(holds))


def trip_of(register: Register, unit_id: str) -> Trip:
    """How far a stock is in its day, as it was last known."""
    return register.trips.get(unit_id, UNKNOWN if register.trips_lost else NEW)


def next_hop(days: Days, index: int, done: int, route_id: str, portal: str) -> int | None:
    """The move that a stock asks for: its next one, or the first later one of that name."""
    for place in range(done, len(days.hops[index])):
        hop = days.hops[index][place]
        if hop.route_id == route_id and (route_id or hop.section_id == portal):
            return place
    return None


def with_trip(register: Register, unit_id: str, trip: Trip) -> Register:
    """The register with this known of a stock's day."""
    return replace(register, trips={**register.trips, unit_id: trip})


def _place(register: Register, days: Days, index: int, held: int) -> tuple[int, int]:
    """How many moves a stock has made, and what it holds once it has run what it was granted."""
    unit_id, hops = days.unit_ids[index], days.hops[index]
    trip = trip_of(register, unit_id)
    if trip.astray:
        return len(hops), 0
    done = trip.done if trip.done != LOST else _by_time(register.now_s, hops, held)
    if not held:
        enters = next((i for i in range(done, len(hops)) if not hops[i].route_id), len(hops))
        waits = enters < len(hops) and trip.asked_s is not None
        return enters, days.queues[hops[enters].section_id] if waits else 0
    place = done
    while place and hops[place - 1].train == hops[done - 1].train:
        hop = hops[place - 1]
        if hop.end & held:
            return place, hop.move.keeps
        place -= 1
        if hop.move.needs & held:  # given back on the way: it asks for the same again
            break
    return place, held


def _by_time(now_s: float, hops: tuple[Hop, ...], held: int) -> int:
    """The place in its day at which a stock with these sections should be about now; its end where there is none."""
    fits = [
        (abs(hop.departs_s - now_s), place)
        for place, hop in enumerate(hops)
        if (hop.start & held if hop.route_id else not held)
    ]
    if hops and hops[-1].end & held:
        fits.append((abs(hops[-1].arrives_s - now_s), len(hops)))
    return min(fits)[1] if fits else len(hops)
