"""What one set runs in a day (運用), made from trains: links of the source first, else first in, first out.

A set goes on as the train that a published link names. Elsewhere, at each place where trains end and begin, the set
that has stood longest leaves first, after a least time for turning back (折返し). A train that comes from or goes
beyond the line does so over a portal. So does, where a portal lies right behind the station, a set with no further work
there, and one whose track the next train needs; sets outside come back first in, first out. What is left begins and
ends the day stabled (留置).

Every train is then in exactly one working, and a working goes on where, and not before, the train before it ended.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from exchange.planned import TrainOnLine, Workings
from exchange.portals import PortalWay, portal_of
from exchange.published import some_names
from exchange.sets import SetPlan, give_sets
from exchange.standing import StandBetweenTrains, give_tracks, night_warnings, standing_tracks
from network.errors import InputError
from network.files.names import is_identifier
from network.model import Direction, Line

TURN_MIN_S: Final = 120  # assumed: the driver of a railcar changes ends; the shortest published here is 3 min
OUTSIDE_MIN_S: Final = 1800
_STABLED: Final = "stabled"
_NAMED_MAX: Final = 12  # trains named in one sentence


@dataclass(frozen=True, slots=True)
class SetRules:
    """How sets go round where the source does not say: least times (s) at a place and outside a portal.

    `stock` are the names of the sets there are: those that do not stand on the line in the morning all wait outside,
    and must suffice. Without it as few sets as can run the day are made and named.
    """

    turn_min_s: int = TURN_MIN_S
    outside_min_s: int = OUTSIDE_MIN_S
    stock: tuple[str, ...] = ()


@dataclass(slots=True)
class _Day:
    """Trains in order of time, and what is known so far of how they begin and end."""

    line: Line
    rules: SetRules
    trains: dict[str, TrainOnLine]
    begins: dict[str, str] = field(default_factory=dict[str, str])
    ends: dict[str, str] = field(default_factory=dict[str, str])
    outside: dict[str, str] = field(default_factory=dict[str, str])  # of a portal: where its sets wait
    ways: dict[tuple[str, Direction, bool], PortalWay | None] = field(
        default_factory=dict["tuple[str, Direction, bool]", "PortalWay | None"]
    )
    assumed: list[str] = field(default_factory=list[str])
    warnings: list[str] = field(default_factory=list[str])
    waited: list[str] = field(default_factory=list[str])  # trains for which a set stood there too short

    def link(self, before: str, after: str) -> None:
        """The set of one train goes on as another."""
        self.ends[before] = f"becomes:{after}"
        self.begins[after] = f"from:{before}"

    def way(self, station_id: str, direction: Direction, *, entering: bool) -> PortalWay | None:
        """`portal_of`, looked for once."""
        key = (station_id, direction, entering)
        if key not in self.ways:
            self.ways[key] = portal_of(self.line, station_id, direction, entering=entering)
        return self.ways[key]

    def by_portal(self, way: PortalWay) -> str:
        """As timetable files write it."""
        self.outside[way.section_id] = way.outside
        return f"portal:{way.section_id}"


def workings_of(
    trains: Iterable[TrainOnLine], line: Line, rules: SetRules | None = None, file: str = ""
) -> Workings:
    """How trains of a day begin and end on a line, and the sets that run them.

    `file` names the source in errors. Raises InputError where two trains have one number, or where the sets that
    `rules` name cannot run the day.
    """
    day = _Day(line, rules or SetRules(), _in_order(trains, file))
    _check_stock(day.rules.stock, file)
    _over_portals(day)
    published = _follow_links(day)
    turned = 0
    for station_id in dict.fromkeys(place for train in day.trains.values() for place in _ends_of(train)):
        turned += _turn_round(day, station_id)
    terminals = {points.terminal_id for points in line.points.values()}
    rest = (day.rules.outside_min_s, day.rules.stock, terminals)
    diagrams = give_sets(SetPlan(day.trains, day.begins, day.ends, day.outside, *rest), file)
    _say_rules(day, published, turned)
    stands = tuple(_stands(day))
    day.assumed += _morning_and_evening(day, stands)
    tracks, conflicts = give_tracks(line, tuple(day.trains.values()), stands)
    crowded = (*night_warnings(line, stands), *conflicts)
    day.warnings += crowded
    if tracks:
        day.assumed.append(
            "tracks: where sets stand over, the usual one of the direction, or else the first other that is free"
        )
    return Workings(day.begins, day.ends, diagrams, tuple(day.assumed), tuple(day.warnings), tracks, crowded)


def begins_s(train: TrainOnLine) -> int:
    """When a train's set must be there, s."""
    return train.calls[0].first_s


def ends_s(train: TrainOnLine) -> int:
    """When a train's set is free, s."""
    return train.calls[-1].last_s


