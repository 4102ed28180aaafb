"""The error model of a LiDAR in line runs, measured on its own scans: mean distances, and what is read of patterns.

Passages at constant speeds over every pattern in turn; the unit's own functions of `onboard.localisation.lidar_points`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from onboard.localisation.lidar_points import (
    CYCLE_S,
    KEPT_S,
    NEAREST_M,
    READ_FROM_M,
    places_now,
    window,
)
from onboard.localisation.marker_patterns import HALF_M, PATTERNS, ROW_M, recognised_pattern
from radio.chance import generator
from simulation.sensors.lidar_scan import MarkerMotion, ScanPoints, distance_m, marker_places, scan, scan_row
from simulation.sensors.line_scans import PLACES_M, SMEARS_M, Floats, Scans

FROM_M: Final = 34.0
TO_M: Final = 4.4
NEAR_SHARE: Final = 0.12  # of a place, within which a cycle counts as one at that place


@dataclass(slots=True)
class Sums:
    """What was found at one speed."""

    errors_m: list[list[float]] = field(default_factory=lambda: [[] for _ in PLACES_M])
    none: Floats = field(default_factory=lambda: np.zeros(len(PLACES_M)))
    cycles: Floats = field(default_factory=lambda: np.zeros(len(PLACES_M)))
    read: Floats = field(default_factory=lambda: np.zeros(len(SMEARS_M)))
    wrong: int = 0
    readings: int = 0
    rows_m: list[float] = field(default_factory=list[float])


def measure(speed_mps: float, passages: int, seed: int, least_readings: int = 0) -> Sums:
    """Passages at one speed, and more until there are so many readings."""
    sums, row, number = Sums(), scan_row(), 0
    while number < passages or sums.readings < least_readings:
        pattern = 1 + number % PATTERNS
        rng = generator(seed, "lidar model", f"{speed_mps:g}", str(number))
        motion = MarkerMotion(FROM_M + float(rng.uniform(0.0, speed_mps * KEPT_S)) - HALF_M, speed_mps, 0.0)
        duration_s = (motion.from_m + HALF_M - TO_M) / speed_mps
        _cycles(
            sums,
            scan(row, marker_places(pattern, ROW_M), motion, duration_s, rng),
            motion,
            duration_s,
            pattern,
        )
        number += 1
    return sums


def _cycles(sums: Sums, points: ScanPoints, motion: MarkerMotion, duration_s: float, pattern: int) -> None:
    first = end = 0
    for cycle in range(int(duration_s / CYCLE_S)):
        now_s = (cycle + 1) * CYCLE_S
        first, end = window(points.time_s, now_s, KEPT_S, first, end)
        if now_s < KEPT_S:
            continue
        middle_m = distance_m(motion, now_s) + HALF_M
        place = int(np.argmin([abs(middle_m / place_m - 1.0) for place_m in PLACES_M]))
        if abs(middle_m / PLACES_M[place] - 1.0) <= NEAR_SHARE:
            sums.cycles[place] += 1.0
            if end == first:
                sums.none[place] += 1.0
            else:
                ago_m = middle_m + 0.5 * KEPT_S * motion.speed_mps
                sums.errors_m[place].append(float(np.mean(points.x_m[first:end])) - ago_m)
        if NEAREST_M <= middle_m <= READ_FROM_M and end > first:
            _read(sums, points, (first, end), (now_s, motion.speed_mps, middle_m - HALF_M), pattern)


def _read(
    sums: Sums, points: ScanPoints, kept: tuple[int, int], now: tuple[float, float, float], pattern: int
) -> None:
    """What is read at each smear, to either side in turn; `now`: time, true speed, the first row's true distance."""
    first, end = kept
    sums.readings += 1
    for index, smear_m in enumerate(SMEARS_M):
        by_mps = smear_m / KEPT_S * (1.0 if sums.readings % 2 else -1.0)
        at_m = places_now(points.x_m, points.time_s, first, end, now[0], now[1] + by_mps)
        number, row_m = recognised_pattern(at_m, points.y_m[first:end], ROW_M)
        sums.read[index] += float(number == pattern)
        sums.wrong += int(number not in (0, pattern))
        if number == pattern and index == 0:
            sums.rows_m.append(row_m - now[2])


def fit_model(
    speeds_mps: tuple[float, ...], passages: int, seed: int, least_readings: int
) -> tuple[Scans, int]:
    """The figures of these speeds, and how many readings gave a wrong pattern."""
    found = [measure(speed_mps, passages, seed, least_readings) for speed_mps in speeds_mps]
    return (
        Scans(
            _figures([sums.none / np.maximum(sums.cycles, 1.0) for sums in found]),
            _figures([[np.mean(errors) for errors in sums.errors_m] for sums in found]),
            _figures([[np.std(errors, ddof=1) for errors in sums.errors_m] for sums in found]),
            _figures([np.minimum.accumulate(sums.read / sums.readings) for sums in found]),
            _figures([np.mean(sums.rows_m) for sums in found]),
            _figures([np.std(sums.rows_m, ddof=1) for sums in found]),
        ),
        sum(sums.wrong for sums in found),
    )


def _figures(rows: Sequence[object]) -> Floats:
    return np.array(rows, dtype=np.float64)
