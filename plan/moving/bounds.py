"""What holds between the moves of legs: how long trains stand, and that a section is one train's at a time.

Every leg is moved by a whole number of ticks against the time for which its occupations were made; all that it
occupies moves with it. Where a set stands, it holds the place from the leg in to the leg out. All that can be said of
moves is then that one is at least so much greater than another (`MoveBound`), and of two that want one section that
either the one goes first or the other (`EitherFirst`).

Moves being whole ticks, a difference of so many seconds is that of the next whole tick above: exact for times that are
ticks, and for others on the safe side, as nobody is given time that is not there.

With a period all repeats for ever, and `periods` counts how often the period is taken off a bound. The period itself
stays open, so that the same bounds serve every period.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Final

from plan.moving.proof import MoveBound
from study.capacity.compression import HeldSection, held_sections
from study.capacity.legs import SetLeg, follows_on, joined_legs, stand_of
from study.capacity.occupation import TOUCH_S

TENTH_S: Final = 0.1
_FAR: Final = 10**9  # ticks; further than any leg is moved
EXCLUSIVE = True  # off: a section is anybody's at any time


@dataclass(frozen=True, slots=True)
class MoveTerms:
    """How legs may be moved, s. `tick_s`: of what moves are multiples; `buffer_s`: between two trains on a section.

    `dwell_min_s`: the shortest stop (infinite: as short as planned); `longer_s`: by how much the longest stand may be
    longer than the shortest. `periodic`: all repeats for ever.
    """

    tick_s: float = TENTH_S
    buffer_s: float = 0.0
    dwell_min_s: float = math.inf
    longer_s: float = math.inf
    periodic: bool = False

    def ticks(self, time_s: float) -> int:
        """A least difference as ticks, on the safe side."""
        return math.ceil((time_s - TOUCH_S) / self.tick_s)


@dataclass(frozen=True, slots=True)
class EitherFirst:
    """Of two that want one section the one goes first or the other.

    With a period that is so for each pair of their repetitions: for any whole number k either `one_first.later(k)`, so
    the one is before the other of k periods later, or `other_first.later(-k)`.
    """

    one_first: MoveBound
    other_first: MoveBound


@dataclass(frozen=True, slots=True)
class LegBounds:
    """All that holds between the moves of `legs`: `always`, and of each of `either` one of two."""

    legs: tuple[SetLeg, ...]
    always: tuple[MoveBound, ...]
    either: tuple[EitherFirst, ...]
    terms: MoveTerms

    def in_a_period(self, period: int) -> list[tuple[int, int]]:
        """Between which moves each leg is with the first one not moved, ticks; (0, 0) where there are none at all."""
        nowhere = [(0, 0)] * len(self.legs)
        least = [-_FAR] * len(self.legs)
        most = [_FAR] * len(self.legs)
        least[0] = most[0] = 0
        for _ in range(len(self.legs) + 1):
            known = (*least, *most)
            for bound in self.always:
                by = bound.at_period(period)
                least[bound.after] = max(least[bound.after], least[bound.before] + by)
                most[bound.before] = min(most[bound.before], most[bound.after] - by)
            if known == (*least, *most):
                between = list(zip(least, most, strict=True))
                return between if all(low <= high for low, high in between) else nowhere
        return nowhere


def bounds_of(legs: Sequence[SetLeg], terms: MoveTerms, again: int | None = None) -> LegBounds:
    """What holds between the moves of legs of any sets, each set's legs in the order in which it runs them.

    `again`: which leg is the first one once more, some periods later, where a set goes round and round.
    """
    held = [one for one in held_sections(legs) if not counted_again(one, legs, again)] if EXCLUSIVE else []
    by_section: dict[str, list[HeldSection]] = defaultdict(list)
    for one in held:
        by_section[one.occupation.section_id].append(one)
    pairs = [pair for same in by_section.values() for pair in combinations(same, 2)]
    always, either = [*_stands(legs, terms), *_returns(legs, terms)], list[EitherFirst]()
    if terms.periodic:
        always += [*_which_repetition(legs), *(_first(one, one, terms).later(1) for one in held)]
        either += [EitherFirst(_first(one, other, terms), _first(other, one, terms)) for one, other in pairs]
    else:
        others = [pair for pair in pairs if pair[0].occupation.stock_id != pair[1].occupation.stock_id]
        for one, other in others:
            before, after = _first(one, other, terms), _first(other, one, terms)
            if _surely_first(one, other) == _surely_first(other, one):
                either.append(EitherFirst(before, after))
            else:
                always.append(before if _surely_first(one, other) else after)
    either = list(_joined(either))
    if again is not None:
        later = round((legs[again].departs_s - legs[0].departs_s) / terms.tick_s)
        either.append(EitherFirst(MoveBound(again, 0, later), MoveBound(0, again, -later, periods=-1)))
    return LegBounds(tuple(legs), tuple(always), tuple(either), terms)


def counted_again(held: HeldSection, legs: Sequence[SetLeg], again: int | None) -> bool:
    """Of the first leg, which is the last one's repetition, the way; of the last one the stand that follows."""
    if again is None or held.begins != held.ends:
        return False
    return held.begins == 0 or (
        held.begins == again and held.occupation.section_id == legs[again].occupations[-1].section_id
    )


