"""Where the track lies: kilometrage to plane coordinates, elevation and curvature.

A curve is a clothoid whose curvature rises linearly over `transition_m`, a circular arc and the same clothoid
back (緩和曲線 of constant rate); elsewhere the track is straight. The heading is then a closed form,

    bearing(s) = bearing_0 + integral of curvature, positive to the right,

and the position its integral (sin, cos), taken by Simpson's rule in steps of at most 1 m: at the sharpest
radius of a railway the error stays below a micrometre a kilometre.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.model import Alignment, Curve, Gradient

Floats = NDArray[np.float64]

STEP_M: Final = 1.0
_OUTSIDE_M: Final = 1e-6  # rounding of a kilometrage that is meant to be the end of the alignment


@dataclass(frozen=True, slots=True, eq=False)
class CurvatureTable:
    """Piecewise linear curvature: value and heading (rad, clockwise) at each break, both exact in between."""

    break_m: Floats
    curvature_per_m: Floats
    heading_rad: Floats

    def curvature_at(self, kilometrage_m: Floats) -> Floats:
        """Curvature, 1/m, positive to the right going DOWN; zero outside the breaks."""
        return np.interp(kilometrage_m, self.break_m, self.curvature_per_m, left=0.0, right=0.0)

    def heading_at(self, kilometrage_m: Floats) -> Floats:
        """Bearing of DOWN, rad clockwise from north; the track is straight outside the breaks."""
        at_m = np.clip(kilometrage_m, self.break_m[0], self.break_m[-1])
        index = np.clip(np.searchsorted(self.break_m, at_m, side="right") - 1, 0, len(self.break_m) - 2)
        into_m = at_m - self.break_m[index]
        span_m = self.break_m[index + 1] - self.break_m[index]
        rise = self.curvature_per_m[index + 1] - self.curvature_per_m[index]
        slope = np.divide(rise, span_m, out=np.zeros_like(span_m), where=span_m > 0.0)
        heading: Floats = (
            self.heading_rad[index] + self.curvature_per_m[index] * into_m + 0.5 * slope * into_m**2
        )
        return heading


def curvature_table(
    from_m: float, to_m: float, bearing_rad: float, curves: Sequence[Curve]
) -> CurvatureTable:
    """Table of curves that are sorted and do not overlap; a transition takes at most half of its curve."""
    breaks = [from_m]
    values = [0.0]
    for curve in curves:
        transition_m = min(curve.transition_m, 0.5 * (curve.to_m - curve.from_m))
        breaks += [curve.from_m, curve.from_m + transition_m, curve.to_m - transition_m, curve.to_m]
        values += [0.0, 1.0 / curve.radius_m, 1.0 / curve.radius_m, 0.0]
    break_m = np.array([*breaks, max(to_m, breaks[-1])])
    curvature = np.array([*values, 0.0])
    turned = np.cumsum(np.diff(break_m) * (curvature[1:] + curvature[:-1]) * 0.5)
    return CurvatureTable(break_m, curvature, bearing_rad + np.concatenate(([0.0], turned)))


def integrate_plane(table: CurvatureTable, kilometrage_m: Floats) -> tuple[Floats, Floats]:
    """East and north, m, relative to the first of ascending kilometrages, a Simpson step between each two."""
    middle_m = 0.5 * (kilometrage_m[1:] + kilometrage_m[:-1])
    step_m = np.diff(kilometrage_m) / 6.0
    node, half = table.heading_at(kilometrage_m), table.heading_at(middle_m)
    east, north = (
        np.concatenate(([0.0], np.cumsum(step_m * (f(node[1:]) + 4.0 * f(half) + f(node[:-1])))))
        for f in (np.sin, np.cos)
    )
    return east, north


@dataclass(frozen=True, slots=True, eq=False)
class _Axis:
    """The integrated axis: coordinates of nodes at most `STEP_M` apart, and the breaks of the elevation."""

    table: CurvatureTable
    node_m: Floats
    east_m: Floats
    north_m: Floats
    elevation_break_m: Floats
    elevation_m: Floats


@lru_cache(maxsize=32)
def _axis(alignment: Alignment) -> _Axis:
    table = curvature_table(
        alignment.from_m, alignment.to_m, float(np.radians(alignment.bearing_deg)), alignment.curves
    )
    count = max(2, int(np.ceil((alignment.to_m - alignment.from_m) / STEP_M)) + 1)
    inner = table.break_m[(table.break_m > alignment.from_m) & (table.break_m < alignment.to_m)]
    # the breaks are nodes too, so that no Simpson step spans a kink of the curvature
    node_m = np.union1d(np.linspace(alignment.from_m, alignment.to_m, count), inner)
    east, north = integrate_plane(table, node_m)
    breaks, rises = _elevation(alignment.from_m, alignment.gradients)
    return _Axis(
        table, node_m, alignment.x_m + east, alignment.y_m + north, breaks, alignment.elevation_m + rises
    )


def _elevation(from_m: float, gradients: Sequence[Gradient]) -> tuple[Floats, Floats]:
    """Breaks of the profile and the rise since `from_m`; level where no gradient is given."""
    breaks, rises = [from_m], [0.0]
    for gradient in gradients:
        breaks += [gradient.from_m, gradient.to_m]
        rises += [rises[-1], rises[-1] + (gradient.to_m - gradient.from_m) * gradient.permille / 1000.0]
    return np.array(breaks), np.array(rises)


def curvature_per_m(alignment: Alignment, kilometrage_m: float) -> float:
    """Curvature of the axis at a kilometrage (m), 1/m, positive to the right going DOWN."""
    return float(_axis(alignment).table.curvature_at(np.array([kilometrage_m]))[0])


def bearing_rad(alignment: Alignment, kilometrage_m: Floats) -> Floats:
    """Bearing of DOWN at kilometrages (m), rad clockwise from north, not reduced to one turn."""
    return _axis(alignment).table.heading_at(np.asarray(kilometrage_m, dtype=np.float64))


def positions(alignment: Alignment, kilometrage_m: Floats, offset_m: float = 0.0) -> Floats:
    """Points of a track, shape (n, 3): east, north and elevation in m.

    `kilometrage_m` holds n kilometrages of the axis (m) in any order; `offset_m` lies to the right of DOWN,
    in the plane. Raises ValueError for a kilometrage outside the alignment.
    """
    at_m = np.atleast_1d(np.asarray(kilometrage_m, dtype=np.float64))
    if at_m.size and (at_m.min() < alignment.from_m - _OUTSIDE_M or at_m.max() > alignment.to_m + _OUTSIDE_M):
        msg = f"{alignment.id}: kilometrage outside {alignment.from_m} m to {alignment.to_m} m"
        raise ValueError(msg)
    axis = _axis(alignment)
    at_m = np.clip(at_m, alignment.from_m, alignment.to_m)
    index = np.clip(np.searchsorted(axis.node_m, at_m, side="right") - 1, 0, len(axis.node_m) - 1)
    base_m = axis.node_m[index]
    heading = axis.table.heading_at(at_m)
    middle, start = axis.table.heading_at(0.5 * (at_m + base_m)), axis.table.heading_at(base_m)
    step_m = (at_m - base_m) / 6.0
    east = axis.east_m[index] + step_m * (np.sin(start) + 4.0 * np.sin(middle) + np.sin(heading))
    north = axis.north_m[index] + step_m * (np.cos(start) + 4.0 * np.cos(middle) + np.cos(heading))
    elevation = np.interp(at_m, axis.elevation_break_m, axis.elevation_m)
    return np.column_stack((east + offset_m * np.cos(heading), north - offset_m * np.sin(heading), elevation))
