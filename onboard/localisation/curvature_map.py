"""The map of curvature (マップ曲率データ): what tracks bend like, metre by metre, and how it is laid along a path.

A map holds, for each piece that it knows, the mean curvature of each metre by rising kilometrage, positive to the right
going DOWN, raw: laid along a path it goes through what a run's measurement goes through, the mean over the bogies of
the leading car and the filter, in the direction of travel, so that their delays cancel (Harada, Maki, Kazato and
Ishiguri, sections 3.1 and 3.3). It may leave pieces out: over them, and as far behind them as the filter remembers,
the laid map is nan and nothing is compared.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.model import Line
from network.path import Path
from network.profile import bearing_of_piece_rad
from onboard.localisation.spatial_filter import pass_all

Floats = NDArray[np.float64]

SIMPSON: Final = ((0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0))  # shares of the bogie base, and weights


@dataclass(frozen=True, slots=True, eq=False)
class PieceCurvature:
    """Mean curvature (1/m) of each metre of a piece from kilometrage `from_m`; the last may be shorter."""

    from_m: float
    to_m: float
    curvature_per_m: Floats

    def breaks_m(self) -> Floats:
        """Kilometrages (m) between which the samples are means."""
        return np.append(self.from_m + np.arange(self.curvature_per_m.size, dtype=np.float64), self.to_m)

    def turned_rad(self, kilometrage_m: Floats) -> Floats:
        """By how much the piece has turned to the right since its low end, at kilometrages (m) on it."""
        breaks_m = self.breaks_m()
        turned = np.concatenate([[0.0], np.cumsum(self.curvature_per_m * np.diff(breaks_m))])
        return np.asarray(np.interp(kilometrage_m, breaks_m, turned), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class CurvatureMap:
    """What is known of a line's curvature, by piece. `error_m`: how far off its places may be."""

    line_id: str
    pieces: Mapping[str, PieceCurvature]
    error_m: float = 0.0


@dataclass(frozen=True, slots=True)
class Mounting:
    """How the gyro's car stands on the rails: its first bogie behind the front, and from there to the second, m."""

    lead_bogie_m: float
    bogie_base_m: float


def samples_of(length_m: float) -> int:
    """How many samples a piece of that length has."""
    return max(math.ceil(length_m - 1e-6), 1)


def design_map(line: Line) -> CurvatureMap:
    """The map that a line's own alignment and points make (線路管理台帳)."""
    pieces: dict[str, PieceCurvature] = {}
    for piece in line.pieces.values():
        count = samples_of(piece.length_m)
        breaks_m = np.append(piece.from_m + np.arange(count, dtype=np.float64), piece.to_m)
        bearing_rad = bearing_of_piece_rad(line, piece, breaks_m)
        pieces[piece.id] = PieceCurvature(
            piece.from_m, piece.to_m, np.diff(bearing_rad) / np.diff(breaks_m)
        )
    return CurvatureMap(line.id, pieces)


def headings_rad(of: CurvatureMap, path: Path) -> Floats:
    """Where the map has the track point at every metre of a path, against its beginning; nan where it has none."""
    count = math.ceil(path.length_m) + 1
    at_m = np.minimum(np.arange(count, dtype=np.float64), path.length_m)
    heading_rad = np.full(count, np.nan)
    turned_rad = 0.0
    for step in path.steps:
        last = step is path.steps[-1]
        here = slice(math.ceil(step.start_m), count if last else math.ceil(step.end_m))
        known = of.pieces.get(step.piece_id)
        if known is None:
            continue
        kilometrage_m = step.entry_m + step.direction * (at_m[here] - step.start_m)
        ends_rad = known.turned_rad(np.array([step.entry_m, step.kilometrage_m(step.end_m)]))
        heading_rad[here] = turned_rad + known.turned_rad(kilometrage_m) - ends_rad[0]
        turned_rad += float(ends_rad[1] - ends_rad[0])
    return heading_rad


def over_bogies(heading_rad: Floats, mounting: Mounting) -> Floats:
    """What the leading car points like with its front at every metre: the mean of the track between its bogies."""
    at_m = np.arange(heading_rad.size, dtype=np.float64)
    mean = np.zeros_like(heading_rad)
    for share, weight in SIMPSON:
        from_front_m = mounting.lead_bogie_m + share * mounting.bogie_base_m
        mean += weight * np.interp(np.maximum(at_m - from_front_m, 0.0), at_m, heading_rad)
    return mean


def laid_per_m(of: CurvatureMap, path: Path, mounting: Mounting, numbers: Floats | None) -> Floats:
    """The map along a path as a run is compared with it: row i is what the metre up to i shows, filtered.

    `numbers`: the filter's (`spatial_filter.sections`); None: none. nan where the map has nothing, or has just begun.
    """
    body_rad = over_bogies(headings_rad(of, path), mounting)
    curvature_per_m = np.diff(body_rad, prepend=np.nan)
    return curvature_per_m if numbers is None else pass_all(numbers, curvature_per_m)