def _in_order(trains: Iterable[TrainOnLine], file: str) -> dict[str, TrainOnLine]:
    ordered: dict[str, TrainOnLine] = {}
    for train in sorted(trains, key=lambda train: (begins_s(train), train.number)):
        if train.number in ordered:
            raise InputError(file, "trains", train.number, "a number of its own for each train of the day")
        ordered[train.number] = train
    return ordered


def _check_stock(stock: Sequence[str], file: str) -> None:
    for i, name in enumerate(stock):
        if not is_identifier(name) or name in stock[:i]:
            raise InputError(file, "stock", name, "identifiers of sets, each once")


def _ends_of(train: TrainOnLine) -> tuple[str, str]:
    return train.calls[0].station_id, train.calls[-1].station_id


def _over_portals(day: _Day) -> None:
    """Trains of other lines come in and go out; where the line has no portal there, they end like any other."""
    missing: dict[str, list[str]] = {}
    chosen: set[str] = set()
    for train in day.trains.values():
        for beyond, entering in ((train.from_beyond, True), (train.to_beyond, False)):
            if not beyond:
                continue
            station_id = _ends_of(train)[0 if entering else 1]
            way = day.way(station_id, train.direction, entering=entering)
            if way is None:
                missing.setdefault(station_id, []).append(train.number)
                continue
            (day.begins if entering else day.ends)[train.number] = day.by_portal(way)
            if not way.only:
                chosen.add(way.section_id)
    for station_id, numbers in missing.items():
        name = day.line.stations[station_id].name
        day.warnings.append(
            f"{some_names(numbers, _NAMED_MAX)}: beyond {name} there is no portal; treated as beginning or ending there"
        )
    if chosen:
        day.assumed.append(f"portals: nothing tells {', '.join(sorted(chosen))} from another one as near")


def _follow_links(day: _Day) -> int:
    """Published links between trains of this day; one that cannot be is named. How many were used."""
    used = 0
    pairs = [(t.number, after) for t in day.trains.values() for after in t.becomes]
    pairs += [(before, t.number) for t in day.trains.values() for before in t.follows]
    pairs += _of_workings(day)
    for before, after in dict.fromkeys(pairs):
        why = _no_link(day, before, after)
        if why:
            day.warnings.append(f"the source's link from {before} to {after} is left out: {why}")
            continue
        day.link(before, after)
        used += 1
    return used


def _of_workings(day: _Day) -> Iterator[tuple[str, str]]:
    """Trains that follow each other in a published working, where the set does not leave the line between them."""
    last: dict[str, str] = {}
    for train in day.trains.values():
        if not train.working:
            continue
        before = last.get(train.working)
        last[train.working] = train.number
        if before is not None and before not in day.ends and train.number not in day.begins:
            yield before, train.number


def _no_link(day: _Day, before: str, after: str) -> str:
    """Why one set cannot run both trains; empty where it can."""
    strange = [number for number in (before, after) if number not in day.trains]
    if strange:
        return f"{strange[0]} is no train of this day"
    ended, begun = day.trains[before], day.trains[after]
    last, first = ended.calls[-1].station_id, begun.calls[0].station_id
    reasons = (
        (last != first, f"one ends at {last}, the other begins at {first}"),
        (before in day.ends, f"{before} ends otherwise ({day.ends.get(before)})"),
        (after in day.begins, f"{after} begins otherwise ({day.begins.get(after)})"),
        (before == after or begins_s(begun) < ends_s(ended), f"{after} begins before {before} has ended"),
        (last == first and not standing_tracks(day.line, ended, begun), "no track serves both"),
    )
    return next((text for holds, text in reasons if holds), "")


@dataclass(slots=True)
class _Turns:
    """At one place: pairs of trains with one set, sets never called for, sets that make room and have a portal.

    `waited` are trains for which a set stood there, but had not stood long enough.
    """

    pairs: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])
    idle: list[str] = field(default_factory=list[str])
    full: list[str] = field(default_factory=list[str])
    waited: list[str] = field(default_factory=list[str])


def _turn_round(day: _Day, station_id: str) -> int:
    """Give sets at one place to its departures; how many turned.

    A set with no further work leaves by the portal, where one is right behind the station. That makes room before,
    so the place is gone through again until no such set is left.
    """
    gone: set[str] = set()
    while True:
        turns = _first_in_first_out(day, station_id, gone)
        leaving = {number for number in turns.idle if _portal_behind(day, station_id, number, entering=False)}
        if not leaving:
            break
        gone |= leaving
    for before, after in turns.pairs:
        day.link(before, after)
    for number in (*gone, *turns.full):
        way = _portal_behind(day, station_id, number, entering=False)
        day.ends[number] = day.by_portal(way) if way else _STABLED
    for number in turns.idle:
        day.ends[number] = _STABLED
    for train in day.trains.values():
        if train.calls[0].station_id == station_id and train.number not in day.begins:
            way = _portal_behind(day, station_id, train.number, entering=True)
            day.begins[train.number] = day.by_portal(way) if way else _STABLED
    day.waited += turns.waited
    return len(turns.pairs)


