"""Power at the wire or battery for a force at the rim: the one place that knows what motors and inverters lose.

Plant, predictions and optimiser all ask it, so what a plan costs is what the plan's run is charged.
"""

from __future__ import annotations

from vehicle.compiled import compiled
from vehicle.records import TrainRow


@compiled
def power_at_grip_w(
    train: TrainRow, motors_share: float, force_n: float, speed_mps: float, grip_n: float
) -> float:
    """`wire_power_w` where the rail passes `grip_n` on to all driven axles together."""
    if motors_share <= 0.0:
        return 0.0
    power_w = force_n * speed_mps
    return power_w / train.efficiency_traction if force_n > 0.0 else power_w * train.efficiency_regeneration


@compiled
def wire_power_w(train: TrainRow, motors_share: float, force_n: float, speed_mps: float) -> float:
    """Power drawn (> 0) or given back (< 0), W, for a force of the motors at the rim; auxiliaries apart.

    `force_n` > 0 pulls, < 0 is the electric brake; `motors_share` of the motors is in service.
    """
    return power_at_grip_w(train, motors_share, force_n, speed_mps, 0.0)
