"""Timetables for the study of a second loop: a train each way every so many minutes, that can be run.

Between meeting places a train each way takes its turn: with the intervals a timetable leaves over the least running
times, a section that a down train runs through in a and an up train in b is good for one each way every

    a + b + what passes between them at either end,

and the largest of these is the interval of the line. Meets lie where that makes them lie; what is left over is
waited off at the far end and at loops. A track of a station is taken from when a train leaves the track before it until
it stands in the next one: routes are granted whole, and given back at the arrival tag. All that is assumed stands in
the constants. `python -m documents.second_loop` prints the table of the study and writes its timetables.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

from exchange.planned import TrainOnLine
from exchange.timetable_writer import file_of_trains, timetable_toml
from exchange.workings import SetRules, workings_of
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.files.timetable_schema import HeadTable
from network.model import Direction, Line
from network.patching.patch import load_patched_line
from network.timetable import Call, CallKind, no_trains, parse_timetable
from simulation.setup import Setup
from study.feasibility.check import feasibility
from study.measures.standard_times import standard_times
from vehicle.train_file import TrainType, load_train, shipped_train

FOLDER: Final = Path("docs/studies/second_loop")
TRAIN: Final = "ev_e301"
SLACK: Final = 1.08  # over the least running time, as `branchline new timetable` gives it first
ROUND_S: Final = 15  # each leg up to the next
DWELL_S: Final = 30
TURN_S: Final = 180  # at the far end: the driver changes ends, and the shortest that is published here
MEET_S: Final = 30  # from an arrival to the opposite departure: release, request, grant, throw, proof
PORTAL_S: Final = 180  # at the near end, one track: out by one portal, in by the other
FIRST_S: Final = 6 * 3600
LAST_S: Final = 22 * 3600
CHOICES: Final = ((), ("SHN",), ("NIT",), ("KNY",), ("KBN",), ("TAK",), ("SHN", "TAK"), ("NIT", "TAK"))
ROOT: Final = Path(__file__).resolve().parents[1]


@dataclass(frozen=True, slots=True)
class SingleTrackStretch:
    """Single track between two places where trains can meet, and how long each direction is in it, s."""

    from_id: str
    to_id: str
    down_s: int
    up_s: int
    at_low_s: int  # what passes between an up train's arrival and the next down train's departure
    at_high_s: int

    @property
    def interval_s(self) -> int:
        """The least time in which it takes a train each way."""
        return self.down_s + self.up_s + self.at_low_s + self.at_high_s


@dataclass(frozen=True, slots=True)
class Legs:
    """A line's legs as they are timetabled, s, by direction and the ids at their ends."""

    line: Line
    train: TrainType
    run_s: Mapping[tuple[Direction, str, str], int]

    @property
    def stations(self) -> list[str]:
        """Along the line."""
        return [s.id for s in sorted(self.line.stations.values(), key=lambda s: s.position_m)]

    @property
    def loops(self) -> list[str]:
        """Where trains can meet, both ends among them."""
        inner = [i for i in self.stations[1:-1] if len(self.line.stations[i].tracks) > 1]
        return [self.stations[0], *inner, self.stations[-1]]

    def way(self, direction: Direction, from_id: str, to_id: str) -> list[str]:
        """The stations from one to another, both among them."""
        order = self.stations if direction is Direction.DOWN else self.stations[::-1]
        return order[order.index(from_id) : order.index(to_id) + 1]

    def through_s(self, direction: Direction, from_id: str, to_id: str) -> int:
        """From a departure to the arrival some stations on, with the stops between."""
        way = self.way(direction, from_id, to_id)
        return sum(self.run_s[direction, *leg] for leg in pairwise(way)) + DWELL_S * (len(way) - 2)

    def stretches(self) -> Iterator[SingleTrackStretch]:
        """Between the places where trains can meet, along the line."""
        loops = self.loops
        for low, high in pairwise(loops):
            yield SingleTrackStretch(
                low,
                high,
                self.through_s(Direction.DOWN, low, high),
                self.through_s(Direction.UP, high, low),
                PORTAL_S if low == loops[0] else MEET_S,
                TURN_S if high == loops[-1] else MEET_S,
            )


