"""The timetable that was written into an OuDia file, read back as it was: the same trains, sets, tracks and ends.

That goes as long as the file still says all that was written: its comment, and for every train where its set comes from
and goes to and which set it is. Whoever edits it in OuDia may take a part of that away, or add a train without; then
the file is read as any other, and why is said.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from exchange.oudia.carried import CommentTable, carried_in, words_in
from exchange.oudia.cells import AfterTrain, BeforeTrain, CallHandling, OudiaCell, StationOperation, index_of
from exchange.oudia.published import NOT_FOR_PASSENGERS
from exchange.oudia.route import DOWN, OudiaDia, OudiaRoute, OudiaStation, OudiaTrain
from exchange.oudia.writer import station_name
from exchange.timetable_writer import call_table, train_table
from network.errors import InputError
from network.files.names import is_identifier
from network.files.timetable_schema import CallTable, DiagramTable, TimetableFile
from network.model import Direction, Line
from network.timetable import DAY_S, Call, CallKind, timetable_of


@dataclass(frozen=True, slots=True)
class WrittenHere:
    """What came of reading a file back: the timetable, or None and why it is read as any other file."""

    file: TimetableFile | None
    why: str = ""


class _LostError(Exception):
    """Something that was written is gone."""


def read_back(route: OudiaRoute, dia: OudiaDia, line: Line) -> WrittenHere:
    """The timetable that was written into a file, for a line. Raises nothing."""
    try:
        carried = carried_in(route.comment, route.file)
        if carried is None:
            return WrittenHere(None)
        file = _file(route, dia, line, carried)
        timetable_of(file, route.file, line)
    except _LostError as lost:
        return WrittenHere(None, f"it was written by branchline, but {lost}")
    except InputError as error:
        return WrittenHere(None, f"it was written by branchline and changed since: {error}")
    return WrittenHere(file)


def _file(route: OudiaRoute, dia: OudiaDia, line: Line, carried: CommentTable) -> TimetableFile:
    written = carried.oudia
    if carried.timetable.line != line.id:
        raise _LostError(f"for the line {carried.timetable.line}")
    if dia.name != written.dia:
        raise _LostError(f"{dia.name!r} is not the plan, {written.dia!r}")
    ids = written.stations
    known = [line.stations[name] for name in ids if name in line.stations]
    if [station_name(station) for station in known] != [station.name for station in route.stations]:
        raise _LostError("its stations are others now")
    trains: dict[str, OudiaTrain] = {}
    for train in dia.trains:
        if not is_identifier(train.number) or train.number in trains:
            raise _LostError(f"a train has the number {train.number!r}")
        if train.cancelled or not train.runs or train.before is None or train.after is None or train.others:
            raise _LostError(f"train {train.number} does not run, or its set has other operations now")
        trains[train.number] = train
    calls = {number: _calls(train, route, ids) for number, train in trains.items()}
    sets = _sets(trains, calls, written.stock)
    before = {after: number for numbers in sets.values() for number, after in pairwise(numbers)}
    after = {number: following for following, number in before.items()}
    tables = [
        train_table(
            number,
            Direction.DOWN if train.direction == DOWN else Direction.UP,
            [table for _, table in calls[number]],
            _begins(train, route, before.get(number)),
            _ends(train, route, after.get(number)),
            revenue=NOT_FOR_PASSENGERS.search(train.kind) is None,
        )
        for number, train in sorted(trains.items(), key=lambda item: (calls[item[0]][0][0], item[0]))
    ]
    diagrams = [DiagramTable(stock=name, trains=numbers) for name, numbers in sets.items()]
    return TimetableFile(timetable=carried.timetable, trains=tables, diagrams=diagrams)


def _along(train: OudiaTrain, route: OudiaRoute, ids: Sequence[str]) -> list[tuple[OudiaStation, str]]:
    pairs = list(zip(route.stations, ids, strict=True))
    return pairs if train.direction == DOWN else pairs[::-1]


def _calls(train: OudiaTrain, route: OudiaRoute, ids: Sequence[str]) -> list[tuple[int, CallTable]]:
    """Calls with the time (s) at which each begins."""
    words = words_in(train.remark)
    found: list[tuple[int, CallTable]] = []
    for (station, station_id), of in zip(_along(train, route, ids), train.cells, strict=False):
        arrival_s, departure_s = (
            None if time_s is None else time_s + words.days * DAY_S
            for time_s in (of.arrival_s, of.departure_s)
        )
        first_s = arrival_s if arrival_s is not None else departure_s
        if of.how not in (CallHandling.STOP, CallHandling.PASS) or first_s is None:
            continue  # it runs through, and nobody says when
        passes = of.how is CallHandling.PASS and (
            arrival_s is None or departure_s is None or arrival_s == departure_s
        )
        kind = CallKind.STOP
        if passes:
            kind, arrival_s, departure_s = (
                CallKind.PASS,
                None,
                arrival_s if departure_s is None else departure_s,
            )
        elif of.how is CallHandling.PASS or station_id in words.operational:
            kind = CallKind.OPERATIONAL
        track = _track(train, station, of, named=station_id in words.named_tracks)
        call = Call(station_id, track, arrival_s, departure_s, kind, station_id in words.inferred)
        found.append((first_s, call_table(call)))
    if not found:
        raise _LostError(f"train {train.number} has no times")
    return found


def _track(train: OudiaTrain, station: OudiaStation, of: OudiaCell, *, named: bool) -> str | None:
    """Name of a track; None for the usual one of the direction, where nobody has named it."""
    if of.track is None or (of.track == station.main(train.direction) and not named):
        return None
    if of.track >= len(station.tracks):
        raise _LostError(f"{station.name} has no track {of.track}")
    return station.tracks[of.track]


def _set_of(train: OudiaTrain) -> str:
    """Number of a train's set: the last part of how it begins, by kind."""
    before = train.before
    if before is None:
        return ""
    return before.part(
        {BeforeTrain.OUT.value: 2, BeforeTrain.OUTER.value: 4, BeforeTrain.JUNCTION.value: 1}[before.kind]
    )


