"""A published timetable on a line of ours: stations joined, trains cut to the line, times that it lacks computed.

What a train does beyond the line is cut off; it then comes from or goes on over a portal. Its direction is that of the
kilometrage, whatever the source calls it. Nothing is changed in silence: what was left out, cut, computed or renamed
stands in sentences (`remarks`), and what a timetable file must own up to in `assumed`.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final

from exchange.branches import branches
from exchange.hidden_meets import hidden_meets
from exchange.planned import TrainOnLine
from exchange.published import PublishedTimetable, PublishedTrain, some_names
from exchange.running import (
    CHANGE_MPS2,
    DWELL_S,
    KnownRunningTimes,
    Running,
    StationRun,
    UntimedError,
    least_s,
    leg_of,
    observed_running,
    plausible_s,
    with_all_times,
)
from exchange.station_join import JoinedBy, StationJoin, join_stations
from exchange.train_numbers import numbers_of
from network.clock import clock
from network.errors import COMMAND_LINE, InputError
from network.files.toml_input import one_of
from network.model import Direction, Line, PlatformTrack, Station
from network.timetable import WRITTEN_S_END, Call, CallKind, platform_of

MOVED_S_MAX: Final = 59  # of whole minutes: what a time may lie after the one that is published
_TRACK_WORDS: Final = re.compile(
    r"番(?:線|乗り?場|のりば)?|号線|乗り場|のりば|ホーム|(?:track|platform|line|no)\.?", re.IGNORECASE
)


OF_OTHER_DAYS: Final = (
    "a number that the source has twice, perhaps for other days (--without NUMBER leaves a train out): {}"
)


@dataclass(frozen=True, slots=True)
class OntoLine:
    """What a published timetable is on a line: trains in order of time, and what has to be said of them."""

    trains: tuple[TrainOnLine, ...]
    join: StationJoin
    assumed: tuple[str, ...]
    remarks: tuple[str, ...]
    elsewhere: int  # trains of the source that do not run on the line


@dataclass(slots=True)
class _UntimedTrain:
    """A train of the source with its calls on the line, before its times are whole."""

    source: PublishedTrain
    number: str
    direction: Direction
    calls: list[Call]
    from_beyond: bool
    to_beyond: bool


@dataclass(slots=True)
class _Remarks:
    """Names of trains (or stations) by what is to be said of them; each is one sentence in the end."""

    by_text: dict[str, list[str]] = field(default_factory=dict[str, list[str]])

    def note(self, text: str, name: str) -> None:
        """One more train of which a sentence is true; `{}` stands for their names."""
        names = self.by_text.setdefault(text, [])
        if name not in names:
            names.append(name)

    def sentences(self) -> tuple[str, ...]:
        """The sentences with names."""
        return tuple(text.replace("{}", some_names(names)) for text, names in self.by_text.items())


def onto_line(
    published: PublishedTimetable,
    line: Line,
    by_hand: Mapping[str, str] | None = None,
    running: Running | None = None,
    *,
    least: Running | None = None,
    least_of: str = "the trains",
    hand_file: str = COMMAND_LINE,
    in_order: bool = True,
    without: Collection[str] = (),
) -> OntoLine:
    """Put a published timetable on a line.

    `by_hand`, `hand_file`, `in_order`: see `join_stations`. `running` gives running times of legs, by which trains are
    there; what it does not know, and all without it, comes from other trains of the timetable. `least` gives those that
    no train takes less than, those of `least_of`; without it they follow from distance and the line's speed. Trains
    `without` are left out, by their numbers on the line.

    Raises InputError where stations cannot be joined, or no train runs on the line.
    """
    file = published.source
    join = join_stations(file, published.stations, line, by_hand, hand_file=hand_file, in_order=in_order)
    remarks = _Remarks()
    cuts, elsewhere = _cut_all(published, line, join, remarks, without)
    times = _times(cuts, line, running, least)
    trains: list[TrainOnLine] = []
    computed = 0
    for cut in cuts:
        try:
            timed = _timed(cut, line, times, remarks)
        except UntimedError as why:
            remarks.note(f"left out: {{}} ({why})", cut.number)
            continue
        trains.append(_planned(cut, timed, line, remarks))
        computed += sum(call.inferred for call in timed)
    if not trains:
        expected = "; ".join((f"one with two stops on {line.id}", *remarks.sentences()))
        raise InputError(file, "trains", f"{len(published.trains)} trains", expected)
    trains.sort(key=lambda train: (train.calls[0].first_s, train.number))
    trains = _linked(trains, cuts, remarks)
    stops = sum(len(train.calls) for train in trains)
    assumed = _assumed(computed, stops, given=running is not None, least_of="" if least is None else least_of)
    meets = tuple(meet.text(line) for meet in hidden_meets(trains, line))
    off = branches(published, line, join.ids)
    all_remarks = (*_of_join(join, line), *off, *remarks.sentences(), *meets)
    return OntoLine(tuple(trains), join, assumed, all_remarks, elsewhere)


def _times(
    cuts: Sequence[_UntimedTrain], line: Line, running: Running | None, least: Running | None
) -> KnownRunningTimes:
    """Running times that somebody gives, else those of the timetable; and the least that there can be on the line."""
    calls = [cut.calls for cut in cuts]

    def at_least(leg: StationRun) -> float:
        length_m = line.stations[leg.to_id].position_m - line.stations[leg.from_id].position_m
        given_s = [of(leg) or 0.0 for of in (running, least) if of is not None]
        return max([plausible_s(length_m, line.max_speed_mps, leg.from_stand + leg.to_stand), *given_s])

    return KnownRunningTimes(
        _first_of(running, observed_running(calls)),
        _first_of(running, least, observed_running(calls, rough=True)),
        at_least,
    )


def _first_of(*known: Running | None) -> Running:
    """What the first knows that knows anything of a leg."""

    def running(leg: StationRun) -> float | None:
        times_s = (of(leg) for of in known if of is not None)
        return next((time_s for time_s in times_s if time_s is not None), None)

    return running


def _cut_all(
    published: PublishedTimetable,
    line: Line,
    join: StationJoin,
    remarks: _Remarks,
    without: Collection[str],
) -> tuple[list[_UntimedTrain], int]:
    """Trains that run on the line, cut to it, and how many do not; what cannot be used is said, and what may be of
    another day.
    """
    found: list[tuple[PublishedTrain, list[Call], bool, bool]] = []
    names = {row.key: row.name for row in join.rows}
    usual = {station.key: station.usual for station in published.stations}
    for train in published.trains:
        joined = [i for i, call in enumerate(train.calls) if call.station_id in join.ids]
        stops = {join.ids[train.calls[i].station_id] for i in joined}
        if len(stops) < 2:
            continue
        before, after = joined[0] > 0, joined[-1] < len(train.calls) - 1
        calls = [train.calls[i] for i in joined]
        for i in set(range(joined[0], joined[-1])) - set(joined):
            name = names[train.calls[i].station_id]
            remarks.note(f"calls at {name}, which is not on the line, are left out: {{}}", train.number)
        found.append((train, calls, before or bool(train.comes_from), after or bool(train.goes_to)))
    numbers = numbers_of((train.number, _runs_down(calls, line, join)) for train, calls, _, _ in found)
    if unknown := [number for number in without if number not in numbers]:
        expected = f"a train of {published.source} on {line.id}: {one_of(sorted(numbers), unknown[0])}"
        raise InputError(COMMAND_LINE, "--without", unknown[0], expected)
    cuts: list[_UntimedTrain] = []
    for (train, calls, before, after), number in zip(found, numbers, strict=True):
        if number in without:
            remarks.note("left out, as asked: {}", number)
            continue
        if number.rpartition("-")[0] == train.number:
            remarks.note(OF_OTHER_DAYS, number)
        if train.said:
            remarks.note(f"the source says of {{}}: {train.said}", number)
        direction = Direction.DOWN if _runs_down(calls, line, join) else Direction.UP
        if not train.number:
            remarks.note("trains without a number are given one: {}", number)
        elif number != train.number:
            remarks.note("numbers: {}", f"{train.number} is {number}")
        try:
            placed = (
                (
                    call,
                    line.stations[join.ids[call.station_id]],
                    usual[call.station_id].get(train.direction, ""),
                )
                for call in calls
            )
            ours = _merged([_call(*each, direction, remarks, number) for each in placed])
            _check_one_way(ours, line, direction)
            cut = _UntimedTrain(train, number, direction, ours, before, after)
            _trim_passes(cut, line, remarks)
        except UntimedError as why:
            remarks.note(f"left out: {{}} ({why})", number)
            continue
        cuts.append(cut)
    return cuts, len(published.trains) - len(found)


def _runs_down(calls: Sequence[Call], line: Line, join: StationJoin) -> bool:
    first, last = (line.stations[join.ids[calls[i].station_id]].position_m for i in (0, -1))
    return last > first


def _call(
    call: Call, station: Station, usual: str, direction: Direction, remarks: _Remarks, number: str
) -> Call:
    """A call at a station of the line, with its track where the line has one of that name; `usual`: the source's name
    of the one that such trains take, which is written where the line has another.
    """
    track = None
    if call.track:
        track = _track_named(call.track, station.tracks, direction)
        if track is None:
            remarks.note(
                f"tracks: {station.name} has no {call.track!r} for trains going {direction.name.lower()}; the usual one"
                " is taken for {}",
                number,
            )
    elif usual and (named := _track_named(usual, station.tracks, direction)):
        own = next(track for track in station.tracks if track.name == named)
        track = None if direction in own.directions else named
    arrival_s, departure_s = call.arrival_s, call.departure_s
    if not call.stops:
        arrival_s, departure_s = None, departure_s if departure_s is not None else arrival_s
    if arrival_s is not None and departure_s is not None and departure_s < arrival_s:
        raise UntimedError(f"it leaves {station.name} at {clock(departure_s)}, before it arrives")
    return Call(station.id, track, arrival_s, departure_s, call.kind, call.inferred)


def _track_named(name: str, tracks: Sequence[PlatformTrack], direction: Direction) -> str | None:
    """The line's name of a track of the source's: the same, or the same without words such as 番線."""
    usable = [track.name for track in tracks if direction in track.marks_m]
    if name in usable:
        return name
    like = [track for track in usable if _track_words(track) == _track_words(name)]
    return like[0] if len(like) == 1 else None


def _track_words(name: str) -> str:
    text = unicodedata.normalize("NFKC", name).casefold()
    return "".join(_TRACK_WORDS.sub("", text).split()) or text


def _merged(calls: Sequence[Call]) -> list[Call]:
    """Calls of which two in a row at one station are one: a source may list a junction once for each branch."""
    found: list[Call] = []
    for call in calls:
        if not found or found[-1].station_id != call.station_id:
            found.append(call)
            continue
        first = found[-1]
        kind = first.kind if first.kind is CallKind.STOP else call.kind
        arrival_s = first.arrival_s if first.arrival_s is not None else call.arrival_s
        departure_s = call.departure_s if call.departure_s is not None else first.departure_s
        arrival_s = None if kind is CallKind.PASS else arrival_s
        track, inferred = call.track or first.track, call.inferred or first.inferred
        found[-1] = Call(call.station_id, track, arrival_s, departure_s, kind, inferred)
    return found


def _check_one_way(calls: Sequence[Call], line: Line, direction: Direction) -> None:
    for before, after in pairwise(calls):
        step_m = line.stations[after.station_id].position_m - line.stations[before.station_id].position_m
        if step_m * direction <= 0:
            raise UntimedError(f"it turns round at {line.stations[before.station_id].name}")


def _trim_passes(cut: _UntimedTrain, line: Line, remarks: _Remarks) -> None:
    """The first and the last call are stops: a train that passes the first station on the line calls at the next."""
    for end, where in ((0, "first"), (-1, "last")):
        while cut.calls and not cut.calls[end].stops:
            call = cut.calls.pop(end)
            name = line.stations[call.station_id].name
            remarks.note(f"passing {name} as the {where} station on the line is left out: {{}}", cut.number)
            if end == 0:
                cut.from_beyond = True
            else:
                cut.to_beyond = True
    if len(cut.calls) < 2:
        raise UntimedError("it stops at less than two stations of the line")


def _timed(cut: _UntimedTrain, line: Line, times: KnownRunningTimes, remarks: _Remarks) -> tuple[Call, ...]:
    """The train's calls with all times; at the ends of its run there is one time, on the way there are two."""
    calls = cut.calls
    first, last = calls[0], calls[-1]
    if first.departure_s is None and first.arrival_s is not None:
        calls[0] = replace(first, departure_s=first.arrival_s, arrival_s=None)
        remarks.note("the one time at the first station is read as the departure of {}", cut.number)
    if not cut.to_beyond and last.departure_s is not None:
        if last.arrival_s is None:
            calls[-1] = replace(last, arrival_s=last.departure_s, departure_s=None)
        elif last.arrival_s == last.departure_s:
            calls[-1] = replace(last, departure_s=None)
    positions_m = [line.stations[call.station_id].position_m for call in calls]
    timed = _spaced(with_all_times(calls, positions_m, times), positions_m, line, cut.number, remarks)
    if timed[0].first_s >= WRITTEN_S_END:
        raise UntimedError(f"it begins at {clock(timed[0].first_s)}, which a day's file does not reach")
    _say_short(timed, times, line, cut.number, remarks)
    return timed


