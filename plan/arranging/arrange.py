"""`branchline arrange`: a published timetable made to work on a line, with the least moved."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final

from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import parse_toml, read_text
from network.model import Line
from network.timetable import Timetable, timetable_of
from plan.arranging.draft import printed_calls, trains_to_arrange
from plan.arranging.empty_workings import with_empty_workings
from plan.arranging.line_times import line_times
from plan.arranging.model import REACH_S, ArrangeModel, NoRoomError
from plan.arranging.problem import Arranged, PrintedMove, Standing, TrainToArrange
from plan.arranging.written import MovesOfDay, arranged_file, moves_of_day
from vehicle.train_file import TrainType, load_train, train_named

REACHES_S: Final = (
    300,
    1200,
    REACH_S,
)  # tried one after the other: the less may move, the sooner all is known
WORK_MAX: Final = 2.0  # of the solver's counted work for each


@dataclass(frozen=True, slots=True)
class ArrangedDay:
    """A day that works: its file, what was moved, and what is beyond the limit."""

    line: Line
    file: TimetableFile
    timetable: Timetable
    figures: MovesOfDay
    moves: tuple[PrintedMove, ...]
    beyond: tuple[PrintedMove, ...]
    added: tuple[tuple[str, str, int], ...]  # train, station and time, s, of a call that no source prints
    empty: tuple[str, ...]  # numbers of empty workings that were added
    arranged: Arranged

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "line": self.line.id,
            "trains": len(self.timetable.trains),
            "empty_workings": list(self.empty),
            **asdict(self.figures),
            "mean_s": round(self.figures.mean_s, 2),
            "proven": self.arranged.proven,
            "bound_s": round(self.arranged.bound_s, 1),
            "reach_s": self.arranged.reach_s,
            "moves": [asdict(move) for move in self.moves],
            "beyond": [asdict(move) for move in self.beyond],
            "added_stops": [
                {"train": number, "station": station_id, "time_s": at_s}
                for number, station_id, at_s in self.added
            ],
        }


def arrange(line_name: str, timetable_name: str, train_name: str, limit_s: int) -> ArrangedDay:
    """The nearest plan to a timetable that works on a line with a kind of train. Raises InputError."""
    line = load_line(shipped_line(line_name))
    path = shipped_timetable(timetable_name)
    file = parse_toml(read_text(path), str(path), TimetableFile)
    return arranged_day(line, file, str(path), load_train(train_named(train_name)), limit_s)


def arranged_day(line: Line, file: TimetableFile, name: str, train: TrainType, limit_s: int) -> ArrangedDay:
    """The same of what has been read; `name` names the timetable in errors."""
    timetable = timetable_of(file, name, line)
    times = line_times(line, train, timetable.head.dwell_min_s)
    file, empty = with_empty_workings(file, timetable, line, times)
    timetable = timetable_of(file, name, line)
    printed = printed_calls(file, timetable)
    trains = trains_to_arrange(line, timetable, printed, times)
    try:
        arranged = nearest_plan(trains, limit_s)
    except NoRoomError as why:
        raise InputError(name, "trains", len(trains), f"a day for which the line has room: {why}") from why
    sentences = tuple(_assumed(train, arranged, empty))
    written = arranged_file(line, file, timetable, printed, trains, arranged, sentences)
    return ArrangedDay(
        line,
        written,
        timetable_of(written, name, line),
        moves_of_day(printed, arranged.moves),
        arranged.moves,
        tuple(move for move in arranged.moves if abs(move.by_s) > limit_s),
        tuple(_added(trains, arranged)),
        empty,
        arranged,
    )


def nearest_plan(trains: Sequence[TrainToArrange], limit_s: int) -> Arranged:
    """The plan that moves printed times least. Raises NoRoomError where there is none."""
    for reach_s in REACHES_S:
        try:
            return ArrangeModel(trains, limit_s, reach_s).solve(WORK_MAX)
        except NoRoomError:
            if reach_s == REACHES_S[-1]:
                raise
    raise AssertionError


def _added(trains: Sequence[TrainToArrange], arranged: Arranged) -> Iterator[tuple[str, str, int]]:
    for train in trains:
        for visit, here in zip(train.visits, arranged.visits[train.number], strict=True):
            if here.stands and visit.standing is not Standing.ALWAYS:
                yield train.number, visit.station_id, here.arrival_s


def _assumed(train: TrainType, arranged: Arranged, empty: Sequence[str]) -> Iterator[str]:
    yield (
        f"arranged: arrivals that no source gives as {train.id} runs; calls that none prints, for trains to meet, are"
        " marked inferred"
    )
    if arranged.moves:
        total_s = sum(abs(move.by_s) for move in arranged.moves)
        yield f"arranged: {len(arranged.moves)} printed times are moved, by {total_s} s in all"
    if empty:
        yield f"arranged: {', '.join(empty)} are empty workings, for sets that have no room where they are wanted"
