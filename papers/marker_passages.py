"""Trains that pass markers with a LiDAR: scanned points, and what the unit makes of them cycle by cycle.

One set of parameters for every passage: the scanner's, its mount's and the markers' (`simulation.sensors.lidar_scan`),
and those of table 2 (`onboard.localisation.lidar_points`). The points are the physics; what differs between columns of
a reproduction is only how they are made use of.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.localisation.lidar_points import (
    CYCLE_S,
    FARTHEST_M,
    KEPT_S,
    NEAREST_M,
    SPEED,
    PointUse,
    detect,
    passage,
    read_window_m,
)
from onboard.localisation.marker_patterns import PATTERNS, ROW_M, ROWS
from papers.reproduction import Parameter
from radio.chance import generator
from simulation.sensors.lidar_scan import (
    HORIZON,
    SIGN_SHEETING,
    TRAM_MOUNT,
    MarkerMotion,
    ScanPoints,
    coverage,
    marker_places,
    scan,
    scan_row,
)

Floats = NDArray[np.float64]

KMH: Final = 3.6
BEFORE_M: Final = 2.0  # further off than speeds are detected, where a passage begins
NEAREST_ROW_M: Final = 1.5  # where it ends at the latest


PAPER_USE: Final = PointUse()


@dataclass(frozen=True, slots=True)
class PointsUsed:
    """How points are made use of; `stamp_s`: a point's time is known to the end of so long a frame, 0: its own."""

    used: PointUse = PAPER_USE
    stamp_s: float = CYCLE_S

    def stamped_times(self, times_s: Floats) -> Floats:
        """Times as the unit knows them."""
        if self.stamp_s == 0.0:
            return times_s
        return np.array(np.ceil(times_s / self.stamp_s - 1e-9) * self.stamp_s, dtype=np.float64)


# by name, for the rows that they take away
USES: Final[Mapping[str, PointsUsed]] = {
    "as the paper": PointsUsed(),
    "not corrected": PointsUsed(PointUse(corrected=False)),
    "not smoothed": PointsUsed(PointUse(smoothed=False)),
    "points kept for 0.5 s": PointsUsed(PointUse(kept_s=0.5)),
    "every point's own time": PointsUsed(stamp_s=0.0),
}


@dataclass(frozen=True)
class MarkerPassage:
    """One train over one group of markers; speeds at the beginning of the passage, m/s and m/s2."""

    points: ScanPoints
    motion: MarkerMotion
    pattern: int
    spacing_m: float
    cycles: int

    @cached_property
    def times_s(self) -> Floats:
        """The end of each cycle."""
        return np.array((np.arange(self.cycles) + 1) * CYCLE_S, dtype=np.float64)

    @property
    def speeds_mps(self) -> Floats:
        """The train's at the end of each cycle."""
        return self.motion.speed_mps + self.motion.acceleration_mps2 * self.times_s

    def readings_by(self, use: PointsUsed) -> PassageReadings:
        """What the unit makes of it."""
        points, own, cycles = self.points, np.zeros(1, SPEED).view(np.recarray)[0], np.zeros((self.cycles, 5))
        used = use.used._replace(spacing_m=self.spacing_m)
        passage(use.stamped_times(points.time_s), points.x_m, points.y_m, own, used, cycles)
        return PassageReadings(
            cycles[:, 0],
            cycles[:, 2] if used.smoothed else cycles[:, 1],
            self.speeds_mps,
            self._numbers(cycles),
        )

    def seen_perfectly(self) -> PassageReadings:
        """The same with a sensor that has the true distance of the markers' middle in every cycle; it reads nothing."""
        run_m = self.motion.speed_mps * self.times_s + 0.5 * self.motion.acceleration_mps2 * self.times_s**2
        middle_m = self.motion.from_m + 0.5 * (ROWS - 1) * self.spacing_m - run_m
        mean_m: Floats = np.where((middle_m >= NEAREST_M) & (middle_m <= FARTHEST_M), middle_m, -1.0)
        own, speeds_mps = np.zeros(1, SPEED).view(np.recarray)[0], np.zeros(self.cycles)
        for cycle, away_m in enumerate(mean_m):
            detect(own, away_m)
            speeds_mps[cycle] = own.speed_mps
        return PassageReadings(mean_m, speeds_mps, self.speeds_mps, Readings(0, 0, 0))

    def _numbers(self, cycles: Floats) -> Readings:
        numbers = cycles[cycles[:, 3] >= 0.0, 3]
        right = int(np.count_nonzero(numbers == self.pattern))
        return Readings(numbers.size, right, int(np.count_nonzero(numbers > 0.0)) - right)


@dataclass(frozen=True, slots=True)
class Readings:
    """Of a passage: how often its pattern was looked for, recognised rightly and recognised wrongly."""

    looked: int
    right: int
    wrong: int

    @property
    def recognised(self) -> bool:
        """Whether the passage gives its pattern: more than half of its readings do."""
        return 2 * self.right > self.looked


