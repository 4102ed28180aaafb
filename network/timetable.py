"""Timetables (ダイヤ): what trains are planned, and which train set runs them (運用).

Times are seconds after midnight of the operating day and go on growing after the next midnight.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, TypeVar

from network.clock import clock, first_given
from network.errors import InputError
from network.files.line_schema import DIRECTIONS
from network.files.quantities import SPEED
from network.files.timetable_schema import CallTable, HeadTable, TimetableFile, TrainTable
from network.files.toml_input import one_of, parse_toml, read_text
from network.graph import reachable_stops
from network.model import Direction, Line, PlatformTrack, SectionKind

DAY_S: Final = 86_400
# files write hours up to 29; what is later is found again from what is before
WRITTEN_S_END: Final = 30 * 3600
LAST_S_MAX: Final = 3 * DAY_S  # assumed: a run is of one day, and some hours around it
_TIME: Final = re.compile(r"([01]\d|2[0-9]):([0-5]\d)(?::([0-5]\d))?")


class CallKind(Enum):
    """What a train does at a station of its timetable."""

    STOP = "stop"  # for passengers (客扱い)
    OPERATIONAL = "operational"  # stands with its doors closed, to be met or overtaken, for a crew (運転停車)
    PASS = "pass"  # runs through (通過)


@dataclass(frozen=True, slots=True)
class Call:
    """A train at a station, on `track` or, when None, on the usual one of the train's direction.

    In `exchange`, before a source is joined to a line, station and track are named as the source names them. Only the
    last call may lack a departure; an arrival may be left out everywhere but there. Where a train passes,
    `departure_s` is when, and there is no arrival; the first and the last call are stops. `inferred`: one of its times
    is not the source's but computed.
    """

    station_id: str
    track: str | None
    arrival_s: int | None
    departure_s: int | None
    kind: CallKind = CallKind.STOP
    inferred: bool = False

    @property
    def stops(self) -> bool:
        """Whether the train stands here, for passengers or not."""
        return self.kind is not CallKind.PASS

    @property
    def first_s(self) -> int:
        """Arrival, or departure where no arrival is given, s."""
        return first_given(self.arrival_s, self.departure_s, 0)

    @property
    def last_s(self) -> int:
        """Departure, or arrival where no departure is given, s."""
        return first_given(self.departure_s, self.arrival_s, 0)


@dataclass(frozen=True, slots=True)
class AtPortal:
    """The train comes in from another line, or goes out to it, over a portal section."""

    section_id: str


@dataclass(frozen=True, slots=True)
class Stabled:
    """The train stands on its first (last) call's track before it begins (after it ends) (留置)."""


@dataclass(frozen=True, slots=True)
class FromTrain:
    """The set arrived as another train (折返し)."""

    number: str


@dataclass(frozen=True, slots=True)
class BecomesTrain:
    """The set goes on as another train (折返し)."""

    number: str


Begin = AtPortal | Stabled | FromTrain
End = AtPortal | Stabled | BecomesTrain
OtherTrain = TypeVar("OtherTrain", FromTrain, BecomesTrain)


@dataclass(frozen=True, slots=True)
class TimetableTrain:
    """A train (列車) as planned."""

    number: str
    direction: Direction
    revenue: bool
    calls: tuple[Call, ...]
    begins: Begin
    ends: End

    @property
    def due_calls(self) -> tuple[Call, ...]:
        """Its calls without the times that it cannot keep: no arrival where it begins on the line, and no departure
        where it ends there.
        """
        calls = list(self.calls)
        if not isinstance(self.begins, AtPortal):
            calls[0] = replace(calls[0], arrival_s=None)
        if not isinstance(self.ends, AtPortal):
            calls[-1] = replace(calls[-1], departure_s=None)
        return tuple(calls)


@dataclass(frozen=True, slots=True)
class Diagram:
    """One train set (編成) and the trains it runs, in order (運用)."""

    stock_id: str
    train_numbers: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Timetable:
    """A validated timetable; every train is in exactly one diagram."""

    head: HeadTable
    trains: Mapping[str, TimetableTrain]
    diagrams: tuple[Diagram, ...]


