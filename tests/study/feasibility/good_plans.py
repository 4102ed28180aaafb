"""Plans drawn by chance that work by the way they are made; nothing here asks the check.

Sets are put on a drawn line one by one. Each goes from end to end some times, with slack running times and stays drawn
by chance. Everything that it uses is kept in a book of who has what from when to when, with some room on either side; a
set for which the book has no room is tried again at another time, and left out in the end.
"""

import math
from dataclasses import dataclass, field, replace

from network.errors import InputError
from tests.study.feasibility.plans import Plan, line_of
from tests.system.chaos.draw import Draw
from tests.system.chaos.ground import Call, Planned
from tests.system.chaos.lines import DrawnLine, drawn_line
from tests.system.chaos.timetables import Stop, mirrored

FIRST_S = 9 * 3600
ROOM_S = 20  # between two sets on anything
LEAD_S = 240  # a train from a portal may be there this long before its first call
PORTAL_RUN_S = 150
TURN_BACK_S = 100
TRIES = 80

Key = tuple[str, ...]


@dataclass
class Book:
    """Who has what: intervals by key."""

    taken: dict[Key, list[tuple[float, float]]] = field(default_factory=dict)

    def free(self, wanted: list[tuple[Key, float, float]]) -> bool:
        return not any(
            from_s < other_to_s + ROOM_S and other_from_s < to_s + ROOM_S
            for key, from_s, to_s in wanted
            for other_from_s, other_to_s in self.taken.get(key, [])
        )

    def enter(self, wanted: list[tuple[Key, float, float]]) -> None:
        for key, from_s, to_s in wanted:
            self.taken.setdefault(key, []).append((from_s, to_s))


@dataclass
class Trip:
    """A set on its way: what it uses, and its trains so far."""

    wanted: list[tuple[Key, float, float]] = field(default_factory=list)
    trains: list[Planned] = field(default_factory=list)
    stands_from_s: float = -math.inf
    stands_on: Key = ()


def good_plan(seed: int) -> Plan:
    """The plan of a seed."""
    draw = Draw(seed, ("good plan",))
    drawn = _line(seed, draw)
    line = line_of(drawn.text, drawn.id)
    halts = frozenset(s.id for s in line.stations.values() if s.is_halt)
    book = Book()
    trains: list[Planned] = []
    for number in range(draw.of("sets").whole(2, 6)):
        for attempt in range(TRIES):
            trip = _trip(f"K{number + 1}", drawn, halts, draw.of(f"set {number}", f"try {attempt}"))
            if book.free(trip.wanted):
                book.enter(trip.wanted)
                trains += trip.trains
                break
    return Plan(line, tuple(trains))


def _line(seed: int, draw: Draw) -> DrawnLine:
    """A drawn line; one in some hundred is no file that can be read, by the rounding of its end, and drawn again."""
    for attempt in range(TRIES):
        try:
            return drawn_line(f"good_{seed}", draw.of("line", str(attempt)))
        except InputError:
            continue
    raise AssertionError(seed)


def _trip(stock: str, drawn: DrawnLine, halts: frozenset[str], draw: Draw) -> Trip:
    """One set's day: from a portal or a track at one end, some times along the line, and off it or to stay."""
    ways = {"down": list(drawn.stops), "up": mirrored(drawn.stops)}
    whole_minutes = draw.chance(0.5)
    direction = draw.one_of(("down", "up"))
    now_s = float(FIRST_S + draw.whole(0, 5400))
    trips = draw.whole(1, 3)
    trip = Trip()
    for k in range(trips):
        stops = ways[direction]
        from_portal = k == 0 and bool(stops[0].portal) and draw.chance(0.7)
        to_portal = k == trips - 1 and bool(stops[-1].portal) and draw.chance(0.7)
        begins = f"portal:{stops[0].portal}" if from_portal else "stabled" if k == 0 else f"from:{stock}{k}"
        last = "stabled" if k == trips - 1 else f"becomes:{stock}{k + 2}"
        ends = f"portal:{stops[-1].portal}" if to_portal else last
        train = Planned(stock, f"{stock}{k + 1}", direction, begins, ends, ())
        now_s = _run(trip, train, stops, halts, now_s, draw.of(f"trip {k}"), whole_minutes=whole_minutes)
        now_s += TURN_BACK_S + draw.whole(0, 900)
        direction = "up" if direction == "down" else "down"
    if trip.stands_on:
        trip.wanted.append((trip.stands_on, trip.stands_from_s, math.inf))
    return trip


def _run(
    trip: Trip,
    train: Planned,
    stops: list[Stop],
    halts: frozenset[str],
    now_s: float,
    draw: Draw,
    *,
    whole_minutes: bool,
) -> float:
    """One train along the line from `now_s`; when it is at its end, s."""

    def up_to(time_s: float) -> int:
        return math.ceil(time_s / 60.0) * 60 if whole_minutes else math.ceil(time_s)

    calls: list[Call] = []
    from_portal, to_portal = train.begins.startswith("portal"), train.ends.startswith("portal")
    arrival_s = departure_s = up_to(now_s)
    left_s = 0
    own = ""  # the last station that is no halt
    for k, stop in enumerate(stops):
        first, last = k == 0, k == len(stops) - 1
        if not first:
            arrival_s = up_to(departure_s + stop.run_s)
        stays_s = (
            draw.whole(25, 60)
            if stop.station in halts
            else draw.one_of((draw.whole(25, 90), draw.whole(60, 600)))
        )
        departure_s = arrival_s if first and not from_portal else up_to(arrival_s + stays_s)
        track = (
            "1" if stop.tracks < 2 else trip.stands_on[2] if first and trip.stands_on else draw.one_of("12")
        )
        calls.append(
            Call(
                stop.station,
                track,
                None if first and not from_portal else arrival_s,
                None if last and not to_portal else departure_s,
            )
        )
        if stop.station in halts:
            continue
        key = ("track", stop.station, track)
        if first:
            _start(trip, stop, key, arrival_s, from_portal=from_portal)
        else:
            _hop(trip, (own, stop.station), key, left_s, arrival_s)
        own, left_s = stop.station, departure_s
    if to_portal:
        out_s = left_s + PORTAL_RUN_S
        trip.wanted += [
            (trip.stands_on, trip.stands_from_s, out_s),
            (("portal", stops[-1].station), left_s, out_s),
            (("throat", stops[-1].station, "portal"), left_s, out_s),
        ]
        trip.stands_on = ()
    trip.trains.append(replace(train, calls=tuple(calls)))
    return float(arrival_s)


def _start(trip: Trip, stop: Stop, key: Key, arrival_s: float, *, from_portal: bool) -> None:
    """Where the set is when its train begins."""
    if from_portal:
        trip.stands_on, trip.stands_from_s = key, arrival_s - LEAD_S
        trip.wanted += [
            (("portal", stop.station), arrival_s - LEAD_S, arrival_s),
            (("throat", stop.station, "portal"), arrival_s - LEAD_S, arrival_s),
        ]
    elif not trip.stands_on:
        trip.stands_on, trip.stands_from_s = key, -math.inf


def _hop(trip: Trip, stations: tuple[str, str], key: Key, left_s: float, arrival_s: float) -> None:
    """From station to station: the track left is free when the next one is reached, which is taken on leaving."""
    here, there = stations
    low, high = sorted(stations)
    trip.wanted += [
        (trip.stands_on, trip.stands_from_s, arrival_s),
        (("between", low, high), left_s, arrival_s),
        (("throat", here, there), left_s, arrival_s),
        (("throat", there, here), left_s, arrival_s),
    ]
    trip.stands_on, trip.stands_from_s = key, left_s