def legs_of(line: Line, train: TrainType) -> Legs:
    """The legs of a line with the slack of a timetable."""
    setup = Setup("", line, no_trains(line, float(DWELL_S)), {"": train})
    return Legs(
        line,
        train,
        {
            (leg.direction, leg.from_id, leg.to_id): math.ceil(leg.stop_stop_s * SLACK / ROUND_S) * ROUND_S
            for leg in standard_times(setup)
        },
    )


def line_with(*loops: str) -> Line:
    """The Karasuyama line, with a second track at these halts."""
    path = shipped_line("karasuyama")
    return load_patched_line(path, {"add_loops": list(loops)}, "") if loops else load_line(path)


@dataclass(frozen=True, slots=True)
class EvenTimetable:
    """An even timetable. Waits are seconds beyond the least stop or turn, those at loops by direction."""

    legs: Legs
    every_s: int
    at_loops_s: Mapping[tuple[Direction, str], int]
    at_the_end_s: int

    @property
    def waited_s(self) -> int:
        """By the passengers of a train each way, together."""
        return sum(self.at_loops_s.values())

    def trains(self, from_s: int, to_s: int) -> Iterator[TrainOnLine]:
        """A day's trains, down ones odd; an up train as soon as a down train has brought its set and has waited."""
        for i, departs_s in enumerate(range(from_s, to_s, self.every_s)):
            down = self._calls(Direction.DOWN, departs_s)
            yield TrainOnLine(str(2 * i + 1), Direction.DOWN, down)
            up = self._calls(Direction.UP, down[-1].last_s + TURN_S + self.at_the_end_s)
            yield TrainOnLine(str(2 * i + 2), Direction.UP, up)

    def _calls(self, direction: Direction, departs_s: int) -> tuple[Call, ...]:
        order = self.legs.stations if direction is Direction.DOWN else self.legs.stations[::-1]
        calls = [Call(order[0], None, None, departs_s, CallKind.STOP)]
        at_s = departs_s
        for leg in pairwise(order):
            arrives_s = at_s + self.legs.run_s[direction, *leg]
            at_s = arrives_s + DWELL_S + self.at_loops_s.get((direction, leg[1]), 0)
            calls.append(Call(leg[1], None, arrives_s, None if leg[1] == order[-1] else at_s, CallKind.STOP))
        return tuple(calls)


def even_timetable(legs: Legs, every_s: int) -> EvenTimetable:
    """The even timetable of that interval. ValueError where a stretch or a track is taken for too long.

    From far to near: by how much a set must come back later to each loop, so that it leaves when a down train has come
    out of the next stretch. It waits at the far end as far as that leaves room, then at the loop as long as the track
    is not wanted, then the down train does.
    """
    stretches = list(legs.stretches())
    for stretch in stretches:
        if stretch.interval_s > every_s:
            raise ValueError(f"{stretch.from_id} - {stretch.to_id} is taken for {stretch.interval_s} s")
    at_loops_s: dict[tuple[Direction, str], int] = {}
    end_room_s = every_s - stretches[-1].interval_s
    at_the_end_s = 0
    round_s = stretches[-1].down_s + TURN_S + stretches[-1].up_s
    for near, far in reversed(list(pairwise(stretches))):
        # Since a down train came out of the near stretch: when its set may go back in, from when and till when.
        ready_s = 2 * DWELL_S + round_s
        last_s = every_s - near.down_s - near.up_s - near.at_low_s
        in_turn_s = ready_s % every_s
        wait_s = 0 if MEET_S <= in_turn_s <= last_s else (MEET_S - in_turn_s) % every_s
        round_s = near.down_s + ready_s + wait_s + near.up_s
        if far is stretches[-1]:
            at_the_end_s = min(wait_s, end_room_s)
            wait_s -= at_the_end_s
        for direction, taken_s in (
            (Direction.UP, far.up_s + near.up_s),
            (Direction.DOWN, near.down_s + far.down_s),
        ):
            room_s = every_s - taken_s - DWELL_S - MEET_S
            if room_s < 0:
                raise ValueError(f"a track at {near.to_id} is taken for {every_s - room_s} s")
            at_loops_s[direction, near.to_id] = min(wait_s, room_s)
            wait_s -= min(wait_s, room_s)
        if wait_s:
            raise ValueError(f"{wait_s} s too long at {near.to_id}")
    return EvenTimetable(legs, every_s, at_loops_s, at_the_end_s)