def no_trains(line: Line, dwell_min_s: float) -> Timetable:
    """A day of `line` on which nothing runs, for what is asked of line and stock alone."""
    return Timetable(HeadTable(id="none", line=line.id, dwell_min_s=dwell_min_s), {}, ())


def load_timetable(path: Path, line: Line) -> Timetable:
    """Read a timetable of `line`. Raises InputError for the first thing that is wrong with it."""
    return parse_timetable(read_text(path), str(path), line)


def parse_timetable(text: str, file: str, line: Line) -> Timetable:
    """Parse and validate the text of a timetable; `file` names it in errors. Raises InputError."""
    return timetable_of(parse_toml(text, file, TimetableFile), file, line)


def timetable_of(entry: TimetableFile, file: str, line: Line) -> Timetable:
    """The timetable that the tables of a file describe; `file` names it in errors. Raises InputError."""
    head = entry.timetable
    if head.line != line.id:
        raise InputError(file, "timetable.line", head.line, f"{line.id}, the line it is used with")
    trains: dict[str, TimetableTrain] = {}
    for i, item in enumerate(entry.trains):
        if item.number in trains:
            raise InputError(file, f"trains[{i}].number", item.number, "a number of its own")
        trains[item.number] = _train(file, f"trains[{i}]", item, line)
    keys = {number: f"trains[{i}]" for i, number in enumerate(trains)}
    diagrams = tuple(Diagram(item.stock, tuple(item.trains)) for item in entry.diagrams)
    _check_each_once(file, keys, diagrams)
    for i, diagram in enumerate(diagrams):
        _shift_past_midnight(trains, diagram)
        _check_diagram(file, f"diagrams[{i}]", keys, trains, diagram)
        last_s = trains[diagram.train_numbers[-1]].calls[-1].last_s
        if last_s > LAST_S_MAX:
            expected = f"trains in order of time that end within {LAST_S_MAX // 3600} h"
            raise InputError(file, f"diagrams[{i}].trains", list(diagram.train_numbers), expected)
    return Timetable(head, trains, diagrams)


def platform_of(line: Line, call: Call, direction: Direction) -> PlatformTrack:
    """Where a train in `direction` calls: the track named, else the usual one, else any with a mark.

    Raises KeyError when the station has no such track (a validated timetable has none of these).
    """
    usable = [track for track in line.stations[call.station_id].tracks if direction in track.marks_m]
    if call.track is not None:
        usable = [track for track in usable if track.name == call.track]
    usable.sort(key=lambda track: direction not in track.directions)
    if not usable:
        raise KeyError(f"{call.station_id} has no track {call.track or ''} {direction.name.lower()}")
    return usable[0]


def _train(file: str, key: str, entry: TrainTable, line: Line) -> TimetableTrain:
    direction = DIRECTIONS[entry.direction]
    calls: list[Call] = []
    for i, item in enumerate(entry.calls):
        where = f"{key}.calls[{i}]"
        after_s = calls[-1].last_s if calls else None
        _check_times(file, where, item, after_s, last=i == len(entry.calls) - 1)
        call = call_of(file, where, item, after_s)
        _check_place(file, where, line, call, direction)
        if entry.revenue:
            _check_platform(file, where, line, call, direction)
        if calls:
            _check_order(file, where, line, calls[-1], call, direction)
        calls.append(call)
    begins = _beyond(file, f"{key}.begins", entry.begins, "from", FromTrain)
    ends = _beyond(file, f"{key}.ends", entry.ends, "becomes", BecomesTrain)
    if isinstance(begins, AtPortal):
        _check_portal(file, f"{key}.begins", line, begins, calls[0], direction, entering=True)
    else:
        _check_has_track(file, f"{key}.calls[0].station", line, calls[0])
    if isinstance(ends, AtPortal):
        _check_portal(file, f"{key}.ends", line, ends, calls[-1], direction, entering=False)
    else:
        _check_has_track(file, f"{key}.calls[{len(calls) - 1}].station", line, calls[-1])
    return TimetableTrain(entry.number, direction, entry.revenue, tuple(calls), begins, ends)


