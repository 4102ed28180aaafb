"""A train's path: pieces in order of travel, with one coordinate that grows in the direction of travel.

Outside (tags, marks, limits) things have a piece and a kilometrage; on board everything is on the path.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from network.graph import next_pieces
from network.model import Direction, LevelCrossing, Line


@dataclass(frozen=True, slots=True)
class PathStep:
    """One piece of a path: it begins `start_m` along the path, where its kilometrage is `entry_m`."""

    piece_id: str
    direction: Direction
    start_m: float
    length_m: float
    entry_m: float

    @property
    def end_m(self) -> float:
        """Path coordinate of its end, m."""
        return self.start_m + self.length_m

    def to_path_m(self, kilometrage_m: float) -> float:
        """Path coordinate (m) of a kilometrage (m) on this piece."""
        return self.start_m + self.direction * (kilometrage_m - self.entry_m)

    def kilometrage_m(self, path_m: float) -> float:
        """Kilometrage (m) of a path coordinate (m) on this piece."""
        return self.entry_m + self.direction * (path_m - self.start_m)


@dataclass(frozen=True, slots=True)
class Path:
    """Steps end to end from coordinate 0; made by `path_of`. Coordinates beyond it extend the end pieces."""

    steps: tuple[PathStep, ...]
    direction: Direction
    length_m: float
    _starts_m: tuple[float, ...] = field(init=False, repr=False, compare=False)
    _by_piece: Mapping[str, PathStep] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_starts_m", tuple(step.start_m for step in self.steps))
        object.__setattr__(self, "_by_piece", {step.piece_id: step for step in self.steps})

    @property
    def piece_ids(self) -> tuple[str, ...]:
        """Pieces in order of travel."""
        return tuple(step.piece_id for step in self.steps)

    def __contains__(self, piece_id: object) -> bool:
        """Whether the piece is on the path."""
        return piece_id in self._by_piece

    def step_of(self, piece_id: str) -> PathStep:
        """The step on a piece. Raises KeyError when the piece is not on the path."""
        return self._by_piece[piece_id]

    def to_path_m(self, piece_id: str, kilometrage_m: float) -> float:
        """Path coordinate (m) of a kilometrage (m) on a piece. Raises KeyError when it is not on the path."""
        return self._by_piece[piece_id].to_path_m(kilometrage_m)

    def to_road_m(self, crossing: LevelCrossing) -> float:
        """Path coordinate (m) where trains come onto the road of a level crossing. Raises KeyError as `to_path_m`."""
        return self.to_path_m(crossing.piece_id, crossing.edge_m(self.direction))

    def step_at(self, path_m: float) -> PathStep:
        """The step at a path coordinate (m); at a joint the one being entered."""
        return self.steps[max(bisect_right(self._starts_m, path_m) - 1, 0)]

    def locate(self, path_m: float) -> tuple[str, float]:
        """Piece and kilometrage (m) at a path coordinate (m); at a joint those of the piece being entered."""
        step = self.step_at(path_m)
        return step.piece_id, step.kilometrage_m(path_m)

    def kilometrage_m(self, path_m: float) -> float:
        """Kilometrage (m) at a path coordinate (m)."""
        return self.step_at(path_m).kilometrage_m(path_m)


def path_of(line: Line, piece_ids: Sequence[str], direction: Direction) -> Path:
    """Path over `piece_ids`, in order of travel.

    Raises KeyError for an unknown piece, ValueError when there is none or one does not follow the other.
    """
    if not piece_ids:
        raise ValueError("a path has at least one piece")
    for before, after in pairwise(piece_ids):
        if after not in next_pieces(line, before, direction):
            raise ValueError(f"{after} does not follow {before} going {direction.name.lower()}")
    steps: list[PathStep] = []
    start_m = 0.0
    for piece_id in piece_ids:
        piece = line.pieces[piece_id]
        entry_m = piece.from_m if direction is Direction.DOWN else piece.to_m
        length_m = round(piece.length_m, 6)
        steps.append(PathStep(piece_id, direction, start_m, length_m, entry_m))
        # Kilometrages are whole micrometres; rounding keeps sums of them so.
        start_m = round(start_m + length_m, 6)
    return Path(tuple(steps), direction, start_m)
