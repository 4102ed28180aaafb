"""Recounts a proof that legs do not fit, from the legs alone; it shares no code with what finds proofs.

Each bound of a circle must be what the legs themselves, or the cases told apart, give to the tick, two cases all that
there are, and each circle add up to more than nothing for just the periods that it claims.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise, product

from plan.moving.proof import Circle, Impossibility, MoveBound, Refutation
from study.capacity.legs import SetLeg, stand_of
from study.capacity.occupation import Occupation

Span = tuple[str, int, float, int, float]  # a section; of which leg and when, s, it is held, and is free


class Recount:
    """The facts of legs. `again`: the leg that is the first one some periods later, where sets go round."""

    def __init__(self, legs: Sequence[SetLeg], tick_s: float, again: int | None = None) -> None:
        self._tick_s = tick_s
        self.names = tuple(f"{leg.number} {leg.held[0].section_id} {leg.held[-1].section_id}" for leg in legs)
        self._spans, self._always = list[Span](), set[MoveBound]()
        follows, sets = {id(leg.start): at for at, leg in enumerate(legs)}, list[str]()
        for at, leg in enumerate(legs):
            if leg.stock_id not in sets and sets:  # which of its repetitions is meant
                self._always |= {MoveBound(0, at, 0), MoveBound(at, 0, 1, periods=1)}
            sets.append(leg.stock_id)
            own = leg.held if at == 0 or legs[at - 1].held[-1] is not leg.start else leg.occupations
            for one in own if at != again else own[:-1]:
                to = follows.get(id(one), at) if one is own[-1] else at
                if again is None or at or to:
                    self._take(one, leg, at, to)
        later = 0 if again is None else round((legs[again].departs_s - legs[0].departs_s) / tick_s)
        self._again = () if not again else (MoveBound(again, 0, later), MoveBound(0, again, -later))

    def _take(self, one: Occupation, leg: SetLeg, at: int, to: int) -> None:
        stand, begin_s = stand_of(one), max(one.begin_s, min(other.begin_s for other in leg.occupations))
        end_s = stand.arrives_s if one is leg.held[-1] and math.isinf(one.leaves_s) else one.end_s
        self._spans.append(span := (one.section_id, at, begin_s, to, end_s))
        self._always.add(self._before(span, span).later(1))
        if to != at:
            least = self._ticks(stand.arrives_s + stand.least_s - stand.departs_s)
            self._always |= {MoveBound(at, to, least), *([MoveBound(to, at, 0)] if stand.passes else [])}

    def _ticks(self, time_s: float) -> int:
        return math.ceil((time_s - 1e-6) / self._tick_s)

    def _before(self, one: Span, other: Span) -> MoveBound:
        return MoveBound(one[3], other[1], self._ticks(one[4] - other[2]), one[0])

    def refuse(self, proof: Impossibility) -> None:
        """ValueError where anything is not as it says."""
        if (proof.tick_s, proof.legs) != (self._tick_s, self.names):
            raise ValueError("it is of other legs")
        if all(one.to_ticks is not None and one.to_ticks < max(one.from_ticks, 1) for one in proof.excluded):
            raise ValueError("it excludes no interval")
        for one in proof.excluded:
            claims = one.from_ticks, math.inf if one.to_ticks is None else one.to_ticks
            if claims != (shown := self._excluded(one.because, ())):
                raise ValueError(f"it shows {shown}, not {claims}")

    def _excluded(self, proof: Refutation, decided: tuple[MoveBound, ...]) -> tuple[float, float]:
        if isinstance(proof, Circle):
            return self._circle(proof.bounds, decided)
        if not self._one_holds(proof.one_first, proof.other_first, 0):
            raise ValueError(f"more cases than {proof.one_first} and {proof.other_first}")
        low, high = self._excluded(proof.if_one, (*decided, proof.one_first))
        least, most = self._excluded(proof.if_other, (*decided, proof.other_first))
        return max(low, least), min(high, most)

    def _one_holds(self, one: MoveBound, other: MoveBound, turn: int) -> bool:
        """Whether one of two holds however many periods there are between; with `turn` 1: both for one number."""
        bare, periods = (one.later(-one.periods), other.later(-other.periods)), one.periods + other.periods
        pairs = [(a, b) for a, b in product(self._spans, repeat=2) if a is not b and a[0] == b[0]]
        ones = [pair for pair in pairs if self._before(*pair) == bare[0]]
        others = [pair for pair in pairs if self._before(*pair[::-1]) == bare[1]]
        if bare in (self._again, self._again[::-1]):
            return periods == turn - 1
        return periods == turn and any(way[0] == way[1] or self._alike(*way) for way in product(ones, others))

    def _alike(self, one: tuple[Span, Span], other: tuple[Span, Span]) -> bool:
        """Whether two legs have two sections in one order: else each would be before the other."""
        legs = [(span[1], span[3]) for span in (*one, *other)]
        both = legs[:2] == legs[2:] and all(a == b for a, b in legs)
        return both and self._before(*other).least + self._before(*one[::-1]).least > 0

    def _circle(self, bounds: tuple[MoveBound, ...], decided: tuple[MoveBound, ...]) -> tuple[float, float]:
        if not bounds or any(a.after != b.before for a, b in pairwise((*bounds, bounds[0]))):
            raise ValueError("a circle that does not close")
        new = [bound for bound in bounds if bound not in self._always and bound not in decided]
        if new and not (len(new) == 2 and any(self._one_holds(a, b, 1) for a, b in (new, new[::-1]))):
            raise ValueError(f"nothing says {new[0]}")
        least, periods = sum(bound.least for bound in bounds), sum(bound.periods for bound in bounds)
        if periods == 0 and least <= 0:
            raise ValueError(f"a circle of {least} ticks")
        if periods > 0:
            return 0, (least - 1) // periods
        return least // periods + 1 if periods else 0, math.inf
