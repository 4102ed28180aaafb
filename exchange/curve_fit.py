"""From a surveyed polyline to an alignment: straights, transitions and circular curves by least squares.

The polyline gives vertices some 5 m to 500 m apart, each good to a metre or so. Curves are first found where
the smoothed heading turns; then the gap before each curve, its length and its deflection are fitted together
so that the integrated axis passes through the vertices (lateral residuals, soft_l1 against stray vertices);
then radii are rounded to values a surveyor would have set out and everything else is fitted once more. Of a long
track that is done a few curves at a time, each time from where the axis fitted so far ends.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import least_squares

from network.alignment import CurvatureTable, curvature_table, integrate_plane
from network.model import Curve

Floats = NDArray[np.float64]

SMOOTHING_M: Final = 30.0  # standard deviation of the window over the heading
STRAIGHT_RADIUS_M: Final = 2500.0  # flatter than this is straight within the vertices' accuracy
DEFLECTION_MIN_RAD: Final = float(np.radians(1.0))
CURVE_LENGTH_MIN_M: Final = 120.0  # a small turn is set out with a long radius, not with a kink
RADIUS_MIN_M: Final = 200.0  # the vertices do not tell sharper curves of this length apart
FAR_TURN_RAD: Final = float(np.radians(80.0))
RADIUS_MIN_FAR_M: Final = 100.0  # assumed: sharper is a tramway
TRANSITION_MAX_M: Final = 42.0  # 400 times the largest cant, 105 mm

_GRID_M: Final = 5.0
_AXIS_STEP_M: Final = 6.0  # straight between them: 2 cm at radius 200 m
_AXIS_BEYOND_M: Final = 150.0
_FILL_M: Final = 40.0  # on long sides, points between the vertices, so that straights weigh as much as curves
_BLOCK: Final = 500
_PROJECTIONS: Final = 3  # each a Newton step; the first guess is metres off
_OUTLIER_M: Final = 3.0
_FIXED: Final = 1e-9
_RESIDUAL_MAX_M: Final = 500.0
CURVES_AT_ONCE: Final = 40  # with more, the far end swings too widely while the near one is fitted
LOST_M: Final = 40.0  # no vertex is so wrong; a fit that is has found another minimum
# Curves of a block, and those of them fitted again in the next, which sees what comes after; fewer where it is astray.
_BLOCKS: Final = ((14, 5), (9, 3), (6, 2), (4, 1))
_ASTRAY_M: Final = 100.0
_HOPELESS_M: Final = 500.0


@dataclass(frozen=True, slots=True)
class AxisFit:
    """A fitted axis. Kilometrage 0 is the foot of the polyline's first vertex; angles in rad, lengths in m.

    `rms_m` and `max_m` are lateral distances from the axis to the polyline, sampled every 10 m along it.
    """

    east_m: float
    north_m: float
    bearing_rad: float
    curves: tuple[Curve, ...]
    length_m: float
    rms_m: float
    max_m: float


@dataclass(frozen=True, slots=True, eq=False)
class SampledAxis:
    """An integrated axis at close kilometrages, to project points on."""

    along_m: Floats
    east_m: Floats
    north_m: Floats
    heading_rad: Floats

    def project(self, points: Floats, guess_m: Floats) -> tuple[Floats, Floats]:
        """Kilometrage and lateral distance (positive right), m, of points (n, 2), searched from a guess."""
        at_m = guess_m.copy()
        for _ in range(_PROJECTIONS):
            along, _ = self._local(points, at_m)
            at_m = np.clip(at_m + np.clip(along, -50.0, 50.0), self.along_m[0], self.along_m[-1])
        return at_m, self._local(points, at_m)[1]

    def nearest(self, points: Floats) -> tuple[Floats, Floats]:
        """As `project`, with the nearest sample as guess."""
        guess_m = np.empty(len(points))
        for low in range(0, len(points), _BLOCK):  # the distances of all at once would not fit a memory
            block = points[low : low + _BLOCK]
            east = block[:, :1] - self.east_m[None, :]
            north = block[:, 1:2] - self.north_m[None, :]
            guess_m[low : low + _BLOCK] = self.along_m[np.argmin(east**2 + north**2, axis=1)]
        return self.project(points, guess_m)

    def _local(self, points: Floats, at_m: Floats) -> tuple[Floats, Floats]:
        east = points[:, 0] - np.interp(at_m, self.along_m, self.east_m)
        north = points[:, 1] - np.interp(at_m, self.along_m, self.north_m)
        heading = np.interp(at_m, self.along_m, self.heading_rad)
        sin, cos = np.sin(heading), np.cos(heading)
        return east * sin + north * cos, east * cos - north * sin


def interpolated(at_m: Floats, along_m: Floats, points: Floats) -> Floats:
    """Points (n, 2) at these chainages of a polyline with vertices at `along_m`."""
    return np.column_stack([np.interp(at_m, along_m, points[:, 0]), np.interp(at_m, along_m, points[:, 1])])


def chainage(points: Floats) -> Floats:
    """Distance along a polyline (n, 2) to each vertex, m."""
    return np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))


def sample_axis(east_m: float, north_m: float, table: CurvatureTable, to_m: float) -> SampledAxis:
    """Integrate a curvature table from its first break to `to_m`, starting at a point of the plane."""
    along = np.append(np.arange(float(table.break_m[0]), to_m, _AXIS_STEP_M), to_m)
    east, north = integrate_plane(table, along)
    return SampledAxis(along, east_m + east, north_m + north, table.heading_at(along))


def fit_curves(vertices: Floats) -> AxisFit:
    """Fit an axis to the vertices of a polyline, (n, 2) east and north in m, n >= 3."""
    problem = _Problem(vertices)
    if problem.count <= CURVES_AT_ONCE:
        unknowns, radii = problem.fitted()
        whole = _result(problem, unknowns, radii)
        if whole.max_m <= LOST_M or problem.count <= _BLOCKS[-1][0]:
            return whole
    return _fit_blocks(vertices)


def snap_radius(radius_m: float, turn_rad: float = 0.0) -> float:
    """Round a fitted radius: steps of 10 m below 1000 m, 50 m below 2000 m, then 100 m; at least 200 m.

    A curve that turns far shows its radius well enough to be sharper, at least 100 m.
    """
    step_m = 10.0 if radius_m < 1000.0 else 50.0 if radius_m < 2000.0 else 100.0
    least_m = RADIUS_MIN_M if turn_rad < FAR_TURN_RAD else RADIUS_MIN_FAR_M
    return max(least_m, round(radius_m / step_m) * step_m)


def find_curves(vertices: Floats) -> Floats:
    """Curves of a polyline as rows (from, to, deflection), m and rad, where the smoothed heading turns."""
    along = chainage(vertices)
    sides = np.diff(vertices, axis=0)
    heading = np.unwrap(np.arctan2(sides[:, 0], sides[:, 1]))
    grid = np.arange(0.0, along[-1], _GRID_M)
    side = np.clip(np.searchsorted(along, grid, side="right") - 1, 0, len(sides) - 1)
    turn = np.asarray(gaussian_filter1d(heading[side], SMOOTHING_M / _GRID_M, order=1)) / _GRID_M
    sign = np.where(np.abs(turn) > 1.0 / STRAIGHT_RADIUS_M, np.sign(turn), 0.0)
    edges = np.flatnonzero(np.diff(sign)) + 1
    rows: list[tuple[float, float, float]] = []
    for first, last in zip(np.append(0, edges), np.append(edges, len(sign)), strict=True):
        deflection = float(turn[first:last].sum()) * _GRID_M
        if sign[first] != 0.0 and abs(deflection) > DEFLECTION_MIN_RAD:
            rows.append((float(grid[first]), float(grid[last - 1]) + _GRID_M, deflection))
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _transition(length_m: Floats) -> Floats:
    return np.minimum(TRANSITION_MAX_M, length_m / 3.0)


@dataclass(frozen=True, slots=True)
class _Begin:
    """Where an axis goes on: place (m), bearing (rad), and its kilometrage (m) there."""

    east_m: float
    north_m: float
    bearing_rad: float
    along_m: float


def _fit_blocks(vertices: Floats) -> AxisFit:
    """Fit a long track block by block; the last curves of each are fitted again with the next."""
    along, found = chainage(vertices), find_curves(vertices)
    curves: list[Curve] = []
    first: tuple[float, float, float] | None = None
    begin: _Begin | None = None
    cut_m, low = 0.0, 0
    while first is None or low < len(found):
        block = _best_block(vertices, along, found, low, cut_m, begin)
        if first is None:
            first = (float(block.axis.east_m[0]), float(block.axis.north_m[0]), float(block.unknowns[1]))
        kept = block.problem.curves(block.unknowns, block.radii)[: block.kept]
        zero_m = 0.0 if begin is None else begin.along_m
        curves += (replace(c, from_m=c.from_m + zero_m, to_m=c.to_m + zero_m) for c in kept)
        low += len(kept)
        if low >= len(found) or block.max_m > _HOPELESS_M:
            break
        begin, cut_m = _going_on(block.problem, block.axis, kept[-1].to_m, zero_m, cut_m)
        while low < len(found) and found[low, :2].mean() < cut_m:  # the curve before has taken it in
            low += 1
    return _whole(vertices, along, first, tuple(curves))


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    """A fitted block: of its curves the first `kept` stay; `max_m` is the worst lateral distance up to there."""

    problem: _Problem
    unknowns: Floats
    radii: Floats | None
    axis: SampledAxis
    kept: int
    max_m: float


def _best_block(
    vertices: Floats, along: Floats, found: Floats, low: int, cut_m: float, begin: _Begin | None
) -> _Block:
    """The first block that lies on the polyline, from many curves to few; else the one that is least off."""
    blocks: list[_Block] = []
    for count, ahead in _BLOCKS:
        high = min(low + count, len(found))
        last = high == len(found)
        end_m = along[-1] if last else (found[high - 1, 1] + found[high, 0]) / 2.0
        part = _part(vertices, along, cut_m, end_m)
        problem = _Problem(part, found[low:high] - (cut_m, cut_m, 0.0), begin)
        unknowns, radii = problem.fitted()
        axis = problem.axis(unknowns, radii)
        kept = high - low if last else count - ahead
        at_m, lateral = axis.nearest(problem.dense)
        kept_m = axis.along_m[-1] if last else problem.curves(unknowns, radii)[kept - 1].to_m
        max_m = float(np.abs(lateral[at_m <= kept_m]).max(initial=0.0))
        blocks.append(_Block(problem, unknowns, radii, axis, kept, max_m))
        if max_m <= _ASTRAY_M:
            break
    return min(blocks, key=lambda block: block.max_m)


def _part(vertices: Floats, along: Floats, from_m: float, to_m: float) -> Floats:
    """A polyline from one chainage to another."""
    inside = vertices[(along > from_m) & (along < to_m)]
    ends = interpolated(np.array([from_m, to_m]), along, vertices)
    return np.vstack((ends[:1], inside, ends[1:]))


def _going_on(
    problem: _Problem, axis: SampledAxis, at_m: float, zero_m: float, cut_m: float
) -> tuple[_Begin, float]:
    """Place and bearing of the axis at `at_m`, and the polyline's chainage there."""
    east, north, bearing = (
        float(np.interp(at_m, axis.along_m, values))
        for values in (axis.east_m, axis.north_m, axis.heading_rad)
    )
    near = int(np.argmin(np.hypot(*(problem.dense - (east, north)).T)))
    return _Begin(east, north, bearing, zero_m + at_m), cut_m + float(problem.dense_m[near])


