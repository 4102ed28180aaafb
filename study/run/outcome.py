"""What became of a run in one word and a sentence: what a sweep counts. A forked copy says it, so it makes no tables.

Only what every drill expects is asked for: that nothing unsafe happens and that every train arrives.
"""

from __future__ import annotations

from enum import Enum
from typing import Final

import msgspec

from simulation.events import Unsafe
from simulation.faults.script import Script
from simulation.result import RunResult
from study.run.forks import Died
from study.run.scores import ON_TIME_S
from study.run.verdict import not_arrived

NOTHING: Final = "nothing"  # what a train waits for that waits for nobody


class Kind(Enum):
    """Classes of outcomes, the good ones first."""

    ON_TIME = "all arrive, within 60 s of plan"
    LATE = "all arrive, late"
    NOT_APPLICABLE = "fault not applicable"
    NOT_ARRIVED = "not every train arrives"
    BROKEN = "broken"
    CRASH = "crash"


BAD: Final = frozenset({Kind.NOT_ARRIVED, Kind.BROKEN, Kind.CRASH})


class Outcome(msgspec.Struct, frozen=True):
    """One run. `label` is its class in words; `late_s` by how much it was late at most, `digest` which run it was."""

    kind: Kind
    label: str
    late_s: float = 0.0
    digest: str = ""

    @property
    def bad(self) -> bool:
        """Whether something that every drill expects was not so."""
        return self.kind in BAD


def outcome_of(result: RunResult, script: Script) -> Outcome:
    """The class of a run that came to its end; the gravest where there are several."""
    late_s, digest = late_s_max(result), result.digest
    begun = {id(course.item) for course in result.courses}
    first = script.faults[0] if script.faults else script.acts[0]
    if broken := broken_in(result):
        return Outcome(Kind.BROKEN, ", ".join(broken), late_s, digest)
    if not_arrived(result):
        return Outcome(Kind.NOT_ARRIVED, f"{Kind.NOT_ARRIVED.value}: {_waiting(result)}", late_s, digest)
    if id(first) not in begun:
        return Outcome(Kind.NOT_APPLICABLE, Kind.NOT_APPLICABLE.value, late_s, digest)
    kind = Kind.ON_TIME if late_s <= ON_TIME_S else Kind.LATE
    return Outcome(kind, kind.value, late_s, digest)


def outcome_of_death(died: Died) -> Outcome:
    """The class of a run that had no end."""
    return Outcome(Kind.CRASH, f"{Kind.CRASH.value} {died.why}")


def broken_in(result: RunResult) -> tuple[str, ...]:
    """What was unsafe in a run, each once, in the order in which it came; not where and when."""
    broken = [(v.t_s, f"invariant {v.checker}") for v in result.violations if v.checker != "everyone-arrives"]
    broken += [
        (entry.t_s, f"unsafe: {entry.event.text}")
        for entry in result.journal.entries
        if isinstance(entry.event, Unsafe)
    ]
    words = [word for _, word in sorted(broken)]
    return tuple(dict.fromkeys([*words, *(["collision"] if result.collisions else [])]))


def late_s_max(result: RunResult) -> float:
    """Most seconds after plan of any arrival or departure; 0 where none was late."""
    pairs = [
        pair
        for stop in result.stops
        for pair in (
            (stop.arrival_s, stop.planned_arrival_s),
            (stop.departure_s, stop.planned_departure_s),
        )
    ]
    late = [real - planned for real, planned in pairs if real is not None and planned is not None]
    return round(max([0.0, *late]), 1)


def _waiting(result: RunResult) -> str:
    """Who waits for what, without the place; why the run ended where nobody waits."""
    waiting = sorted({f"{w.stock_id} waits for {w.waits_for}" for w in result.waiting})
    return ", ".join(waiting) or result.ended_because
