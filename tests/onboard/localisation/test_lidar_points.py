"""Equations 2 to 4: points moved by the way run since, speed by the mean distance, smoothed twice."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.lidar_points import (
    CYCLE_S,
    FILLED,
    MEANS,
    SPEED,
    detect,
    mean_distance_m,
    places_now,
    read_window_m,
    window,
)


def fresh() -> Any:  # noqa: ANN401 - a record
    return np.zeros(1, SPEED).view(np.recarray)[0]


@given(
    speed_mps=st.floats(0.0, 40.0),
    now_s=st.floats(0.1, 20.0),
    ages_s=st.lists(st.floats(0.0, 0.1), min_size=1, max_size=30),
)
def test_points_on_one_marker_come_together_at_the_true_speed(
    speed_mps: float, now_s: float, ages_s: list[float]
) -> None:
    times = np.sort(now_s - np.array(ages_s))
    seen_m = 5.0 + speed_mps * (now_s - times)  # further off, the longer ago
    assert places_now(seen_m, times, 0, times.size, now_s, speed_mps) == pytest.approx(5.0, abs=1e-9)
    spread_m = np.ptp(places_now(seen_m, times, 0, times.size, now_s, 0.0))
    assert spread_m == pytest.approx(speed_mps * np.ptp(times), abs=1e-9)


def test_both_means_are_filled_after_49_cycles_and_not_before() -> None:
    own = fresh()
    speeds = []
    for cycle in range(60):
        detect(own, 30.0 - 8.0 * CYCLE_S * cycle)
        speeds.append(float(own.speed_mps))
    # the first cycle detects nothing: there was no mean before it
    assert speeds[FILLED] == pytest.approx(8.0)
    assert speeds[FILLED - 1] < 8.0 - 1e-3
    assert own.cycles == 59
    triangle = np.cumsum(np.convolve(np.ones(MEANS), np.ones(MEANS))) / MEANS**2
    assert speeds[1 : FILLED + 1] == pytest.approx(8.0 * triangle)


def test_without_points_the_speed_detected_is_0_and_the_count_begins_anew() -> None:
    own = fresh()
    for cycle in range(60):
        detect(own, 30.0 - 8.0 * CYCLE_S * cycle)
    detect(own, -1.0)
    assert (float(own.detected_mps), int(own.cycles)) == (0.0, 0)
    detect(own, 20.0)
    assert float(own.detected_mps) == 0.0  # nothing to compare with
    assert own.speed_mps < 8.0


def test_means_count_between_5_and_30_m_only() -> None:
    assert mean_distance_m(np.array([9.0, 11.0]), 0, 2) == 10.0
    for x_m in (4.9, 30.1):
        assert mean_distance_m(np.array([x_m]), 0, 1) == -1.0
    assert mean_distance_m(np.array([9.0]), 1, 1) == -1.0


def test_the_window_holds_what_is_not_older() -> None:
    times = np.array([0.01, 0.05, 0.10, 0.15, 0.21])
    assert window(times, 0.16, 0.1, 0, 0) == (2, 4)
    assert window(times, 0.20, 0.1, 2, 4) == (3, 4)


def test_rows_further_apart_are_read_with_the_nearest_as_near() -> None:
    assert read_window_m(0.25) == 5.0
    assert read_window_m(1.25) == pytest.approx(6.5)
