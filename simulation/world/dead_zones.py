"""Stretches of line that the radio does not reach for now, though the line's coverage says so (不感地帯)."""

from __future__ import annotations

from network.model import Line
from network.path import Path
from radio.air import NETWORKS
from simulation.faults.links import LineStretch, OfNetwork, is_of


class DeadZonesInForce:
    """Those in force, by the section that each is named after."""

    def __init__(self, line: Line) -> None:
        self._line = line
        self._by_section: dict[
            str, list[tuple[str, float, float, OfNetwork]]
        ] = {}  # alignment, from and to, m

    def put_stretches(self, section_id: str, stretches: tuple[LineStretch, ...]) -> None:
        """These are the stretches that are named after a section."""
        pieces = [self._line.pieces[piece_id] for piece_id in self._line.sections[section_id].piece_ids]
        low_m, high_m = min(piece.from_m for piece in pieces), max(piece.to_m for piece in pieces)
        begins_m = [low_m + one.from_share * (high_m - low_m) for one in stretches]
        self._by_section[section_id] = [
            (pieces[0].alignment_id, from_m, from_m + one.length_m, one.network)
            for from_m, one in zip(begins_m, stretches, strict=True)
        ]

    def hides(self, path: Path, position_m: float, network: str = NETWORKS[0]) -> bool:
        """Whether a front at a path coordinate, m, stands in one of a network."""
        return any(self._by_section.values()) and self.hides_place(*self.place_of(path, position_m), network)

    def place_of(self, path: Path, position_m: float) -> tuple[str, float]:
        """The alignment and the kilometrage, m, of a path coordinate, m."""
        step = path.step_at(position_m)
        return self._line.pieces[step.piece_id].alignment_id, step.kilometrage_m(position_m)

    def hides_place(self, alignment_id: str, at_m: float, network: str = "") -> bool:
        """Whether an alignment's kilometrage, m, lies in one, of whichever network if none is named."""
        every = (zone for zones in self._by_section.values() for zone in zones)
        return any(
            on == alignment_id and from_m <= at_m <= to_m and (not network or is_of(of, network))
            for on, from_m, to_m, of in every
        )
