"""What carries the trains: SUMO, or a plain one-dimensional track with the same interface.

A carrier executes given speeds step by step and tells where each train then is: that position is the truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from network.model import Direction


class Truth(NamedTuple):
    """Where a train's front is: piece, direction of travel, distance (m) from where that direction enters it."""

    piece_id: str
    direction: Direction
    offset_m: float
    speed_mps: float


class Carrier(Protocol):
    """The interface of SUMO and of the plain track."""

    def insert(
        self, unit_id: str, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        """Put a standing train on the first of `pieces`, its front `offset_m` from where `direction` enters it."""
        ...

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        """Execute `steps` steps with the speeds (m/s) of each train; returns steps after which trains collided.

        The result is 0 without a collision; otherwise the collision was seen after that many steps and the rest
        was not executed.
        """
        ...

    def truth(self, unit_id: str) -> Truth:
        """Where a train's front is now."""
        ...

    def reroute(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change what lies ahead; the first piece is the one the front stands on."""
        ...

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change ends in place: the rear becomes the front; the first piece is the one that the front stood on."""
        ...

    def remove(self, unit_id: str) -> None:
        """Take a train off the line."""
        ...

    def collisions(self) -> tuple[str, ...]:
        """What collided since the start, one line each."""
        ...

    def close(self) -> None:
        """Release what the carrier holds."""
        ...
