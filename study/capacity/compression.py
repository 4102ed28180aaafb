"""Timetable compression (UIC Code 406, 2nd edition 2013) on a line where trains meet.

Every leg of every train is moved to the left until it touches, with the order of trains on each section, the tracks
and the meets as they are. What may be moved against what is a system of differences: a leg begins no sooner than the
leg before it on a section has freed it, and no sooner than its train has done with standing. Its least solution is
the compressed timetable, the chain of what touches says what it is made of.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise
from typing import Final

from study.capacity.legs import SetLeg, costs_between, joined_legs, stand_of
from study.capacity.occupation import TOUCH_S, Occupation, OccupationCost


class StandingRule(StrEnum):
    """How long trains stand between two legs of a part: as planned, as UIC 406 has it, or no longer than they must."""

    KEPT = "kept"
    LEAST = "least"


class ContradictionError(ValueError):
    """Trains that each have to come after the other: no moving makes that right."""

    def __init__(self, numbers: Sequence[str]) -> None:
        super().__init__(f"{' and '.join(numbers)} each have to wait for the other")
        self.numbers: Final = tuple(numbers)


@dataclass(frozen=True, slots=True)
class HeldSection:
    """A section held from something that moves with the leg `begins` to something that moves with the leg `ends`."""

    occupation: Occupation
    begins: int
    ends: int


@dataclass(frozen=True, slots=True)
class Touch:
    """One leg that begins as soon as another lets it, s; `section_id` is empty where its own train's stand does."""

    before: int
    after: int
    least_s: float  # of the second's move less the first's
    end_s: float
    begin_s: float
    section_id: str


@dataclass(frozen=True, slots=True)
class ChainLink:
    """One link of the critical chain: from when a train's leg is let begin to when it lets the next one begin.

    The chain is without gaps, so that its links make up the compressed time; `costs_s` make up the link.
    """

    number: str
    section_id: str
    begin_s: float
    end_s: float
    costs_s: Mapping[OccupationCost, float]

    @property
    def length_s(self) -> float:
        """How long it is."""
        return self.end_s - self.begin_s


@dataclass(frozen=True, slots=True)
class Compressed:
    """A part of a line with its trains pushed together.

    `occupied_s`: from the first beginning to when the same trains could begin all over again. `moves_s`: by how much
    each leg moved (negative: to the left). `section_id`: the critical section, on which most of the chain lies.
    """

    legs: tuple[SetLeg, ...]
    moves_s: tuple[float, ...]
    begins_s: float
    occupied_s: float
    chain: tuple[ChainLink, ...]

    @property
    def trains(self) -> tuple[str, ...]:
        """The numbers of its trains, in order."""
        return tuple(dict.fromkeys(leg.number for leg in self.legs))

    @property
    def section_id(self) -> str:
        """The critical section."""
        spent = self.by_section_s()
        return max(spent, key=lambda section_id: (spent[section_id], section_id)) if spent else ""

    def by_section_s(self) -> dict[str, float]:
        """How much of the chain lies on each section, s."""
        found: dict[str, list[float]] = {}
        for link in self.chain:
            found.setdefault(link.section_id, []).append(link.length_s)
        return {section_id: math.fsum(lengths) for section_id, lengths in found.items()}

    def costs_s(self) -> dict[OccupationCost, float]:
        """What the compressed time goes into, s; together all of it."""
        return {cost: math.fsum(link.costs_s[cost] for link in self.chain) for cost in OccupationCost}


def compressed(
    legs: Iterable[SetLeg],
    section_ids: frozenset[str],
    stops: StandingRule = StandingRule.KEPT,
    dwell_min_s: float = math.inf,
) -> Compressed:
    """The trains of a part pushed together; ContradictionError where its trains cannot be put into an order.

    `dwell_min_s`: the shortest dwell, where stops are no longer than they must.
    """
    inside = tuple(leg for leg in legs if any(o.section_id in section_ids for o in leg.held))
    if not inside:
        return Compressed((), (), 0.0, 0.0, ())
    held = held_sections(inside, section_ids)
    begins_s = min(one.occupation.begin_s for one in held)
    touches = (*_in_turn(held), *_stands(inside, section_ids, stops, dwell_min_s))
    moves_s, because = _least(inside, held, touches, begins_s)
    last, first = _again(held, moves_s)
    occupied_s = (last.occupation.end_s + moves_s[last.ends]) - (
        first.occupation.begin_s + moves_s[first.begins]
    )
    chain = _chain(inside, held, moves_s, because, (first, last))
    return Compressed(inside, tuple(moves_s), begins_s, occupied_s, chain)


