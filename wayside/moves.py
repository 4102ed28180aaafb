"""The moves that trains have yet to make, as the proof that all can finish takes them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Move:
    """From one track to the next. Sections are bits: `needs` must be free of others, `keeps` is held afterwards."""

    needs: int
    keeps: int
    due_s: float = 0.0  # when it is planned: what is due first is tried first


@dataclass(frozen=True, slots=True)
class Train:
    """A train with what it holds, and the moves that it still has to make.

    Place 0 is where it is, place k where move k - 1 of `ahead` ends. `choices`: for each place the moves that it can
    make there, all later ones of `ahead`; none: it has come to its end. Empty: it makes all its moves one by one.
    """

    holds: int
    ahead: tuple[Move, ...]
    choices: tuple[tuple[int, ...], ...] = ()

    def choices_at(self) -> tuple[tuple[int, ...], ...]:
        """For each place the moves that it can make there."""
        return self.choices or (*((place,) for place in range(len(self.ahead))), ())


def bits_of(mask: int) -> Iterator[int]:
    """The bits of a mask, each as a mask."""
    while mask:
        low = mask & -mask
        yield low
        mask ^= low
