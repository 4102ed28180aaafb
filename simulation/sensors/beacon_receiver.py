"""The receiver of train-stop beacons (ATS地上子): it shows that a beacon was passed, and the tachometer's count then.

Most beacons show no more than that (ATS-Sx); some also send a number (ATS-P). Fitted to trains that carry `beacons`.
"""

from __future__ import annotations

from typing import Annotated, Any, Protocol

from onboard.board import SensedRow
from onboard.localisation.beacons import BeaconsRow, BeaconWindow
from simulation.sensor_settings import BeaconTrust
from simulation.sensors.noise import source_of
from simulation.sensors.scene import SceneRow
from simulation.sensors.tag_reader import WithTachometer, latch
from simulation.settings import PositionSensor
from simulation.setup import Setup
from vehicle.compiled import compiled
from vehicle.record import put_settings


class BeaconReceiverRow(Protocol):
    """One train's receiver."""

    fitted: Annotated[int, "1: the train has one"]
    source: Annotated[int, "of its noise"]
    sigma_m: Annotated[float, "standard deviation of where it notices a beacon"]
    most_m: Annotated[float, "at most this far off"]
    latched_m: Annotated[float, "the tachometer when it noticed the last beacon"]
    deaf: Annotated[int, "1: it notices none"]
    deceived: Annotated[int, "1: it will notice one in the next step that is not there"]


def fit(own: BeaconReceiverRow, setup: Setup, stock_id: str) -> None:
    """A receiver with noise of its own, on trains that carry one."""
    own.fitted = int(PositionSensor.BEACONS in setup.sensors.carried_by(stock_id))
    own.source = source_of(setup.seed, "beacon receiver", stock_id, *setup.today)
    own.sigma_m, own.most_m = setup.beacons.notice_sigma_m, setup.beacons.notice_max_m


def fit_reader(readers: Any, setup: Setup, stock_id: str) -> None:  # noqa: ANN401 - all readers' rows
    """What its unit goes by."""
    own: BeaconsRow = readers.beacons
    own.fitted = int(PositionSensor.BEACONS in setup.sensors.carried_by(stock_id))
    own.trusts = int(setup.beacons.trust is BeaconTrust.PAPER)
    put_settings(own.settings, setup.beacons, BeaconWindow)


@compiled
def beacon_receiver(
    own: BeaconReceiverRow, sensors: WithTachometer, scene: SceneRow, sensed: SensedRow
) -> None:
    """Tell of the beacon that the front passed in this step, if it passed one."""
    shown = sensed.readings.beacons
    shown.noticed = 0
    if own.fitted == 0 or scene.carries_more == 0:
        return
    if scene.beacon_beyond_m >= 0.0 and own.deaf == 0:
        latch(own, sensors.tachometer, scene, scene.beacon_beyond_m)
        shown.told = scene.beacon_told
        shown.number = scene.beacon_number if scene.beacon_told != 0 else 0
    elif own.deceived != 0:
        latch(own, sensors.tachometer, scene, 0.0)
        shown.told = shown.number = 0
        own.deceived = 0
    else:
        return
    shown.noticed, shown.odometer_m = 1, own.latched_m
