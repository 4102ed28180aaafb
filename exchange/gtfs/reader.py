"""A GTFS feed as a published timetable: one day, its trains by rail, with what was left out said.

A trip before 03:00 is the end of the day before; times go on beyond 24:00 as the feed has them. Platforms are tracks
(platform_code) of their parent_station. Trips of one block are run by one set. Where nobody may get on or off a train
stands for other reasons (運転停車), and a trip of such calls alone is an empty working.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Final

from exchange.gtfs import columns
from exchange.gtfs.days import date_of, next_date, one_service, read_services
from exchange.gtfs.stops import GtfsStop, read_stops
from exchange.gtfs.tables import Feed
from exchange.published import PublishedTimetable, PublishedTrain, some_names
from exchange.station_order import ordered_stations, runs_down
from network.clock import clock, first_given
from network.errors import COMMAND_LINE, InputError
from network.files.names import title_of
from network.files.toml_input import one_of
from network.timetable import Call, CallKind

DAY_BEGINS_S: Final = 3 * 3600
CALLS_MAX: Final = 2000  # of one trip
_DAY_S: Final = 86_400
_LONG_S: Final = 6 * 3600  # between two calls: said, because a time is likely wrong
_TIME: Final = re.compile(r"(\d{1,3}):([0-5]\d):([0-5]\d)")
# Route types of rail, those of the extended list with them; buses, ferries and the like are left out.
_RAIL: Final = (range(3), range(5, 8), range(12, 13), range(100, 118), range(400, 406), range(900, 907))
_KINDS: Final = {kind.value: kind for kind in CallKind}


@dataclass(frozen=True, slots=True)
class GtfsChoice:
    """What of a feed is wanted: a date (YYYY-MM-DD) or a service id, and routes by id or short name (none: by rail)."""

    date: str = ""
    service: str = ""
    routes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class WrittenTrain:
    """A trip with times, tracks and kinds as they were planned, and how it begins and ends."""

    train: PublishedTrain
    begins: str
    ends: str


@dataclass(frozen=True, slots=True)
class OwnFeed:
    """What we have written into a feed: head and diagrams of a timetable file (JSON), and its trains in order."""

    head: str
    trains: tuple[WrittenTrain, ...]


@dataclass(frozen=True, slots=True)
class GtfsDay:
    """A published timetable, and how much the whole feed holds: trips, stops that are called at, calls.

    `written` is what we have written into the feed ourselves, None for a feed of somebody else's.
    """

    published: PublishedTimetable
    trips: int
    stops: int
    calls: int
    written: OwnFeed | None = None


@dataclass(slots=True)
class _GtfsTrip:
    id: str
    route: str
    service: str
    number: str
    down: bool
    block: str
    revenue: str
    begins: str
    ends: str
    calls: list[tuple[int, _Call]] = field(default_factory=list["tuple[int, _Call]"])


@dataclass(frozen=True, slots=True)
class _Call:
    """A row of stop_times; `no_passengers` where nobody may get on or off; what follows is in our own feeds alone."""

    stop: str
    arrival_s: int | None
    departure_s: int | None
    no_passengers: bool
    kind: str
    given: str
    track: str | None
    inferred: bool


@dataclass(slots=True)
class _Left:
    """Trips that are left out, by reason."""

    by_reason: dict[str, list[str]] = field(default_factory=dict[str, list[str]])

    def note(self, reason: str, trip: _GtfsTrip) -> None:
        """One more."""
        self.by_reason.setdefault(reason, []).append(trip.number)

    def sentences(self) -> tuple[str, ...]:
        """What is left, each with how many and some of them."""
        return tuple(
            f"{len(names)} {reason}: {some_names(names)}" for reason, names in self.by_reason.items()
        )


def read_gtfs(path: Path, choice: GtfsChoice | None = None) -> GtfsDay:
    """Read one day of a feed, a zip archive or a folder. Raises InputError, one for whatever is wrong with it."""
    wanted = choice or GtfsChoice()
    feed = Feed.at_path(path)
    routes = _routes(feed)
    trips = _trips(feed, routes)
    stops = read_stops(feed)
    called, calls = _read_calls(feed, trips, stops)
    written = _written(feed, trips, stops)
    left = _Left()
    ours = _of_routes(path, trips.values(), routes, wanted.routes, left)
    ours = _of_day(feed, ours, wanted, left)
    ours = _whole(feed, ours, stops, left)
    if not ours:
        raise InputError(
            str(path), "trips.txt", None, f"a trip by rail on that day ({'; '.join(left.sentences())})"
        )
    runs = [(_stations_of(trip, stops), trip.down) for trip in ours]
    order = ordered_stations(runs)
    places = {key: i for i, key in enumerate(order)}
    trains = tuple(
        _train(trip, stops, runs_down(run, places, says_down=trip.down))
        for trip, (run, _) in zip(ours, runs, strict=True)
    )
    published = PublishedTimetable(
        name=_name(routes, {trip.route for trip in ours}),
        stations=tuple(stops.published(key) for key in order),
        trains=trains,
        source=str(path),
        left=(*left.sentences(), *_long_runs(trains), *_tables_left(feed)),
    )
    return GtfsDay(published, len(trips), len(called), calls, written)


def _routes(feed: Feed) -> dict[str, tuple[int, str, str]]:
    """Type, short and long name of each route by id."""
    file = f"{feed.path}: routes.txt"
    found: dict[str, tuple[int, str, str]] = {}
    for row in feed.rows("routes.txt", ("route_id", "route_type"), ("route_short_name", "route_long_name")):
        route_id, kind, short, long = row.texts
        if route_id in found:
            raise InputError(file, f"line {row.line}.route_id", route_id, "an id of its own")
        if not kind.isdecimal() or len(kind) > 4:
            raise InputError(
                file, f"line {row.line}.route_type", kind, "a number of GTFS's list of route types"
            )
        found[route_id] = (int(kind), short, long)
    return found


def _trips(feed: Feed, routes: Mapping[str, object]) -> dict[str, _GtfsTrip]:
    file = f"{feed.path}: trips.txt"
    more = ("trip_short_name", "direction_id", "block_id", columns.REVENUE, columns.BEGINS, columns.ENDS)
    trips: dict[str, _GtfsTrip] = {}
    for row in feed.rows("trips.txt", ("route_id", "service_id", "trip_id"), more):
        route, service, trip_id, number, direction, block, revenue, begins, ends = row.texts
        if route not in routes:
            raise InputError(file, f"line {row.line}.route_id", route, one_of(routes, route))
        if not trip_id or trip_id in trips:
            raise InputError(file, f"line {row.line}.trip_id", trip_id, "an id of its own")
        if direction not in ("", "0", "1"):
            raise InputError(file, f"line {row.line}.direction_id", direction, "0, 1 or nothing")
        trips[trip_id] = _GtfsTrip(
            trip_id, route, service, number or trip_id, direction != "1", block, revenue, begins, ends
        )
    return trips


def _read_calls(
    feed: Feed, trips: Mapping[str, _GtfsTrip], stops: Mapping[str, GtfsStop]
) -> tuple[set[str], int]:
    """Put the rows of stop_times to their trips, in order; stops that are called at, and how many rows there are."""
    file = f"{feed.path}: stop_times.txt"
    needed = ("trip_id", "stop_id", "stop_sequence", "arrival_time", "departure_time")
    own = columns.TRACK in feed.columns("stop_times.txt")
    called: set[str] = set()
    calls = 0
    more = ("pickup_type", "drop_off_type", "timepoint", columns.CALL, columns.TIMES, columns.TRACK)
    for row in feed.rows("stop_times.txt", needed, more):
        trip_id, stop, sequence, arrival, departure, pickup, drop_off, timepoint, kind, given, track = (
            row.texts
        )
        key = f"line {row.line}"
        if trip_id not in trips:
            raise InputError(file, f"{key}.trip_id", trip_id, "a trip of trips.txt")
        if stop not in stops:
            raise InputError(file, f"{key}.stop_id", stop, "a stop of stops.txt")
        if not sequence.isdecimal() or len(sequence) > 9:
            raise InputError(file, f"{key}.stop_sequence", sequence, "a whole number")
        if kind and kind not in _KINDS:
            raise InputError(file, f"{key}.{columns.CALL}", kind, one_of(_KINDS, kind))
        trip = trips[trip_id]
        if len(trip.calls) >= CALLS_MAX:
            raise InputError(file, f"{key}.trip_id", trip_id, f"a trip of at most {CALLS_MAX} calls")
        call = _Call(
            stop,
            _seconds(file, f"{key}.arrival_time", arrival),
            _seconds(file, f"{key}.departure_time", departure),
            pickup == columns.NO_PASSENGERS and drop_off == columns.NO_PASSENGERS,
            kind,
            given,
            track if own else None,
            own and timepoint == columns.INFERRED,
        )
        trip.calls.append((int(sequence), call))
        called.add(stop)
        calls += 1
    for trip in trips.values():
        trip.calls.sort(key=lambda item: item[0])
        if any(before[0] == after[0] for before, after in pairwise(trip.calls)):
            raise InputError(file, "stop_sequence", trip.id, "a trip whose calls have numbers of their own")
        _check_times(file, trip)
    return called, calls


def _seconds(file: str, key: str, text: str) -> int | None:
    if not text:
        return None
    match = _TIME.fullmatch(text)
    if match is None or int(match[1]) >= 100:
        raise InputError(file, key, text, "a time H:MM:SS before 100:00:00")
    return int(match[1]) * 3600 + int(match[2]) * 60 + int(match[3])


def _check_times(file: str, trip: _GtfsTrip) -> None:
    """Times of a trip do not go back, and its first and last call have one."""
    last_s = 0
    for i, (_, call) in enumerate(trip.calls):
        for what, time_s in (("arrival_time", call.arrival_s), ("departure_time", call.departure_s)):
            if time_s is None:
                continue
            if time_s < last_s:
                raise InputError(
                    file, f"{what} of trip {trip.id}", clock(time_s), f"a time not before {clock(last_s)}"
                )
            last_s = time_s
        if i in (0, len(trip.calls) - 1) and call.arrival_s is None and call.departure_s is None:
            raise InputError(
                file, f"arrival_time of trip {trip.id}", None, f"a time at {call.stop}, an end of it"
            )


def _of_routes(
    path: Path,
    trips: Iterable[_GtfsTrip],
    routes: Mapping[str, tuple[int, str, str]],
    wanted: Sequence[str],
    left: _Left,
) -> list[_GtfsTrip]:
    """Trips of the routes that are wanted, else of all by rail."""
    for name in wanted:
        if not any(name in (route_id, short) for route_id, (_, short, _) in routes.items()):
            raise InputError(COMMAND_LINE, "--route", name, one_of(routes, name))
    kept: list[_GtfsTrip] = []
    for trip in trips:
        kind, short, _ = routes[trip.route]
        if wanted:
            if trip.route in wanted or short in wanted:
                kept.append(trip)
            else:
                left.note("trips of other routes", trip)
        elif any(kind in kinds for kinds in _RAIL):
            kept.append(trip)
        else:
            left.note(f"trips that are not by rail (route_type {kind}, route {short or trip.route})", trip)
    if not kept:
        raise InputError(str(path), "routes.txt", None, "a route by rail; say --route to take another")
    return kept


def _of_day(feed: Feed, trips: Sequence[_GtfsTrip], wanted: GtfsChoice, left: _Left) -> list[_GtfsTrip]:
    """Trips of one operating day, from 03:00 to 03:00."""
    services = read_services(feed)
    if wanted.date:
        date = date_of(COMMAND_LINE, "--date", wanted.date)
        today, tomorrow = services.running_on(date), services.running_on(next_date(date))
    else:
        counts: dict[str, int] = {}
        for trip in trips:
            counts[trip.service] = counts.get(trip.service, 0) + 1
        if wanted.service and wanted.service not in counts:
            raise InputError(COMMAND_LINE, "--service", wanted.service, one_of(counts, wanted.service))
        today = tomorrow = frozenset((wanted.service or one_service(counts),))
    kept: list[_GtfsTrip] = []
    for trip in trips:
        early = bool(trip.calls) and _first_s(trip.calls[0][1]) < DAY_BEGINS_S
        if trip.service not in (tomorrow if early else today):
            left.note("trips of other days", trip)
            continue
        if early:
            trip.calls = [(i, _next_day(call)) for i, call in trip.calls]
        kept.append(trip)
    return kept


def _next_day(call: _Call) -> _Call:
    return replace(
        call,
        arrival_s=None if call.arrival_s is None else call.arrival_s + _DAY_S,
        departure_s=None if call.departure_s is None else call.departure_s + _DAY_S,
    )


def _first_s(call: _Call) -> int:
    return first_given(call.arrival_s, call.departure_s, 0)


def _whole(
    feed: Feed, trips: Iterable[_GtfsTrip], stops: Mapping[str, GtfsStop], left: _Left
) -> list[_GtfsTrip]:
    """Trips with a time of their own and two stations at least, and none twice; in order of time."""
    headway: set[str] = set()
    if feed.has_table("frequencies.txt"):
        headway = {row.texts[0] for row in feed.rows("frequencies.txt", ("trip_id",))}
    kept: list[_GtfsTrip] = []
    for trip in trips:
        stations = _stations_of(trip, stops)
        if trip.id in headway:
            left.note("trips given by headway (frequencies.txt)", trip)
        elif len(stations) < 2:
            left.note("trips with less than two stations", trip)
        elif len(set(stations)) < len(stations):
            left.note("trips that come twice to one station", trip)
        else:
            kept.append(trip)
    return sorted(kept, key=lambda trip: (_first_s(trip.calls[0][1]), trip.number, trip.id))


def _stations_of(trip: _GtfsTrip, stops: Mapping[str, GtfsStop]) -> tuple[str, ...]:
    """Stations in order of travel; two calls in a row at one, as at two platforms, count once."""
    keys = [stops[call.stop].station for _, call in trip.calls]
    return tuple(key for i, key in enumerate(keys) if i == 0 or keys[i - 1] != key)


def _train(trip: _GtfsTrip, stops: Mapping[str, GtfsStop], down: bool) -> PublishedTrain:
    plain = [call for _, call in trip.calls]
    revenue = trip.revenue != "0" if trip.revenue else not all(call.no_passengers for call in plain)
    calls = tuple(_call(call, i, len(plain), stops, revenue=revenue) for i, call in enumerate(plain))
    return PublishedTrain(
        trip.number,
        "down" if down else "up",
        calls,
        revenue=revenue,
        comes_from=_portal(trip.begins),
        goes_to=_portal(trip.ends),
        working=trip.block,
    )


def _portal(text: str) -> str:
    return text.removeprefix("portal:") if text.startswith("portal:") else ""


def _call(call: _Call, index: int, count: int, stops: Mapping[str, GtfsStop], *, revenue: bool) -> Call:
    """A call; at the ends of a trip a feed has to write two times, and the same one again is none of the plan's."""
    arrival_s, departure_s = call.arrival_s, call.departure_s
    kind = _KINDS.get(call.kind)
    if kind is None:
        kind = CallKind.OPERATIONAL if call.no_passengers and revenue else CallKind.STOP
    first, last = index == 0, index == count - 1
    if kind is CallKind.PASS:
        arrival_s, departure_s = None, departure_s if departure_s is not None else arrival_s
    elif call.given == "departure" or (not call.given and first and departure_s == arrival_s):
        arrival_s = None
    elif call.given == "arrival" or (not call.given and last and departure_s == arrival_s):
        departure_s = None
    stop = stops[call.stop]
    track = stop.track if call.track is None else call.track
    return Call(stop.station, track or None, arrival_s, departure_s, kind, call.inferred)


