"""Sets that are missing where trains begin: brought as empty workings (回送) from where there is room for the night.

Sets that are too many begin (end) the day at the nearest station with room at which trains begin or end, at an end of
the line, or else at any, and run empty before their first train (after their last one). When, the plan finds: nothing
of them is printed. Of the tracks there one stays free. How many sets a station may have of its own trains, and whose
sets come from elsewhere, is tried in the order of `NIGHTS`.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

from exchange.timetable_writer import call_table, train_table
from network.files.timetable_schema import DiagramTable, TimetableFile, TrainTable
from network.model import Direction, Line, SectionKind
from network.timetable import DAY_S, Call, CallKind, Stabled, Timetable, TimetableTrain
from plan.arranging.line_times import LineTimes

TURNS_S = 600  # assumed, to begin with: between an empty working and the train before or after it


@dataclass(frozen=True, slots=True)
class NightRule:
    """How many tracks stations inside the line keep free of sets, and whether the first trains' sets come empty."""

    kept: int
    first: bool


NIGHTS: Final = (NightRule(0, first=False), NightRule(1, first=True), NightRule(1, first=False))


@dataclass(slots=True)
class _Night:
    """Which trains' sets stand where before the day (after it), and how many more may."""

    line: Line
    rule: NightRule
    turning: frozenset[str]  # stations where trains begin or end
    sets: dict[str, list[TimetableTrain]] = field(default_factory=lambda: defaultdict(list))

    @property
    def ends(self) -> frozenset[str]:
        """The first and the last station of the line."""
        stations = self.line.stations.values()
        return frozenset(end(stations, key=lambda s: s.position_m).id for end in (min, max))

    def tracks(self, station_id: str) -> int:
        """How many tracks it has of its own."""
        tracks = self.line.stations[station_id].tracks
        sections = {track.section_id for track in tracks}
        return sum(self.line.sections[name].kind is SectionKind.TRACK for name in sections)

    def too_many(self, station_id: str) -> bool:
        """Whether more sets stand there than may."""
        tracks = self.tracks(station_id)
        kept = 0 if station_id in self.ends else self.rule.kept
        return len(self.sets[station_id]) > max(tracks - kept, min(tracks, 1))

    def nearest(self, station_id: str) -> str | None:
        """The nearest other station where one more leaves a track free; one where trains turn before any other."""
        here_m = self.line.stations[station_id].position_m
        for names in (self.turning | self.ends, frozenset(self.line.stations)):
            others = [
                self.line.stations[name]
                for name in sorted(names - {station_id})
                if self.tracks(name) > len(self.sets[name]) + 1
            ]
            if others:
                return min(others, key=lambda s: (abs(s.position_m - here_m), s.id)).id
        return None


def with_empty_workings(
    file: TimetableFile, timetable: Timetable, line: Line, times: LineTimes, rule: NightRule = NIGHTS[-1]
) -> tuple[TimetableFile, tuple[str, ...]]:
    """The day with them, and their numbers. Where no station has room, it stays as it is."""
    tables = {train.number: train for train in file.trains}
    diagrams = {diagram.stock: list(diagram.trains) for diagram in file.diagrams}
    added: list[str] = []
    turning = frozenset(train.calls[at].station_id for train in timetable.trains.values() for at in (0, -1))
    for morning in (True, False):
        night = _Night(line, rule, turning)
        for train in timetable.trains.values():
            if isinstance(train.begins if morning else train.ends, Stabled):
                night.sets[train.calls[0 if morning else -1].station_id].append(train)
        for station_id, sets in list(night.sets.items()):
            sets.sort(
                key=lambda train: train.calls[0 if morning else -1].last_s, reverse=morning is rule.first
            )
            while night.too_many(station_id) and (other := night.nearest(station_id)) is not None:
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
        call_table(Call(from_id, None, None, leaves_s, CallKind.OPERATIONAL, inferred=True)),
        call_table(Call(to_id, None, leaves_s + run_s, None, CallKind.OPERATIONAL, inferred=True)),
    ]
    begins, ends = ("stabled", f"becomes:{train.number}") if morning else (f"from:{train.number}", "stabled")
    return train_table(number, direction, calls, begins, ends, revenue=False)
