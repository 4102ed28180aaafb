"""What became of a drill's expectations: judged from the journal and the true trajectories after the run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import polars as pl

from network.clock import clock
from onboard.notes import MissionBegun
from simulation.events import JournalEntry
from simulation.faults.script import Expectation, Matcher, Property
from simulation.judge.log import Checker
from simulation.result import RunResult
from simulation.setup import STEPS_PER_S
from study.record.tables import RunTables
from study.runner.outcome import missing_said, outside_said, rules_said, waiting_said
from study.wording import outcome as words
from study.wording.phrase import Phrase, joined_phrases
from study.wording.script import expectation_text, matcher_text

KMH_PER_MPS: Final = 3.6
SPEED_TOLERANCE_KMH: Final = 0.5


@dataclass(frozen=True, slots=True)
class ExpectationVerdict:
    """One expectation: whether it was met, and what happened, in words."""

    expected: Phrase
    passed: bool
    said: Phrase
    at_s: float | None = None  # when it happened, or was broken
    from_s: float = -math.inf  # the stretch of time that was judged
    to_s: float = math.inf

    @property
    def text(self) -> str:
        """What was expected, in English."""
        return self.expected.en

    @property
    def happened(self) -> str:
        """What happened, in English."""
        return self.said.en


def judge(
    expectations: tuple[Expectation, ...], result: RunResult, tables: RunTables
) -> tuple[ExpectationVerdict, ...]:
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
        self._rows: list[tuple[JournalEntry, dict[str, str]]] = []
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


def _window(expectation: Expectation, seen: _Journal) -> tuple[float, float] | Phrase:
    """The stretch of time that an expectation speaks of, or why there is none."""
    from_s = -math.inf
    if expectation.after is not None:
        at_s = seen.first(expectation.after, -math.inf, math.inf)
        if at_s is None:
            return _never(expectation.after)
        from_s = at_s
    to_s = seen.end_s if expectation.by_s is None else expectation.by_s
    if expectation.within_s is not None:
        to_s = min(to_s, from_s + expectation.within_s)
    if expectation.until is not None:
        end_s = seen.first(expectation.until, from_s, math.inf, strictly_after=True)
        if end_s is None:
            return _never(expectation.until, from_s)
        to_s = min(to_s, end_s)
    if to_s < from_s:
        return words.BACKWARDS.fill(at=_clock(to_s))
    return from_s, to_s


def _judge_event(expectation: Expectation, seen: _Journal) -> ExpectationVerdict:
    window = _window(expectation, seen)
    if isinstance(window, Phrase):
        return ExpectationVerdict(expectation_text(expectation), False, window)
    if expectation.event is None:
        raise ValueError("an expectation of an event has none")
    at_s = seen.first(expectation.event, *window)
    if expectation.absent:
        happened = words.DID_NOT if at_s is None else words.HAPPENED.fill(at=_clock(at_s))
        return ExpectationVerdict(expectation_text(expectation), at_s is None, happened, at_s, *window)
    if at_s is not None:
        return ExpectationVerdict(
            expectation_text(expectation), True, words.AT.fill(at=_clock(at_s)), at_s, *window
        )
    ever_s = seen.first(expectation.event, -math.inf, math.inf)
    happened = words.NEVER if ever_s is None else words.TOO_LATE.fill(at=_clock(ever_s))
    return ExpectationVerdict(expectation_text(expectation), False, happened, ever_s, *window)


def _judge_property(expectation: Expectation, seen: _Journal, tables: RunTables) -> ExpectationVerdict:
    result = seen.result
    if expectation.holds is Property.NO_INVARIANT_BROKEN:
        return _judge_safety(expectation, result)
    if expectation.holds is Property.EVERYONE_ARRIVES:
        missing = missing_said(result)
        missing += tuple(waiting_said(waiting) for waiting in result.waiting if missing)
        cut = ", ".join(result.cut)
        arrived = words.OTHERS_ARRIVED.fill(trains=cut) if cut else words.ALL_ARRIVED
        happened = joined_phrases(missing, "; ", "；") if missing else arrived
        return ExpectationVerdict(
            expectation_text(expectation), (not missing) is not expectation.absent, happened
        )
    window = _window(expectation, seen)
    if isinstance(window, Phrase):
        return ExpectationVerdict(expectation_text(expectation), False, window)
    if expectation.holds is Property.SPEED_AT_MOST:
        return _judge_speed(expectation, tables, *window)
    return _judge_entry(expectation, tables, *window)


def _judge_safety(expectation: Expectation, result: RunResult) -> ExpectationVerdict:
    """No broken invariant, no collision, nothing that the world calls unsafe; or some, and none but those named."""
    broken = rules_said(result)
    excused = [v for v in result.violations if v.checker in expectation.rules]
    outside = [words.OUTSIDE_DESIGN.fill(what=what) for what in outside_said(result)]
    none = joined_phrases((words.NONE_BROKEN, *outside), "; ", "；")
    at_s, happened = min(broken, key=lambda found: (found[0], found[1].en), default=(None, none))
    collided = result.collisions if Checker.SUMO_COLLISION.value in expectation.rules else ()
    only = not expectation.rules or len(broken) == len(excused) + len(collided)
    passed = bool(broken) is expectation.absent and only
    return ExpectationVerdict(expectation_text(expectation), passed, happened, at_s)


def _judge_speed(
    expectation: Expectation, tables: RunTables, from_s: float, to_s: float
) -> ExpectationVerdict:
    own, t_s = tables.trajectory.filter(unit=expectation.unit), pl.col("t_s")
    rows = own.filter((t_s >= from_s) & (t_s <= to_s))
    if rows.is_empty():  # of who is on the line there is a row a second
        rows = own.filter((t_s > from_s - 1.0) & (t_s < to_s + 1.0))
    if rows.is_empty():
        return ExpectationVerdict(expectation_text(expectation), False, words.OFF_LINE, None, from_s, to_s)
    fastest_kmh = float(rows["speed_mps"].max() or 0.0) * KMH_PER_MPS  # type: ignore[arg-type]
    passed = fastest_kmh <= expectation.kmh + SPEED_TOLERANCE_KMH
    return ExpectationVerdict(
        expectation_text(expectation), passed, words.AT_MOST.fill(kmh=fastest_kmh), None, from_s, to_s
    )


def _judge_entry(
    expectation: Expectation, tables: RunTables, from_s: float, to_s: float
) -> ExpectationVerdict:
    rows = tables.blocks.filter(
        (pl.col("unit") == expectation.unit)
        & (pl.col("section") == expectation.section)
        & (pl.col("entered_s") >= from_s)
        & (pl.col("entered_s") <= to_s)
    )
    if rows.is_empty():
        return ExpectationVerdict(expectation_text(expectation), True, words.NOT_ENTERED, None, from_s, to_s)
    at_s = float(rows["entered_s"][0])
    return ExpectationVerdict(
        expectation_text(expectation), False, words.ENTERED.fill(at=_clock(at_s)), at_s, from_s, to_s
    )


def _never(matcher: Matcher, from_s: float = -math.inf) -> Phrase:
    what = Phrase(matcher.text, matcher_text(matcher))
    if math.isfinite(from_s):
        return words.NOT_FROM.fill(what=what, at=_clock(from_s))
    return words.NO_STRETCH.fill(what=what)


def _clock(t_s: float) -> str:
    return f"{clock(int(t_s))}.{int(t_s * 10) % 10}"
