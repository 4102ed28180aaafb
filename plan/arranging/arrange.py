"""`branchline arrange`: a published timetable made to work on a line, with the least moved."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from exchange.hidden_meets import meets_between
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import parse_toml, read_text
from network.model import Line
from network.patching.loop_addition import between_id
from network.patching.patch import load_patched_line
from network.timetable import Timetable, timetable_of
from plan.arranging.draft import PrintedCall, printed_calls, trains_to_arrange
from plan.arranging.empty_workings import NIGHTS, with_empty_workings
from plan.arranging.lacking import NO_HALTS, Day, Halts, MoreTracks
from plan.arranging.line_times import LineTimes, line_times
from plan.arranging.nearest import NothingFoundError, nearest_plan
from plan.arranging.problem import Arranged, PrintedMove, Standing, TrainToArrange
from plan.arranging.search import gap_of
from plan.arranging.telling import Tell, tell_nobody
from plan.arranging.written import MovesOfDay, arranged_file, moves_of_day
from vehicle.train_file import TrainType, load_train, train_named

CHOICE_TRAINS_MAX: Final = (
    80  # assumed: with 101 no proof comes where all could have any track (decision 284)
)
LIMIT_S: Final = 300  # assumed: by how much people can bear that a printed time is moved
NAMED_TRAINS: Final = 4  # that a track is for, in a sentence


@dataclass(frozen=True, slots=True)
class _Draft:
    """A day with its empty workings, before times are settled."""

    file: TimetableFile
    timetable: Timetable
    printed: dict[str, tuple[PrintedCall, ...]]
    trains: list[TrainToArrange]
    empty: tuple[str, ...] = ()
    by_print: bool = False  # with few choices of tracks


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
    gap: tuple[float, float]  # from the least at most, s, and as a share of what is counted (`search.gap_of`)
    lacking: MoreTracks | None  # tracks with which no printed time would be beyond the limit
    none_within_s: int  # no plan moves each printed time by so much at most, which is proven
    by_print: (
        bool  # trains have a choice of tracks only where sets turn and beside those that are there by print
    )

    @property
    def text(self) -> str:
        """How much of the print is moved, in a sentence."""
        moved = self.figures
        return (
            f"printed times moved: {moved.moved} of {moved.printed}, {moved.past_minute} out of their minute;"
            f" {moved.total_s} s in all, {moved.mean_s:.1f} s a printed time"
        )

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "line": self.line.id,
            "trains": len(self.timetable.trains),
            "empty_workings": list(self.empty),
            **asdict(self.figures),
            "mean_s": round(self.figures.mean_s, 2),
            "lacking": None if self.lacking is None else asdict(self.lacking),
            "proven": self.arranged.proven,
            "bound_s": round(self.arranged.bound_s, 1),
            "gap_s": round(self.gap[0], 1),
            "reach_s": self.arranged.reach_s,
            "none_within_s": self.none_within_s,
            "moves": [asdict(move) for move in self.moves],
            "beyond": [asdict(move) for move in self.beyond],
            "added_stops": [
                {"train": number, "station": station_id, "time_s": at_s}
                for number, station_id, at_s in self.added
            ],
        }


class NoPlanError(Exception):
    """The search came to its end without a plan: an answer, and no bad input.

    `lacking`: tracks with which there is one, and `would_do` a sentence of it.
    """

    def __init__(self, why: str, line: Line, lacking: MoreTracks | None) -> None:
        self.why: Final = why
        self.line: Final = line
        self.lacking: Final = lacking
        self.would_do: Final = "" if lacking is None else lacking_text(line, lacking)
        super().__init__("; ".join(filter(None, (why, self.would_do))))

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        lacking = None if self.lacking is None else asdict(self.lacking)
        return {"line": self.line.id, "why": self.why, "lacking": lacking}


def arrange(
    line_name: str, timetable_name: str, train_name: str, limit_s: int, tell: Tell = tell_nobody
) -> ArrangedDay:
    """The nearest plan to a timetable that works on a line with a kind of train. Raises InputError, NoPlanError."""
    line_path = shipped_line(line_name)
    line = load_line(line_path)
    path = shipped_timetable(timetable_name)
    file = parse_toml(read_text(path), str(path), TimetableFile)
    return arranged_day(line, file, str(path), load_train(train_named(train_name)), limit_s, line_path, tell)


def arranged_day(
    line: Line,
    file: TimetableFile,
    name: str,
    train: TrainType,
    limit_s: int,
    line_path: Path | None = None,
    tell: Tell = tell_nobody,
) -> ArrangedDay:
    """The same of what has been read; `name` names the timetable in errors.

    `line_path`: the line's file, where second tracks at its halts are looked at too, if the limit cannot be kept.
    `tell` takes what is being done.
    """
    tell("running and blocking times")
    drafts = tuple(_drafts(line, file, name, train, limit_s))
    halts = NO_HALTS
    if line_path is not None:

        def with_loops(at: Sequence[str]) -> Line:
            return load_patched_line(line_path, {"add_loops": list(at)}, "")

        def room(at: Sequence[str]) -> bool:
            try:
                with_loops(at)
            except InputError:
                return False
            return True

        def laid(at: Sequence[str]) -> list[Day]:
            return [draft.trains for draft in _drafts(with_loops(at), file, name, train, limit_s)]

        stations = line.stations.values()
        along_m = {station.id: station.position_m for station in stations}
        between = dict(_between(line, drafts[0].timetable))
        for (low, high), here in between.items():
            along_m[here] = (along_m[low] + along_m[high]) / 2.0
        names = {*(s.id for s in stations if s.is_halt), *between.values()}
        by_ends = {frozenset(ends): name for ends, name in between.items()}
        halts = Halts(frozenset(names), along_m, room, laid, by_ends)
    try:
        found = nearest_plan([draft.trains for draft in drafts], limit_s, halts, tell)
    except NothingFoundError as why:
        no_room = f"{name}: the line has no room for its {len(file.trains)} trains: {why}"
        raise NoPlanError(no_room, line, why.lacking) from why
    draft, arranged = drafts[found.index], found.arranged
    beyond = tuple(move for move in arranged.moves if abs(move.by_s) > limit_s)
    sentences = tuple(_assumed(train, arranged, draft.empty))
    written = arranged_file(
        line, draft.file, draft.timetable, draft.printed, draft.trains, arranged, sentences
    )
    return ArrangedDay(
        line,
        written,
        timetable_of(written, name, line),
        moves_of_day(draft.printed, arranged.moves),
        arranged.moves,
        beyond,
        tuple(_added(draft.trains, arranged)),
        draft.empty,
        arranged,
        gap_of(draft.trains, arranged, limit_s),
        found.lacking,
        found.none_within_s,
        draft.by_print,
    )


def lacking_text(line: Line, lacking: MoreTracks) -> str:
    """A sentence of it."""
    signal = {name: ends for ends, name in _between(line)}
    names = [
        (
            f"{line.stations[station_id].name} had {count} more track{'s' if count > 1 else ''}"
            if station_id in line.stations
            else "there were a signal station between "
            + " and ".join(line.stations[end].name for end in signal[station_id])
        )
        + f" (for {', '.join(lacking.trains[station_id][:NAMED_TRAINS])})"
        for station_id, count in lacking.by_station.items()
    ]
    worst = f" by more than {lacking.worst_s} s" if lacking.worst_s else ""
    laid = all(s not in line.stations or line.stations[s].is_halt for s in lacking.by_station)
    quick = "" if laid else ", on tracks as quick as those that are there"
    return f"if {' and '.join(names)}, no printed time would be moved{worst}{quick}"


def _between(line: Line, timetable: Timetable | None = None) -> Iterator[tuple[tuple[str, str], str]]:
    """Neighbours and what a signal station between them is called; of a day those between which its trains meet."""
    in_order = [station.id for station in sorted(line.stations.values(), key=lambda s: s.position_m)]
    meets = None if timetable is None else frozenset(meets_between(timetable, line))
    for ends in pairwise(in_order):
        if meets is None or ends in meets:
            yield ends, between_id(*ends)


def _draft(
    line: Line,
    file: TimetableFile,
    name: str,
    times: LineTimes,
    empty: tuple[str, ...],
    limit_s: int,
    *,
    by_print: bool,
) -> _Draft:
    timetable = timetable_of(file, name, line)
    printed = printed_calls(file, timetable)
    trains = trains_to_arrange(line, timetable, printed, times, limit_s, by_print=by_print)
    return _Draft(file, timetable, printed, trains, empty, by_print)


def _drafts(line: Line, file: TimetableFile, name: str, train: TrainType, limit_s: int) -> Iterator[_Draft]:
    """The day with the empty workings of each rule of the night; of many trains first with few choices of tracks,
    then with more, where these do not do.
    """
    timetable = timetable_of(file, name, line)
    times = line_times(line, train, timetable.head.dwell_min_s)
    days: list[tuple[TimetableFile, tuple[str, ...]]] = []
    for rule in NIGHTS:
        more, empty = with_empty_workings(file, timetable, line, times, rule)
        if all(more != other for other, _ in days):
            days.append((more, empty))
    for by_print in (True, False) if len(file.trains) > CHOICE_TRAINS_MAX else (False,):
        for more, empty in days:
            yield _draft(line, more, name, times, empty, limit_s, by_print=by_print)


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
