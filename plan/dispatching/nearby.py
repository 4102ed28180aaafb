"""Orders near a known one: where a train waits for another, it is tried before it, as long as that delays all less.

Quick and counted, and blind beyond one change at a time: what it leaves is for a solver to find, which proves as well.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from wayside.certificate import CertificateProof, finishing_order, follows
from wayside.moves import Move, Train
from wayside.order_question import OrderTrain, OrderWay

TRIED_MAX: Final = 300  # assumed: orders played through, half a millisecond each
STEPS: Final = 300  # assumed: of a search for an order that begins so


@dataclass(frozen=True, slots=True)
class _Playing:
    """An order played through: all delay that counts, s, and who waits: how long, s, for how many before it, where."""

    order: tuple[int, ...]
    cost_s: int
    waits: tuple[tuple[int, int, int], ...]


class _Nearby:
    """What is tried, one after the other."""

    def __init__(
        self,
        trains: Sequence[OrderTrain],
        ways: Sequence[Sequence[OrderWay]],
        searched: Sequence[Train],
    ) -> None:
        self._trains, self._ways, self._searched = trains, ways, searched
        self.tried = 0

    def played(self, order: Sequence[int]) -> _Playing:
        """An order that is possible."""
        return _played_through(self._trains, self._ways, order)

    def near(self, played: _Playing) -> Iterator[_Playing]:
        """With each that waits before that for which it waits, the longest wait first."""
        for _, at, after in sorted(played.waits, key=lambda wait: (-wait[0], wait[1])):
            if self.tried >= TRIED_MAX:
                return
            self.tried += 1
            other = _put_before(self._searched, played.order, at, after)
            if other is not None:
                yield self.played(other)

    def descended(self, played: _Playing) -> _Playing:
        """The best that single changes lead to, each for the better."""
        while (better := next((p for p in self.near(played) if p.cost_s < played.cost_s), None)) is not None:
            played = better
        return played


def improved(
    trains: Sequence[OrderTrain],
    ways: Sequence[Sequence[OrderWay]],
    searched: Sequence[Train],
    order: Sequence[int],
) -> tuple[int, ...]:
    """An order in which all can run that delays all no more, and none near it less, as far as was tried: by changes
    for the better, then by one for the worse and all for the better that follow.
    """
    nearby = _Nearby(trains, ways, searched)
    best: _Playing | None = nearby.descended(nearby.played(order))
    found = best
    while best is not None:
        found = best
        tries = (nearby.descended(worse) for worse in nearby.near(found))
        best = next((played for played in tries if found is not None and played.cost_s < found.cost_s), None)
    return tuple(order) if found is None else found.order


def _put_before(
    searched: Sequence[Train], order: Sequence[int], at: int, after: int
) -> tuple[int, ...] | None:
    """The order with a train's moves up to one made before that of another; the rest as near as it can be. None: no
    order was found that begins so.
    """
    mover = order[at]
    own = [k for k in range(after, at + 1) if order[k] == mover]
    begun = (*order[:after], *(mover for _ in own))
    if not follows(searched, begun):
        return None
    rest = [order[k] for k in range(after, len(order)) if k not in own]
    whole = (*begun, *rest)
    if follows(searched, whole):
        return whole
    ranks: dict[int, list[float]] = defaultdict(list)
    for rank, index in enumerate(rest):
        ranks[index].append(float(rank))
    left: list[Train] = []
    for index, train in enumerate(searched):
        done = begun.count(index)
        moves = zip(train.ahead[done:], ranks[index], strict=True)
        ahead = tuple(Move(move.needs, move.keeps, rank) for move, rank in moves)
        left.append(Train(train.ahead[done - 1].keeps if done else train.holds, ahead))
    found = finishing_order(left, STEPS)
    return (*begun, *found.order) if found.proof is CertificateProof.ORDER else None


def _played_through(
    trains: Sequence[OrderTrain], ways: Sequence[Sequence[OrderWay]], order: Sequence[int]
) -> _Playing:
    """Each move as soon as it can be."""
    free_s: dict[int, int] = {}
    freed_by: dict[int, int] = {}
    for train in trains:
        free_s.update(dict.fromkeys(set(train.holds).difference(train.keeps), train.comes_s))
    keeps = [set(train.keeps) for train in trains]
    ready_s = [train.comes_s + train.ready_s for train in trains]
    made = [0] * len(trains)
    cost_s, waits = 0, list[tuple[int, int, int]]()
    for at, index in enumerate(order):
        move, way = trains[index].moves[made[index]], ways[index][made[index]]
        could_s, held = max(ready_s[index], move.departs_s), keeps[index]
        wanted = [section for section in way.needs if section not in held]
        last = max(wanted, key=lambda section: free_s.get(section, 0), default=None)
        starts_s = could_s if last is None else max(could_s, free_s.get(last, 0))
        if last is not None and starts_s > could_s and last in freed_by:
            waits.append((starts_s - could_s, at, freed_by[last]))
        comes_s = starts_s + move.runs_s
        for section in {*held, *way.needs}.difference(way.keeps):
            free_s[section], freed_by[section] = comes_s, at
        keeps[index] = set(way.keeps)
        ready_s[index] = comes_s + move.stays_s
        made[index] += 1
        if move.counts:
            cost_s += max(0, comes_s - max(0, move.due_s))
    return _Playing(tuple(order), cost_s, tuple(waits))
