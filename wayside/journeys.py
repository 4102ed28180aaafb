"""The day of each stock as fixed data (`wayside.config.Journey`), indexed, and what is kept of how far it has come.

Where all stock is in its day follows from these and from the register (`wayside.places`).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import Any, Final

import msgspec
from msgspec.structs import asdict

from wayside.certificate import CertificateAnswer
from wayside.config import (
    NO_CUTS,
    CutRules,
    DispatcherMeans,
    JourneyMove,
    ManagerConfig,
    OrderRule,
    RouteEntry,
)
from wayside.moves import Move, Train

LOST: Final = -1  # nobody knows how far a stock is in its day


class PlannedMove(JourneyMove, frozen=True, kw_only=True):
    """A move with what it means. As bits: sections where it begins and ends, those of open line on its way, and all on
    its way in their order.
    """

    move: Move
    start: int
    end: int
    line: int
    way: tuple[int, ...] = ()

    def rest(self, held: int) -> Move:
        """The move of a train that has a part of it: what lies behind its first section need not be free any more."""
        first = next((at for at, section in enumerate(self.way) if section & held), 0)
        return Move(sum(self.way[first:]), self.move.keeps, self.move.due_s) if first else self.move


@dataclass(frozen=True, slots=True)
class LineWays:
    """The line as moves need it: sections and queues before portals as bits, and routes by name and by their ends."""

    bits: Mapping[str, int]
    queues: Mapping[str, int]
    open_line: int
    routes: Mapping[str, RouteEntry]
    between: Mapping[tuple[str, str], str]

    def move(self, given: JourneyMove) -> PlannedMove:
        """A move with what it means."""
        return PlannedMove(**asdict(given), **self._meaning(given))

    def turned(self, hop: PlannedMove, here: str, there: str) -> PlannedMove | None:
        """The same move of a train's day from one of two tracks or to one of two; None: no route leads there."""
        route_id = self.between.get((here, there))
        if route_id is None:
            return None
        others = tuple(o for o in (hop.section_id, *hop.others) if o != there)
        turned = msgspec.structs.replace(hop, route_id=route_id, section_id=there, others=others)
        return msgspec.structs.replace(turned, **self._meaning(turned))

    def _meaning(self, given: JourneyMove) -> dict[str, Any]:
        route, end = self.routes.get(given.route_id), self.bits[given.section_id]
        start = 0 if route is None else self.bits[route.from_section]
        needs = end | self.queues.get(given.section_id, 0)
        if route is not None:
            needs = sum(self.bits[s] for s in set(route.section_ids))
        move = Move(needs, 0 if given.leaves else end, given.departs_s)
        way = () if route is None else tuple(self.bits[s] for s in route.section_ids)
        return {"move": move, "start": start, "end": end, "line": needs & self.open_line, "way": way}