@dataclass(frozen=True, slots=True, eq=False)
class PassageReadings:
    """Cycle by cycle: mean distance (m; -1: none), the unit's speed and the train's (m/s); and the readings."""

    mean_m: Floats
    speed_mps: Floats
    true_mps: Floats
    readings: Readings


def pass_markers(
    name: str,
    number: int,
    seed: int,
    far_mps: float,
    acceleration_mps2: float = 0.0,
    spacing_m: float = ROW_M,
    far_m: float = FARTHEST_M,
) -> MarkerPassage:
    """A passage over pattern `number` in turn, at `far_mps` where the markers' middle is `far_m` away."""
    rng = generator(seed, "markers", name, str(number))
    half_m = 0.5 * (ROWS - 1) * spacing_m
    from_m = FARTHEST_M + BEFORE_M + far_mps * (KEPT_S + CYCLE_S * float(rng.random()))
    begin_mps = math.sqrt(far_mps * far_mps - 2.0 * acceleration_mps2 * (from_m - far_m))
    last_m = read_window_m(spacing_m) - far_mps * KEPT_S - 0.5
    run_m = from_m - max(last_m, half_m + NEAREST_ROW_M)
    motion = MarkerMotion(from_m - half_m, begin_mps, acceleration_mps2)
    end_mps = math.sqrt(begin_mps * begin_mps + 2.0 * acceleration_mps2 * run_m)
    duration_s = 2.0 * run_m / (begin_mps + end_mps)
    pattern = 1 + number % PATTERNS
    points = scan(scan_row(), marker_places(pattern, spacing_m), motion, duration_s, rng)
    return MarkerPassage(points, motion, pattern, spacing_m, int(duration_s / CYCLE_S))


def parameters() -> tuple[Parameter, ...]:
    """The one set, with origins."""
    manual = "Livox Horizon user manual v1.0, specifications"
    covers = round(coverage(HORIZON, 0.5, 1.1), 3)
    return (
        Parameter("field, horizontal and vertical", "81.7 x 25.1", "deg", manual),
        Parameter("points", HORIZON.points_per_s, "1/s", manual),
        Parameter("range noise (1 sigma at 20 m)", HORIZON.range_sigma_m, "m", manual),
        Parameter("angle noise (1 sigma)", HORIZON.angle_sigma_deg, "deg", f"{manual}: below it"),
        Parameter("divergence, horizontal and vertical", "0.03 x 0.28", "deg", manual),
        Parameter(
            "share of the field hit in 0.5 s", covers, "", "2.1: 0.98; cells of 5 mrad, as the maker counts"
        ),
        Parameter("beams", HORIZON.beams, "", "the driver's records of this model"),
        Parameter(
            "sweep there and back", round(HORIZON.sweep_hz, 2), "Hz", "assumed: about a prism of the Mid-40"
        ),
        Parameter(
            "nod", round(HORIZON.nod_hz, 2), "Hz", "assumed: with it the share after 0.5 s is that of 2.1"
        ),
        Parameter(
            "gap between beams",
            HORIZON.beam_gap_deg,
            "deg",
            "assumed: likewise; lines 0.3 deg apart in 0.1 s",
        ),
        Parameter("height, left of the middle", "1.870, 0.279", "m", "4.1"),
        Parameter("pitched down", TRAM_MOUNT.pitch_down_deg, "deg", "4.1"),
        Parameter("grid across and along", ROW_M, "m", "4.2"),
        Parameter("side of a marker", SIGN_SHEETING.side_m, "m", "assumed: the paper names no size"),
        Parameter(
            "face over the track",
            SIGN_SHEETING.lean_deg,
            "deg",
            "assumed: upright, light meets it within 21 deg",
        ),
        Parameter(
            "gain over white", round(SIGN_SHEETING.gain), "", "sheeting RA2 of EN 12899-1, 150 cd/lx/m2"
        ),
        Parameter(
            "least reading of a marker", 150, "of 255", "what white scatters; more returns to its source"
        ),
        Parameter(
            "patterns", f"{PATTERNS} of 8 markers on 4 x 4 cells", "", "assumed: figures 4, 7 and 8 are lost"
        ),
        Parameter("cycle", CYCLE_S, "s", "table 2"),
        Parameter("points kept", KEPT_S, "s", "table 2"),
        Parameter("speed detected from, to", "30, 5", "m", "table 2"),
        Parameter("pattern read from, to", "6, 5", "m", "table 2; of points that have been moved"),
        Parameter("means", "twice 25 samples", "", "4.3"),
        Parameter(
            "time of a point",
            "the end of its cycle of 0.02 s",
            "",
            "assumed: the driver hands over frames, whose points share a time; `every point's own time` beside it",
        ),
    )
