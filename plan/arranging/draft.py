"""From a timetable file to what is to be arranged: what is printed, what is computed, which stations lie on the way."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

from network.errors import InputError
from network.files.timetable_schema import CallTable, TimetableFile
from network.model import Line, SectionKind, Station
from network.timetable import AtPortal, Call, CallKind, FromTrain, Timetable, TimetableTrain, platform_of
from plan.arranging.line_times import LineTimes
from plan.arranging.problem import Standing, TrainToArrange, Visit
from plan.arranging.windows import windows_s

WITHIN_S: Final = 2700  # assumed: a train of which nothing is printed runs within so much of its first draft
OPERATIONAL_STAY_S: Final = 10  # assumed: a train that only waits for another
BESIDE_S: Final = (
    300  # assumed: so late a train may be where another one needs its track; with a wider limit that, up to
)
BESIDE_S_MAX: Final = 1200  # assumed: beyond it nearly all trains of a day could be beside each other


@dataclass(frozen=True, slots=True)
class _There:
    """A train at a station, its usual track, and within which times it can have that, s."""

    number: str
    usual: str
    from_s: int
    to_s: int

    def meets(self, other: _There) -> bool:
        """Whether both could have it at once."""
        return self.from_s <= other.to_s and other.from_s <= self.to_s


@dataclass(frozen=True, slots=True)
class PrintedCall:
    """A call with the times that are printed, s; a computed one (`inferred`) counts for nothing."""

    call: Call
    arrival_s: int | None
    departure_s: int | None


def printed_calls(file: TimetableFile, timetable: Timetable) -> dict[str, tuple[PrintedCall, ...]]:
    """The calls of each train with what of them is printed."""
    tables = {train.number: train.calls for train in file.trains}
    return {
        number: tuple(
            _printed(call, table, train.revenue, first=index == 0, last=index == len(train.calls) - 1)
            for index, (call, table) in enumerate(zip(train.calls, tables[number], strict=True))
        )
        for number, train in timetable.trains.items()
    }


def _printed(call: Call, table: CallTable, revenue: bool, *, first: bool, last: bool) -> PrintedCall:
    """What comes before a train is on the line, or after it has left it, counts for nothing; nor does what is computed,
    but the departure of a call with a computed time, where passengers go by it.
    """
    counts = revenue or not table.inferred
    return PrintedCall(
        call,
        None if first or table.inferred else call.arrival_s,
        call.departure_s if counts and not last else None,
    )


def trains_to_arrange(
    line: Line,
    timetable: Timetable,
    printed: Mapping[str, tuple[PrintedCall, ...]],
    times: LineTimes,
    limit_s: int = BESIDE_S,
    *,
    by_print: bool = False,
) -> list[TrainToArrange]:
    """All trains of the day, moved by `limit_s` at most. Raises InputError where the line has no way for one.

    `by_print`: with a choice of tracks only beside trains that are there by print, as is enough on most days.
    """
    turn_s = math.ceil(max(times.setup.turn_s, timetable.head.turn_min_s))
    found: list[TrainToArrange] = []
    turning = frozenset(train.calls[i].station_id for train in timetable.trains.values() for i in (0, -1))
    for number, train in timetable.trains.items():
        try:
            visits = tuple(_visits(line, train, printed[number], times))
        except KeyError as missing:
            expected = f"a line with a way for it; there is none for {missing}"
            raise InputError(timetable.head.id, "trains", number, expected) from missing
        follows = train.begins.number if isinstance(train.begins, FromTrain) else None
        leads_s = [v.leg.lead.stands for v in visits if v.leg is not None]
        if not leads_s:
            expected = "a train from one station with tracks of its own to another"
            raise InputError(timetable.head.id, "trains", number, expected)
        window_s = (train.calls[0].last_s - WITHIN_S, train.calls[-1].last_s + WITHIN_S)
        free = all(v.arrival_s is None and v.departure_s is None for v in visits)
        enters, leaves = (
            way.section_id if isinstance(way, AtPortal) else None for way in (train.begins, train.ends)
        )
        window_s = window_s if free else (0, 0)
        found.append(
            TrainToArrange(
                number, visits, follows, turn_s + leads_s[0], *window_s, enters=enters, leaves=leaves
            )
        )
    late_s = 0 if by_print else min(max(BESIDE_S, limit_s), BESIDE_S_MAX)
    beside = stations_beside_another(found, late_s)
    return [_with_choice(train, turning | beside.get(train.number, frozenset())) for train in found]


def _with_choice(train: TrainToArrange, choice: Collection[str]) -> TrainToArrange:
    """The same with any track at these stations, and with the usual one elsewhere."""
    visits = [
        visit if visit.station_id in choice else replace(visit, tracks=visit.tracks[:1])
        for visit in train.visits
    ]
    return replace(train, visits=tuple(visits))


def stations_beside_another(
    trains: Sequence[TrainToArrange], late_s: int = BESIDE_S
) -> dict[str, frozenset[str]]:
    """By train: where it could be at once with another that usually has the same track, or with two that do.

    As long as a train can have its track by print, and `late_s` longer: from leaving the place before until it is at
    the next one. So one follows, overtakes or meets another. With no `late_s` only what is there by print counts.
    """
    there: dict[str, list[_There]] = defaultdict(list)
    for train in trains:
        windows = windows_s(train, late_s)
        places = [i for i, visit in enumerate(train.visits) if visit.tracks]
        for before, here, after in zip([places[0], *places], places, [*places[1:], places[-1]], strict=False):
            comes_s, _, to_s = windows[here]
            from_s = windows[before][1] if late_s and before != here else comes_s
            until_s = to_s + (windows[after][0] - windows[here][1] if late_s and after != here else 0)
            visit = train.visits[here]
            there[visit.station_id].append(_There(train.number, visit.tracks[0], from_s, until_s))
    found: dict[str, set[str]] = defaultdict(set)
    for station_id, all_there in there.items():
        for one, other in combinations(all_there, 2):
            if one.usual != other.usual or not one.meets(other):
                continue
            for third in all_there if late_s else (one, other):
                if third.meets(one) and third.meets(other):
                    found[third.number].add(station_id)
    return {number: frozenset(stations) for number, stations in found.items()}


def _visits(
    line: Line,
    train: TimetableTrain,
    calls: tuple[PrintedCall, ...],
    times: LineTimes,
) -> Iterator[Visit]:
    """A visit for every station of its way, those too that it runs through and of which the print says nothing."""
    by_station = {call.call.station_id: call for call in calls}
    before: Station | None = None
    place: Station | None = None
    for station in _on_the_way(line, train):
        call = by_station.get(station.id)
        run = None if before is None else times.run(train.direction, before.id, station.id)
        tracks = _tracks(line, station, train, call)
        leg = None
        if tracks and place is not None:
            leg = times.leg(train.direction, place.id, station.id)
        yield Visit(
            station.id,
            _standing(call, tracks),
            None if call is None else call.arrival_s,
            None if call is None else call.departure_s,
            _stay_s(call, times.setup.timetable.head.dwell_min_s),
            run,
            leg,
            tracks,
            times.slower(train.direction, station.id),
        )
        before = station
        place = station if tracks else place


def _on_the_way(line: Line, train: TimetableTrain) -> list[Station]:
    first, last = (line.stations[train.calls[i].station_id].position_m for i in (0, -1))
    low_m, high_m = min(first, last), max(first, last)
    return [
        station
        for station in sorted(line.stations.values(), key=lambda s: s.position_m * train.direction)
        if low_m <= station.position_m <= high_m
        and any(train.direction in track.marks_m for track in station.tracks)
    ]


def _standing(call: PrintedCall | None, tracks: tuple[str, ...]) -> Standing:
    if call is not None and call.call.stops:
        return Standing.ALWAYS
    return Standing.MAY if tracks else Standing.NEVER


def _stay_s(call: PrintedCall | None, dwell_min_s: float) -> int:
    if call is None or call.call.kind is not CallKind.STOP:
        return OPERATIONAL_STAY_S
    return math.ceil(dwell_min_s)


def _tracks(line: Line, station: Station, train: TimetableTrain, call: PrintedCall | None) -> tuple[str, ...]:
    """Sections of the tracks that it may have, the usual one first; with a platform where passengers get on."""
    if station.is_halt:
        return ()
    passengers = call is not None and call.call.kind is CallKind.STOP and train.revenue
    usable = [
        track
        for track in station.tracks
        if train.direction in track.marks_m
        and line.sections[track.section_id].kind is SectionKind.TRACK
        and (track.platform_m is not None or not passengers)
    ]
    usual = platform_of(line, Call(station.id, None, None, 0), train.direction)
    usable.sort(key=lambda track: track.section_id != usual.section_id)
    return tuple(track.section_id for track in usable)