def text_of(made: EvenTimetable, stem: str, line_id: str, from_s: int = FIRST_S, to_s: int = LAST_S) -> str:
    """The timetable file. InputError where sets cannot run it."""
    trains = list(made.trains(from_s, to_s))
    workings = workings_of(trains, made.legs.line, SetRules(turn_min_s=TURN_S))
    head = HeadTable(
        id=stem,
        name=f"A train each way every {made.every_s // 60} min",
        line=line_id,
        dwell_min_s=float(DWELL_S),
        sources=["made by documents.second_loop"],
    )
    times = (
        f"times: {100 * SLACK - 100:.0f} % over the least running time of {TRAIN}, each leg up to the next {ROUND_S} s;"
        f" stops of {DWELL_S} s"
    )
    return timetable_toml(file_of_trains(head, trains, workings, [times]))


def is_possible(made: EvenTimetable, hours: int = 4) -> bool:
    """Whether `branchline check` finds nothing impossible in it."""
    try:
        text = text_of(made, "x", made.legs.line.id, FIRST_S, FIRST_S + 3600 * hours)
    except InputError:
        return False
    timetable = parse_timetable(text, "x", made.legs.line)
    stock = dict.fromkeys((diagram.stock_id for diagram in timetable.diagrams), made.legs.train)
    return feasibility(Setup("x", made.legs.line, timetable, stock)).on_time


def best(legs: Legs) -> EvenTimetable:
    """The shortest whole number of minutes that works."""
    least_s = max(stretch.interval_s for stretch in legs.stretches())
    for minutes in range(math.ceil(least_s / 60), 121):
        try:
            made = even_timetable(legs, 60 * minutes)
        except ValueError:
            continue
        if is_possible(made):
            return made
    raise ValueError("no interval of two hours or less works")


def table(choices: Sequence[Sequence[str]]) -> Iterator[str]:
    """A row for each choice of loops: the stretch that decides, the interval, the waits."""
    train = load_train(shipped_train(TRAIN))
    yield "| loops | stretch that decides | it needs | interval | trains an hour each way | waits of a pair |"
    yield "|---|---|---|---|---|---|"
    for loops in choices:
        legs = legs_of(line_with(*loops), train)
        longest = max(legs.stretches(), key=lambda stretch: stretch.interval_s)
        made = best(legs)
        names = [legs.line.stations[i].name for i in (longest.from_id, longest.to_id)]
        inner = ", ".join(legs.line.stations[i].name for i in legs.loops[1:-1])
        yield (
            f"| {inner} | {' – '.join(names)} | {longest.interval_s / 60:.1f} min | {made.every_s // 60} min"
            f" | {3600 / made.every_s:.2f} | {made.waited_s / 60:.1f} min |"
        )


_SCENARIO: Final = """extends = "karasuyama_weekday"
id = "{id}"
name = "JR Karasuyama line, a train each way every {minutes} min, {what}"
timetable = "{id}_times.toml"
"""
_LOOP: Final = """
[patch.line]
add_loops = ["{station}"]
"""
CASES: Final = (
    ("before", None, "as it is"),
    ("loop_at_hanaoka", "SHN", "with a second loop at Shimotsuke-Hanaoka"),
    ("loop_at_niita", "NIT", "with a second loop at Niita"),
)


def files() -> dict[Path, str]:
    """The scenarios and timetables of the study, each at the shortest interval that works."""
    train = load_train(shipped_train(TRAIN))
    made: dict[Path, str] = {}
    for name, station, what in CASES:
        shortest = best(legs_of(line_with(*([station] if station else [])), train))
        minutes = shortest.every_s // 60
        scenario = _SCENARIO.format(id=name, minutes=minutes, what=what)
        scenario += _LOOP.format(station=station) if station else ""
        made[ROOT / FOLDER / f"{name}.toml"] = f"# Made by documents.second_loop.\n{scenario}"
        times = text_of(shortest, f"{name}_times", "karasuyama")
        made[ROOT / FOLDER / f"{name}_times.toml"] = f"# Made by documents.second_loop.\n{times}"
    return made


def main() -> None:
    """Write the files, and print the table."""
    for path, text in files().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    sys.stdout.writelines(f"{row}\n" for row in table(CHOICES))


if __name__ == "__main__":
    main()