def held_sections(legs: Sequence[SetLeg], section_ids: Container[str] | None = None) -> list[HeldSection]:
    """All that is held in a part, or on the line, in order of time; what never begins or ends, while its leg runs.

    `begins` and `ends` of each are indices of `legs`.
    """
    number = {id(leg): index for index, leg in enumerate(legs)}
    leaves = {id(before): number[id(after)] for before, after in joined_legs(legs)}
    begun = {id(after.start) for _, after in joined_legs(legs)}
    found: list[HeldSection] = []
    for index, leg in enumerate(legs):
        if leg.start is not None and id(leg.start) not in begun:
            found.append(HeldSection(_finite(leg.start, leg), index, index))
        for one in leg.occupations:
            ends = leaves.get(id(leg), index) if one is leg.end else index
            found.append(HeldSection(_finite(one, leg), index, ends))
    if section_ids is not None:
        found = [one for one in found if one.occupation.section_id in section_ids]
    found.sort(key=lambda h: (h.occupation.begin_s, h.occupation.end_s, h.occupation.number))
    return found


def _finite(occupation: Occupation, leg: SetLeg) -> Occupation:
    """An occupation without a beginning begins as its leg does; one without an end ends as its leg does."""
    begin_s = max(occupation.begin_s, min(o.begin_s for o in leg.occupations))
    end_s = occupation.end_s
    if not math.isfinite(end_s) or (occupation is leg.end and not math.isfinite(occupation.leaves_s)):
        end_s = max(stand_of(occupation).arrives_s, begin_s)
    if begin_s == occupation.begin_s and end_s == occupation.end_s:
        return occupation
    return _clipped(occupation, begin_s, max(end_s, begin_s))


def _clipped(occupation: Occupation, begin_s: float, end_s: float) -> Occupation:
    slices = tuple(
        replace(s, begin_s=max(s.begin_s, begin_s), end_s=min(s.end_s, end_s))
        for s in occupation.slices
        if s.end_s > begin_s and s.begin_s < end_s
    )
    if not slices:
        last = occupation.slices[-1]
        slices = (replace(last, begin_s=begin_s, end_s=end_s),)
    return replace(occupation, slices=slices)


def _in_turn(held: Sequence[HeldSection]) -> list[Touch]:
    """One after the other on each section, as planned; a set does not wait for itself."""
    by_section: dict[str, list[HeldSection]] = {}
    for one in held:
        by_section.setdefault(one.occupation.section_id, []).append(one)
    found: list[Touch] = []
    for section_id, ordered in by_section.items():
        for before, after in pairwise(ordered):
            end_s, begin_s = before.occupation.end_s, after.occupation.begin_s
            own = before.occupation.stock_id == after.occupation.stock_id
            least_s = min(end_s - begin_s, 0.0) if own else end_s - begin_s
            if before.ends != after.begins:
                found.append(Touch(before.ends, after.begins, least_s, end_s, begin_s, section_id))
    return found


def _stands(
    legs: Sequence[SetLeg], section_ids: frozenset[str], stops: StandingRule, dwell_min_s: float
) -> list[Touch]:
    """Between the legs of a set whose stand lies in the part: no sooner than it must, and where kept no later."""
    number = {id(leg): index for index, leg in enumerate(legs)}
    found: list[Touch] = []
    for before, after in joined_legs(legs):
        end = before.end
        if end is None:
            continue
        stand = stand_of(end, dwell_min_s)
        one, other = number[id(before)], number[id(after)]
        slack_s = max(stand.departs_s - stand.arrives_s - stand.least_s, 0.0)
        turns = before.number != after.number
        if end.section_id not in section_ids:
            if turns or stops is StandingRule.LEAST:
                continue  # what it does beyond the part is no matter of the part
            slack_s = 0.0
        elif stops is StandingRule.KEPT and not turns:
            slack_s = 0.0
        found.append(Touch(one, other, -slack_s, stand.arrives_s + stand.least_s, stand.departs_s, ""))
        if slack_s == 0.0 and not turns:
            found.append(Touch(other, one, 0.0, stand.departs_s, stand.arrives_s, ""))
    return found


