"""The scan: where its points lie, when, how much of the field it covers, and what reads brighter than white."""

from dataclasses import replace

import numpy as np
import pytest

from onboard.localisation.marker_patterns import MARKERS, PATTERNS
from simulation.sensors.lidar_scan import (
    HORIZON,
    SIGN_SHEETING,
    SWAY_SIGMA_M,
    TRACK_READING,
    WHITE,
    MarkerMotion,
    Plate,
    ScanPoints,
    coverage,
    distance_m,
    marker_places,
    scan,
    scan_row,
)
from vehicle.compiled import INTERPRETED

pytestmark = pytest.mark.skipif(INTERPRETED, reason="it scans: interpreted, a passage takes minutes")


def points_of(
    motion: MarkerMotion, duration_s: float, seed: int = 1, least: float = WHITE, pattern: int = 1
) -> ScanPoints:
    rng = np.random.default_rng(seed)
    return scan(scan_row(least_reading=least), marker_places(pattern, 0.25), motion, duration_s, rng)


def test_half_a_second_covers_98_percent_of_the_field() -> None:
    covered = [coverage(HORIZON, 0.5, begins_s) for begins_s in (0.0, 1.1, 3.3, 7.7, 20.2, 71.0)]
    assert np.mean(covered) == pytest.approx(0.98, abs=0.01)
    assert min(covered) > 0.96
    assert coverage(HORIZON, 0.1) < 0.7


def test_a_scan_that_repeats_covers_less() -> None:
    repeats = replace(HORIZON, sweeps_a_nod=10.0, shots_a_sweep=330.0)
    assert coverage(repeats, 0.5) < 0.9


def test_points_of_a_standing_train_lie_on_the_markers() -> None:
    points, places = points_of(MarkerMotion(5.0, 0.0, 0.0), 1.0), marker_places(1, 0.25)
    assert points.time_s.size > 300
    assert np.all(np.diff(points.time_s) > 0.0)
    away = np.min(
        np.hypot(points.x_m[:, None] - 5.0 - places[:, 0], points.y_m[:, None] - places[:, 1]), axis=1
    )
    half_m = SIGN_SHEETING.side_m / 2.0
    assert np.quantile(away, 0.99) < half_m + 3.0 * HORIZON.range_sigma_m + 3.0 * SWAY_SIGMA_M
    assert (
        len(
            {
                int(np.argmin(np.hypot(5.0 + places[:, 0] - x, places[:, 1] - y)))
                for x, y in zip(points.x_m, points.y_m, strict=True)
            }
        )
        == MARKERS
    )


def test_without_noise_points_lie_in_the_faces_of_upright_plates() -> None:
    """In rows that are 0.25 m apart; where half a beam misses, its range is that of the edge."""
    exact = scan_row(replace(HORIZON, range_sigma_m=0.0, angle_sigma_deg=0.0))
    motion, rng = MarkerMotion(5.0, 0.0, 0.0), np.random.default_rng(1)
    past_m = scan(exact, marker_places(1, 0.25), motion, 0.5, rng).x_m - 5.0
    assert np.quantile(np.abs(past_m - 0.25 * np.round(past_m / 0.25)), 0.9) < 0.01


def test_each_point_is_where_the_marker_was_at_its_time() -> None:
    motion = MarkerMotion(25.0, 10.0, -0.5)
    points = points_of(motion, 1.5)
    rows_m = np.array([distance_m(motion, t) for t in points.time_s])
    behind_m = points.x_m - rows_m
    assert behind_m.min() > -0.15
    assert behind_m.max() < 0.75 + 0.15
    standing = points.x_m - 25.0
    assert standing.min() < -5.0  # without the train's own way they would lie metres off


def test_the_track_reads_darker_than_white_and_markers_brighter() -> None:
    everything = points_of(MarkerMotion(5.0, 0.0, 0.0), 0.3, least=0.0)
    markers = points_of(MarkerMotion(5.0, 0.0, 0.0), 0.3)
    assert np.count_nonzero(everything.reading == TRACK_READING) > 100
    assert markers.reading.min() > WHITE
    assert np.count_nonzero(everything.reading > WHITE) == markers.reading.size
    track = everything.reading == TRACK_READING
    assert np.median(np.abs(everything.x_m[track] - 5.4)) < 1.5


def test_markers_that_scatter_like_white_are_not_found() -> None:
    dull = scan_row(plate=Plate(retroreflection=1.0 / np.pi))
    points = scan(dull, marker_places(1, 0.25), MarkerMotion(5.0, 0.0, 0.0), 0.3, np.random.default_rng(1))
    assert points.time_s.size == 0


def test_the_seed_decides_everything() -> None:
    motion = MarkerMotion(12.0, 8.0, 0.0)
    first, again, other = (points_of(motion, 0.5, seed) for seed in (4, 4, 5))
    assert np.array_equal(first.x_m, again.x_m)
    assert first.x_m.size != other.x_m.size or not np.array_equal(first.x_m, other.x_m)


def test_a_pattern_that_is_not_in_the_catalogue_is_refused() -> None:
    with pytest.raises(ValueError, match=f"1 to {PATTERNS}"):
        marker_places(PATTERNS + 1, 0.25)