def _surely_first(first: HeldSection, then: HeldSection) -> bool:
    """Whether a set was in the section when the day began, or the other one stays in it when the day is over."""
    return math.isinf(first.occupation.enters_s) or math.isinf(then.occupation.leaves_s)


def _stands(legs: Sequence[SetLeg], terms: MoveTerms) -> Iterator[MoveBound]:
    """Between two legs of a set that goes on: the stand is as long as it must and may be; none in passing."""
    number = {id(leg): index for index, leg in enumerate(legs)}
    for before, after in joined_legs(legs):
        if before.end is None:
            continue
        stand = stand_of(before.end, terms.dwell_min_s)
        one, other = number[id(before)], number[id(after)]
        planned_s = stand.departs_s - stand.arrives_s
        yield MoveBound(one, other, terms.ticks(stand.least_s - planned_s))
        longest_s = stand.least_s if stand.passes else stand.least_s + terms.longer_s
        if math.isfinite(longest_s):
            yield MoveBound(other, one, terms.ticks(planned_s - longest_s))


def _returns(legs: Sequence[SetLeg], terms: MoveTerms) -> Iterator[MoveBound]:
    """A set that left the line comes back after that, if nothing but its own order says so."""
    own: dict[str, list[int]] = defaultdict(list)
    for index, leg in enumerate(legs):
        own[leg.stock_id].append(index)
    for indices in own.values():
        for one, other in pairwise(indices):
            before, after = legs[one], legs[other]
            if not follows_on(before, after):
                yield MoveBound(one, other, terms.ticks(min(before.arrives_s - after.departs_s, 0.0)))


def _which_repetition(legs: Sequence[SetLeg]) -> Iterator[MoveBound]:
    """Of a set's repetitions that is meant which sets out with the first set's, or less than a period later."""
    firsts = {leg.stock_id: at for at, leg in reversed(list(enumerate(legs)))}
    for at in sorted(firsts.values())[1:]:
        yield MoveBound(0, at, 0)
        yield MoveBound(at, 0, 1, periods=1)


def _first(one: HeldSection, other: HeldSection, terms: MoveTerms) -> MoveBound:
    """The one has the section before the other."""
    least_s = one.occupation.end_s - other.occupation.begin_s + terms.buffer_s
    return MoveBound(one.ends, other.begins, terms.ticks(least_s), one.occupation.section_id)


def _joined(either: Sequence[EitherFirst]) -> Iterator[EitherFirst]:
    """Questions between the same legs that can only have one answer as one question.

    Who goes first over one section goes first over the other where the opposite would need both to be before the other.
    """
    by_legs: dict[tuple[int, int, int, int], list[EitherFirst]] = defaultdict(list)
    for each in either:
        one, other = each.one_first, each.other_first
        key = one.before, one.after, other.before, other.after
        if (one.before, one.after) == (other.after, other.before):
            together = by_legs[key]
            for at, known in enumerate(together):
                if (
                    known.one_first.least + each.other_first.least > 0
                    and each.one_first.least + known.other_first.least > 0
                ):
                    together[at] = EitherFirst(
                        max(known.one_first, one, key=_least), max(known.other_first, other, key=_least)
                    )
                    break
            else:
                together.append(each)
        else:
            by_legs[key].append(each)
    for together in by_legs.values():
        yield from together


def _least(bound: MoveBound) -> int:
    return bound.least