def _say_short(
    calls: Sequence[Call], times: KnownRunningTimes, line: Line, number: str, remarks: _Remarks
) -> None:
    """Legs for which the times leave less than any train takes; the run will be late there."""
    for before, call in pairwise(calls):
        left_s, needed_s = call.first_s - before.last_s, math.ceil(times.least(leg_of(before, call)))
        if left_s < needed_s:
            from_name, to_name = (line.stations[one.station_id].name for one in (before, call))
            remarks.note(
                f"times too short: from {from_name} to {to_name} {left_s} s are left, where at least {needed_s} s are"
                " needed: {}",
                number,
            )


def _spaced(
    timed: Sequence[Call], positions_m: Sequence[float], line: Line, number: str, remarks: _Remarks
) -> tuple[Call, ...]:
    """Times in whole minutes may leave none for a run: within the minute the later time is moved."""
    calls = list(timed)
    for i in range(1, len(calls)):
        before, call = calls[i - 1], calls[i]
        run_s = math.floor(least_s(positions_m[i] - positions_m[i - 1]))
        late_s = before.last_s + run_s - call.first_s
        if late_s <= 0:
            continue
        if late_s > MOVED_S_MAX:
            name = line.stations[call.station_id].name
            raise UntimedError(
                f"its time at {name}, {clock(call.first_s)}, does not follow {clock(before.last_s)}"
            )
        arrival_s = None if call.arrival_s is None else call.arrival_s + late_s
        departure_s = call.departure_s
        if departure_s is not None:
            departure_s = max(departure_s, call.first_s + late_s)
        calls[i] = replace(call, arrival_s=arrival_s, departure_s=departure_s, inferred=True)
        remarks.note("times in one minute with those before are moved by up to a minute: {}", number)
    return tuple(calls)


