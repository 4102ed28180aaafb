"""What a train meets along its path, every metre: elevation, how the track bends, how fast it may go, what sky it sees.

What a train weighs against (elevation, mean curvature) is that of the alignment; the short curves of diverging legs are
in `heading_rad` alone, which is where the track really points.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.alignment import bearing_rad
from network.model import Alignment, Curve, Line, Piece, PointsLeg
from network.offsets import turned_rad
from network.path import Path, PathStep

PROFILE: Final = np.dtype(
    [
        ("elevation_m", "f8"),
        ("turn_rad", "f8"),
        ("limit_mps", "f8"),
        ("heading_rad", "f8"),
        ("irregularity_rad", "f8"),
        ("sky", "f8"),
        ("kilometrage_m", "f8"),
    ],
    align=True,
)
NO_SKY: Final = 0.0  # in a tunnel
PART_OF_SKY: Final = 0.5  # among slopes, trees or houses
OPEN_SKY: Final = 1.0


ROWS_KEPT: Final = 500_000  # of the paths asked for last; some 28 MB


class Profiles:
    """The profiles asked for last, each computed once; a line is known by being the same object."""

    def __init__(self, compute: Callable[[Line, Path], NDArray[np.void]]) -> None:
        self._compute = compute
        self._kept: OrderedDict[tuple[int, Path], tuple[Line, NDArray[np.void]]] = OrderedDict()
        self._rows = 0

    def of_path(self, line: Line, path: Path) -> NDArray[np.void]:
        """The profile of a path, which is its caller's to change."""
        key = (id(line), path)
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key][1].copy()
        rows = self._compute(line, path)
        self._kept[key] = (line, rows)  # the line with it, so that no other gets its id
        self._rows += rows.size
        while self._rows > ROWS_KEPT:
            self._rows -= self._kept.popitem(last=False)[1][1].size
        return rows.copy()


def profile_of(line: Line, path: Path) -> NDArray[np.void]:
    """PROFILE rows at path coordinates 0, 1, 2 m ... ceil(length); the last is at the path's end.

    - elevation_m: begins with the alignment's and changes with its gradients.
    - turn_rad: integral of |curvature| from the start, so that the mean |curvature| under a train of length
      l is (turn(front) - turn(front - l)) / l; transitions are clothoids (curvature linear in distance).
    - limit_mps: lowest limit in force within 1 m either way, so that row floor(x), round(x) or ceil(x) is
      never above the limit at x. It holds for a point; a train obeys the lowest over its whole length.
    - heading_rad: by how much the track has turned to the right, as its trains see it, since the path's beginning, with
      the curves of the legs of points; its slope is the signed curvature.
    - irregularity_rad: how far the rails as laid point off that; 0 here, the world lays it.
    - sky: NO_SKY, PART_OF_SKY or OPEN_SKY.
    - kilometrage_m: of its alignment: what does not depend on which way a train comes.
    """
    return _PROFILES.of_path(line, path)


def _computed_profile(line: Line, path: Path) -> NDArray[np.void]:
    count = math.ceil(path.length_m) + 1
    at_m = np.minimum(np.arange(count, dtype=np.float64), path.length_m)
    rows = np.zeros(count, PROFILE)
    rows["limit_mps"] = line.max_speed_mps
    rows["sky"] = OPEN_SKY
    elevation_m = float(_elevation_m(_alignment(line, path.steps[0]), np.array([path.steps[0].entry_m]))[0])
    turn_rad = heading_rad = 0.0
    turns: dict[str, _CurveTurns] = {}
    for step in path.steps:
        alignment = _alignment(line, step)
        here = slice(math.ceil(step.start_m), count if step is path.steps[-1] else math.ceil(step.end_m))
        inside_m = step.entry_m + step.direction * (at_m[here] - step.start_m)
        ends_m = np.array([step.entry_m, step.kilometrage_m(step.end_m)])
        kilometrages_m = np.concatenate((ends_m, inside_m))
        height_m = _elevation_m(alignment, kilometrages_m)
        if alignment.id not in turns:
            turns[alignment.id] = _CurveTurns(alignment.curves)
        turned = turns[alignment.id].at(kilometrages_m)
        bend_rad = np.abs(turned - turned[:1])
        rows["kilometrage_m"][here] = inside_m
        rows["elevation_m"][here] = elevation_m + height_m[2:] - height_m[0]
        rows["turn_rad"][here] = turn_rad + bend_rad[2:]
        elevation_m += float(height_m[1] - height_m[0])
        turn_rad += float(bend_rad[1])
        points_rad = bearing_of_piece_rad(line, line.pieces[step.piece_id], kilometrages_m)
        rows["heading_rad"][here] = heading_rad + points_rad[2:] - points_rad[0]
        heading_rad += float(points_rad[1] - points_rad[0])
        for sky, covers in ((PART_OF_SKY, alignment.obstructed), (NO_SKY, alignment.tunnels)):
            for cover in covers:
                rows["sky"][here][(cover.from_m <= inside_m) & (inside_m <= cover.to_m)] = sky
        _limit_on_alignment(rows, alignment, step)
    _limit_on_points(rows, line, path)
    rows["turn_rad"] = np.maximum.accumulate(rows["turn_rad"])
    return rows


_PROFILES: Final = Profiles(_computed_profile)