@dataclass(frozen=True, slots=True)
class Days:
    """Fixed data, indexed: the day of each stock, and the rules by which routes are given.

    Where tracks are changed, the register has days of its own in which that is so (`with_track`).
    """

    unit_ids: tuple[str, ...]
    hops: tuple[tuple[PlannedMove, ...], ...]
    moves: tuple[tuple[Move, ...], ...]
    index: Mapping[str, int]
    bits: Mapping[str, int]
    queues: Mapping[str, int]
    certificate: bool
    order: OrderRule
    late_s: float
    hold_s_max: float
    overtaken_max: int
    parts: bool
    ways: LineWays
    given: tuple[int, ...] = ()
    may: tuple[DispatcherMeans, ...] = ()
    cuts: CutRules = NO_CUTS

    def trains_cut(self, index: int, place: int, next_train: str) -> tuple[str, ...]:
        """The trains of a stock that lose calls if it goes on as that one from where it is; none: it may not.

        Those that lose all must be allowed to; that others lose some, at that station.
        """
        hops = self.hops[index]
        at = self._goes_on_at(index, place, next_train)
        if at is None:
            return ()
        station = hops[place].begins_at
        numbers = tuple(dict.fromkeys(hop.train for hop in hops[place:at]))
        begun = next(k for k, hop in enumerate(hops) if hop.train == hops[place].train) < place
        whole = numbers[1:] if begun else numbers
        in_part = begun or hops[at - 1].train == next_train
        if in_part and station not in self.cuts.turn_back_at:
            return ()
        whole = tuple(number for number in whole if number != next_train)
        return numbers if set(whole) <= set(self.cuts.trains) else ()

    def _goes_on_at(self, index: int, place: int, next_train: str) -> int | None:
        """The place of a stock's day at which a later train of it leaves the station where a move begins."""
        hops = self.hops[index]
        if place >= len(hops) or not hops[place].begins_at or hops[place].train == next_train:
            return None
        of_it = (k for k in range(place + 1, len(hops)) if hops[k].train == next_train)
        return next((k for k in of_it if hops[k].begins_at == hops[place].begins_at), None)

    def next_trains(self, index: int, place: int) -> tuple[str, ...]:
        """As which of its later trains a stock could go on from where it is to make a move."""
        numbers = dict.fromkeys(hop.train for hop in self.hops[index][place + 1 :])
        return tuple(number for number in numbers if self._goes_on_at(index, place, number) is not None)

    def with_cut(self, index: int, place: int, next_train: str) -> Days | None:
        """With that stock going on as another of its trains from where it is to make a move; None: it has no way."""
        hops = self.hops[index]
        at = self._goes_on_at(index, place, next_train)
        here = None if at is None else self.ways.routes.get(hops[place].route_id)
        if at is None or here is None:
            return None
        first = self.ways.turned(hops[at], here.from_section, hops[at].section_id)
        if first is None:
            return None
        turn_s = next(hop.stays_s for hop in reversed(hops[:at]) if hop.train != next_train)
        before = [
            msgspec.structs.replace(hop, stays_s=turn_s) if k == place - 1 else hop
            for k, hop in enumerate(hops[:place])
        ]
        own = (*before, msgspec.structs.replace(first, others=hops[at].others), *hops[at + 1 :])
        return self._with_hops(index, own)

    def _with_hops(self, index: int, own: tuple[PlannedMove, ...]) -> Days:
        moves = tuple(each.move for each in own)
        return replace(
            self,
            hops=(*self.hops[:index], own, *self.hops[index + 1 :]),
            moves=(*self.moves[:index], moves, *self.moves[index + 1 :]),
        )

    def with_track(self, index: int, place: int, section_id: str) -> Days | None:
        """With that move of a stock ending on another track, and the one after it beginning there; None: it cannot."""
        hops = self.hops[index]
        hop = hops[place]
        route = self.ways.routes.get(hop.route_id)
        turned = None if route is None else self.ways.turned(hop, route.from_section, section_id)
        if turned is None or hop.leaves or section_id not in hop.others:
            return None
        changed = [turned]
        if place + 1 < len(hops):
            following = self.ways.turned(hops[place + 1], section_id, hops[place + 1].section_id)
            if following is None:
                return None
            changed.append(following)
        return self._with_hops(index, (*hops[:place], *changed, *hops[place + len(changed) :]))


class DayProgress(msgspec.Struct, frozen=True):
    """How far a stock is in its day. `done`: moves granted. `late_s`: how late it asked for the last of them.

    `asked_s`: since when it asks for the next one in vain; `held_s`: since when the order of trains holds it back;
    `overtaken`: how many were let on over its way meanwhile. `said`: what the journal said of it last.
    `part`: it was granted a part of its next move. `granted_s`: when the last one was granted. `orders`: how many it
    was given about that move or the next one; `own_way`: it has refused to go there otherwise, `keeps`: to give its
    route back. `back_s`: until when it asks for none, if it has given its route back as it was asked to. `next_train`:
    as which train it was ordered to go on from where it stands; `whole`: it has refused that, or was asked too often.
    `cut_s`: when that was weighed last.
    """

    done: int = 0
    late_s: float = 0.0
    asked_s: float | None = None
    held_s: float | None = None
    overtaken: int = 0
    astray: bool = False
    said: str = ""
    part: bool = False
    granted_s: float = -inf
    orders: int = 0
    own_way: bool = False
    keeps: bool = False
    back_s: float = -inf
    next_train: str = ""
    whole: bool = False
    cut_s: float = -inf

    def asks(self, now_s: float) -> DayProgress:
        """With it asking for its next move: since now, or still."""
        return self if self.asked_s is not None else msgspec.structs.replace(self, asked_s=now_s)