def _first_in_first_out(day: _Day, station_id: str, gone: set[str]) -> _Turns:
    """Sets at one place to its departures, where those in `gone` leave at once."""
    # a halt has one, the line
    room = len({track.section_id for track in day.line.stations[station_id].tracks})
    turns = _Turns()
    linked = 0  # sets that stand here by a published link
    # a set that arrives in the minute in which another leaves was there in time
    for _, leaves, number in sorted(_movements(day, station_id)):
        train = day.trains[number]
        if leaves and number in day.begins:
            linked -= day.begins[number].startswith("from:")
        elif leaves:
            served = [n for n in turns.idle if standing_tracks(day.line, day.trains[n], train)]
            if not served:
                continue
            if begins_s(train) - ends_s(day.trains[served[0]]) < day.rules.turn_min_s:
                turns.waited.append(number)
                continue
            turns.idle.remove(served[0])
            turns.pairs.append((served[0], number))
        elif number in day.ends:
            linked += day.ends[number].startswith("becomes:")
        elif number in gone:
            continue
        else:
            turns.idle.append(number)
            # who comes needs a track too: of those that stand there, the one that leaves last makes room for it
            before = turns.idle[-2] if len(turns.idle) > 1 else number
            if len(turns.idle) + linked > room and _portal_behind(day, station_id, before, entering=False):
                turns.idle.remove(before)
                turns.full.append(before)
    return turns


def _movements(day: _Day, station_id: str) -> Iterator[tuple[int, int, str]]:
    for train in day.trains.values():
        first, last = _ends_of(train)
        if last == station_id:
            yield ends_s(train), 0, train.number
        if first == station_id:
            yield begins_s(train), 1, train.number


def _portal_behind(day: _Day, station_id: str, number: str, *, entering: bool) -> PortalWay | None:
    """The portal next to a station on the side where the train ends (begins), if it has one."""
    if day.line.stations[station_id].is_halt:
        return None
    way = day.way(station_id, day.trains[number].direction, entering=entering)
    return way if way is not None and way.routes == 1 else None


def _stands(day: _Day) -> Iterator[StandBetweenTrains]:
    """Every time that a set stands between two trains, before its first or after its last one."""
    for number, train in day.trains.items():
        begin, end = day.begins[number], day.ends[number]
        if begin == _STABLED:
            yield StandBetweenTrains(train.calls[0].station_id, None, train)
        if end == _STABLED:
            yield StandBetweenTrains(train.calls[-1].station_id, train, None)
        elif end.startswith("becomes:"):
            yield StandBetweenTrains(
                train.calls[-1].station_id, train, day.trains[end.removeprefix("becomes:")]
            )


def _say_rules(day: _Day, published: int, turned: int) -> None:
    """What was assumed of how sets go round; a least time that decided nothing is not an assumption."""
    outside = f"at least {_minutes(day.rules.outside_min_s)} outside the line"
    if published:
        day.assumed.append(f"diagrams: {published} links between trains are the source's")
    if turned and day.outside:
        day.assumed.append(
            f"diagrams: sets turn back and come back from the portal first in, first out, {outside}"
        )
    elif turned:
        day.assumed.append("diagrams: sets turn back first in, first out")
    elif day.outside:
        day.assumed.append(f"diagrams: sets come back from the portal first in, first out, {outside}")
    if day.waited:
        least = _minutes(day.rules.turn_min_s)
        day.assumed.append(
            f"turning back takes {least} at least, so that {some_names(day.waited, _NAMED_MAX)} had another set"
        )


def _minutes(time_s: int) -> str:
    return f"{time_s / 60:g} min"


def _morning_and_evening(day: _Day, stands: Iterable[StandBetweenTrains]) -> Iterator[str]:
    """Where sets stand before and after the day: it can be repeated where both are the same."""
    morning: dict[str, int] = {}
    evening: dict[str, int] = {}
    for stand in stands:
        if stand.arrives is None:
            morning[stand.station_id] = morning.get(stand.station_id, 0) + 1
        elif stand.leaves is None:
            evening[stand.station_id] = evening.get(stand.station_id, 0) + 1
    for station_id in dict.fromkeys((*morning, *evening)):
        before, after = morning.get(station_id, 0), evening.get(station_id, 0)
        if before != after:
            name = day.line.stations[station_id].name
            yield (
                f"stabled sets: {before} at {name} in the morning, {after} in the evening, so that the day can not be "
                "repeated without a working that is not published"
            )
