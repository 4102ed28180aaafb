"""Where a train lies along its way: the pieces from its rear to its front, in metres from where it was put there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from network.graph import next_pieces
from network.model import Direction, Line
from sumo_cfg.scenery import along_m


class PieceEntered(NamedTuple):
    """A piece on the way; `entry_m`: where on the way it begins."""

    piece_id: str
    entry_m: float


class Trail:
    """The way of one train. `front_m` is on the way; so is all that is told of places."""

    def __init__(
        self, line: Line, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        self._line, self.length_m = line, length_m
        self.direction, self.front_m = direction, offset_m
        self._lies = [PieceEntered(pieces[0], 0.0)]
        self._ahead = list(pieces[1:])
        while self._lies[0].entry_m > offset_m - length_m:
            behind = next_pieces(line, self._lies[0].piece_id, direction.opposite)
            if not behind:
                break
            entry_m = self._lies[0].entry_m - line.pieces[behind[0]].length_m
            self._lies.insert(0, PieceEntered(behind[0], entry_m))

    def lead(self, pieces: Sequence[str]) -> None:
        """Another way lies ahead; the first piece is the one under the front."""
        self._ahead = list(pieces[1:])

    def follow(self, piece_id: str, offset_m: float) -> None:
        """The front is `offset_m` into a piece that it stood on or that lay ahead. ValueError for another."""
        while self._lies[-1].piece_id != piece_id:
            if not self._ahead:
                raise ValueError(f"{piece_id} is not on the way")
            self._lies.append(PieceEntered(self._ahead.pop(0), self._end_m(self._lies[-1])))
        self.front_m = self._lies[-1].entry_m + offset_m
        while len(self._lies) > 1 and self._lies[1].entry_m <= self.front_m - self.length_m:
            self._lies.pop(0)

    def turn(self, pieces: Sequence[str]) -> None:
        """The rear becomes the front, in place; the first of `pieces` is the one that the front stood on."""
        self._lies = [PieceEntered(each.piece_id, -self._end_m(each)) for each in reversed(self._lies)]
        self.front_m = self.length_m - self.front_m
        self._ahead = list(pieces[len(self._lies) :])
        self.direction = self.direction.opposite

    def within(self, run_m: float) -> Iterator[PieceEntered]:
        """Pieces that the train lies on, and those that it comes onto within `run_m`."""
        yield from self._lies
        last = self._lies[-1]
        for ahead_id in self._ahead:
            last = PieceEntered(ahead_id, self._end_m(last))
            if last.entry_m > self.front_m + run_m:
                return
            yield last

    def place_m(self, entered: PieceEntered, position_m: float) -> float:
        """Where on the way a kilometrage of such a piece is, m."""
        return entered.entry_m + along_m(self._line.pieces[entered.piece_id], self.direction, position_m)

    def _end_m(self, each: PieceEntered) -> float:
        return each.entry_m + self._line.pieces[each.piece_id].length_m
