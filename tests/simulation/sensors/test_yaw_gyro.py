"""The yaw gyro: the body's own motion, its noise and bias, and what faults make of them."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from network.errors import InputError
from network.files.toml_input import validate
from simulation.faults.fault import folded_value
from simulation.faults.table import FAULTS
from simulation.faults.yaw_gyro import Gyro, GyroBias, GyroDead, GyroNoise, GyroStuck
from simulation.sensor_settings import Curvature
from simulation.sensors.scene import SCENE
from simulation.sensors.yaw_gyro import YawGyroRow, body_matrices, body_turned_rad, fit, yaw_gyro
from simulation.settings import PositionSensor
from simulation.setup import Setup
from simulation.world.records import STOCK
from vehicle.record import dtype_of

STEPS = 4000


def carrying(setup: Setup, **curvature: object) -> Setup:
    sensors = setup.sensors.model_copy(update={"carries": (PositionSensor.CURVATURE,)})
    return replace(setup, sensors=sensors, curvature=setup.curvature.model_copy(update=curvature))


def fitted(setup: Setup, stock_id: str = "K1") -> YawGyroRow:
    row: Any = np.zeros(1, dtype_of(YawGyroRow)).view(np.recarray)[0]
    fit(row, setup, stock_id)
    return row


def shown(row: YawGyroRow, turned_rad: np.ndarray, first_step: int = 0) -> np.ndarray:
    """What it shows while the bogies turn by so much in each step."""
    scene: Any = np.zeros(1, SCENE).view(np.recarray)[0]
    sensed: Any = np.zeros(1, STOCK["sensed"]).view(np.recarray)[0]
    found = []
    for step, rad in enumerate(turned_rad, first_step):
        scene.step, scene.step_s, scene.turned_rad = step, 0.1, rad
        yaw_gyro(row, None, scene, sensed)
        reading = sensed.readings.curvature
        found.append(reading.yaw_radps if reading.taken else np.nan)
    return np.array(found)


def test_a_train_that_carries_none_has_none(rtri_setup: Setup) -> None:
    assert fitted(rtri_setup).fitted == 0
    assert fitted(carrying(rtri_setup)).fitted == 1
    of_one = rtri_setup.sensors.model_copy(update={"carries_of": {"K1": (PositionSensor.CURVATURE,)}})
    assert of_one.any_gyro and not rtri_setup.sensors.any_gyro


def test_the_body_follows_its_bogies_late_and_turns_as_far() -> None:
    keeps, takes, turns = body_matrices(1.0, 0.3, 0.1)
    row: Any = np.zeros(1, dtype_of(YawGyroRow)).view(np.recarray)[0]
    row.keeps[:], row.takes[:], row.turns[:] = keeps.ravel(), takes, turns
    angle, lag = 0.0, []
    for step in range(200):
        angle += body_turned_rad(row, 0.05)
        lag.append(0.05 * 0.1 * (step + 1) - angle)
    assert [row.body_radps, row.body_radps2] == pytest.approx([0.05, 0.0], abs=1e-6)
    assert lag[-1] / 0.05 == pytest.approx(2.0 * 0.3 / (2.0 * np.pi), rel=1e-6)  # the reader's delay


def test_noise_is_that_of_the_mean_of_a_steps_samples(rtri_setup: Setup) -> None:
    for factor in (0.5, 1.0, 2.0):
        setup = carrying(rtri_setup, noise_factor=factor, bias_sigma_degps=0.0, bias_walk_degps=0.0)
        noise = shown(fitted(setup), np.zeros(STEPS))
        assert np.degrees(noise.std()) == pytest.approx(factor * 0.19 / np.sqrt(170.0), rel=0.05)
        assert abs(np.degrees(noise.mean())) < 0.001 * factor
        assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.05


def test_noise_is_counted_by_the_step(rtri_setup: Setup) -> None:
    setup = carrying(rtri_setup)
    whole = shown(fitted(setup), np.zeros(100))
    row = fitted(setup)
    assert np.array_equal(whole, np.concatenate([shown(row, np.zeros(40)), shown(row, np.zeros(60), 40)]))
    assert not np.array_equal(whole, shown(fitted(replace(setup, seed=2)), np.zeros(100)))


def test_a_bias_belongs_to_the_train_and_walks_slowly(rtri_setup: Setup) -> None:
    setup = carrying(rtri_setup, noise_factor=0.0, bias_walk_s=60.0)
    bias = np.degrees(shown(fitted(setup), np.zeros(STEPS)))
    assert np.abs(np.diff(bias)).max() < 0.02 and 0.003 < bias.std() < 0.03
    assert abs(bias.mean()) < 3.1 * 0.5


def test_each_fault_does_what_it_says(rtri_setup: Setup) -> None:
    setup = carrying(rtri_setup, bias_sigma_degps=0.0, bias_walk_degps=0.0)
    turning = np.full(50, 0.002)
    row = fitted(setup)
    row.state = 1
    assert np.all(np.isnan(shown(row, turning)))
    row = fitted(setup)
    shown(row, turning)
    row.state = 2
    assert len(set(shown(row, turning, 50))) == 1
    row = fitted(setup)
    row.jump_radps = 0.01
    assert np.mean(shown(row, np.zeros(500))) == pytest.approx(0.01, abs=1e-4)
    row = fitted(setup)
    row.noise_factor = 20.0
    assert shown(row, np.zeros(500)).std() > 15.0 * row.sigma_radps


def test_faults_that_overlap_are_folded() -> None:
    faults = [
        GyroBias(target="K1", jump_degps=0.1),
        GyroNoise(target="K1", factor=3.0),
        GyroNoise(target="K1", factor=2.0),
        GyroStuck(target="K1"),
    ]
    found = folded_value(Gyro(), faults)
    assert (found.is_silent, found.is_stuck, found.noise_factor) == (False, True, 6.0)
    assert found.jump_radps == pytest.approx(np.radians(0.1))
    assert folded_value(found, [GyroDead(target="K1")]).is_silent
    assert {"gyro_dead", "gyro_stuck", "gyro_bias", "gyro_noise"} <= set(FAULTS)


def test_a_bias_that_walks_in_no_time_is_refused() -> None:
    """What it keeps is exp(-step / time constant): of a constant of 0 that is no number."""
    with pytest.raises(InputError, match=r"bias_walk_s is 0\.0; expected 1 to 7200 s"):
        validate({"bias_walk_s": 0.0}, "s.toml", Curvature)
