"""What of a run is to be shown: a train, a station, a stretch of time, a language."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property, partial

import polars as pl

from network.errors import InputError
from network.files.toml_input import one_of
from network.model import Direction, Line, Station
from network.station_names import station_id_of
from network.timetable import seconds_of
from study.measures.wait_text import at_time
from study.record.read_back import RunRead
from study.report.data import ReportedRun
from study.wording.phrase import Language, Names, names_of


@dataclass(frozen=True, slots=True)
class Choice:
    """What a person asked for; None: everything. Times in s since midnight."""

    train: str | None = None
    station: str | None = None
    from_s: float | None = None
    to_s: float | None = None
    language: Language = "en"
    beside: tuple[RunRead, ...] = ()  # other runs, shown with it


@dataclass(frozen=True)
class ChosenRun(ReportedRun):
    """A run as a kind shows it: its figures and tables, seen through a choice."""

    read: RunRead
    choice: Choice
    window: tuple[float, float]

    @cached_property
    def window_s(self) -> tuple[float, float]:
        """First and last time shown, s."""
        return self.window

    @cached_property
    def names(self) -> Names:
        """Names of stations by id."""
        return names_of(self.line)

    @property
    def named_line(self) -> Line:
        """The line with its stations called as in the language chosen, and in no other."""
        stations = {s.id: replace(s, name=self.name(s.id), name_ja="") for s in self.line.stations.values()}
        return replace(self.line, stations=stations)

    def name(self, station_id: str) -> str:
        """What a station is called in the language chosen; a portal's section goes by its id."""
        known = self.names.get(station_id)
        return station_id if known is None else known.in_(self.choice.language)

    def chosen_rows(self, frame: pl.DataFrame) -> pl.DataFrame:
        """The rows of a table that are of the train and the station chosen, where it has such columns."""
        choice = self.choice
        if choice.train is not None and "train" in frame.columns:
            frame = frame.filter(pl.col("train") == choice.train)
        if choice.station is not None and "station" in frame.columns:
            frame = frame.filter(pl.col("station") == choice.station)
        return frame

    def rows_in_window(self, frame: pl.DataFrame, *columns: str) -> pl.DataFrame:
        """The rows with any of these times in the window, or with none at all; all of them if nobody chose one."""
        if self.choice.from_s is None and self.choice.to_s is None:
            return frame
        from_s, to_s = self.window_s
        first = pl.min_horizontal(columns)
        last = pl.max_horizontal(columns)
        return frame.filter((last >= from_s) & (first < to_s))

    def legs_by_direction(
        self, rows: pl.DataFrame
    ) -> list[tuple[Direction, list[tuple[str, str]], pl.DataFrame]]:
        """Of each direction that has any: its legs along the line, and its rows of a table of trains' legs."""
        found: list[tuple[Direction, list[tuple[str, str]], pl.DataFrame]] = []
        for direction in Direction:
            goes = [self.directions.get(train) is direction for train in rows["train"]]
            own = rows.filter(pl.Series(goes, dtype=pl.Boolean))
            legs = set(own.select("from_station", "to_station").iter_rows())
            if legs:
                found.append((direction, sorted(legs, key=partial(self.along, direction)), own))
        return found

    @property
    def station(self) -> Station | None:
        """The station chosen."""
        return None if self.choice.station is None else self.line.stations[self.choice.station]


def chosen_run(read: RunRead, choice: Choice) -> ChosenRun:
    """A run through a choice. InputError for a train, station or time that the run does not have."""
    ran = {str(train) for train in read.tables.stops["train"].unique()}
    planned = [number for number in read.timetable.trains if number in ran]
    _known("--train", choice.train, [*planned, *sorted(ran.difference(planned))])
    if choice.station is not None:
        choice = replace(choice, station=station_id_of(read.line, choice.station))
    for other in choice.beside:
        if other.line.id != read.line.id:
            raise InputError("command line", "--with", other.line.id, f"a run of the line {read.line.id}")
    window_s = _window_s(ReportedRun(read.line, read.timetable, read.tables).window_s, choice)
    return ChosenRun(read.line, read.timetable, read.tables, read, choice, window_s)


def _window_s(run_s: tuple[float, float], choice: Choice) -> tuple[float, float]:
    """First and last time to show, s. InputError, in times as they are typed, for a stretch that is none of the run."""
    begins_s, ends_s = run_s
    from_s = begins_s if choice.from_s is None else choice.from_s
    to_s = ends_s if choice.to_s is None else choice.to_s
    if choice.from_s is not None and choice.to_s is not None and from_s >= to_s:
        raise InputError("command line", "--to", at_time(to_s), f"a time after --from, {at_time(from_s)}")
    in_run = f"a time of the run, which goes from {at_time(begins_s)} to {at_time(ends_s)}"
    if from_s >= ends_s:
        raise InputError("command line", "--from", at_time(from_s), in_run)
    if to_s <= begins_s:
        raise InputError("command line", "--to", at_time(to_s), in_run)
    return from_s, to_s


def _known(option: str, value: str | None, choices: Collection[str]) -> None:
    if value is not None and value not in choices:
        raise InputError("command line", option, value, one_of(choices, value))


def time_of(option: str, text: str | None) -> float | None:
    """The time of a text HH:MM or HH:MM:SS, s; None of none. InputError naming the option."""
    return None if text is None else float(seconds_of("command line", option, text, None))
