"""What the checkers found: each kind of breach with its subject once, further occurrences counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum


class Checker(StrEnum):
    """Stable names of the checkers, as reports and scenarios use them."""

    ONE_TRAIN_A_SECTION = "one-train-a-section"
    NO_DOUBLE_GRANT = "no-double-grant"
    INSIDE_HOLDING = "inside-holding"
    POINTS_UNDER_TRAIN = "points-under-train"
    NO_THROW_UNDER_TRAIN = "no-throw-under-train"
    PROVEN_BEFORE_ENTRY = "proven-before-entry"
    RELEASE_BEHIND_REAR = "release-behind-rear"
    UNDEFINED_GRANTS_NOTHING = "undefined-grants-nothing"
    WITHIN_BOUNDS = "within-bounds"
    TELEGRAM_ONCE = "telegram-once"
    SUMO_COLLISION = "sumo-collision"
    EVERYONE_ARRIVES = "everyone-arrives"
    TOKENS_GROW = "tokens-grow"
    NO_JUMP = "no-jump"
    NO_DEAD_STATE = "no-dead-state"
    ONE_COMES_IN = "one-comes-in"
    PILOTS_LEAVE = "pilots-leave"
    CROSSING_OPEN = "crossing-open"
    CROSSING_WARNING = "crossing-warning"
    TOO_FAST = "too-fast"


@dataclass(frozen=True, slots=True)
class Violation:
    """The first breach of one rule by one subject, whose ids it names; `checker` is a name of `Checker`."""

    t_s: float
    checker: str
    text: str
    subject: str = ""


class Log:
    """Violations in the order in which they were first seen."""

    def __init__(self) -> None:
        self._first: dict[tuple[Checker, str], Violation] = {}
        self._outside: dict[tuple[str, str], Violation] = {}
        self._counts: Counter[str] = Counter()

    def note(self, t_s: float, checker: Checker, subject: str, text: str, *, outside: bool = False) -> None:
        """Write down a breach; `subject` names what is at fault, so that a lasting breach stays one entry.

        One that is `outside` the design is kept apart and does not count.
        """
        if outside:
            self.note_outside(t_s, checker.value, subject, text)
            return
        self._counts[checker.value] += 1
        self._first.setdefault((checker, subject), Violation(t_s, checker.value, text, subject))

    def note_outside(self, t_s: float, what: str, subject: str, text: str) -> None:
        """Write down what is outside the design: a checker's breach, or something else."""
        self._outside.setdefault((what, subject), Violation(t_s, what, text, subject))

    @property
    def outside(self) -> tuple[Violation, ...]:
        """First occurrences of what is outside the design."""
        return tuple(self._outside.values())

    @property
    def violations(self) -> tuple[Violation, ...]:
        """First occurrences."""
        return tuple(self._first.values())

    @property
    def counts(self) -> Mapping[str, int]:
        """All occurrences by name of the checker."""
        return dict(self._counts)