def _least(
    legs: Sequence[SetLeg], held: Sequence[HeldSection], touches: Sequence[Touch], begins_s: float
) -> tuple[list[float], list[Touch | None]]:
    """The least moves, s, and what holds each leg where it is (None: the beginning of the part)."""
    moves_s = [-math.inf] * len(legs)
    for one in held:
        moves_s[one.begins] = max(moves_s[one.begins], begins_s - one.occupation.begin_s)
    because: list[Touch | None] = [None] * len(legs)
    ordered = sorted(touches, key=lambda t: (t.begin_s, t.end_s))
    for _ in range(len(legs) + 1):
        moved = False
        for touch in ordered:
            to_s = moves_s[touch.before] + touch.least_s
            if to_s > moves_s[touch.after] + TOUCH_S:
                moves_s[touch.after] = to_s
                because[touch.after] = touch
                moved = True
        if not moved:
            return moves_s, because
    raise ContradictionError(_circle(legs, because))


def _circle(legs: Sequence[SetLeg], because: Sequence[Touch | None]) -> list[str]:
    """The trains of a circle of legs that push each other."""
    for start in range(len(legs)):
        seen: list[int] = []
        at: int | None = start
        while at is not None and at not in seen:
            seen.append(at)
            touch = because[at]
            at = None if touch is None else touch.before
        if at is not None:
            return list(dict.fromkeys(legs[i].number for i in reversed(seen[seen.index(at) :])))
    return []


def _again(held: Sequence[HeldSection], moves_s: Sequence[float]) -> tuple[HeldSection, HeldSection]:
    """The last and the first of the section that makes the same trains wait longest before they could begin again."""
    first: dict[str, HeldSection] = {}
    last: dict[str, HeldSection] = {}
    for one in held:
        section_id = one.occupation.section_id
        if section_id not in first or _begin_s(one, moves_s) < _begin_s(first[section_id], moves_s):
            first[section_id] = one
        if section_id not in last or _end_s(one, moves_s) > _end_s(last[section_id], moves_s):
            last[section_id] = one
    longest = max(first, key=lambda s: (_end_s(last[s], moves_s) - _begin_s(first[s], moves_s), s))
    return last[longest], first[longest]


def _begin_s(held: HeldSection, moves_s: Sequence[float]) -> float:
    return held.occupation.begin_s + moves_s[held.begins]


def _end_s(held: HeldSection, moves_s: Sequence[float]) -> float:
    return held.occupation.end_s + moves_s[held.ends]


def _chain(
    legs: Sequence[SetLeg],
    held: Sequence[HeldSection],
    moves_s: Sequence[float],
    because: Sequence[Touch | None],
    ends: tuple[HeldSection, HeldSection],
) -> tuple[ChainLink, ...]:
    """From the last end back to the first beginning, by what holds each leg where it is."""
    first, last = ends
    until_s, stop_s = _end_s(last, moves_s), _begin_s(first, moves_s)
    by_leg = {(h.begins, h.occupation.section_id): h for h in held}
    by_leg |= {(h.ends, h.occupation.section_id): h for h in held}
    at, section_id = last.ends, last.occupation.section_id
    links: list[ChainLink] = []
    while until_s > stop_s + TOUCH_S:
        touch = because[at]
        from_s = stop_s if touch is None else max(touch.begin_s + moves_s[at], stop_s)
        one = by_leg.get((at, section_id))
        links.append(_link(legs[at], None if one is None else one.occupation, from_s, until_s, moves_s[at]))
        if touch is None:
            break
        at, until_s = touch.before, from_s
        section_id = touch.section_id or legs[at].occupations[-1].section_id
    return tuple(reversed(links))


def _link(
    leg: SetLeg, occupation: Occupation | None, begin_s: float, end_s: float, move_s: float
) -> ChainLink:
    one = leg.occupations[-1] if occupation is None else occupation
    costs_s = costs_between(one, begin_s - move_s, end_s - move_s, leg.occupations)
    return ChainLink(leg.number, one.section_id, begin_s, end_s, costs_s)
