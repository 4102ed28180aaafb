"""Why no moves fit: a tree of cases, each of which ends in a circle of legs whose seconds are too many.

A circle of bounds leads from a leg's move back to itself. Adding them up, the move is greater than itself by so many
ticks less so many periods; where that is more than nothing, the bounds contradict each other. What is so always may do
already; else cases are told apart, in which of two trains the one or the other goes first over a section.
A proof for one period holds for all for which each of its circles does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from network.errors import InputError
from plan.moving.bounds import EitherFirst, LegBounds
from plan.moving.proof import Circle, MoveBound, Refutation, TwoCases, circles_of

CASES_MAX: Final = 20_000  # that are looked at for one proof


class TooManyCasesError(InputError):
    """Neither a proof nor moves within `CASES_MAX`: unlike other input, of this nothing is known."""

    def __init__(self) -> None:
        expected = "a proof or moves within so many: a line with fewer places to meet, or fewer trains"
        super().__init__("the search for a proof", "cases", CASES_MAX, expected)


def excluded_by(proof: Refutation) -> tuple[float, float]:
    """Between which periods a proof holds, ticks, both among them; infinite where there is no limit."""
    if isinstance(proof, TwoCases):
        (least, most), (low, high) = excluded_by(proof.if_one), excluded_by(proof.if_other)
        return max(least, low), min(most, high)
    least = sum(bound.least for bound in proof.bounds)
    periods = sum(bound.periods for bound in proof.bounds)
    if periods > 0:
        return 0, (least - 1) // periods
    return (least // periods + 1 if periods else 0), math.inf


def refutation_of(bounds: LegBounds, period: int = 0) -> Refutation | None:
    """Why no moves fit (with that period, if there is one); None where some do. Raises TooManyCasesError."""
    return _CaseSearch(bounds, period).refuted(bounds.always)


class _CaseSearch:
    """One search through cases, depth first, the one that leaves least open first."""

    def __init__(self, bounds: LegBounds, period: int) -> None:
        self._bounds, self._period, self._cases = bounds, period, 0

    def refuted(self, known: Sequence[MoveBound]) -> Refutation | None:
        self._cases += 1
        if self._cases > CASES_MAX:
            raise TooManyCasesError
        reach = _Reach(known, len(self._bounds.legs), self._period)
        circle = reach.circle or self._turn(reach)
        if circle is not None:
            return circle
        case = self._open_case(reach)
        if case is None:
            return None
        one, other = case
        if_one = self.refuted((*known, one))
        if if_one is None or not _uses(if_one, one):
            return if_one
        if_other = self.refuted((*known, other))
        if if_other is None or not _uses(if_other, other):
            return if_other
        return TwoCases(one, other, if_one, if_other)

    def _turn(self, reach: _Reach) -> Circle | None:
        """The one before the other, which is before the one of a period later: so it is in some repetition."""
        for either in self._bounds.either if self._period else ():
            one, other = either.one_first, either.other_first.later(1)
            least = one.at_period(self._period) + other.at_period(self._period)
            if least + reach.by[one.after][other.before] + reach.by[other.after][one.before] > 0:
                between, back = reach.way(one.after, other.before), reach.way(other.after, one.before)
                return Circle((one, *between, other, *back))
        return None

    def _open_case(self, reach: _Reach) -> tuple[MoveBound, MoveBound] | None:
        """What is not decided yet: where the sides are nearest to contradicting what is known."""
        best: tuple[float, MoveBound, MoveBound] | None = None
        for either in self._bounds.either:
            for case in self._undecided(either, reach):
                nearer, further = sorted(case, key=lambda bound: self._room(bound, reach))
                room, rest = self._room(nearer, reach), self._room(further, reach)
                rank = -math.inf if rest < 0 else room if room < 0 else room + rest
                if best is None or rank < best[0]:
                    best = rank, nearer, further
        return None if best is None else best[1:]

    def _undecided(self, either: EitherFirst, reach: _Reach) -> list[tuple[MoveBound, MoveBound]]:
        """The pairs of repetitions of which what is known does not say who is first."""
        one, other, period = either.one_first, either.other_first, self._period
        ahead = reach.by[one.before][one.after]
        behind = reach.by[other.before][other.after]
        if not period:
            return [] if ahead >= one.least or behind >= other.least else [(one, other)]
        from_k = math.floor((behind - other.at_period(period)) / period) + 1
        to_k = math.ceil((one.at_period(period) - ahead) / period)
        return [(one.later(k), other.later(-k)) for k in range(from_k, to_k)]

    def _room(self, bound: MoveBound, reach: _Reach) -> float:
        """By how many ticks more it could be asked for without contradicting what is known; negative: it does."""
        return -(reach.by[bound.after][bound.before] + bound.at_period(self._period))


def _uses(proof: Refutation, bound: MoveBound) -> bool:
    return any(bound in circle.bounds for circle in circles_of(proof))


class _Reach:
    """By how much each leg is moved more than each other, at least, by all that is known together, ticks."""

    def __init__(self, known: Sequence[MoveBound], legs: int, period: int) -> None:
        self.by = [[0.0 if a == b else -math.inf for b in range(legs)] for a in range(legs)]
        self._came: dict[tuple[int, int], MoveBound] = {}
        self.circle = next(
            (Circle((b,)) for b in known if b.before == b.after and b.at_period(period) > 0), None
        )
        for bound in known:
            self._take(bound.before, bound.after, bound.at_period(period), bound)
        for via in range(legs):
            for a in range(legs):
                if a != via and self.by[a][via] > -math.inf and self.circle is None:
                    self._extend(a, via, legs)

    def _take(self, a: int, b: int, by: float, last: MoveBound) -> None:
        if by > self.by[a][b]:
            self.by[a][b], self._came[a, b] = by, last

    def _extend(self, a: int, via: int, legs: int) -> None:
        """Ways from one leg that go over another; there is a circle where one leads back."""
        for b in range(legs):
            by = self.by[a][via] + self.by[via][b]
            if b != via and by > self.by[a][b]:
                self.by[a][b], self._came[a, b] = by, self._came[via, b]
                if a == b:
                    self.circle = Circle(self.way(a, a))
                    return

    def way(self, from_leg: int, to_leg: int) -> tuple[MoveBound, ...]:
        """The bounds that lead from one leg to another; none to itself where there is no circle."""
        found: list[MoveBound] = []
        while (from_leg, to_leg) in self._came and (not found or to_leg != from_leg):
            found.append(self._came[from_leg, to_leg])
            to_leg = found[-1].before
        return tuple(reversed(found))
