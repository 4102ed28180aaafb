"""From a published timetable to a timetable file of a line: joined, given sets, checked as every file is, written.

Readers of foreign forms end here, so that what is said of stations, times and sets is said alike for all.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from exchange.additions import Additions
from exchange.onto_line import onto_line
from exchange.planned import TrainOnLine, Working, Workings
from exchange.published import PublishedTimetable
from exchange.running import Running
from exchange.station_join import StationJoin
from exchange.timetable_writer import file_of_trains, timetable_toml
from exchange.workings import SetRules, workings_of
from network.errors import COMMAND_LINE, InputError
from network.files.json_input import write_aside
from network.files.names import title_of
from network.files.timetable_schema import HeadTable, TimetableFile
from network.model import Line
from network.timetable import Timetable, timetable_of

DWELL_MIN_S: Final = 20


@dataclass(frozen=True, slots=True)
class ImportOrder:
    """What is to be made of a published timetable: the file's id and credit, and what the source does not say.

    `by_hand`, `hand_file`, `in_order`, `without`, `running`, `least`, `least_of`: see `exchange.onto_line.onto_line`.
    An empty `name` is the source's own.
    """

    id: str
    credit: str
    name: str = ""
    rules: SetRules = field(default_factory=SetRules)
    additions: Additions = field(default_factory=Additions)
    by_hand: Mapping[str, str] = field(default_factory=dict[str, str])
    hand_file: str = COMMAND_LINE
    in_order: bool = True
    without: tuple[str, ...] = ()
    running: Running | None = None
    least: Running | None = None
    least_of: str = "the trains"


@dataclass(frozen=True, slots=True)
class ImportedTimetable:
    """A timetable file and what is to be said of it: `remarks` of the joining, `warnings` of sets that cannot be."""

    file: TimetableFile
    timetable: Timetable
    join: StationJoin
    elsewhere: int
    diagrams: tuple[Working, ...]
    remarks: tuple[str, ...]
    warnings: tuple[str, ...]
    left: tuple[str, ...]
    crowded: tuple[str, ...] = ()  # of the warnings those that an arranged plan answers

    def arranged(self, file: TimetableFile, timetable: Timetable) -> ImportedTimetable:
        """With a plan that works in place of the source's own."""
        left = tuple(text for text in self.warnings if text not in self.crowded)
        return replace(self, file=file, timetable=timetable, warnings=left, crowded=())

    @property
    def departures_alone(self) -> bool:
        """Whether the source gives an arrival at less than half of the stops on the way."""
        inner = [call for train in self.file.trains for call in train.calls[1:-1] if call.passes is None]
        return 2 * sum(call.inferred for call in inner) > len(inner)

    def figures(self) -> dict[str, Any]:
        """For reports: counts, the table of stations, and every sentence."""
        trains = self.timetable.trains.values()
        return {
            "timetable": self.timetable.head.id,
            "line": self.timetable.head.line,
            "trains": len(self.timetable.trains),
            "trains_elsewhere": self.elsewhere,
            "calls": sum(len(train.calls) for train in trains),
            "sets": len(self.diagrams),
            "stations": [
                {"source": row.name, "station": row.station_id, "by": row.by.value, "like": list(row.near)}
                for row in self.join.rows
            ],
            "stations_not_in_source": list(self.join.missing),
            "assumed": list(self.timetable.head.assumed),
            "remarks": list(self.remarks),
            "left": list(self.left),
            "warnings": list(self.warnings),
        }


def import_timetable(published: PublishedTimetable, line: Line, order: ImportOrder) -> ImportedTimetable:
    """Make the timetable file; nothing is written. Raises InputError, naming the source."""
    onto = onto_line(
        published,
        line,
        order.by_hand,
        order.running,
        least=order.least,
        least_of=order.least_of,
        hand_file=order.hand_file,
        in_order=order.in_order,
        without=order.without,
    )
    trains = _in_order((*onto.trains, *order.additions.trains))
    rules = SetRules(
        order.rules.turn_min_s, order.rules.outside_min_s, order.rules.stock or order.additions.stock
    )
    workings = workings_of(trains, line, rules, published.source)
    _check_turning(published.source, line, trains, workings)
    head = HeadTable(
        id=order.id,
        name=order.name or published.name,
        line=line.id,
        dwell_min_s=DWELL_MIN_S,
        sources=[title_of(order.credit)],
    )
    assumed = (*order.additions.assumed, _dwell(onto.trains), *onto.assumed)
    file = file_of_trains(head, trains, workings, assumed)
    timetable = timetable_of(file, published.source, line)
    return ImportedTimetable(
        file,
        timetable,
        onto.join,
        onto.elsewhere,
        workings.diagrams,
        onto.remarks,
        workings.warnings,
        published.left,
        workings.crowded,
    )


def _check_turning(file: str, line: Line, trains: Iterable[TrainOnLine], workings: Workings) -> None:
    """Whoever made the list of stations learns at once of all halts where trains begin or end."""
    ends = (
        (train.calls[at].station_id, how[train.number])
        for train in trains
        for at, how in ((0, workings.begins), (-1, workings.ends))
    )
    halts = sorted(
        {name for name, how in ends if line.stations[name].is_halt and not how.startswith("portal:")},
        key=lambda name: line.stations[name].position_m,
    )
    if halts:
        names = ", ".join(line.stations[name].name for name in halts)
        expected = "stations where trains can begin and end: kind = station in the list of stations, as these are halts"
        raise InputError(file, "stations", names, expected)


def write_timetable(imported: ImportedTimetable, out: Path) -> None:
    """Write the file whole or not at all. Raises InputError."""
    write_aside(out, timetable_toml(imported.file))


def _in_order(trains: Iterable[TrainOnLine]) -> tuple[TrainOnLine, ...]:
    return tuple(sorted(trains, key=lambda train: (train.calls[0].first_s, train.number)))


def _dwell(trains: Iterable[TrainOnLine]) -> str:
    times = (
        time_s
        for train in trains
        for call in train.calls
        if not call.inferred
        for time_s in (call.arrival_s, call.departure_s)
    )
    whole = all(time_s is None or time_s % 60 == 0 for time_s in times)
    why = "because the source gives whole minutes" if whole else "because the source does not say"
    return f"dwell: {DWELL_MIN_S} s at least, {why}"
