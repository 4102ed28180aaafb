"""A day of trains that repeat, as a timetable and a scenario that run it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from exchange.timetable_writer import file_of_timetable, timetable_toml
from network.files.json_input import write_aside
from network.files.timetable_schema import HeadTable
from network.files.toml_text import text_toml
from network.model import Direction
from network.timetable import BecomesTrain, Diagram, FromTrain, Timetable, TimetableTrain
from plan.least_interval import RepeatedPaths
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

    def trains(self, setup: Setup) -> list[tuple[TimetableTrain, ...]]:
        """The trains of each set that comes onto the line, in order of time; down trains have odd numbers."""
        first_s = min(
            path.trains[0].calls[0].last_s + moves[1]
            for path, moves in zip(self.pattern.paths, self.moves_s, strict=True)
        )
        found: list[tuple[TimetableTrain, ...]] = []
        for again, departs_s in enumerate(range(self.from_s, self.to_s, self.every_s)):
            for path, moves in zip(self.pattern.paths, self.moves_s, strict=True):
                by_s = departs_s - first_s
                added = added_path(setup, path, again, [move + by_s for move in moves])
                found.append(_numbered(added.trains, again))
        return sorted(found, key=lambda own: own[0].calls[0].last_s)


def _numbered(trains: tuple[TimetableTrain, ...], again: int) -> tuple[TimetableTrain, ...]:
    numbers = {t.number: str(2 * again + (1 if t.direction is Direction.DOWN else 2)) for t in trains}
    return tuple(
        replace(
            train,
            number=numbers[train.number],
            begins=FromTrain(numbers[train.begins.number])
            if isinstance(train.begins, FromTrain)
            else train.begins,
            ends=BecomesTrain(numbers[train.ends.number])
            if isinstance(train.ends, BecomesTrain)
            else train.ends,
        )
        for train in trains
    )


def timetable_of(setup: Setup, repeated: Repetition, timetable_id: str) -> Timetable:
    """The day as a timetable. A set that left the line comes back where it left, first out, first in."""
    sets = repeated.trains(setup)
    outside: dict[str, list[tuple[int, int]]] = defaultdict(list)
    workings: list[list[str]] = []
    for trains in sets:
        calls = trains[0].calls[0], trains[-1].calls[-1]
        waiting = outside[calls[0].station_id]
        if waiting and waiting[0][0] + OUTSIDE_S <= calls[0].last_s:
            own = waiting.pop(0)[1]
        else:
            own = len(workings)
            workings.append([])
        workings[own] += [train.number for train in trains]
        outside[calls[1].station_id].append((calls[1].first_s, own))
        outside[calls[1].station_id].sort()
    head = HeadTable(
        id=timetable_id,
        name=f"A train each way every {repeated.every_s} s",
        line=setup.line.id,
        dwell_min_s=setup.unit.dwell_min_s,
        sources=["made by branchline best"],
        assumed=[
            f"diagrams: sets come back first in, first out, at least {OUTSIDE_S // 60} min outside the line"
        ],
    )
    by_number = {train.number: train for own in sets for train in own}
    diagrams = tuple(Diagram(f"V{at}", tuple(own)) for at, own in enumerate(workings, start=1))
    return Timetable(head, by_number, diagrams)


def write_day(out: Path, timetable: Timetable, extends: str, loops: Sequence[str] = ()) -> None:
    """A scenario file, and its timetable beside it; `loops` are laid at halts. Raises InputError."""
    times = out.with_name(f"{timetable.head.id}.toml")
    write_aside(times, timetable_toml(file_of_timetable(timetable)))
    rows = [
        f"extends = {text_toml(extends)}",
        f"id = {text_toml(out.stem)}",
        f"name = {text_toml(timetable.head.name)}",
        f"timetable = {text_toml(times.name)}",
    ]
    if loops:
        rows += ["", "[patch.line]", f"add_loops = [{', '.join(map(text_toml, loops))}]"]
    write_aside(out, "\n".join(rows) + "\n")