def _name(routes: Mapping[str, tuple[int, str, str]], used: set[str]) -> str:
    names = [routes[name][2] or routes[name][1] or name for name in sorted(used)]
    return title_of(names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more")


def _long_runs(trains: Iterable[PublishedTrain]) -> list[str]:
    """Trains with hours between two calls: taken as they are, and said, because a time is likely wrong."""
    found: list[str] = []
    for train in trains:
        times = [t for call in train.calls for t in (call.arrival_s, call.departure_s) if t is not None]
        if any(after - before > _LONG_S for before, after in pairwise(times)):
            found.append(train.number)
    return (
        [f"taken, but over {_LONG_S // 3600} h lie between two calls: {some_names(found)}"] if found else []
    )


def _tables_left(feed: Feed) -> list[str]:
    """Tables that nothing here reads."""
    known = ("shapes.txt", "transfers.txt", "fare_attributes.txt", "pathways.txt")
    found = [name for name in known if feed.has_table(name)]
    return [f"tables: {', '.join(found)}"] if found else []


def _written(feed: Feed, trips: Mapping[str, _GtfsTrip], stops: Mapping[str, GtfsStop]) -> OwnFeed | None:
    """What we have written into a feed ourselves, with its times as they stand there."""
    if columns.TIMETABLE not in feed.columns("feed_info.txt"):
        return None
    head = next((row.texts[0] for row in feed.rows("feed_info.txt", (columns.TIMETABLE,))), "")
    trains = tuple(
        WrittenTrain(_train(trip, stops, down=trip.down), trip.begins, trip.ends) for trip in trips.values()
    )
    return OwnFeed(head, trains) if head else None
