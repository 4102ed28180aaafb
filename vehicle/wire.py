"""Power at the wire or battery for a force at the rim: the one place that knows what motors and inverters lose.

Plant, predictions and optimiser all ask it, so what a plan costs is what the plan's run is charged.
"""

from __future__ import annotations

from vehicle.adhesion import DRY, adhesion_coefficient
from vehicle.compiled import compiled
from vehicle.losses import losses_w, running_motors
from vehicle.mass import GRAVITY_MPS2
from vehicle.records import TrainRow
from vehicle.traction import motored_grip_n


@compiled
def power_at_grip_w(
    train: TrainRow, motors_share: float, force_n: float, speed_mps: float, grip_n: float
) -> float:
    """`wire_power_w` where the rail passes `grip_n` on to all driven axles together."""
    if motors_share <= 0.0:
        return 0.0
    power_w = force_n * speed_mps
    if train.losses_given > 0.0:
        running = running_motors(train, motors_share, force_n, speed_mps, grip_n)
        return power_w + losses_w(train, running, force_n, speed_mps)
    return power_w / train.efficiency_traction if force_n > 0.0 else power_w * train.efficiency_regeneration


@compiled
def wire_power_w(train: TrainRow, motors_share: float, force_n: float, speed_mps: float) -> float:
    """Power drawn (> 0) or given back (< 0), W, for a force of the motors at the rim; auxiliaries apart.

    `force_n` > 0 pulls, < 0 is the electric brake, 0 coasts; `motors_share` of the motors is in service. The rail is
    dry and the train empty where it matters: in how many motors a train that cuts motors out may run. Continuous in
    speed and force, but where a motor more must run than loses least, and at no force, where motors are cut out.
    """
    grip_n = 0.0
    if train.motors_cut_out > 0.0:
        weight_n = train.mass_empty_kg * GRAVITY_MPS2
        grip_n = motored_grip_n(train, weight_n, adhesion_coefficient(train, DRY, speed_mps))
    return power_at_grip_w(train, motors_share, force_n, speed_mps, grip_n)
