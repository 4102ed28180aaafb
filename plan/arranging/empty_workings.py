"""Sets that are missing where trains begin: brought as empty workings (回送) from where there is room for the night.

A station inside the line keeps one track free of sets that stand over; at an end of it every track may have one. Sets
that are too many begin (end) the day at the nearest station with room at which trains begin or end, or at an end of the
line, and run empty before their first train (after their last one). When, the plan finds: nothing of them is printed.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise

from exchange.timetable_writer import call_table, train_table
from network.files.timetable_schema import DiagramTable, TimetableFile, TrainTable
from network.model import Direction, Line, SectionKind
from network.timetable import DAY_S, Call, CallKind, Stabled, Timetable, TimetableTrain
from plan.arranging.line_times import LineTimes

TURNS_S = 600  # assumed, to begin with: between an empty working and the train before or after it


@dataclass(slots=True)
class _Night:
    """Which trains' sets stand where before the day (after it), and how many more may."""

    line: Line
    turning: frozenset[str]  # stations where trains begin or end
    sets: dict[str, list[TimetableTrain]] = field(default_factory=lambda: defaultdict(list))

    @property
    def ends(self) -> frozenset[str]:
        """The first and the last station of the line."""
        stations = self.line.stations.values()
        return frozenset(end(stations, key=lambda s: s.position_m).id for end in (min, max))

    def room(self, station_id: str) -> int:
        """How many more sets may stand there; negative: so many are too many."""
        sections = {
            track.section_id
            for track in self.line.stations[station_id].tracks
            if self.line.sections[track.section_id].kind is SectionKind.TRACK
        }
        kept = 0 if station_id in self.ends else 1
        return max(len(sections) - kept, min(len(sections), 1)) - len(self.sets[station_id])

    def nearest(self, station_id: str) -> str | None:
        """The nearest other station with room."""
        here_m = self.line.stations[station_id].position_m
        others = [
            station
            for name in sorted((self.turning | self.ends) - {station_id})
            if self.room(name) > 0 and (station := self.line.stations[name])
        ]
        return min(others, key=lambda s: (abs(s.position_m - here_m), s.id)).id if others else None


def with_empty_workings(
    file: TimetableFile, timetable: Timetable, line: Line, times: LineTimes
) -> tuple[TimetableFile, tuple[str, ...]]:
    """The day with them, and their numbers. Where no station has room, it stays as it is."""
    tables = {train.number: train for train in file.trains}
    diagrams = {diagram.stock: list(diagram.trains) for diagram in file.diagrams}
    added: list[str] = []
    turning = frozenset(train.calls[at].station_id for train in timetable.trains.values() for at in (0, -1))
    for morning in (True, False):
        night = _Night(line, turning)
        for train in timetable.trains.values():
            if isinstance(train.begins if morning else train.ends, Stabled):
                night.sets[train.calls[0 if morning else -1].station_id].append(train)
        for station_id, sets in list(night.sets.items()):
            sets.sort(key=lambda train: train.calls[0 if morning else -1].last_s, reverse=not morning)
            while night.room(station_id) < 0 and (other := night.nearest(station_id)) is not None:
                train = sets.pop()
                night.sets[other].append(train)
                number = _free_number(tables)
                tables[number] = _empty(line, times, number, train, other, morning=morning)
                change = {"begins": f"from:{number}"} if morning else {"ends": f"becomes:{number}"}
                tables[train.number] = tables[train.number].model_copy(update=change)
                own = next(trains for trains in diagrams.values() if train.number in trains)
                own.insert(own.index(train.number) + (0 if morning else 1), number)
                added.append(number)
    rows = [DiagramTable(stock=stock, trains=trains) for stock, trains in diagrams.items()]
    return file.model_copy(update={"trains": list(tables.values()), "diagrams": rows}), tuple(added)


def _free_number(tables: dict[str, TrainTable]) -> str:
    number = 1
    while f"E{number}" in tables:
        number += 1
    return f"E{number}"


def _empty(
    line: Line, times: LineTimes, number: str, train: TimetableTrain, other: str, *, morning: bool
) -> TrainTable:
    """From the other station to the train's first (from its last to the other), with times to begin with."""
    own = train.calls[0 if morning else -1]
    from_id, to_id = (other, own.station_id) if morning else (own.station_id, other)
    low_m, high_m = (line.stations[name].position_m for name in (from_id, to_id))
    direction = Direction.DOWN if high_m > low_m else Direction.UP
    way = [
        station.id
        for station in sorted(line.stations.values(), key=lambda s: s.position_m * direction)
        if min(low_m, high_m) <= station.position_m <= max(low_m, high_m)
    ]
    run_s = sum(times.run(direction, *leg).stop_stop for leg in pairwise(way))
    leaves_s = own.last_s - TURNS_S - run_s if morning else own.last_s + TURNS_S
    leaves_s = math.floor(max(0, min(leaves_s, 2 * DAY_S)))
    calls = [
        call_table(Call(from_id, None, None, leaves_s, CallKind.OPERATIONAL), inferred=True),
        call_table(Call(to_id, None, leaves_s + run_s, None, CallKind.OPERATIONAL), inferred=True),
    ]
    begins, ends = ("stabled", f"becomes:{train.number}") if morning else (f"from:{train.number}", "stabled")
    return train_table(number, direction, calls, begins, ends, revenue=False)
