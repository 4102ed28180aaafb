"""A plan that was arranged as the tables of a timetable file, and what it moved in a few figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from exchange.timetable_writer import call_table
from network.files.timetable_schema import CallTable, TimetableFile, TrainTable
from network.model import Line
from network.timetable import Call, CallKind, Timetable, TimetableTrain, platform_of
from plan.arranging.draft import PrintedCall
from plan.arranging.problem import Arranged, ArrangedVisit, PrintedMove, TrainToArrange

MINUTE_S = 60


@dataclass(frozen=True, slots=True)
class MovesOfDay:
    """How far printed times were moved: `printed` times in all, of which `moved` were, and by how much, s.

    `past_minute`: those that are no longer in the minute that was printed.
    """

    printed: int
    moved: int
    past_minute: int
    total_s: int
    worst_s: int

    @property
    def mean_s(self) -> float:
        """Over all printed times, s."""
        return self.total_s / self.printed if self.printed else 0.0


def moves_of_day(printed: Mapping[str, Sequence[PrintedCall]], moves: Sequence[PrintedMove]) -> MovesOfDay:
    """The figures of a day."""
    count = sum(
        time_s is not None for own in printed.values() for c in own for time_s in (c.arrival_s, c.departure_s)
    )
    total_s = sum(abs(move.by_s) for move in moves)
    past = sum(not 0 <= move.by_s < MINUTE_S for move in moves)
    worst_s = max((abs(move.by_s) for move in moves), default=0)
    return MovesOfDay(count, len(moves), past, total_s, worst_s)


def arranged_file(
    line: Line,
    file: TimetableFile,
    timetable: Timetable,
    printed: Mapping[str, Sequence[PrintedCall]],
    problem: Sequence[TrainToArrange],
    arranged: Arranged,
    sentences: Sequence[str],
) -> TimetableFile:
    """The file with the times of the plan; calls that only a plan has are marked inferred."""
    to_arrange = {train.number: train for train in problem}
    after_s = comes_in_after(problem, arranged)
    tables = [
        _train(
            line,
            table,
            timetable.trains[table.number],
            printed[table.number],
            soonest(to_arrange[table.number], arranged.visits[table.number], after_s),
        )
        for table in file.trains
    ]
    head = file.timetable.model_copy(update={"assumed": [*file.timetable.assumed, *sentences]})
    return file.model_copy(update={"timetable": head, "trains": tables})


def comes_in_after(problem: Sequence[TrainToArrange], arranged: Arranged) -> dict[tuple[str, str], int]:
    """Before which time, s, a train (number) may not come to a station, as another has to stand there first."""
    comes = [
        (one.number, visit.leg, here)
        for one in problem
        for visit, here in zip(one.visits, arranged.visits[one.number], strict=True)
        if visit.leg is not None and visit.leg.overlaps
    ]
    found: dict[tuple[str, str], int] = {}
    for number, leg, here in comes:
        for other, before, there in comes:
            if other != number and there.arrival_s <= here.arrival_s and {*leg.overlaps} & {*before.overlaps}:
                stood_s = before.stood.stands if there.stands else before.stood.passes
                enters_s = leg.enters.stands if here.stands else leg.enters.passes
                key = number, here.station_id
                found[key] = max(found.get(key, 0), there.arrival_s + stood_s + enters_s)
    return found


def soonest(
    train: TrainToArrange, visits: Sequence[ArrangedVisit], after_s: Mapping[tuple[str, str], int]
) -> tuple[ArrangedVisit, ...]:
    """The same with arrivals as early as trains can run: what others need is freed no later by that.

    `after_s`: see `comes_in_after`.
    """
    found = [visits[0]]
    for (left, visit), (before, here) in zip(pairwise(train.visits), pairwise(visits), strict=True):
        run_s = next(
            s
            for one, other, s in (visit.run.ways() if visit.run else ())
            if (one, other) == (before.stands, here.stands)
        )
        run_s += left.longer_s(before.track, stands=before.stands, leaves=True)
        run_s += visit.longer_s(here.track, stands=here.stands, leaves=False)
        arrives_s = here.arrival_s
        # by a portal that others need till then
        goes_on = train.leaves is not None and visit is train.visits[-1]
        if here.stands and not goes_on:
            free_s = after_s.get((train.number, here.station_id), 0)
            arrives_s = min(arrives_s, max(found[-1].departure_s + run_s, visit.arrival_s or 0, free_s))
        found.append(ArrangedVisit(here.station_id, arrives_s, here.departure_s, here.stands, here.track))
    return tuple(found)


def _train(
    line: Line,
    table: TrainTable,
    train: TimetableTrain,
    printed: Sequence[PrintedCall],
    visits: Sequence[ArrangedVisit],
) -> TrainTable:
    calls = list(_calls(line, train, printed, visits))
    return table.model_copy(update={"calls": calls})


def _calls(
    line: Line, train: TimetableTrain, printed: Sequence[PrintedCall], visits: Sequence[ArrangedVisit]
) -> Iterator[CallTable]:
    by_station = {call.call.station_id: call for call in printed}
    for index, visit in enumerate(visits):
        call = by_station.get(visit.station_id)
        if call is None and visit.track is None:
            continue  # a halt that it runs through, of which nothing is printed
        first, last = index == 0, index == len(visits) - 1
        kind = CallKind.OPERATIONAL if call is None or not call.call.stops else call.call.kind
        arrival_s = None if first or not visit.stands else visit.arrival_s
        departure_s = None if last else visit.departure_s
        source = (None, None) if call is None else (call.arrival_s, call.departure_s)
        here = Call(
            visit.station_id,
            _track(line, train, visit, None if call is None else call.call.track),
            arrival_s,
            departure_s,
            kind if visit.stands else CallKind.PASS,
            inferred=(arrival_s, departure_s) != source,
        )
        yield call_table(here)


def _track(line: Line, train: TimetableTrain, visit: ArrangedVisit, named: str | None) -> str | None:
    """Its name where it is not the usual one, or was named before."""
    if visit.track is None:
        return named
    tracks = line.stations[visit.station_id].tracks
    name = next(
        track.name for track in tracks if track.section_id == visit.track and train.direction in track.marks_m
    )
    usual = platform_of(line, Call(visit.station_id, None, None, 0), train.direction)
    return name if named is not None or usual.name != name else None
