"""What a turn of the measured wheel is worth: worn, creeping, in curves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.board import SENSED
from simulation.sensors.scene import SCENE
from simulation.sensors.table import SENSORS_ROW
from simulation.sensors.tachometer import CONTACT_HALF_M, TachometerRow, fit_train, tachometer, turns_more
from simulation.settings import Sensors
from vehicle.records import TRAIN

RADIUS_M, SLOPE, PLAY_M = 0.43, 0.05, 0.007
RUN_M = 100.0


def row_of(creep: float = 0.0, slope: float = 0.0) -> TachometerRow:
    train = np.zeros(1, dtype=TRAIN).view(np.recarray)[0]
    train.wheel_diameter_m, train.pulses_per_revolution = 2.0 * RADIUS_M, 1e6
    own: TachometerRow = np.zeros(1, dtype=SENSORS_ROW).view(np.recarray)[0].tachometer
    fit_train(own, train)
    own.creep_share, own.outwards_m = creep, PLAY_M
    if slope > 0.0:
        own.slope_per_m, own.outwards_m2 = slope / RADIUS_M, RADIUS_M * CONTACT_HALF_M / slope
    return own


def counted_m(own: TachometerRow, used: float = 0.0, curvature_per_m: float = 0.0) -> float:
    scene, sensed = (np.zeros(1, dtype=of).view(np.recarray)[0] for of in (SCENE, SENSED))
    scene.step_s, scene.wheel_run_m, scene.wheel_mps = 0.1, RUN_M, 10.0
    scene.used_adhesion, scene.curvature_per_m = used, curvature_per_m
    tachometer(own, None, scene, sensed)
    assert sensed.speed_mps == pytest.approx(sensed.odometer_m / RUN_M * 10.0, rel=1e-5)
    return float(sensed.odometer_m)


def test_a_wheel_that_pulls_turns_more_and_one_that_brakes_less() -> None:
    assert counted_m(row_of(creep=0.003), used=1.0) == pytest.approx(RUN_M * 1.003)
    assert counted_m(row_of(creep=0.003), used=-0.5) == pytest.approx(RUN_M * 0.9985)
    assert counted_m(row_of(), used=1.0) == pytest.approx(RUN_M)


def test_in_a_curve_the_leading_axle_runs_on_a_larger_circle() -> None:
    """Of 0.05 * 7 mm more in 0.43 m once its flange touches, which it does at 688 m and less."""
    least_m = RADIUS_M * CONTACT_HALF_M / SLOPE / PLAY_M
    assert least_m == pytest.approx(688.0)
    at_most = 1.0 + SLOPE * PLAY_M / RADIUS_M
    assert counted_m(row_of(slope=SLOPE), curvature_per_m=1.0 / 200.0) == pytest.approx(RUN_M / at_most)
    assert counted_m(row_of(slope=SLOPE), curvature_per_m=0.0) == pytest.approx(RUN_M)
    half = 1.0 + SLOPE * PLAY_M / 2.0 / RADIUS_M
    assert counted_m(row_of(slope=SLOPE), curvature_per_m=0.5 / least_m) == pytest.approx(RUN_M / half)


@given(st.floats(0.0, 0.004), st.floats(0.0, 0.2), st.floats(-1.0, 1.0), st.floats(0.0, 0.02))
def test_it_changes_by_no_more_than_the_settings_say(
    creep: float, slope: float, used: float, curvature: float
) -> None:
    own = row_of(creep, slope)
    scene = np.zeros(1, dtype=SCENE).view(np.recarray)[0]
    scene.used_adhesion, scene.curvature_per_m = used, curvature
    sensors = Sensors(creep_share=creep, tread_conicity=slope, flangeway_m=PLAY_M)
    most = sensors.wheel_varies_share(2.0 * RADIUS_M)
    assert abs(1.0 / turns_more(own, scene) - 1.0) <= most * (1.0 + most) + 1e-12
    trailing = sensors.model_copy(update={"tachometer_axle": "trailing"})
    assert trailing.wheel_varies_share(2.0 * RADIUS_M) == creep
    assert [
        Sensors(creep_share=c, tread_conicity=t).wheels_vary for c, t in ((0, 0), (creep, 0), (0, slope))
    ] == [
        False,
        creep > 0.0,
        slope > 0.0,
    ]