def seconds_of(file: str, key: str, text: str, not_before_s: int | None) -> int:
    """Seconds after midnight; a time over 12 h less than the one before is one of the next day."""
    match = _TIME.fullmatch(text)
    if match is None:
        raise InputError(file, key, text, "a time HH:MM or HH:MM:SS (24:00 to 29:59 are after midnight)")
    hours, minutes, seconds = (int(part or 0) for part in match.groups())
    time_s = hours * 3600 + minutes * 60 + seconds
    if not_before_s is None:
        return time_s
    while time_s < not_before_s - DAY_S // 2:
        time_s += DAY_S
    if time_s < not_before_s:
        raise InputError(file, key, text, f"a time not before {clock(not_before_s)}")
    return time_s


def time_text(time_s: int, after_s: int | None = None) -> str:
    """HH:MM, with :SS where there are seconds; hours from 30 on are those of the day after.

    With the time before it, one over 12 h later is left as it is, which no file takes: it would be read as another.
    """
    lost = after_s is not None and time_s - after_s > DAY_S // 2
    text = clock(time_s if time_s < WRITTEN_S_END or lost else time_s % DAY_S)
    return text.removesuffix(":00") if text.count(":") == 2 else text


def put_days(rows: Iterable[dict[str, Any]], timetable: Timetable) -> None:
    """Write 00:10 as 24:10 in the tables of trains, where it is that: then it stays so when what is before is gone."""
    for row in rows:
        for table, call in zip(row["calls"], timetable.trains[row["number"]].calls, strict=True):
            for name, time_s in (
                ("arrival", call.arrival_s),
                ("departure", call.departure_s),
                ("pass", call.last_s),
            ):
                if name in table and time_s is not None and DAY_S <= time_s < WRITTEN_S_END:
                    table[name] = time_text(time_s)


def call_of(file: str, key: str, entry: CallTable, after_s: int | None) -> Call:
    """A call with the times that are written, each after the one before; which belong together is not checked."""
    times_s: dict[str, int] = {}
    for name, text in (("arrival", entry.arrival), ("departure", entry.departure), ("pass", entry.passes)):
        if text is not None:
            times_s[name] = after_s = seconds_of(file, f"{key}.{name}", text, after_s)
    kind = CallKind.OPERATIONAL if entry.operational else CallKind.STOP
    if "pass" in times_s:
        kind, times_s = CallKind.PASS, {"departure": times_s["pass"]}
    arrival_s, departure_s = times_s.get("arrival"), times_s.get("departure")
    return Call(entry.station, entry.track, arrival_s, departure_s, kind, entry.inferred)


def _check_times(file: str, key: str, entry: CallTable, after_s: int | None, *, last: bool) -> None:
    """Which times a call of a whole timetable has."""
    if entry.passes is not None:
        _check_passing(file, key, entry, after_s, last=last)
    elif entry.departure is None and not last:
        raise InputError(file, f"{key}.departure", None, "a departure: only the last call goes without")
    elif entry.departure is None and entry.arrival is None:
        raise InputError(file, f"{key}.arrival", None, "a time: the call has none")


def _check_passing(file: str, key: str, entry: CallTable, after_s: int | None, *, last: bool) -> None:
    """A station that the train runs through has one time, and lies between stops."""
    if entry.arrival is not None or entry.departure is not None or entry.operational:
        other = (
            "operational" if entry.operational else "arrival" if entry.arrival is not None else "departure"
        )
        raise InputError(
            file, f"{key}.{other}", getattr(entry, other), "nothing beside pass: it does not stop"
        )
    if after_s is None or last:
        raise InputError(
            file, f"{key}.pass", entry.passes, "arrival or departure: its first and last call are stops"
        )


def _check_place(file: str, key: str, line: Line, call: Call, direction: Direction) -> None:
    if call.station_id not in line.stations:
        raise InputError(file, f"{key}.station", call.station_id, one_of(line.stations, call.station_id))
    usable = [track.name for track in line.stations[call.station_id].tracks if direction in track.marks_m]
    if not usable:
        expected = f"a station with a stopping mark for trains going {direction.name.lower()}"
        raise InputError(file, f"{key}.station", call.station_id, expected)
    if call.track is not None and call.track not in usable:
        expected = f"a track with a mark for trains going {direction.name.lower()}, {one_of(usable)}"
        raise InputError(file, f"{key}.track", call.track, expected)


