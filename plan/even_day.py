"""A day of trains that repeat, as a timetable and a scenario that run it."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any, Final

from exchange.timetable_writer import file_of_timetable, timetable_toml
from network.files.json_input import write_aside
from network.files.timetable_schema import HeadTable
from network.files.toml_text import toml_of
from network.model import Direction
from network.timetable import BecomesTrain, Diagram, FromTrain, Timetable, TimetableTrain
from plan.least_interval import RepeatedPaths
from plan.round_day import Working, cut_to_day
from simulation.setup import Setup
from study.capacity.standard import added_path

OUTSIDE_S: Final = (
    1800  # assumed: a set that left the line can be back after that, as `exchange.workings` has it
)


@dataclass(frozen=True, slots=True)
class Repetition:
    """Trains of a pattern, by how much each leg of each path is moved, every so many s from one time to another."""

    pattern: RepeatedPaths
    moves_s: Sequence[Sequence[float]]
    every_s: int
    from_s: int = 6 * 3600
    to_s: int = 22 * 3600

    def workings(self, setup: Setup) -> list[Working]:
        """The trains of each set; down trains have odd numbers."""
        return self._round(setup) if self.pattern.goes_round else self._from_portals(setup)

    def _from_portals(self, setup: Setup) -> list[Working]:
        """A set that left the line comes back where it left, first out, first in."""
        pattern = list(zip(self.pattern.paths, self.moves_s, strict=True))
        first_s = min(path.trains[0].calls[0].last_s + moves[1] for path, moves in pattern)
        found: list[Working] = []
        for again, departs_s in enumerate(range(self.from_s, self.to_s, self.every_s)):
            for path, moves in pattern:
                by_s = [move + departs_s - first_s for move in moves]
                found.append(added_path(setup, path, again, by_s).trains)
        workings: list[Working] = []
        numbers = _odd_and_even()
        outside: dict[str, list[tuple[int, int]]] = defaultdict(list)
        for unnumbered in sorted(found, key=lambda own: own[0].calls[0].last_s):
            trains = _numbered(unnumbered, numbers)
            leaves, comes = trains[-1].calls[-1], trains[0].calls[0]
            waiting = outside[comes.station_id]
            own = len(workings)
            if waiting and waiting[0][0] + OUTSIDE_S <= comes.last_s:
                own = waiting.pop(0)[1]
                workings[own] += trains
            else:
                workings.append(trains)
            outside[leaves.station_id].append((leaves.first_s, own))
            outside[leaves.station_id].sort()
        return workings

    def _round(self, setup: Setup) -> list[Working]:
        """Each set goes on with its next round as many repetitions later as there are sets."""
        (path,), (moves,), (legs,) = self.pattern.paths, self.moves_s, self.pattern.legs
        sets = round((moves[-1] - moves[0] + legs[-1].departs_s - legs[0].departs_s) / self.every_s)
        way = sum(leg.number == legs[-1].number for leg in legs)  # legs of one train
        first_s = path.trains[1].calls[0].last_s + moves[1]
        workings: list[list[TimetableTrain]] = [[] for _ in range(sets)]
        numbers = _odd_and_even()
        for again in range(sets + math.ceil((self.to_s - self.from_s) / self.every_s)):
            by_s = self.from_s + (again - sets) * self.every_s - first_s
            added = added_path(
                setup, path, again, [by_s + move for move in (*[moves[0]] * (way - 1), *moves)]
            )
            workings[again % sets] += _numbered(added.trains[1:], numbers)
        cut = (cut_to_day(setup.line, working, self.from_s, self.to_s) for working in workings)
        return [working for working in cut if working]


def _numbered(trains: tuple[TimetableTrain, ...], next_number: Mapping[Direction, Iterator[int]]) -> Working:
    numbers = [str(next(next_number[train.direction])) for train in trains]
    return tuple(
        replace(
            train,
            number=number,
            begins=FromTrain(numbers[at - 1]) if isinstance(train.begins, FromTrain) and at else train.begins,
            ends=BecomesTrain(numbers[at + 1]) if isinstance(train.ends, BecomesTrain) else train.ends,
        )
        for at, (train, number) in enumerate(zip(trains, numbers, strict=True))
    )


def _odd_and_even() -> dict[Direction, Iterator[int]]:
    return {Direction.DOWN: count(1, 2), Direction.UP: count(2, 2)}


def timetable_of(setup: Setup, repeated: Repetition, timetable_id: str) -> Timetable:
    """The day as a timetable."""
    workings = repeated.workings(setup)
    head = HeadTable(
        id=timetable_id,
        name=f"{repeated.pattern.trains_each_way} each way every {repeated.every_s} s",
        line=setup.line.id,
        dwell_min_s=setup.unit.dwell_min_s,
        sources=["made by branchline best"],
        assumed=[
            f"diagrams: sets come back first in, first out, at least {OUTSIDE_S // 60} min outside the line"
        ],
    )
    by_number = {train.number: train for own in workings for train in own}
    diagrams = tuple(
        Diagram(f"V{at}", tuple(train.number for train in own)) for at, own in enumerate(workings, start=1)
    )
    return Timetable(head, by_number, diagrams)


def write_day(out: Path, timetable: Timetable, extends: str, changes: Mapping[str, Any]) -> None:
    """A scenario file, and its timetable beside it; `changes`: other tables of the scenario. Raises InputError."""
    times = out.with_name(f"{timetable.head.id}.toml")
    write_aside(times, timetable_toml(file_of_timetable(timetable)))
    head = {"extends": extends, "id": out.stem, "name": timetable.head.name, "timetable": times.name}
    write_aside(out, toml_of({**head, **changes}))
