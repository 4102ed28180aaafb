"""A drill as its run leaves it: faults, acts and expectations as numbered marks in time and on the line."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from study.wording import outcome as words
from study.wording.phrase import Phrase


class MarkKind(Enum):
    """What a mark stands for; the value is the letter of its number."""

    FAULT = "F"
    ACT = "A"
    EXPECTATION = "E"


@dataclass(frozen=True, slots=True)
class MarkPlace:
    """Where on the line something is: stretches of kilometrage, m, or units, which carry it; neither: all of it."""

    stretches_m: tuple[tuple[float, float], ...] = ()
    units: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.stretches_m or self.units)


@dataclass(frozen=True, slots=True)
class Mark:
    """One item of a drill. An expectation's stretch is what was judged, `at_s` when it was met or broken."""

    kind: MarkKind
    number: int
    text: str
    from_s: float
    to_s: float
    at_s: float | None = None
    passed: bool = True
    happened: str = ""
    text_ja: str = ""
    happened_ja: str = ""
    where: MarkPlace = MarkPlace()

    @property
    def said(self) -> Phrase:
        """What it is about."""
        return Phrase(self.text, self.text_ja)

    @property
    def became(self) -> Phrase:
        """What happened."""
        return Phrase(self.happened, self.happened_ja)

    @property
    def label(self) -> str:
        """F1, A1, E1."""
        return f"{self.kind.value}{self.number}"


@dataclass(frozen=True, slots=True)
class DrillShown:
    """What the report shows of a drill; `score` is a sentence."""

    passed: bool
    marks: tuple[Mark, ...]
    score: str
    score_ja: str = ""

    def of_kinds(self, *kinds: MarkKind) -> tuple[Mark, ...]:
        """Marks of some kinds, in order."""
        return tuple(mark for mark in self.marks if mark.kind in kinds)

    def unmet(self) -> tuple[Phrase, ...]:
        """Expectations that were not met, and what happened."""
        return tuple(
            words.UNMET.fill(text=mark.said, happened=mark.became)
            for mark in self.of_kinds(MarkKind.EXPECTATION)
            if not mark.passed
        )

    def verdict(self) -> Phrase:
        """Passed or not, in words."""
        judged, unmet = len(self.of_kinds(MarkKind.EXPECTATION)), len(self.unmet())
        return words.FAILED.fill(count=unmet, all=judged) if unmet else words.PASSED.fill(count=judged)


def mark_of(kind: MarkKind, number: int, said: Phrase, from_s: float, to_s: float, became: Phrase) -> Mark:
    """A mark, with its words in both languages."""
    return Mark(
        kind,
        number,
        said.en,
        from_s,
        to_s,
        happened=became.en,
        text_ja=said.in_("ja"),
        happened_ja=became.in_("ja"),
    )
