"""The receiver of beacons: what it notices, how far off, and what its faults make of it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from onboard.board import SENSED
from onboard.localisation.table import READERS_ROW
from simulation.carriers.plain_track import PlainTrack
from simulation.faults.beacon_receiver import DeafReceiver, FalseBeacon
from simulation.sensor_settings import Beacons, BeaconTrust
from simulation.sensors.beacon_receiver import beacon_receiver, fit, fit_reader
from simulation.sensors.scene import NO_TAG_M, SCENE
from simulation.sensors.table import SENSORS_ROW
from simulation.settings import PositionSensor, Sensors
from simulation.setup import STEP_S, Setup
from simulation.world.disorder import put_fault
from simulation.world.trains import Trains

RUN_M = 2.0  # in the step
CARRIES = Sensors(carries=(PositionSensor.TAGS, PositionSensor.BEACONS))


def sensors_of(setup: Setup) -> Any:  # noqa: ANN401 - a row of all sensors
    row: Any = np.zeros(1, SENSORS_ROW).view(np.recarray)[0]
    fit(row.beacon_receiver, setup, "K1")
    row.tachometer.gain = row.tachometer.wheel_factor = 1.0
    row.tachometer.step_m = RUN_M
    row.tachometer.turned_m = row.tachometer.odometer_m = 1000.0
    return row


def shown(row: Any, beyond_m: float, step: int = 1, number: int = 12, *, told: bool = False) -> Any:  # noqa: ANN401
    scene: Any = np.zeros(1, SCENE).view(np.recarray)[0]
    sensed: Any = np.zeros(1, SENSED).view(np.recarray)[0]
    scene.carries_more, scene.step, scene.run_m = 1, step, RUN_M
    scene.beacon_beyond_m, scene.beacon_number, scene.beacon_told = beyond_m, number, int(told)
    beacon_receiver(row.beacon_receiver, row, scene, sensed)
    return sensed.readings.beacons


def test_it_notices_that_one_was_passed_and_only_where_it_is_told_which(rtri_setup: Setup) -> None:
    row = sensors_of(replace(rtri_setup, sensors=CARRIES))
    assert not shown(row, NO_TAG_M).noticed
    plain, numbered = shown(row, 1.0), shown(row, 1.0, told=True)
    assert (plain.noticed, plain.told, plain.number) == (1, 0, 0)
    assert (numbered.noticed, numbered.told, numbered.number) == (1, 1, 12)


def test_where_it_notices_it_is_as_the_settings_say(rtri_setup: Setup) -> None:
    settings = Beacons(notice_sigma_m=0.3, notice_max_m=0.5)
    row = sensors_of(replace(rtri_setup, sensors=CARRIES, beacons=settings))
    errors_m = np.array([shown(row, 1.0, step).odometer_m - 999.0 for step in range(4000)])
    assert np.abs(errors_m).max() == pytest.approx(0.5)
    assert errors_m.std() == pytest.approx(0.3, rel=0.15)
    assert abs(errors_m.mean()) < 0.03


def test_what_was_counted_since_is_what_the_tachometer_shows_of_the_step(rtri_setup: Setup) -> None:
    """Wheels that slide at a quarter of the train's speed turn 0.25 m over the last metre of it, locked ones none."""
    row = sensors_of(replace(rtri_setup, sensors=CARRIES, beacons=Beacons(notice_sigma_m=0.0)))
    for turned_m, since_m in ((0.25 * RUN_M, 0.25), (0.0, 0.0)):
        row.tachometer.step_m = turned_m
        assert shown(row, 1.0).odometer_m == pytest.approx(1000.0 - since_m)


def test_a_train_that_carries_none_notices_none(rtri_setup: Setup) -> None:
    assert not shown(sensors_of(rtri_setup), 1.0).noticed


def test_faults_of_the_receiver(rtri_setup: Setup) -> None:
    setup = replace(rtri_setup, sensors=CARRIES)
    pieces_m = {piece.id: piece.length_m for piece in setup.line.pieces.values()}
    trains = Trains(setup, PlainTrack(pieces_m, STEP_S))
    row = trains.stock.view(np.recarray)[0].sensors
    put_fault(DeafReceiver(target="K1"), trains, True)
    assert not shown(row, 1.0).noticed
    put_fault(DeafReceiver(target="K1"), trains, False)
    assert shown(row, 1.0).noticed
    fault = FalseBeacon(target="K1")
    put_fault(fault, trains, fault.applied_to(fault.base()))
    assert [int(shown(row, NO_TAG_M).noticed) for _ in range(3)] == [1, 0, 0]


def test_the_unit_is_told_what_the_scenario_says(rtri_setup: Setup) -> None:
    settings = Beacons(trust=BeaconTrust.PAPER, window_share=0.2, window_least_m=15.0)
    readers: Any = np.zeros(1, READERS_ROW).view(np.recarray)[0]
    fit_reader(readers, replace(rtri_setup, sensors=CARRIES, beacons=settings), "K1")
    own = readers.beacons
    assert (own.fitted, own.trusts, own.settings.window_share, own.settings.window_least_m) == (
        1,
        1,
        0.2,
        15.0,
    )
    fit_reader(readers, rtri_setup, "K1")
    assert (own.fitted, own.trusts) == (0, 0)
