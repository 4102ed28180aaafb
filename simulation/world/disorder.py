"""What faults make of trains and of what lies along the track: each value put where the world has it."""

from __future__ import annotations

from functools import partial, singledispatch
from typing import Any

import numpy as np

from simulation.faults.beacon_receiver import FalseBeacon
from simulation.faults.fault import Fault, Onset, SensorFault
from simulation.faults.gnss import GnssFault, Reception
from simulation.faults.lidar import LidarFault, MarkerMissing
from simulation.faults.links import DeadZone, LineStretch, LinkFault, Telegram
from simulation.faults.rail import RailFault
from simulation.faults.tachometer import Reading, ShownByTachometer
from simulation.faults.tag_reader import TagFault
from simulation.faults.yaw_gyro import Gyro, GyroFault
from simulation.sensors import tachometer as tacho
from simulation.sensors import yaw_gyro
from simulation.sensors.gnss import put_reception
from simulation.world.trains import Trains


def fault_onset(trains: Trains, t_s: float, chance: np.random.Generator) -> Onset:
    """What a fault that takes hold now may keep of it."""
    return Onset(t_s, chance, partial(_shown_mps, trains))


def _shown_mps(trains: Trains, stock_id: str) -> float:
    """What the tachometer of a train shows."""
    slot = trains.slot_of[stock_id]
    tachometer = trains.tachometers[slot]
    stuck_mps = float(tachometer.frozen_mps)
    turned_mps = float(trains.plants[slot].wheel_speed_mps * tachometer.gain / tachometer.wheel_factor)
    return stuck_mps if stuck_mps >= 0.0 else turned_mps


@singledispatch
def put_fault(fault: Fault[Any], _trains: Trains, _value: Any) -> None:  # noqa: ANN401 - of the fault's own type
    """Make the quantity that a fault changes so."""
    raise NotImplementedError(f"nothing says where the world has {fault.changes}")


@put_fault.register
def _tachometer(fault: ShownByTachometer, trains: Trains, reading: Reading) -> None:
    slot = trains.slot_of[fault.target]
    tachometer = trains.tachometers[slot]
    tachometer.gain = reading.gain
    tachometer.frozen_mps = tacho.IN_ORDER if reading.stuck_mps is None else reading.stuck_mps
    trains.premises.fault(slot, in_force=reading != Reading())


@put_fault.register
def _tag(fault: TagFault, trains: Trains, read_id: int | None) -> None:
    tag_id = int(fault.target)
    if read_id == tag_id:
        trains.tag_faults.pop(tag_id, None)
    else:
        trains.tag_faults[tag_id] = read_id


@put_fault.register(SensorFault)
def _sensor(fault: SensorFault[Any], trains: Trains, value: float) -> None:
    setattr(trains.sensors[fault.sensor][trains.slot_of[fault.target]], fault.field, value)


@put_fault.register
def _deceived(fault: FalseBeacon, trains: Trains, deceived: bool) -> None:
    if deceived:  # once; the receiver forgets it with the step
        trains.sensors["beacon_receiver"][trains.slot_of[fault.target]].deceived = 1


@put_fault.register
def _gnss(fault: GnssFault, trains: Trains, reception: Reception) -> None:
    put_reception(trains.sensors["gnss_receiver"][trains.slot_of[fault.target]], reception)


@put_fault.register
def _gyro(fault: GyroFault, trains: Trains, gyro: Gyro) -> None:
    own = trains.sensors["yaw_gyro"][trains.slot_of[fault.target]]
    own.state = yaw_gyro.DEAD if gyro.is_silent else yaw_gyro.STUCK if gyro.is_stuck else yaw_gyro.IN_ORDER
    own.jump_radps, own.noise_factor = gyro.jump_radps, gyro.noise_factor


@put_fault.register
def _lidar(fault: LidarFault, trains: Trains, visibility_m: float) -> None:
    own = trains.lidars[trains.slot_of[fault.target]]
    own.visibility_m = min(visibility_m, trains.setup.lidar.visibility_m)
    own.blind = int(own.visibility_m <= 0.0)


@put_fault.register
def _markers(fault: MarkerMissing, trains: Trains, whole: bool) -> None:
    trains.pool.lay_markers(int(fault.target), whole=whole)


@put_fault.register
def _rail(fault: RailFault, trains: Trains, share: float) -> None:
    trains.set_rail(trains.slot_of[fault.target], share)


@put_fault.register
def _coverage(fault: DeadZone, trains: Trains, dead: tuple[LineStretch, ...]) -> None:
    trains.dead_zones.put_stretches(fault.target, dead)


@put_fault.register
def _link(_fault: LinkFault, _trains: Trains, _value: Telegram) -> None:
    """Nothing now: each telegram is folded when it is sent."""
