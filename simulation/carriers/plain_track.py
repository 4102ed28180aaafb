"""The plain carrier: one dimension, no SUMO; for single-train experiments, sweeps, and as a check on the other carrier.

A train lies on the piece under its front and on those behind it, by the way it came. Only trains that lie on one
piece can touch, and sections keep trains apart: so a stretch is carried in one go, and step by step where two trains
come to lie on one piece, or a train was put there or turned (`simulation.carriers.touching`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, islice
from typing import Final

from network.graph import next_pieces
from network.model import Direction, Line
from simulation.carriers.carrier import Truth
from simulation.carriers.touching import Extent, Look, text_of, touch

# the piece from which a direction enters a piece; None: no track
Before = Callable[[str, Direction], str | None]


@dataclass(slots=True, eq=False)
class _Train:
    """`pieces`: under the front, then ahead; `behind`: those that the rest of it lies on, from the front backwards.

    `clear_m`: the front's offset from which the last of `behind` is clear.
    """

    unit_id: str
    pieces: list[str]
    direction: Direction
    offset_m: float
    length_m: float
    speed_mps: float = 0.0
    behind: list[str] = field(default_factory=list[str])
    clear_m: float = math.inf


def _nowhere(_piece_id: str, _direction: Direction) -> None:
    """Nothing is known of the track behind."""


class PlainTrack:
    """Trains on sequences of pieces, moved by the trapezoid rule.

    `before` says what lies behind a train that is put on the track longer than what is behind its front on the piece;
    `legs` gives the other leg of the points by each leg. `look`: what collisions it looks for.
    """

    def __init__(
        self,
        piece_lengths_m: Mapping[str, float],
        step_s: float,
        before: Before = _nowhere,
        legs: Mapping[str, str] | None = None,
        look: Look = Look.AS_SUMO,
    ) -> None:
        self._lengths_m: Final = dict(piece_lengths_m)
        self._step_s: Final = step_s
        self._before: Final = before
        self._look: Final = look
        self._legs: Final = dict(legs or {}) if Look.FOULING in look else {}
        self._trains: dict[str, _Train] = {}
        self._on: dict[str, list[_Train]] = {}  # by piece
        self._close = False  # two trains lie where they could touch
        self._judged = True  # as they now lie
        self._collisions: dict[tuple[str, str], str] = {}

    @staticmethod
    def of_line(line: Line, step_s: float, look: Look = Look.AS_SUMO) -> PlainTrack:
        """The track of a line."""

        def before(piece_id: str, direction: Direction) -> str | None:
            found = next_pieces(line, piece_id, direction.opposite)
            return found[0] if found else None

        legs = {points.normal_piece: points.reverse_piece for points in line.points.values()}
        legs |= {reverse: normal for normal, reverse in legs.items()}
        return PlainTrack(
            {piece.id: piece.length_m for piece in line.pieces.values()}, step_s, before, legs, look
        )

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
        train = _Train(unit_id, list(pieces), direction, offset_m, length_m, speed_mps)
        covered_m, piece_id = offset_m, self._before(pieces[0], direction)
        while covered_m < length_m and piece_id is not None:
            train.behind.append(piece_id)
            covered_m += self._lengths_m[piece_id]
            piece_id = self._before(piece_id, direction)
        self._trains[unit_id] = train
        self._lay(train)
        self._judged = False

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        """Execute the speeds; after the step in which trains collide that had not, it stops."""
        if steps <= 0 or (not columns and self._judged):
            return 0
        if self._close or not self._judged:
            return self._run_looking(columns, steps)
        step_s = self._step_s
        ends: list[tuple[_Train, float, float]] = []
        for unit_id, speeds in columns:
            train = self._trains[unit_id]
            offset_m, speed_mps = train.offset_m, train.speed_mps
            for next_mps in islice(speeds, steps):
                offset_m += (speed_mps + next_mps) / 2.0 * step_s
                speed_mps = next_mps
            ends.append((train, offset_m, speed_mps))
        if self._comes_close(ends):
            return self._run_looking(columns, steps)
        for train, offset_m, speed_mps in ends:
            train.offset_m, train.speed_mps = offset_m, speed_mps
            self._follow(train)
        return 0

    def _comes_close(self, ends: Sequence[tuple[_Train, float, float]]) -> bool:
        """Whether any train gets onto a piece that another lies on or gets onto; `ends`: offset and speed after it."""
        taken: set[str] = set()
        for train, front_m, _ in ends:
            left_m = front_m - self._lengths_m[train.pieces[0]]
            for piece_id in train.pieces[1:]:
                if left_m < 0.0:
                    break
                beside = self._legs.get(piece_id, piece_id)
                if not taken.isdisjoint((piece_id, beside)) or piece_id in self._on or beside in self._on:
                    return True
                taken.add(piece_id)
                left_m -= self._lengths_m[piece_id]
        return False

    def _run_looking(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        """The same step by step, with a look after each."""
        moving = [(self._trains[unit_id], speeds) for unit_id, speeds in columns]
        for k in range(steps):
            for train, speeds in moving:
                train.offset_m += (train.speed_mps + speeds[k]) / 2.0 * self._step_s
                train.speed_mps = speeds[k]
                self._follow(train)
            self._judged = True
            if self._close and self._collided():
                return k + 1
            if not moving:
                return 0
        return 0

    def _follow(self, train: _Train) -> None:
        """Take up the pieces that its front has got onto, and leave those that its rear has cleared."""
        if train.offset_m < self._lengths_m[train.pieces[0]] and train.offset_m < train.clear_m:
            return
        self._lift(train)
        while train.offset_m >= self._lengths_m[train.pieces[0]] and len(train.pieces) > 1:
            train.offset_m -= self._lengths_m[train.pieces[0]]
            train.behind.insert(0, train.pieces.pop(0))
        self._lay(train)

    def _lay(self, train: _Train) -> None:
        """Write down which pieces a train lies on, those that it has cleared no more."""
        behind_m = [self._lengths_m[piece_id] for piece_id in train.behind]
        while behind_m and train.offset_m + math.fsum(behind_m[:-1]) >= train.length_m:
            behind_m.pop()
            train.behind.pop()
        train.clear_m = train.length_m - math.fsum(behind_m[:-1]) if behind_m else math.inf
        for piece_id in (train.pieces[0], *train.behind):
            self._on.setdefault(piece_id, []).append(train)
        self._close = any(len(trains) > 1 for trains in self._on.values()) or any(
            beside in self._on for leg, beside in self._legs.items() if leg in self._on
        )

    def _lift(self, train: _Train) -> None:
        for piece_id in (train.pieces[0], *train.behind):
            self._on[piece_id].remove(train)
            if not self._on[piece_id]:
                del self._on[piece_id]

    def _collided(self) -> bool:
        """Write down the trains that touch and did not before; whether there are any."""
        found: set[tuple[str, str]] = set()
        for piece_id, trains in self._on.items():
            length_m = self._lengths_m[piece_id]
            for one, other in combinations(trains, 2):
                extents = self._extent(one, piece_id), self._extent(other, piece_id)
                if touch(*extents, length_m, self._look):
                    found.add(_pair(one, other))
            for other in self._on.get(self._legs.get(piece_id, ""), ()):
                found |= {_pair(one, other) for one in trains if one is not other}
        new = sorted(found - self._collisions.keys())
        for one_id, other_id in new:
            self._collisions[one_id, other_id] = text_of(
                one_id, self.truth(one_id), other_id, self.truth(other_id)
            )
        return bool(new)

    def _extent(self, train: _Train, piece_id: str) -> Extent:
        """Where a train lies along one of the pieces that it lies on."""
        leads = piece_id == train.pieces[0]
        passed = () if leads else train.behind[: train.behind.index(piece_id) + 1]
        front_m = train.offset_m + sum(self._lengths_m[passed_id] for passed_id in passed)
        rear_m = front_m - train.length_m
        return Extent(train.direction, front_m, rear_m, train.speed_mps * self._step_s, leads)

    def truth(self, unit_id: str) -> Truth:
        """Where the front is."""
        train = self._trains[unit_id]
        return Truth(train.pieces[0], train.direction, train.offset_m, train.speed_mps)

    def reroute(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change what lies ahead."""
        train = self._trains[unit_id]
        self._lift(train)
        train.pieces = list(pieces)
        train.direction = direction
        self._lay(train)

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change ends in place."""
        train, ahead = self._trains[unit_id], list(pieces)
        self._lift(train)
        train.offset_m = self._lengths_m[train.pieces[0]] - train.offset_m + train.length_m
        train.behind.clear()
        while len(ahead) > 1 and train.offset_m > self._lengths_m[ahead[0]]:
            train.offset_m -= self._lengths_m[ahead[0]]
            train.behind.insert(0, ahead.pop(0))
        train.pieces, train.direction = ahead, direction
        self._lay(train)
        self._judged = False

    def remove(self, unit_id: str) -> None:
        """Take a train off the track."""
        self._lift(self._trains.pop(unit_id))

    def collisions(self) -> tuple[str, ...]:
        """What collided since the start, one line each."""
        return tuple(self._collisions.values())

    def close(self) -> None:
        """Nothing to release."""


def _pair(one: _Train, other: _Train) -> tuple[str, str]:
    first_id, second_id = sorted((one.unit_id, other.unit_id))
    return first_id, second_id
