"""Faults of the beacon receiver: it detects no beacon, or one where there is none."""

from __future__ import annotations

from typing import ClassVar

from simulation.faults.fault import SensorFault, UnitFault
from simulation.settings import PositionSensor


class DeafReceiver(SensorFault[bool]):
    """The receiver detects no beacon."""

    kind = "no_beacon"
    changes = "beacon receiver"
    of_sensor = PositionSensor.BEACONS
    sensor, field = "beacon_receiver", "deaf"

    def base(self) -> bool:
        return False

    def applied_to(self, _deaf: bool) -> bool:
        return True


class FalseBeacon(UnitFault[bool]):
    """The receiver detects a beacon, without a number, where there is none."""

    kind = "false_beacon"
    changes = "false beacon"
    of_sensor = PositionSensor.BEACONS
    momentary: ClassVar[bool] = True

    def base(self) -> bool:
        return False

    def applied_to(self, _deceived: bool) -> bool:
        return True