def _check_has_track(file: str, key: str, line: Line, call: Call) -> None:
    """A train that does not come from, or go to, a portal begins and ends on a track of its own."""
    if line.stations[call.station_id].is_halt:
        stations = [station.id for station in line.stations.values() if not station.is_halt]
        expected = (
            f"a station where a train can begin and end, {one_of(stations, call.station_id)}: this is a halt"
        )
        raise InputError(file, key, call.station_id, expected)


def _check_platform(file: str, key: str, line: Line, call: Call, direction: Direction) -> None:
    """Passengers get on and off at a platform."""
    if call.kind is CallKind.STOP and platform_of(line, call, direction).platform_m is None:
        expected = "operational = true: the track has no platform"
        raise InputError(file, f"{key}.station", call.station_id, expected)


def _check_order(file: str, key: str, line: Line, before: Call, call: Call, direction: Direction) -> None:
    """Calls follow each other in the direction of travel, and a run between two takes time."""
    step_m = line.stations[call.station_id].position_m - line.stations[before.station_id].position_m
    if step_m * direction <= 0:
        expected = f"a station beyond {before.station_id} for a train going {direction.name.lower()}"
        raise InputError(file, f"{key}.station", call.station_id, expected)
    if call.first_s <= before.last_s:
        name = "departure" if call.arrival_s is None else "arrival"
        expected = f"a time after {clock(before.last_s)}, the departure from {before.station_id}"
        raise InputError(file, f"{key}.{name}", clock(call.first_s), expected)
    least_s = abs(step_m) / (SPEED.spans[-1][1] / 3.6)
    if call.first_s - before.last_s < math.floor(least_s):
        name = "departure" if call.arrival_s is None else "arrival"
        expected = f"at least {least_s:.0f} s for {abs(step_m) / 1000:.1f} km from {before.station_id}"
        raise InputError(file, f"{key}.{name}", clock(call.first_s), f"{expected}: no train is faster")


def _beyond(
    file: str, key: str, text: str, word: str, train: type[OtherTrain]
) -> Stabled | AtPortal | OtherTrain:
    """Where a train comes from, or goes to; `word`: what says that it is another `train`."""
    kind, _, name = text.partition(":")
    if (kind, name) == ("stabled", ""):
        return Stabled()
    if name and kind in ("portal", word):
        return AtPortal(name) if kind == "portal" else train(name)
    raise InputError(file, key, text, f"stabled, portal:<section id> or {word}:<train number>")


def _check_portal(
    file: str, key: str, line: Line, portal: AtPortal, call: Call, direction: Direction, *, entering: bool
) -> None:
    """The portal exists and there is a way between it and the first (last) call."""
    section_id = portal.section_id
    value = f"portal:{section_id}"
    portals = [section.id for section in line.sections.values() if section.kind is SectionKind.PORTAL]
    if section_id not in portals:
        raise InputError(file, key, value, f"a portal section, {one_of(portals, section_id)}")
    if line.stations[call.station_id].is_halt:
        return
    track = platform_of(line, call, direction).section_id
    start, goal = (section_id, track) if entering else (track, section_id)
    if goal not in reachable_stops(line, start, direction):
        way = "to the first call" if entering else "from the last call"
        expected = f"a portal with a way {way}, {call.station_id}, going {direction.name.lower()}"
        raise InputError(file, key, value, expected)


def _check_each_once(file: str, keys: Mapping[str, str], diagrams: Iterable[Diagram]) -> None:
    """Every train in exactly one diagram, every set in one diagram."""
    owner: dict[str, str] = {}
    stock: dict[str, str] = {}
    for i, diagram in enumerate(diagrams):
        if diagram.stock_id in stock:
            expected = f"a set of its own; {stock[diagram.stock_id]} runs with this one"
            raise InputError(file, f"diagrams[{i}].stock", diagram.stock_id, expected)
        stock[diagram.stock_id] = f"diagrams[{i}]"
        for j, number in enumerate(diagram.train_numbers):
            key = f"diagrams[{i}].trains[{j}]"
            if number not in keys:
                raise InputError(file, key, number, one_of(keys, number))
            if number in owner:
                raise InputError(
                    file, key, number, f"a train in one diagram only; it is also {owner[number]}"
                )
            owner[number] = key
    for number, key in keys.items():
        if number not in owner:
            raise InputError(file, f"{key}.number", number, "a train that is in one of the diagrams")


