"""Blocking times of theory beside those of a run: part by part, how far they differ, where most, and why there.

Two occupations are one where section, stock and train are. Why a part differs, the run shows: the train
waited for another, telegrams were lost, or it ran earlier or later than predicted.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from study.capacity.occupation import COST_OF, TOUCH_S, Occupation, OccupationPart

SEEN_S: Final = 0.05  # differences below this are none
LATE_S: Final = 5.0  # a train so far off its prediction is reported as such
REPEATED_S: Final = 1.5  # a telegram that took so much longer was sent again


@dataclass(frozen=True, slots=True)
class ComparedOccupation:
    """One occupation in theory and in a run."""

    theory: Occupation
    run: Occupation

    @property
    def usable(self) -> bool:
        """Whether both have an end, so that their parts can be compared."""
        ends = (self.theory.leaves_s, self.run.leaves_s, self.theory.enters_s, self.run.enters_s)
        return all(math.isfinite(t) for t in ends)

    def more_s(self, part: OccupationPart) -> float:
        """By how much the run has more of a part, s."""
        return self.run.of_part(part) - self.theory.of_part(part)

    @property
    def late_s(self) -> float:
        """By how much later its front comes in, s."""
        return self.run.enters_s - self.theory.enters_s


@dataclass(frozen=True, slots=True)
class Difference:
    """One part over all pairs that have it, s: mean in theory and in the run, mean and greatest difference (run less
    theory), where the greatest is, and why it differs there.
    """

    part: OccupationPart
    pairs: int
    theory_s: float
    run_s: float
    mean_s: float
    worst_s: float
    section_id: str
    number: str
    why: str

    def as_dict(self) -> dict[str, object]:
        """Plain data."""
        return {
            "part": self.part.value,
            "cost": COST_OF[self.part].value,
            "pairs": self.pairs,
            "theory_s": round(self.theory_s, 3),
            "run_s": round(self.run_s, 3),
            "mean_s": round(self.mean_s, 3),
            "worst_s": round(self.worst_s, 3),
            "section": self.section_id,
            "train": self.number,
            "why": self.why,
        }


@dataclass(frozen=True, slots=True)
class Compared:
    """Theory beside a run. `only_theory` and `only_run`: occupations that the other lacks."""

    pairs: tuple[ComparedOccupation, ...]
    only_theory: tuple[Occupation, ...]
    only_run: tuple[Occupation, ...]

    def whole_s(self) -> tuple[float, float]:
        """Mean and greatest difference of whole occupations, s: run less theory."""
        more_s = [p.run.length_s - p.theory.length_s for p in self.pairs if p.usable]
        return (math.fsum(more_s) / len(more_s), max(more_s, key=abs)) if more_s else (0.0, 0.0)

    def differences(self) -> tuple[Difference, ...]:
        """Each part that either has, in the order of parts."""
        found = (self._difference(part) for part in OccupationPart)
        return tuple(one for one in found if one is not None)

    def _difference(self, part: OccupationPart) -> Difference | None:
        own = [
            p for p in self.pairs if p.usable and max(p.run.of_part(part), p.theory.of_part(part)) > TOUCH_S
        ]
        if not own:
            return None
        worst = max(own, key=lambda p: abs(p.more_s(part)))
        count = len(own)
        return Difference(
            part,
            count,
            math.fsum(p.theory.of_part(part) for p in own) / count,
            math.fsum(p.run.of_part(part) for p in own) / count,
            math.fsum(p.more_s(part) for p in own) / count,
            worst.more_s(part),
            worst.run.section_id,
            worst.run.number,
            _why(worst, part, self._waited(worst)),
        )

    def _waited(self, pair: ComparedOccupation) -> float:
        """For how long the train waited for others up to that occupation, s."""
        own = (p.run for p in self.pairs if p.run.number == pair.run.number)
        return max((o.waited_s for o in own if o.begin_s <= pair.run.end_s), default=0.0)


def theory_and_run(theory: Iterable[Occupation], run: Iterable[Occupation]) -> Compared:
    """Theory beside a run, in the order of the run."""
    left = {_key(one): one for one in theory}
    pairs: list[ComparedOccupation] = []
    only_run: list[Occupation] = []
    for one in run:
        other = left.pop(_key(one), None)
        if other is None:
            only_run.append(one)
        else:
            pairs.append(ComparedOccupation(other, one))
    return Compared(tuple(pairs), tuple(left.values()), tuple(only_run))


def _key(one: Occupation) -> tuple[str, str, str]:
    return one.section_id, one.stock_id, one.number


_TELEGRAMS: Final = (
    OccupationPart.REQUEST,
    OccupationPart.AIR,
    OccupationPart.GRANT,
    OccupationPart.PROOF,
    OccupationPart.RELEASE,
)
_STANDS: Final = (
    OccupationPart.READY,
    OccupationPart.DWELL,
    OccupationPart.HELD,
    OccupationPart.LAYOVER,
    OccupationPart.CHANGE_ENDS,
    OccupationPart.CHARGING,
    OccupationPart.START,
)


def _why(pair: ComparedOccupation, part: OccupationPart, waited_s: float) -> str:
    """Why a part differs there, in words."""
    more_s = pair.more_s(part)
    if abs(more_s) <= SEEN_S:
        return "no difference"
    if part is OccupationPart.THROW:
        return "the points lay otherwise than the planned order of trains leaves them"
    return _telegram(more_s) if part in _TELEGRAMS else _train(pair, part, waited_s)


def _telegram(more_s: float) -> str:
    if more_s > REPEATED_S:
        return "a telegram was lost and sent again, or refused"
    return f"the air took {'longer' if more_s > 0.0 else 'less'} than its mean"


def _train(pair: ComparedOccupation, part: OccupationPart, waited_s: float) -> str:
    if waited_s > SEEN_S:
        return f"the train had waited {waited_s:.0f} s for what another held"
    if abs(pair.late_s) > LATE_S:
        when = "later" if pair.late_s > 0.0 else "earlier"
        return f"the train came in {abs(pair.late_s):.0f} s {when} than predicted"
    if part in _STANDS:
        return "it came to its stop at another time than predicted"
    return "it was driven otherwise than predicted: notches, load and the brake's real strength"
