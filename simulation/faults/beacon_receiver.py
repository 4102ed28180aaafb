"""Faults of the beacon receiver: it detects no beacon, or one where there is none."""

from __future__ import annotations

from typing import ClassVar

from simulation.faults.fault import SensorFault, SwitchedFault, UnitFault
from simulation.settings import PositionSensor


class DeafReceiver(SwitchedFault, SensorFault[bool]):
    """The receiver detects no beacon."""

    kind = "no_beacon"
    changes = "beacon receiver"
    in_order = False
    of_sensor = PositionSensor.BEACONS
    sensor, field = "beacon_receiver", "deaf"


class FalseBeacon(SwitchedFault, UnitFault[bool]):
    """The receiver detects a beacon, without a number, where there is none."""

    kind = "false_beacon"
    changes = "false beacon"
    in_order = False
    of_sensor = PositionSensor.BEACONS
    momentary: ClassVar[bool] = True
