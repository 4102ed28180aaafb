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

DESIGN: Final = "design"  # the map that the line's own alignment makes
SIMPSON: Final = (
    (0.0, 1.0 / 6.0),
    (0.5, 4.0 / 6.0),
    (1.0, 1.0 / 6.0),
)  # shares of the bogie base, and weights


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
    """What is known of a line's curvature, by piece. `error_m`: how far off its places may be; `made`: from what."""

    line_id: str
    pieces: Mapping[str, PieceCurvature]
    error_m: float = 0.0
    made: str = DESIGN


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
        pieces[piece.id] = PieceCurvature(piece.from_m, piece.to_m, np.diff(bearing_rad) / np.diff(breaks_m))
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


def unbent_rad(body_rad: Floats, mounting: Mounting) -> Floats:
    """Where the track points, from where a car that ran over it did at every metre of its front: `over_bogies` undone.

    The mean over the bogies takes no wave away wholly (at least a third is left), so it can be; beyond the ends the
    track is taken to go on as it does there.
    """
    reach = math.ceil(2.0 * (mounting.lead_bogie_m + mounting.bogie_base_m))
    first, last = body_rad[0], body_rad[-1]
    slope = (last - first) / max(body_rad.size - 1, 1)
    straight = first + slope * np.arange(-reach, body_rad.size + reach)
    apart = np.concatenate([np.full(reach, first), body_rad, np.full(reach, last)]) - straight
    apart[:reach] = apart[body_rad.size + reach :] = (
        0.0  # before and behind it is as straight as it is on average
    )
    waves = 2.0 * np.pi * np.fft.rfftfreq(apart.size)
    body = np.zeros(waves.size, dtype=np.complex128)
    for share, weight in SIMPSON:
        body += weight * np.exp(-1j * waves * (mounting.lead_bogie_m + share * mounting.bogie_base_m))
    track = np.fft.irfft(np.fft.rfft(apart) / body, apart.size)
    late_m = mounting.lead_bogie_m + 0.5 * mounting.bogie_base_m
    return np.asarray((track + straight + slope * late_m)[reach:-reach], dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class FirstRunRecord:
    """What a run showed, step by step: the wheels' count (m) and the body's heading (rad, without bias) at its ends.

    `anchors`: (wheels' count, path coordinate), m, in order: where the front was known to be.
    """

    odometer_m: Floats
    heading_rad: Floats
    anchors: tuple[tuple[float, float], ...]


def measured_map(
    record: FirstRunRecord, path: Path, line: Line, mounting: Mounting, error_m: float, made: str
) -> CurvatureMap:
    """The map that a first run makes (section 3.1): its pieces are those of the path that the run has been on.

    Between anchors the way is as the wheels share it out. What the run has not passed of a piece (where it began and
    ended) is as the line's own alignment has it. ValueError with fewer than two anchors.
    """
    if len(record.anchors) < 2:
        raise ValueError("a map needs two places where the front was known to be")
    counted_m, known_m = (np.array(column) for column in zip(*record.anchors, strict=True))
    front_m = np.interp(record.odometer_m, counted_m, known_m)
    whole_m = np.arange(math.ceil(known_m[0]), math.floor(known_m[-1]) + 1, dtype=np.float64)
    body_rad = np.interp(whole_m, front_m, record.heading_rad)
    track_rad = unbent_rad(body_rad, mounting)
    reach = mounting.lead_bogie_m + mounting.bogie_base_m
    first_m, last_m = whole_m[0] + reach, whole_m[-1] - 2.0 * reach
    design = design_map(line)
    pieces: dict[str, PieceCurvature] = {}
    for step in path.steps:
        if step.end_m <= first_m or step.start_m >= last_m:
            continue
        own = design.pieces[step.piece_id]
        breaks_m = own.breaks_m()
        at_m = np.array([step.to_path_m(break_m) for break_m in breaks_m])
        heading_rad = np.interp(at_m, whole_m, track_rad)
        seen = (np.minimum(at_m[:-1], at_m[1:]) >= first_m) & (np.maximum(at_m[:-1], at_m[1:]) <= last_m)
        curvature_per_m = np.where(seen, np.diff(heading_rad) / np.diff(breaks_m), own.curvature_per_m)
        pieces[step.piece_id] = PieceCurvature(own.from_m, own.to_m, curvature_per_m)
    return CurvatureMap(line.id, pieces, error_m, made)