class LastCertificate(msgspec.Struct, frozen=True):
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

    def finishes_from(self, stands: Stands) -> bool:
        """Whether it leads all stock from these places to the end of the day."""
        return self.leads_from(stands) and self.until_s == inf


class LastSearch(msgspec.Struct, frozen=True):
    """The last search that found no order of the whole day: from which places, with how many steps, what it found
    instead, until when that is taken as it is, s, and what the journal was told.
    """

    at: tuple[int, ...]
    holds: tuple[int, ...]
    found: CertificateAnswer
    steps: int
    again_s: float
    said: str = ""

    def lasts(self, now_s: float) -> bool:
        """Whether it is not yet time to look again."""
        return now_s < self.again_s


class Stands(msgspec.Struct, frozen=True):
    """All stock with a day: how many moves each has made, and what it holds once it has run what it was granted."""

    at: tuple[int, ...]
    holds: tuple[int, ...]

    def trains(self, days: Days, until_s: float = inf) -> list[Train]:
        """As the search takes them; of their moves those planned to begin before that."""
        places = zip(self.holds, days.moves, self.at, strict=True)
        trains = [Train(held, _before(moves, done, until_s)) for held, moves, done in places]
        return [self._on_its_way(days, index, train) for index, train in enumerate(trains)]

    def next_move(self, days: Days, index: int) -> Move:
        """The next move of a stock, or what is left of it where it has a part."""
        hop, held = days.hops[index][self.at[index]], self.holds[index]
        return hop.rest(held) if days.parts and held & hop.move.needs else hop.move

    def _on_its_way(self, days: Days, index: int, train: Train) -> Train:
        """With what is left of its next move."""
        if not days.parts or not train.ahead:
            return train
        return Train(train.holds, (self.next_move(days, index), *train.ahead[1:]))

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


def could_leave_s(days: Days, stands: Stands, index: int, trip: DayProgress) -> float:
    """When a stock can leave where its last move ends, as late as it left; at once, if it asks. s."""
    at = stands.at[index]
    if at == 0 or trip.asked_s is not None:
        return trip.back_s
    before = days.hops[index][at - 1]
    return max(trip.back_s, before.arrives_s + trip.late_s + before.stays_s)


def overdue_s(days: Days, stands: Stands, index: int, trip: DayProgress, held: int, now_s: float) -> float:
    """For how long a stock that has not asked could have left, s. One that is on its way (`held`) is not overdue."""
    at, hops = stands.at[index], days.hops[index]
    if trip.asked_s is not None or at == len(hops) or held & ~stands.holds[index]:
        return 0.0
    return max(0.0, now_s - max(hops[at].departs_s, could_leave_s(days, stands, index, trip)))


NEW: Final = DayProgress()
UNKNOWN: Final = DayProgress(LOST)


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
    between = {(route.from_section, route.section_ids[-1]): route.route_id for route in config.routes}
    ways = LineWays(bits, queues, line, routes, between)
    hops = tuple(tuple(map(ways.move, journey.moves)) for journey in given.journeys)
    unit_ids = tuple(journey.unit_id for journey in given.journeys)
    index = {unit_id: index for index, unit_id in enumerate(unit_ids)}
    return Days(
        unit_ids,
        hops,
        tuple(tuple(hop.move for hop in each) for each in hops),
        index,
        bits,
        queues,
        given.certificate,
        given.order,
        given.late_s,
        given.hold_s_max,
        given.overtaken_max,
        given.parts,
        ways,
        tuple(index[unit_id] for unit_id in given.given if unit_id in index),
        given.may,
        given.cuts,
    )


def next_hop(days: Days, index: int, done: int, route_id: str, portal: str) -> int | None:
    """The move that a stock asks for: its next one, or the first later one of that name."""
    for place in range(done, len(days.hops[index])):
        hop = days.hops[index][place]
        if hop.route_id == route_id and (route_id or hop.section_id == portal):
            return place
    return None
