"""The plain carrier: one dimension, no SUMO; for single-train experiments and as a check on the other carrier."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from network.model import Direction
from simulation.carriers.carrier import Truth


@dataclass(slots=True)
class _Train:
    pieces: list[str]
    direction: Direction
    offset_m: float
    length_m: float
    speed_mps: float = 0.0


class PlainTrack:
    """Trains as points on sequences of pieces, moved by the trapezoid rule; trains do not see each other."""

    def __init__(self, piece_lengths_m: Mapping[str, float], step_s: float) -> None:
        self._lengths_m: Final = dict(piece_lengths_m)
        self._step_s: Final = step_s
        self._trains: dict[str, _Train] = {}

    def insert(
        self,
        unit_id: str,
        pieces: Sequence[str],
        direction: Direction,
        offset_m: float,
        length_m: float,
        speed_mps: float = 0.0,
    ) -> None:
        """Put a train on the track; a standing one unless an experiment begins in motion."""
        self._trains[unit_id] = _Train(list(pieces), direction, offset_m, length_m, speed_mps)

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        """Execute the speeds; never reports a collision."""
        for unit_id, speeds in columns:
            train = self._trains[unit_id]
            for k in range(steps):
                train.offset_m += (train.speed_mps + speeds[k]) / 2.0 * self._step_s
                train.speed_mps = speeds[k]
            while train.offset_m >= self._lengths_m[train.pieces[0]] and len(train.pieces) > 1:
                train.offset_m -= self._lengths_m[train.pieces.pop(0)]
        return 0

    def truth(self, unit_id: str) -> Truth:
        """Where the front is."""
        train = self._trains[unit_id]
        return Truth(train.pieces[0], train.direction, train.offset_m, train.speed_mps)

    def reroute(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change what lies ahead."""
        train = self._trains[unit_id]
        train.pieces = list(pieces)
        train.direction = direction

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change ends in place."""
        train = self._trains[unit_id]
        train.offset_m = self._lengths_m[train.pieces[0]] - train.offset_m + train.length_m
        train.pieces = list(pieces)
        train.direction = direction

    def remove(self, unit_id: str) -> None:
        """Take a train off the track."""
        del self._trains[unit_id]

    def collisions(self) -> tuple[str, ...]:
        """The plain track knows none."""
        return ()

    def close(self) -> None:
        """Nothing to release."""
