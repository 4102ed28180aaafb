"""The LiDAR of line runs: when it looks, where it sees markers within a step, and what hides them."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from onboard.board import SENSED
from onboard.localisation.lidar import SETBACK_M
from onboard.localisation.lidar_points import CYCLE_S, KEPT_S, SPOTS
from onboard.localisation.marker_patterns import HALF_M
from simulation.sensor_settings import Lidar
from simulation.sensors.lidar import LOOKS_FROM_M, LidarSensorRow, fit, lidar, reach_m
from simulation.sensors.line_scans import PLACES_M, SPEEDS_MPS, line_scans
from simulation.sensors.scene import SCENE
from simulation.sensors.table import SENSORS_ROW
from simulation.settings import PositionSensor, Sensors
from simulation.setup import Setup

PERFECT = Lidar(laid_within_m=0.0, dirt_share=0.0)


def carried(setup: Setup, settings: Lidar = PERFECT, seed: int = 1) -> LidarSensorRow:
    row: LidarSensorRow = np.zeros(1, SENSORS_ROW["lidar"]).view(np.recarray)[0]
    sensors = Sensors(carries=(PositionSensor.TAGS, PositionSensor.LIDAR))
    fit(row, replace(setup, sensors=sensors, lidar=settings, seed=seed), "K1")
    return row


def look(
    own: LidarSensorRow,
    ahead_m: float,
    step: int = 0,
    speed_mps: float = 10.0,
    before_mps: float = 10.0,
    number: int = 4,
) -> Any:  # noqa: ANN401 - a reading
    scene: Any = np.zeros(1, SCENE).view(np.recarray)[0]
    sensed: Any = np.zeros(1, SENSED).view(np.recarray)[0]
    scene.step, scene.step_s, scene.speed_mps, scene.carries_more = step, 0.1, speed_mps, 1
    scene.markers_ahead_m, scene.markers_number = ahead_m, number
    own.before_mps = before_mps
    lidar(own, None, scene, sensed)
    return sensed.readings.lidar


def test_a_train_without_one_and_markers_out_of_range_show_nothing(rtri_setup: Setup) -> None:
    none: LidarSensorRow = np.zeros(1, SENSORS_ROW["lidar"]).view(np.recarray)[0]
    fit(none, rtri_setup, "K1")
    assert look(none, 10.0).looks == 0
    own = carried(rtri_setup)
    assert look(own, LOOKS_FROM_M + 0.1).looks == look(own, np.inf).looks == 0
    assert look(own, LOOKS_FROM_M - 0.1).looks == 1


def test_five_moments_of_a_step_lie_where_an_even_change_of_speed_has_them(rtri_setup: Setup) -> None:
    own = carried(rtri_setup)
    figures: Any = own.scans
    figures.row_sigma_m[:] = figures.row_bias_m[:] = 0.0
    shown = look(own, 10.0, speed_mps=9.0, before_mps=10.0)
    for k in range(SPOTS):
        ago_s = (SPOTS - 1 - k) * CYCLE_S
        run_m = (9.0 + (9.0 + 10.0 * ago_s)) / 2.0 * ago_s  # trapezoid
        assert shown.row_m[k] == pytest.approx(10.0 + run_m + SETBACK_M)
        assert shown.run_m[k] == pytest.approx((9.0 + 10.0 * ago_s) * KEPT_S)


def test_mean_distances_scatter_by_the_figures(rtri_setup: Setup) -> None:
    own, speed_mps, place_m = carried(rtri_setup), 10.0, 14.0
    ahead_m = place_m - HALF_M - SETBACK_M
    means = np.array(
        [look(own, ahead_m, step, speed_mps, speed_mps).mean_m[SPOTS - 1] for step in range(3000)]
    )
    means = means[means > 0.0]
    at = SPEEDS_MPS.index(speed_mps), PLACES_M.index(place_m)
    figures = line_scans()
    error_m = means - place_m - 0.5 * KEPT_S * speed_mps
    sigma_m = float(figures.sigma_m[at])
    assert error_m.mean() == pytest.approx(figures.bias_m[at], abs=4.0 * sigma_m / np.sqrt(means.size))
    assert error_m.std() == pytest.approx(sigma_m, rel=0.08)


def test_a_stretch_changes_nothing_and_a_seed_everything(rtri_setup: Setup) -> None:
    own = carried(rtri_setup)
    first = [float(look(own, 12.0, step).mean_m[2]) for step in (7, 8, 9)]
    assert [float(look(own, 12.0, step).mean_m[2]) for step in (9, 8, 7)] == first[::-1]
    assert float(look(carried(rtri_setup, seed=2), 12.0, 7).mean_m[2]) != first[0]


@pytest.mark.parametrize(
    ("settings", "sees"),
    [
        (PERFECT, True),
        (Lidar(visibility_m=200.0), True),
        (Lidar(visibility_m=5.0), False),
        (Lidar(dirt_share=0.99), False),
    ],
)
def test_fog_and_dirt_hide_markers(rtri_setup: Setup, settings: Lidar, sees: bool) -> None:
    own = carried(rtri_setup, settings)
    shown = look(own, 9.0)
    assert shown.looks == 1
    assert (max(shown.mean_m) > 0.0) == sees
    assert (reach_m(own) > 10.0) == sees


def test_a_covered_window_sees_nothing(rtri_setup: Setup) -> None:
    own = carried(rtri_setup)
    own.blind = 1
    assert max(look(own, 9.0).mean_m) < 0.0


def test_a_group_with_a_marker_gone_is_seen_and_shows_no_pattern(rtri_setup: Setup) -> None:
    shown = look(carried(rtri_setup), 6.0, number=-4)
    assert max(shown.mean_m) > 0.0
    assert shown.pattern == 0
