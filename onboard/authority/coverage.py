"""Where on its path a train reaches the radio network (無線エリア), by the unit's own fixed data and position."""

from __future__ import annotations

import math
from collections.abc import Sequence

from network.model import Alignment, Coverage, Line
from network.path import Path

WELL_INSIDE_M = 1.0  # beyond the edge by this much, so that rounding cannot put the train outside


def covered_at(line: Line, path: Path, position_m: float) -> bool:
    """Whether the radio reaches a train whose front is at a path coordinate, m."""
    alignment, at_m = _on_alignment(line, path, position_m)
    return _holds(alignment.coverage, at_m)


def covered_by(line: Line, path: Path, position_m: float, networks: int) -> tuple[bool, ...]:
    """Which of one or two networks reaches it there."""
    if networks == 1:
        return (covered_at(line, path, position_m),)
    alignment, at_m = _on_alignment(line, path, position_m)
    return tuple(_holds(reach, at_m) for reach in alignment.of_networks or (alignment.coverage, ()))


def _on_alignment(line: Line, path: Path, position_m: float) -> tuple[Alignment, float]:
    step = path.step_at(position_m)
    return line.alignments[line.pieces[step.piece_id].alignment_id], step.kilometrage_m(position_m)


def _holds(stretches: Sequence[Coverage], at_m: float) -> bool:
    return any(stretch.from_m <= at_m <= stretch.to_m for stretch in stretches)


def next_coverage_m(line: Line, path: Path, position_m: float) -> float:
    """Path coordinate (m) ahead that is just inside a stretch where the radio reaches again; infinite if none is."""
    best_m = math.inf
    for step in path.steps:
        piece = line.pieces[step.piece_id]
        for stretch in line.alignments[piece.alignment_id].coverage:
            edge_m = stretch.from_m if step.direction > 0 else stretch.to_m
            if piece.from_m <= edge_m <= piece.to_m and step.to_path_m(edge_m) + WELL_INSIDE_M > position_m:
                best_m = min(best_m, step.to_path_m(edge_m))
    return best_m + WELL_INSIDE_M