def _planned(cut: _UntimedTrain, timed: Sequence[Call], line: Line, remarks: _Remarks) -> TrainOnLine:
    """The train; where there is no platform it stands without passengers."""
    calls: list[Call] = []
    revenue = cut.source.revenue
    for call in timed:
        if revenue and call.kind is CallKind.STOP and _without_platform(line, call, cut.direction):
            name = line.stations[call.station_id].name
            remarks.note(f"stops at {name}, which has no platform, are not for passengers: {{}}", cut.number)
            calls.append(replace(call, kind=CallKind.OPERATIONAL))
        else:
            calls.append(call)
    return TrainOnLine(
        cut.number,
        cut.direction,
        tuple(calls),
        revenue,
        cut.source.follows,
        cut.source.becomes,
        cut.from_beyond,
        cut.to_beyond,
        cut.source.working,
    )


def _without_platform(line: Line, call: Call, direction: Direction) -> bool:
    try:
        return platform_of(line, call, direction).platform_m is None
    except KeyError:
        return False  # no mark in this direction: what reads the timetable file says so


def _linked(
    trains: Sequence[TrainOnLine], cuts: Sequence[_UntimedTrain], remarks: _Remarks
) -> list[TrainOnLine]:
    """Links between trains by the numbers that they have here; one to a number that several have is left out."""
    ours: dict[str, list[str]] = {}
    for cut in cuts:
        ours.setdefault(cut.source.number, []).append(cut.number)

    def renamed(numbers: Sequence[str], number: str) -> tuple[str, ...]:
        found: list[str] = []
        for name in numbers:
            match ours.get(name, []):
                case [one]:
                    found.append(one)
                case []:
                    remarks.note("links to trains that are not on the line are left out: {}", number)
                case _:
                    remarks.note(
                        f"links to {name}, which several trains are called, are left out: {{}}", number
                    )
        return tuple(found)

    return [
        replace(
            train, follows=renamed(train.follows, train.number), becomes=renamed(train.becomes, train.number)
        )
        for train in trains
    ]


def _assumed(computed: int, calls: int, *, given: bool, least_of: str) -> tuple[str, ...]:
    """What the timetable file says of computed times."""
    if not computed:
        return ()
    whose = (
        "running times of the legs" if given else "the quickest train of the timetable that has both times"
    )
    needs = f"the least running time of {least_of}" if least_of else "the line's speed"
    return (
        f"times: {computed} of {calls} calls have one that is not the source's (marked inferred): an arrival"
        f" {DWELL_S} s before the departure, or earlier by {whose}, but not before {needs} allows, with starts and"
        f" stops at {CHANGE_MPS2} m/s2; else by distance between the times around it",
    )


def _of_join(join: StationJoin, line: Line) -> tuple[str, ...]:
    """Stations that the source lacks, and those that it may only spell otherwise."""
    found: list[str] = []
    missing = [
        line.stations[name].name or name for name in join.missing if not line.stations[name].is_signal_station
    ]
    if missing:
        found.append(
            f"stations of the line that the source has not: {some_names(missing)}; no train calls there"
        )
    for row in join.rows:
        near = [name for name in row.near if name in join.missing]
        if row.by is JoinedBy.NONE and near:
            found.append(f"{row.name} is not joined: if it is {near[0]}, say so by hand")
    return tuple(found)
