"""Where a piece lies beside its alignment, and how it crosses over from one track to another.

A leg of points leaves one track and meets the other parallel to them: the offset is a cubic of the distance,

    offset(t) = low + (high - low) t^2 (3 - 2 t),    t = distance / length,

which bends one way and then the other, at most by 6 (high - low) / length^2: 1/150 m for 4 m over 60 m.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from network.model import Line, Piece, PointsLeg

Floats = NDArray[np.float64]


def end_offsets_m(line: Line, piece: Piece) -> tuple[float, float]:
    """Lateral offsets (m, to the right of DOWN) of a piece at its low and at its high end."""
    return _end_offset_m(line, piece, piece.low_node), _end_offset_m(line, piece, piece.high_node)


def lateral_m(line: Line, piece: Piece, kilometrage_m: Floats) -> Floats:
    """Lateral offset (m, to the right of DOWN) of a piece at kilometrages (m) on it."""
    low_m, high_m = end_offsets_m(line, piece)
    share = (kilometrage_m - piece.from_m) / piece.length_m
    return np.asarray(low_m + (high_m - low_m) * share * share * (3.0 - 2.0 * share), dtype=np.float64)


def turned_rad(line: Line, piece: Piece, kilometrage_m: Floats) -> Floats:
    """Heading of a piece against its alignment's, going DOWN, at kilometrages (m) on it; rad, to the right positive."""
    low_m, high_m = end_offsets_m(line, piece)
    share = (kilometrage_m - piece.from_m) / piece.length_m
    slope = (high_m - low_m) / piece.length_m * 6.0 * share * (1.0 - share)
    return np.asarray(np.arctan(slope), dtype=np.float64)


def _end_offset_m(line: Line, piece: Piece, node_id: str) -> float:
    """Lateral offset (m) of a piece at one of its ends, the same for every piece of its alignment there.

    At the toe of points it is the stem's, at the far end of a leg that of the track it leads to; two legs
    that meet (a crossover, 渡り線) meet halfway.
    """
    there = [
        p
        for p in line.pieces.values()
        if node_id in (p.low_node, p.high_node) and p.alignment_id == piece.alignment_id
    ]
    there.sort(key=lambda p: p.id)
    stems = {points.stem_piece for points in line.points.values() if points.node_id == node_id}
    for candidates in (
        [p for p in there if p.id in stems],
        [p for p in there if p.leg in (None, PointsLeg.STEM)],
    ):
        if candidates:
            return candidates[0].offset_m
    return sum(p.offset_m for p in there) / len(there)