def bearing_of_piece_rad(line: Line, piece: Piece, kilometrage_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where a piece points going DOWN, to the right positive, with the curves of a leg of points.

    By what it differs from place to place a train going UP turns too: both its way and what is right are reversed.
    """
    alignment = line.alignments[piece.alignment_id]
    return bearing_rad(alignment, kilometrage_m) + turned_rad(line, piece, kilometrage_m)


def heights_of(line: Line) -> dict[str, tuple[tuple[float, float], ...]]:
    """How high each piece lies: from its low end, distances along it where its gradient changes, and elevations, m."""
    heights: dict[str, tuple[tuple[float, float], ...]] = {}
    for piece in line.pieces.values():
        alignment = line.alignments[piece.alignment_id]
        changes_m = [g.to_m for g in alignment.gradients if piece.from_m < g.to_m < piece.to_m]
        at_m = np.array([piece.from_m, *changes_m, piece.to_m])
        along_m = (at_m - piece.from_m).tolist()
        heights[piece.id] = tuple(zip(along_m, _elevation_m(alignment, at_m).tolist(), strict=True))
    return heights


def _alignment(line: Line, step: PathStep) -> Alignment:
    return line.alignments[line.pieces[step.piece_id].alignment_id]


def _elevation_m(alignment: Alignment, kilometrage_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Elevation at kilometrages: piecewise linear through the ends of the gradients."""
    breaks_m = [alignment.from_m, *(gradient.to_m for gradient in alignment.gradients)]
    heights_m = [alignment.elevation_m]
    for gradient in alignment.gradients:
        heights_m.append(heights_m[-1] + (gradient.to_m - gradient.from_m) * gradient.permille / 1000.0)
    return np.asarray(np.interp(kilometrage_m, breaks_m, heights_m), dtype=np.float64)


class _CurveTurns:
    """Integral of |curvature| from an alignment's beginning: parabolas in the transitions, linear between."""

    def __init__(self, curves: Sequence[Curve]) -> None:
        self._from_m = np.array([curve.from_m for curve in curves])
        self._to_m = np.array([curve.to_m for curve in curves])
        self._transition_m = np.array([curve.transition_m for curve in curves])
        self._radius_m = np.array([abs(curve.radius_m) for curve in curves])
        whole_rad = self._in_curve_rad(np.arange(len(curves)), self._to_m)
        self._before_rad = np.concatenate(([0.0], np.cumsum(whole_rad)))

    def at(self, kilometrage_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """At kilometrages (m); curves lie one behind the other, so that each place has one that began last."""
        if not self._from_m.size:
            return np.zeros_like(kilometrage_m)
        curve = np.maximum(np.searchsorted(self._from_m, kilometrage_m, side="right") - 1, 0)
        at_m = np.clip(kilometrage_m, self._from_m[curve], self._to_m[curve])
        return np.asarray(self._before_rad[curve] + self._in_curve_rad(curve, at_m), dtype=np.float64)

    def _in_curve_rad(
        self, curve: NDArray[np.intp], kilometrage_m: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """From the beginning of the curve of that number to a kilometrage in it."""
        along_m = kilometrage_m - self._from_m[curve]
        length_m = self._to_m[curve] - self._from_m[curve]
        t_m = self._transition_m[curve]
        some_m = np.where(t_m == 0.0, 1.0, t_m)
        up_m = np.minimum(along_m, t_m) ** 2 / (2 * some_m)
        level_m = np.clip(along_m - t_m, 0.0, np.maximum(length_m - 2 * t_m, 0.0))
        left_m = np.minimum(length_m - along_m, t_m)
        down_m = (t_m**2 - left_m**2) / (2 * some_m)
        bent_m = np.where(t_m == 0.0, along_m, up_m + level_m + down_m)
        return np.asarray(bent_m / self._radius_m[curve], dtype=np.float64)


def _lower(rows: NDArray[np.void], from_m: float, to_m: float, speed_mps: float) -> None:
    """Apply a limit between path coordinates to every row within 1 m of it."""
    limits = rows["limit_mps"][max(math.floor(from_m), 0) : math.ceil(to_m) + 1]
    np.minimum(limits, speed_mps, out=limits)


def _limit_on_alignment(rows: NDArray[np.void], alignment: Alignment, step: PathStep) -> None:
    low_m, high_m = sorted((step.entry_m, step.kilometrage_m(step.end_m)))
    for limit in alignment.limits:
        from_m, to_m = max(limit.from_m, low_m), min(limit.to_m, high_m)
        if step.direction in limit.directions and from_m <= to_m:
            on_path_m = sorted((step.to_path_m(from_m), step.to_path_m(to_m)))
            _lower(rows, on_path_m[0], on_path_m[1], limit.speed_mps)


def _limit_on_points(rows: NDArray[np.void], line: Line, path: Path) -> None:
    """Diverging limit over the reverse leg and the stem of points that the path takes in reverse."""
    for step in path.steps:
        piece = line.pieces[step.piece_id]
        if piece.leg is not PointsLeg.REVERSE or piece.points_id is None:
            continue
        points = line.points[piece.points_id]
        _lower(rows, step.start_m, step.end_m, points.diverging_limit_mps)
        if points.stem_piece in path:
            stem = path.step_of(points.stem_piece)
            _lower(rows, stem.start_m, stem.end_m, points.diverging_limit_mps)