def _shift_past_midnight(trains: dict[str, TimetableTrain], diagram: Diagram) -> None:
    """A train that begins over 12 h before the set's train before it ended runs on the next day."""
    ended_s = 0
    for number in diagram.train_numbers:
        train = trains[number]
        while train.calls[0].first_s < ended_s - DAY_S // 2:
            train = replace(train, calls=tuple(_next_day(call) for call in train.calls))
        trains[number] = train
        ended_s = train.calls[-1].last_s


def _next_day(call: Call) -> Call:
    arrival_s = None if call.arrival_s is None else call.arrival_s + DAY_S
    departure_s = None if call.departure_s is None else call.departure_s + DAY_S
    return replace(call, arrival_s=arrival_s, departure_s=departure_s)


def _check_diagram(
    file: str, key: str, keys: Mapping[str, str], trains: Mapping[str, TimetableTrain], diagram: Diagram
) -> None:
    """Each train begins as, where and after the one before it ended."""
    ours = [trains[number] for number in diagram.train_numbers]
    first, last = ours[0], ours[-1]
    if isinstance(first.begins, FromTrain):
        expected = f"stabled or portal: it is the first train of set {diagram.stock_id}"
        raise InputError(file, f"{keys[first.number]}.begins", f"from:{first.begins.number}", expected)
    if isinstance(last.ends, BecomesTrain):
        expected = f"stabled or portal: it is the last train of set {diagram.stock_id}"
        raise InputError(file, f"{keys[last.number]}.ends", f"becomes:{last.ends.number}", expected)
    for i, (before, after) in enumerate(pairwise(ours), start=1):
        _check_change(file, f"{key}.trains[{i}]", keys, before, after)


def _check_change(
    file: str, key: str, keys: Mapping[str, str], before: TimetableTrain, after: TimetableTrain
) -> None:
    begins, ends = keys[after.number] + ".begins", keys[before.number] + ".ends"
    if isinstance(after.begins, FromTrain) and after.begins.number != before.number:
        expected = f"from:{before.number}, the train before it in its diagram"
        raise InputError(file, begins, f"from:{after.begins.number}", expected)
    if isinstance(before.ends, BecomesTrain) and before.ends.number != after.number:
        expected = f"becomes:{after.number}, the train after it in its diagram"
        raise InputError(file, ends, f"becomes:{before.ends.number}", expected)
    # A set that left by one portal may come back by another, as on the two tracks of a main line.
    partner = {BecomesTrain: FromTrain, Stabled: Stabled, AtPortal: AtPortal}[type(before.ends)]
    if type(after.begins) is not partner:
        written = {FromTrain: f"from:{before.number}", Stabled: "stabled", AtPortal: "portal:<section id>"}
        wanted = written[partner]
        raise InputError(file, begins, begins_text(after.begins), f"{wanted}, as train {before.number} ends")
    last, first = before.calls[-1], after.calls[0]
    if partner is not AtPortal:
        if first.station_id != last.station_id:
            expected = f"a train from {last.station_id}, where train {before.number} ends"
            raise InputError(file, key, after.number, f"{expected}; it begins at {first.station_id}")
        if None not in (first.track, last.track) and first.track != last.track:
            where = f"{keys[after.number]}.calls[0].track"
            raise InputError(file, where, first.track, f"{last.track}, where train {before.number} stands")
    if first.first_s < last.last_s:
        expected = f"a train that begins after {clock(last.last_s)}, when train {before.number} ends"
        raise InputError(file, key, after.number, f"{expected}; it begins at {clock(first.first_s)}")


def begins_text(begins: Begin) -> str:
    """How a train begins, as files write it."""
    match begins:
        case AtPortal(section_id):
            return f"portal:{section_id}"
        case FromTrain(number):
            return f"from:{number}"
        case Stabled():
            return "stabled"


def ends_text(ends: End) -> str:
    """How a train ends, as files write it."""
    match ends:
        case AtPortal(section_id):
            return f"portal:{section_id}"
        case BecomesTrain(number):
            return f"becomes:{number}"
        case Stabled():
            return "stabled"
