"""The least number of sets: as many trains as possible go on as another one, by a greatest matching.

Each set is a path of trains, and there are as many sets as trains that follow no other. The trains that follow one are
matched with what they follow (Fulkerson's minimum path cover). Where no more can be matched, a set of trains says why
(Hall, 1935; König, 1931): of these so many begin, and all trains after which any of them could come are fewer.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import msgspec

from plan.roster.facts import RosterTerms, RosterTrain, possible_links


class FewerCannot(msgspec.Struct, frozen=True):
    """A certificate: of the trains `begin` only `follow` can follow another, so that the rest need a set each."""

    sets: int
    begin: tuple[str, ...]
    after: tuple[str, ...]

    @property
    def at_least(self) -> int:
        """How many sets it shows to be needed."""
        return len(self.begin) - len(self.after)


@dataclass(frozen=True, slots=True)
class Roster:
    """Which train each train follows (those that follow none begin a set), and why fewer sets cannot do."""

    follows: Mapping[str, str]
    sets: tuple[tuple[str, ...], ...]
    why: FewerCannot


def least_roster(trains: Sequence[RosterTrain], terms: RosterTerms) -> Roster:
    """As few sets as can be; today's links stay where they do no harm."""
    after: dict[str, list[str]] = defaultdict(list)  # of each train, those that it may follow
    for one, other in possible_links(trains, terms):
        after[other].append(one)
    today = {t.number: t.follows for t in trains if t.follows is not None and t.follows in after[t.number]}
    goes_on = {before: number for number, before in today.items()}
    for train in trains:
        if train.number not in goes_on.values():
            _match(train.number, after, goes_on, set())
    follows = {number: before for before, number in goes_on.items()}
    unmatched = [train.number for train in trains if train.number not in follows]
    begin, seen = list(unmatched), set[str]()
    for number in begin:  # grows: who could give up a train to one of these is one of these
        for before in after[number]:
            if before not in seen:
                seen.add(before)
                begin.append(goes_on[before])
    order = {train.number: at for at, train in enumerate(trains)}
    why = FewerCannot(
        len(unmatched),
        tuple(sorted(begin, key=order.__getitem__)),
        tuple(sorted(seen, key=order.__getitem__)),
    )
    return Roster(follows, tuple(_paths(unmatched, goes_on)), why)


def _match(number: str, after: Mapping[str, Sequence[str]], goes_on: dict[str, str], tried: set[str]) -> bool:
    """Find a train for this one to follow, others giving up theirs for one more if need be."""
    stack = [(number, iter(after.get(number, ())))]
    way: list[str] = []
    while stack:
        _, others = stack[-1]
        before = next((one for one in others if one not in tried), None)
        if before is None:
            stack.pop()
            if way:
                way.pop()
            continue
        tried.add(before)
        way.append(before)
        if before not in goes_on:
            for (taker, _), given in zip(stack, way, strict=True):
                goes_on[given] = taker
            return True
        stack.append((goes_on[before], iter(after.get(goes_on[before], ()))))
    return False


def _paths(firsts: Iterable[str], goes_on: Mapping[str, str]) -> Iterable[tuple[str, ...]]:
    for first in firsts:
        own = [first]
        while own[-1] in goes_on:
            own.append(goes_on[own[-1]])
        yield tuple(own)