def _whole(
    vertices: Floats, along: Floats, first: tuple[float, float, float], curves: tuple[Curve, ...]
) -> AxisFit:
    """The blocks as one axis, with its distances from the whole polyline."""
    east_m, north_m, bearing_rad = first
    to_m = max(float(along[-1]), *(c.to_m for c in curves)) + _AXIS_BEYOND_M
    axis = sample_axis(east_m, north_m, curvature_table(0.0, to_m, bearing_rad, curves), to_m)
    dense = interpolated(np.arange(0.0, along[-1], 10.0), along, vertices)
    _, lateral = axis.nearest(dense)
    return _fitted(first, curves, float(axis.nearest(vertices[-1:])[0][0]), lateral)


class _Problem:
    """Unknowns: lateral start, start bearing, then for n curves the gaps, the lengths and the deflections.

    With `radii` given, a length follows from the deflection: length = radius * |deflection| + transition.
    """

    def __init__(self, vertices: Floats, found: Floats | None = None, begin: _Begin | None = None) -> None:
        self.begin = begin
        self.origin = vertices[0] if begin is None else np.array((begin.east_m, begin.north_m))
        along = chainage(vertices)
        self.length_m = float(along[-1])
        self.points, self.along_m = _fill(vertices, along)
        self.dense_m = np.arange(0.0, self.length_m, 10.0)
        self.dense = interpolated(self.dense_m, along, vertices)
        found = find_curves(vertices) if found is None else found
        self.count = len(found)
        gaps = np.diff(np.concatenate(([0.0], found[:, :2].ravel())))[::2]
        side = vertices[1] - vertices[0]
        lengths = np.maximum(found[:, 1] - found[:, 0], 55.0)
        bearing = float(np.arctan2(side[0], side[1])) if begin is None else begin.bearing_rad
        self.start = np.concatenate(([0.0, bearing], np.maximum(gaps, 0.5), lengths, found[:, 2]))

    def fitted(self) -> tuple[Floats, Floats | None]:
        """Unknowns and rounded radii: solved with free radii, then with these rounded."""
        if self.count == 0:
            return self.start, None
        free = self.solve(self.start, None)
        _, lengths, deflections = self.split(free)
        arc_m = np.maximum(lengths - _transition(lengths), CURVE_LENGTH_MIN_M - TRANSITION_MAX_M)
        turns = np.abs(deflections)
        radii = np.array(
            [snap_radius(r, turn) for r, turn in zip((arc_m / turns).tolist(), turns.tolist(), strict=True)]
        )
        return self.solve(free, radii), radii

    def split(self, unknowns: Floats) -> tuple[Floats, Floats, Floats]:
        """Gaps, lengths and deflections of the curves."""
        gaps, lengths, deflections = unknowns[2:].reshape(3, self.count)
        return gaps, lengths, deflections

    def curves(self, unknowns: Floats, radii: Floats | None) -> tuple[Curve, ...]:
        """The curves that the unknowns stand for, cant left at zero."""
        gaps, lengths, deflections = self.split(unknowns)
        if radii is None:
            transitions = _transition(lengths)
            signed = (lengths - transitions) / deflections
        else:
            arc_m = radii * np.abs(deflections)
            transitions = np.minimum(TRANSITION_MAX_M, arc_m / 2.0)
            lengths = arc_m + transitions
            signed = np.copysign(radii, deflections)
        ends = np.cumsum(gaps + lengths)
        rows = zip(
            (ends - lengths).tolist(), ends.tolist(), signed.tolist(), transitions.tolist(), strict=True
        )
        return tuple(Curve(low, high, radius, transition, 0.0) for low, high, radius, transition in rows)

    def axis(self, unknowns: Floats, radii: Floats | None) -> SampledAxis:
        """The axis that the unknowns stand for."""
        offset_m, bearing = float(unknowns[0]), float(unknowns[1])
        to_m = self.length_m + _AXIS_BEYOND_M
        table = curvature_table(0.0, to_m, bearing, self.curves(unknowns, radii))
        east = float(self.origin[0]) + offset_m * np.cos(bearing)
        north = float(self.origin[1]) - offset_m * np.sin(bearing)
        return sample_axis(float(east), float(north), table, to_m)

    def residuals(self, unknowns: Floats, radii: Floats | None) -> Floats:
        """Lateral distances of the points, m, limited so that a wild trial step stays finite."""
        lateral = self.axis(unknowns, radii).project(self.points, self.along_m)[1]
        return np.clip(lateral, -_RESIDUAL_MAX_M, _RESIDUAL_MAX_M)

    def solve(self, start: Floats, radii: Floats | None) -> Floats:
        """Least squares from `start`; the radii are free or given."""
        gaps, lengths, deflections = self.split(start)
        sign = np.sign(deflections)
        flat, sharp = 0.002, 4.0  # a deflection keeps its sign, so that no radius passes through infinity
        lower = np.concatenate(([-20.0, start[1] - 1.0], 0.0 * gaps, 0.0 * lengths + 50.0))
        upper = np.concatenate(([20.0, start[1] + 1.0], gaps + 400.0, lengths + 600.0))
        low_turn, high_turn = np.where(sign > 0, flat, -sharp), np.where(sign > 0, sharp, -flat)
        if self.begin is not None:  # goes on from an axis already fitted
            lower[:2], upper[:2] = start[:2] - _FIXED, start[:2] + _FIXED
        scale = np.concatenate(([1.0, 0.001], 0.0 * gaps + 10.0, 0.0 * lengths + 10.0, 0.0 * gaps + 0.01))

        def residuals(unknowns: Floats) -> Floats:
            return self.residuals(unknowns, radii)

        low, high = np.concatenate((lower, low_turn)), np.concatenate((upper, high_turn))
        solution = least_squares(
            residuals,
            np.clip(start, low, high),  # points in disorder may begin beyond
            bounds=(low, high),
            loss="soft_l1",
            f_scale=_OUTLIER_M,
            x_scale=scale,
            ftol=1e-6,
            xtol=1e-10,
            tr_solver="lsmr",  # no dense factorisation, whose last digits depend on the number of threads
            max_nfev=80,
        )
        return np.asarray(solution.x, dtype=np.float64)


