"""What became of a run in one word and a sentence: what a sweep counts. A forked copy says it, so it makes no tables.

Only what every drill expects is asked for: that nothing unsafe happens and that every train arrives.
"""

from __future__ import annotations

from enum import Enum
from typing import Final

import msgspec

from simulation.faults.script import Script
from simulation.judge.checkers import Checker
from simulation.result import RunResult
from study.drilling.forks import CopyDied
from study.drilling.scores import ON_TIME_S
from study.runner.outcome import broken_rules, unfinished

_RULES: Final = frozenset(checker.value for checker in Checker)


class OutcomeKind(Enum):
    """Classes of outcomes, the good ones first."""

    ON_TIME = "all arrive, within 60 s of plan"
    LATE = "all arrive, late"
    OWN = "wrong only as the drill itself expects"
    NOT_APPLICABLE = "fault not applicable"
    NOT_ARRIVED = "not every train arrives"
    BROKEN = "broken"
    CRASH = "crash"


BAD: Final = frozenset({OutcomeKind.NOT_ARRIVED, OutcomeKind.BROKEN, OutcomeKind.CRASH})


class SweptRun(msgspec.Struct, frozen=True):
    """One run. `label` is its class in words; `late_s` by how much it was late at most, `digest` which run it was."""

    kind: OutcomeKind
    label: str
    late_s: float = 0.0
    digest: str = ""

    @property
    def bad(self) -> bool:
        """Whether something that every drill expects was not so."""
        return self.kind in BAD

    def beside(self, *own: SweptRun) -> SweptRun:
        """This run, of a script that may end as `own` by itself, or of a fault beside it: nothing is bad that is so."""
        known = {words for run in own if run.kind is self.kind for words in run.label.split(", ")}
        if self.bad and self.kind is not OutcomeKind.CRASH and known.issuperset(self.label.split(", ")):
            return msgspec.structs.replace(self, kind=OutcomeKind.OWN, label=OutcomeKind.OWN.value)
        return self


def expected_breaks(script: Script) -> tuple[SweptRun, ...]:
    """The rules that a drill says may be broken, as persons are wrong in it: each as a run in which it was."""
    wrong = (e for e in script.expectations if e.absent and e.holds)
    return tuple(SweptRun(OutcomeKind.BROKEN, f"invariant {rule}") for e in wrong for rule in e.rules)


def swept_run_of(result: RunResult, script: Script) -> SweptRun:
    """The class of a run that came to its end; the gravest where there are several."""
    late_s, digest = late_s_max(result), result.digest
    begun = {id(course.item) for course in result.courses}
    first = next(iter((*script.faults, *script.acts)), None)
    if broken := broken_in(result):
        return SweptRun(OutcomeKind.BROKEN, ", ".join(broken), late_s, digest)
    if unfinished(result):
        return SweptRun(
            OutcomeKind.NOT_ARRIVED, f"{OutcomeKind.NOT_ARRIVED.value}: {_waiting(result)}", late_s, digest
        )
    if first is not None and id(first) not in begun:
        return SweptRun(OutcomeKind.NOT_APPLICABLE, OutcomeKind.NOT_APPLICABLE.value, late_s, digest)
    kind = OutcomeKind.ON_TIME if late_s <= ON_TIME_S else OutcomeKind.LATE
    cut = ", but for what was cancelled" if any(stop.cancelled for stop in result.stops) else ""
    return SweptRun(kind, f"{kind.value}{cut}", late_s, digest)


def swept_run_of_death(died: CopyDied) -> SweptRun:
    """The class of a run that had no end."""
    return SweptRun(OutcomeKind.CRASH, f"{OutcomeKind.CRASH.value} {died.why}")


def broken_in(result: RunResult) -> tuple[str, ...]:
    """What was unsafe in a run, each kind once, in the order in which it came; not where and when."""
    words: list[str] = []
    for _, text in sorted(broken_rules(result)):
        rule, _, _ = text.partition(":")
        _, _, unsafe = text.partition(" ")
        words.append(f"invariant {rule}" if rule in _RULES else f"unsafe: {unsafe}")
    collided = [Checker.SUMO_COLLISION.value] if result.collisions else []
    return tuple(dict.fromkeys([*words, *collided]))


def late_s_max(result: RunResult) -> float:
    """Most seconds after plan of any arrival or departure; 0 where none was late; of what was cut as stated."""
    pairs = [
        pair
        for stop in result.stops
        for pair in (
            (stop.arrival_s, stop.planned_arrival_s),
            (stop.departure_s, stop.planned_departure_s),
        )
    ]
    late = [real - planned for real, planned in pairs if real is not None and planned is not None]
    return round(max([0.0, *late, *(stop.stated_late_s or 0.0 for stop in result.stops)]), 1)


def _waiting(result: RunResult) -> str:
    """Who waits for what, without the place; why the run ended where nobody waits."""
    waiting = sorted({f"{w.stock_id} waits for {w.waits_for}" for w in result.waiting})
    return ", ".join(waiting) or result.ended_because
