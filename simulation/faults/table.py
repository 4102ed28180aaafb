"""Every fault there is. Files, their checks, the injector and docs/faults.md take them from here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from simulation.faults.cable import CutCable
from simulation.faults.chargers import ChargerDead
from simulation.faults.clocks import WrongClock
from simulation.faults.devices import Frozen, LostStore, PowerOff, Restart
from simulation.faults.fault import Fault
from simulation.faults.links import Cut, DeadZone, Delay, Duplicate, Flip, Loss, Reorder
from simulation.faults.points import NoDetection, Slow, Stuck
from simulation.faults.rail import Slippery
from simulation.faults.speech import FalseClaims
from simulation.faults.vehicle import Brake, Doors, Motors
from simulation.sensors.beacon_receiver import DeafReceiver, FalseBeacon
from simulation.sensors.gnss import (
    GnssAntenna,
    GnssFrozen,
    GnssJammed,
    GnssJump,
    GnssReflections,
    GnssTimeTag,
)
from simulation.sensors.lidar import LidarBlind, LidarFog, MarkerMissing
from simulation.sensors.tachometer import NoOutput, Scale, StuckOutput
from simulation.sensors.tag_reader import Miss, WrongId
from simulation.sensors.yaw_gyro import GyroBias, GyroDead, GyroNoise, GyroStuck

KINDS: Final[tuple[type[Fault[Any]], ...]] = (
    PowerOff,
    LostStore,
    Restart,
    Frozen,
    WrongClock,
    FalseClaims,
    Cut,
    Loss,
    Delay,
    Duplicate,
    Reorder,
    Flip,
    DeadZone,
    CutCable,
    Scale,
    StuckOutput,
    NoOutput,
    Slippery,
    Doors,
    Brake,
    Motors,
    Miss,
    WrongId,
    DeafReceiver,
    FalseBeacon,
    GyroDead,
    GyroStuck,
    GyroBias,
    GyroNoise,
    Stuck,
    NoDetection,
    Slow,
    ChargerDead,
    GnssAntenna,
    GnssJammed,
    GnssReflections,
    GnssJump,
    GnssTimeTag,
    GnssFrozen,
    LidarBlind,
    LidarFog,
    MarkerMissing,
)
FAULTS: Final[Mapping[str, type[Fault[Any]]]] = {kind.kind: kind for kind in KINDS}