def _fill(vertices: Floats, along: Floats) -> tuple[Floats, Floats]:
    """Vertices, and points every `_FILL_M` on sides longer than twice that; with their chainage."""
    marks = [along[-1:]]
    for low, high in pairwise(along.tolist()):
        parts = int((high - low) // _FILL_M) if high - low > 2 * _FILL_M else 1
        marks.append(low + (high - low) * np.arange(parts) / parts)
    at_m = np.sort(np.concatenate(marks))
    return interpolated(at_m, along, vertices), at_m


def _result(problem: _Problem, unknowns: Floats, radii: Floats | None) -> AxisFit:
    axis = problem.axis(unknowns, radii)
    along, lateral = axis.project(problem.dense, problem.dense_m)
    end_m = float(axis.project(problem.points[-1:], along[-1:])[0][0])
    first = float(axis.east_m[0]), float(axis.north_m[0]), float(unknowns[1])
    return _fitted(first, problem.curves(unknowns, radii), end_m, lateral)


def _fitted(
    first: tuple[float, float, float], curves: tuple[Curve, ...], length_m: float, lateral_m: Floats
) -> AxisFit:
    """An axis from place and bearing of its begin, with its lateral distances from the polyline."""
    rms_m = float(np.sqrt(np.mean(lateral_m**2)))
    return AxisFit(*first, curves, length_m, rms_m=rms_m, max_m=float(np.abs(lateral_m).max()))