def _sets(
    trains: Mapping[str, OudiaTrain],
    calls: Mapping[str, Sequence[tuple[int, CallTable]]],
    order: Sequence[str],
) -> dict[str, list[str]]:
    """Trains of each set in order of time, sets in the order in which they were written."""
    found: dict[str, list[str]] = {}
    for number, train in trains.items():
        name = _set_of(train)
        if not is_identifier(name):
            raise _LostError(f"train {number} has no set")
        found.setdefault(name, []).append(number)
    for numbers in found.values():
        numbers.sort(key=lambda number: (calls[number][0][0], calls[number][-1][0]))
    names = [*(name for name in order if name in found), *(name for name in found if name not in order)]
    return {name: found[name] for name in names}


def _begins(train: OudiaTrain, route: OudiaRoute, before: str | None) -> str:
    station = route.stations_along(train.direction)[train.first]
    match train.before:
        case StationOperation(kind) if kind == BeforeTrain.OUT.value:
            return "stabled"
        case StationOperation(kind) as of if kind == BeforeTrain.OUTER.value:
            return f"portal:{_outer(station, of)}"
        case _ if before is not None:
            return f"from:{before}"
        case _:
            raise _LostError(f"train {train.number} follows none of its set")


def _ends(train: OudiaTrain, route: OudiaRoute, after: str | None) -> str:
    station = route.stations_along(train.direction)[train.last]
    match train.after:
        case StationOperation(kind) if kind == AfterTrain.IN.value:
            return "stabled"
        case StationOperation(kind) as of if kind == AfterTrain.OUTER.value:
            return f"portal:{_outer(station, of)}"
        case _ if after is not None:
            return f"becomes:{after}"
        case _:
            raise _LostError(f"no train of its set follows train {train.number}")


def _outer(station: OudiaStation, of: StationOperation) -> str:
    index = index_of(of.part(0))
    if index >= len(station.outer):
        raise _LostError(f"{station.name} has no place beyond it")
    return station.outer[index]
