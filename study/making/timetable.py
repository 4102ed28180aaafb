"""A new timetable: trains to and fro over the whole line at even intervals (折返し運転), which can work.

Trains call at every place with a platform. Through a signal station (信号場) they run, unless the pattern needs its
tracks for meets: then they stand there without passengers (運転停車).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias

from exchange.planned import TrainOnLine
from exchange.timetable_writer import file_of_trains, timetable_toml
from exchange.workings import workings_of
from network.clock import clock
from network.errors import COMMAND_LINE, InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.files.text_input import existing_file
from network.files.timetable_schema import HeadTable
from network.files.toml_text import text_toml
from network.model import Direction, Line
from network.timetable import Call, CallKind, no_trains, parse_timetable
from simulation.setup import Setup
from study.feasibility.check import feasibility
from study.making.place import checked_new, named_from, write_new
from study.measures.standard_times import StandardTime, standard_times
from vehicle.train_file import TrainType, load_train, shipped_train

DWELL_S: Final = 30.0
# Assumed: over the least running time, as timetables have; more where that brings the meets into stations.
SLACKS: Final = (1.08, 1.15, 1.25, 1.35, 1.5)
ROUND_S: Final = 15
MINUTE_S: Final = 60
Legs: TypeAlias = dict[Direction, list[StandardTime]]
Kinds: TypeAlias = dict[str, CallKind]
FIRST_CYCLES: Final = 4  # a short day is tried first: what does not work in it does not work in a long one


@dataclass(frozen=True, slots=True)
class Pattern:
    """What is asked for: a train each way every so often, s, with first departures from `from_s` on, to `to_s`."""

    every_s: int
    from_s: int
    to_s: int


def new_timetable(
    line_name: str, train_name: str, pattern: Pattern, out: Path, scenario: Path | None
) -> PatternDay:
    """Write a timetable, and a scenario that runs it if there is a path for it. InputError."""
    stem = checked_new(out)
    if scenario is not None:
        checked_new(scenario, "--scenario")
    _check(pattern)
    line = load_line(_file(line_name) or shipped_line(line_name))
    train = load_train(_file(train_name) or shipped_train(train_name))
    day = timetable_day(line, train, pattern, stem)
    write_new(out, day.text)
    if scenario is not None:
        write_scenario(scenario, line_name, out, train_name)
    return day


def write_scenario(file: Path, line_name: str, timetable: Path, train_name: str) -> None:
    """Write a scenario that runs that timetable. InputError where there is a file already."""
    names = (named_from(file, name) for name in (line_name, str(timetable), train_name))
    write_new(file, scenario_text(file.stem, *names))


def _file(name: str) -> Path | None:
    return Path(name) if name.endswith(".toml") and existing_file(Path(name)) else None


def _check(pattern: Pattern) -> None:
    if not MINUTE_S <= pattern.every_s <= 24 * 3600:
        raise InputError(COMMAND_LINE, "--every", pattern.every_s // 60, "1 to 1440 minutes")
    if pattern.from_s >= pattern.to_s:
        raise InputError(COMMAND_LINE, "--to", clock(pattern.to_s), f"a time after {clock(pattern.from_s)}")


def timetable_day(line: Line, train: TrainType, pattern: Pattern, stem: str) -> PatternDay:
    """The day with room everywhere, if there is one, by as little over the least running times as may be.

    InputError where no even pattern of that interval can work on the line.
    """
    times = standard_times(Setup(stem, line, no_trains(line, DWELL_S), {"": train}))
    legs = {d: [time for time in times if time.direction is d] for d in Direction}
    if not all(legs.values()):
        raise InputError(
            COMMAND_LINE, "--line", line.id, "a line with a way from end to end in both directions"
        )
    short = Pattern(
        pattern.every_s, pattern.from_s, min(pattern.to_s, pattern.from_s + FIRST_CYCLES * pattern.every_s)
    )
    best: PatternDay | None = None
    for slack in SLACKS:
        for kinds in _kinds(line, legs):
            trials = (
                PatternTrial(line, train, legs, kinds, slack, offset_s, stem)
                for offset_s in _offsets(legs, kinds, slack, pattern.every_s)
            )
            for trial in _best_first(trials, short):
                day = _day(trial, pattern)
                if day is not None and (best is None or day.rank < best.rank):
                    best = day
                    break
            if best is not None and not best.tight:
                return best
    if best is not None:
        return best
    raise InputError(COMMAND_LINE, "--every", pattern.every_s // 60, _expected(line, legs, pattern))


def _best_first(trials: Iterator[PatternTrial], short: Pattern) -> Iterator[PatternTrial]:
    """Those that work on a short day, the best first; none after one with room everywhere and no set more."""
    found: list[tuple[tuple[int, int], PatternTrial]] = []
    for trial in trials:
        day = _day(trial, short)
        if day is None:
            continue
        found.append((day.rank, trial))
        if not day.tight and day.sets <= min(sets for (_, sets), _ in found):
            break
    for _, trial in sorted(found, key=lambda one: one[0]):
        yield trial


def _expected(line: Line, legs: Legs, pattern: Pattern) -> str:
    """What would work instead, as far as it is known without trying."""
    least_min = _least(legs, next(_kinds(line, legs)))
    if 60 * least_min > pattern.every_s:
        return f"a longer interval; {least_min} minutes are enough for one set"
    return f"another interval, or another --train: one set needs {least_min} minutes, but no even pattern was found"


def _kinds(line: Line, legs: Legs) -> Iterator[Kinds]:
    """How trains call at signal stations: first they run through all, then they stand where two can meet."""
    ends = {end for way in legs.values() for end in (way[0].from_id, way[-1].to_id)}
    signal = {station.id: station for station in line.stations.values() if station.is_signal_station}
    through = {name: CallKind.OPERATIONAL if name in ends else CallKind.PASS for name in signal}
    yield through
    loops = {name for name, station in signal.items() if len(station.tracks) > 1} - ends
    if loops:
        yield through | dict.fromkeys(loops, CallKind.OPERATIONAL)


def _offsets(legs: Legs, kinds: Kinds, slack: float, every_s: int) -> Iterator[int]:
    """By how much up trains leave after down trains: first so that a set turns back at once, then any minute."""
    turns_s = _run_s(legs[Direction.DOWN], kinds, slack) + 5 * MINUTE_S
    for minute in range(max(1, every_s // MINUTE_S)):
        yield (turns_s + minute * MINUTE_S) // MINUTE_S * MINUTE_S % every_s


def _leg_s(leg: StandardTime, kinds: Kinds, slack: float) -> int:
    from_passing, to_passing = (kinds.get(name) is CallKind.PASS for name in (leg.from_id, leg.to_id))
    time_s = {
        (False, False): leg.stop_stop_s,
        (False, True): leg.stop_pass_s,
        (True, False): leg.pass_stop_s,
        (True, True): leg.pass_pass_s,
    }[from_passing, to_passing]
    # Trains do not pass the ends of the line, which alone have no time of passing.
    return math.ceil((leg.stop_stop_s if time_s is None else time_s) * slack / ROUND_S) * ROUND_S


def _run_s(legs: Sequence[StandardTime], kinds: Kinds, slack: float) -> int:
    """From the first departure to the last arrival, whole minutes."""
    calls = _calls(legs, kinds, slack, 0)
    return math.ceil(calls[-1].first_s / MINUTE_S) * MINUTE_S


def _least(legs: Legs, kinds: Kinds) -> int:
    """The least interval, min, for one set: there and back, with ten minutes at both ends, in steps of five."""
    return math.ceil((sum(_run_s(way, kinds, SLACKS[0]) for way in legs.values()) / MINUTE_S + 20) / 5) * 5


def _calls(legs: Sequence[StandardTime], kinds: Kinds, slack: float, departs_s: int) -> tuple[Call, ...]:
    calls = [Call(legs[0].from_id, None, None, departs_s, kinds.get(legs[0].from_id, CallKind.STOP))]
    at_s = departs_s
    for leg in legs:
        kind = kinds.get(leg.to_id, CallKind.STOP)
        arrives_s = at_s + _leg_s(leg, kinds, slack)
        at_s = arrives_s if kind is CallKind.PASS else math.ceil((arrives_s + DWELL_S) / 30) * 30
        arrival_s = None if kind is CallKind.PASS else arrives_s
        calls.append(Call(leg.to_id, None, arrival_s, at_s if leg is not legs[-1] else None, kind))
    return tuple(calls)


@dataclass(frozen=True, slots=True)
class PatternTrial:
    """What a pattern is tried with: `slack` over the least running time, up trains `offset_s` after down trains.

    `kinds` has how trains call where they do not stop for passengers.
    """

    line: Line
    train: TrainType
    legs: Legs
    kinds: Kinds
    slack: float
    offset_s: int
    stem: str


@dataclass(frozen=True, slots=True)
class PatternDay:
    """A day of a pattern that works: how many trains and sets, at how many places it is tight, and its file."""

    trains: int
    sets: int
    tight: int
    text: str

    @property
    def rank(self) -> tuple[int, int]:
        """Less is better."""
        return self.tight, self.sets


def _day(day: PatternTrial, pattern: Pattern) -> PatternDay | None:
    """None where it cannot work."""
    line, train, stem = day.line, day.train, day.stem
    planned: list[TrainOnLine] = []
    for direction, first, begin_s in (
        (Direction.DOWN, 1, pattern.from_s),
        (Direction.UP, 2, pattern.from_s + day.offset_s),
    ):
        departures_s = range(begin_s, pattern.to_s, pattern.every_s)
        planned += [
            TrainOnLine(
                str(first + 2 * i), direction, _calls(day.legs[direction], day.kinds, day.slack, departs_s)
            )
            for i, departs_s in enumerate(departures_s)
        ]
    try:
        workings = workings_of(planned, line)
        head = HeadTable(
            id=stem,
            name=f"A train each way every {pattern.every_s // 60} min",
            line=line.id,
            dwell_min_s=DWELL_S,
            sources=["made by `branchline new timetable`"],
        )
        times = (
            f"times: {100 * day.slack - 100:.0f} % over the least running time of {train.id}, each leg up to the next"
            f" {ROUND_S} s"
        )
        text = timetable_toml(file_of_trains(head, planned, workings, [times]))
        timetable = parse_timetable(text, stem, line)
    except InputError:
        return None
    stock = dict.fromkeys((diagram.stock_id for diagram in timetable.diagrams), train)
    found = feasibility(Setup(stem, line, timetable, stock))
    if workings.warnings or not found.on_time:
        return None
    return PatternDay(len(planned), len(stock), found.tight_places, _comments(pattern, line) + text)


def _comments(pattern: Pattern, line: Line) -> str:
    return f"""# {line.name}: a train each way every {pattern.every_s // 60} min from {clock(pattern.from_s)[:5]}.
# Change times, take trains out, add some: `branchline check` says what cannot work. A call may also say
# `pass = "HH:MM:SS"` (runs through), `operational = true` (stands without passengers) and `track`; docs/files.md
# has every key.

"""


def scenario_text(stem: str, line: str, timetable: str, train: str) -> str:
    """A scenario that runs a new timetable."""
    return f"""# Run it with `branchline run {stem}.toml`; what is not said here is as docs/files.md has it.
id = {text_toml(stem)}
name = {text_toml(stem)}
line = {text_toml(line)}
timetable = {text_toml(timetable)}

[trains]
default = {text_toml(train)}
"""
