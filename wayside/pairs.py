"""Invariant: what is dead here is dead: two trains that could not both finish if they were alone cannot with others.

For two trains on a line of their own, all pairs of places from which both can finish, worked out backwards from their
ends. With one row for each place of the first and a bit for each place of the second it takes microseconds a row.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from wayside.moves import Train, bits_of


@dataclass(frozen=True, slots=True)
class _Needs:
    """By section, a bit for each place of a train (bit k: k moves are left): where it holds it, where it needs it."""

    holds: Mapping[int, int]
    needs: Mapping[int, int]


class Pairs:
    """Of all trains two by two."""

    def __init__(self, trains: Sequence[Train]) -> None:
        self._moves = [len(train.ahead) for train in trains]
        needs = [None if train.choices else _needs_of(train) for train in trains]
        self._rows = [
            [self._rows_of(train, other, needs[other]) for other in range(index)]
            for index, train in enumerate(trains)
        ]

    def _rows_of(self, train: Train, other: int, needs: _Needs | None) -> tuple[int, ...] | None:
        return None if train.choices or needs is None else _rows(train, needs, self._moves[other])

    def rows(self, one: int, two: int) -> tuple[int, ...]:
        """By the place of the one of them that comes later, from where on the other both can finish: bit k is k moves
        before its end; none where either has a choice.
        """
        return self._rows[one][two] or ()

    def dead(self, at: Sequence[int], mover: int) -> int | None:
        """A train with which this one cannot finish, where both are; None: with each of them it can."""
        for other in range(len(at)):
            one, two = (mover, other) if other < mover else (other, mover)
            rows = self._rows[one][two] if one != two else None
            if rows is not None and not rows[at[one]] >> (self._moves[two] - at[two]) & 1:
                return other
        return None


def _needs_of(train: Train) -> _Needs:
    holds: dict[int, int] = {}
    needs: dict[int, int] = {}
    held, place = train.holds, 1 << len(train.ahead)
    for move in train.ahead:
        for bit in bits_of(held):
            holds[bit] = holds.get(bit, 0) | place
        for bit in bits_of(move.needs & ~held):
            needs[bit] = needs.get(bit, 0) | place
        held, place = move.keeps, place >> 1
    for bit in bits_of(held):
        holds[bit] = holds.get(bit, 0) | place
    return _Needs(holds, needs)


def _rows(train: Train, other: _Needs, moves: int) -> tuple[int, ...]:
    """For each place of the train, from where on the other both can finish: bit k is k moves before its end."""
    movable = (1 << (moves + 1)) - 2
    rows: list[int] = []
    row = 0
    held = [train.holds, *(move.keeps for move in train.ahead)]
    for place in range(len(train.ahead), -1, -1):
        if place == len(train.ahead):
            goes_first = 1
        else:
            goes_first = row & ~_any(other.holds, train.ahead[place].needs & ~held[place])
        goes = movable & ~_any(other.needs, held[place])
        # The other moves on to a place that is good: a carry runs through all from which it can move.
        good = (goes_first << 1) & goes
        row = goes_first | good | goes & ~(goes + good)
        rows.append(row)
    return tuple(reversed(rows))


def _any(places: Mapping[int, int], sections: int) -> int:
    found = 0
    for bit in bits_of(sections):
        found |= places.get(bit, 0)
    return found
