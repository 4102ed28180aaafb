"""What became of a drill's expectations: judged from the journal and the true trajectories after the run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import polars as pl

from network.clock import clock
from onboard.notes import MissionBegun
from simulation.events import Entry
from simulation.faults.script import Expectation, Matcher, Property
from simulation.result import RunResult
from simulation.setup import STEPS_PER_S
from study.run.outcome import broken_rules, outside_design, unfinished
from study.run.tables import RunTables

KMH_PER_MPS: Final = 3.6
SPEED_TOLERANCE_KMH: Final = 0.5


@dataclass(frozen=True, slots=True)
class Verdict:
    """One expectation: whether it was met, and what happened, in words."""

    text: str
    passed: bool
    happened: str
    at_s: float | None = None  # when it happened, or was broken
    from_s: float = -math.inf  # the stretch of time that was judged
    to_s: float = math.inf


def judge(expectations: tuple[Expectation, ...], result: RunResult, tables: RunTables) -> tuple[Verdict, ...]:
    """A verdict for each expectation, in order."""
    seen = _Journal(result)
    return tuple(
        _judge_event(expectation, seen)
        if expectation.holds is None
        else _judge_property(expectation, seen, tables)
        for expectation in expectations
    )


class _Journal:
    """The journal with the train number that each unit ran at each entry."""

    def __init__(self, result: RunResult) -> None:
        self.result = result
        self.end_s = result.end_step / STEPS_PER_S
        self._rows: list[tuple[Entry, dict[str, str]]] = []
        train_of: dict[str, str] = {}
        for entry in result.journal.entries:
            if isinstance(entry.event, MissionBegun):
                train_of = {**train_of, entry.who: entry.event.train}
            self._rows.append((entry, train_of))

    def first(
        self, matcher: Matcher, from_s: float, to_s: float, strictly_after: bool = False
    ) -> float | None:
        """Time of the first entry that matches in [from, to]."""
        for entry, train_of in self._rows:
            late_enough = entry.t_s > from_s if strictly_after else entry.t_s >= from_s
            if late_enough and entry.t_s <= to_s and matcher.matches(entry, train_of):
                return entry.t_s
        return None


def _window(expectation: Expectation, seen: _Journal) -> tuple[float, float] | str:
    """The stretch of time that an expectation speaks of, or why there is none."""
    from_s = -math.inf
    if expectation.after is not None:
        at_s = seen.first(expectation.after, -math.inf, math.inf)
        if at_s is None:
            return f"'{expectation.after.text}' never happened"
        from_s = at_s
    to_s = seen.end_s if expectation.by_s is None else expectation.by_s
    if expectation.within_s is not None:
        to_s = min(to_s, from_s + expectation.within_s)
    if expectation.until is not None:
        end_s = seen.first(expectation.until, from_s, math.inf, strictly_after=True)
        if end_s is None:
            return f"'{expectation.until.text}' never happened"
        to_s = min(to_s, end_s)
    if to_s < from_s:
        return f"the time given ends at {_clock(to_s)}, before it begins"
    return from_s, to_s


def _judge_event(expectation: Expectation, seen: _Journal) -> Verdict:
    window = _window(expectation, seen)
    if isinstance(window, str):
        return Verdict(expectation.text, False, window)
    if expectation.event is None:
        raise ValueError("an expectation of an event has none")
    at_s = seen.first(expectation.event, *window)
    if expectation.absent:
        happened = "did not happen" if at_s is None else f"happened at {_clock(at_s)}"
        return Verdict(expectation.text, at_s is None, happened, at_s, *window)
    if at_s is not None:
        return Verdict(expectation.text, True, f"at {_clock(at_s)}", at_s, *window)
    ever_s = seen.first(expectation.event, -math.inf, math.inf)
    happened = "never happened" if ever_s is None else f"happened at {_clock(ever_s)}, outside the time given"
    return Verdict(expectation.text, False, happened, ever_s, *window)


def _judge_property(expectation: Expectation, seen: _Journal, tables: RunTables) -> Verdict:
    result = seen.result
    if expectation.holds is Property.NO_INVARIANT_BROKEN:
        return _judge_safety(expectation, result)
    if expectation.holds is Property.EVERYONE_ARRIVES:
        happened = "; ".join(unfinished(result))
        return Verdict(expectation.text, (not happened) is not expectation.absent, happened or "all arrived")
    window = _window(expectation, seen)
    if isinstance(window, str):
        return Verdict(expectation.text, False, window)
    if expectation.holds is Property.SPEED_AT_MOST:
        return _judge_speed(expectation, tables, *window)
    return _judge_entry(expectation, tables, *window)


def _judge_safety(expectation: Expectation, result: RunResult) -> Verdict:
    """No broken invariant, no collision, nothing that the world calls unsafe."""
    broken = broken_rules(result)
    outside = outside_design(result)
    none = "; outside the design: ".join(("none broken", *outside))
    at_s, happened = min(broken, default=(None, none))
    return Verdict(expectation.text, (not broken) is not expectation.absent, happened, at_s)


def _judge_speed(expectation: Expectation, tables: RunTables, from_s: float, to_s: float) -> Verdict:
    rows = tables.trajectory.filter(
        (pl.col("unit") == expectation.unit) & (pl.col("t_s") >= from_s) & (pl.col("t_s") <= to_s)
    )
    if rows.is_empty():
        return Verdict(expectation.text, True, "stood all the time", None, from_s, to_s)
    fastest_kmh = float(rows["speed_mps"].max() or 0.0) * KMH_PER_MPS  # type: ignore[arg-type]
    passed = fastest_kmh <= expectation.kmh + SPEED_TOLERANCE_KMH
    return Verdict(expectation.text, passed, f"at most {fastest_kmh:.1f} km/h", None, from_s, to_s)


def _judge_entry(expectation: Expectation, tables: RunTables, from_s: float, to_s: float) -> Verdict:
    rows = tables.blocks.filter(
        (pl.col("unit") == expectation.unit)
        & (pl.col("section") == expectation.section)
        & (pl.col("entered_s") >= from_s)
        & (pl.col("entered_s") <= to_s)
    )
    if rows.is_empty():
        return Verdict(expectation.text, True, "did not enter", None, from_s, to_s)
    at_s = float(rows["entered_s"][0])
    return Verdict(expectation.text, False, f"entered at {_clock(at_s)}", at_s, from_s, to_s)


def _clock(t_s: float) -> str:
    return f"{clock(int(t_s))}.{int(t_s * 10) % 10}"
