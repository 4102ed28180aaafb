"""What wire or battery can give and take now (電源の制約), and what is left of the motors' force by it.

`plant.source_gives_w` and `plant.source_takes_w` are set from outside before each step, at DC, +inf where nothing
limits. The auxiliaries come first: they have their share of what is given, and they use what is given back.
"""

from __future__ import annotations

import math
from typing import Final

from vehicle.compiled import compiled
from vehicle.records import PlantRow, TrainRow
from vehicle.wire import power_at_grip_w

HALVINGS: Final = 40  # of the force: to a billionth of a newton


@compiled
def pull_within_n(
    plant: PlantRow,
    train: TrainRow,
    pull_n: float,
    held_n: float,
    inertia_kg: float,
    grip_n: float,
    dt_s: float,
) -> float:
    """As much of a pull (N) as the source can give beside the auxiliaries over the next step.

    `held_n` is what resists the train; the speed is that in the middle of the step, as energy is counted.
    """
    if plant.source_gives_w == math.inf or pull_n <= 0.0:
        return pull_n
    left_w = plant.source_gives_w - train.auxiliary_power_w
    share, half_s = plant.motors_share, 0.5 * dt_s
    middle_mps = max(plant.speed_mps + (pull_n - held_n) / inertia_kg * half_s, 0.5 * plant.speed_mps)
    if power_at_grip_w(train, share, pull_n, middle_mps, grip_n) <= left_w:
        return pull_n
    low_n, high_n = 0.0, pull_n
    for _ in range(HALVINGS):
        middle_n = 0.5 * (low_n + high_n)
        middle_mps = max(plant.speed_mps + (middle_n - held_n) / inertia_kg * half_s, 0.5 * plant.speed_mps)
        if power_at_grip_w(train, share, middle_n, middle_mps, grip_n) <= left_w:
            low_n = middle_n
        else:
            high_n = middle_n
    return low_n


@compiled
def brake_within_n(
    plant: PlantRow, train: TrainRow, brake_n: float, speed_mps: float, grip_n: float, dt_s: float
) -> float:
    """As much of an electric brake force (N) as the source takes beside the auxiliaries; counts what it refuses.

    `speed_mps` is that in the middle of the step, as energy is counted.
    """
    if brake_n <= 0.0 or (plant.source_takes_w == math.inf and plant.source_gives_w == math.inf):
        return brake_n
    taken_w = max(plant.source_takes_w, 0.0) + train.auxiliary_power_w
    share = plant.motors_share
    back_w = -power_at_grip_w(train, share, -brake_n, speed_mps, grip_n)
    # slow motors take more than they brake; a source that cannot give it ends the electric brake
    if back_w <= taken_w:
        return brake_n if back_w >= -max(plant.source_gives_w - train.auxiliary_power_w, 0.0) else 0.0
    low_n, high_n = 0.0, brake_n
    for _ in range(HALVINGS):
        middle_n = 0.5 * (low_n + high_n)
        if -power_at_grip_w(train, share, -middle_n, speed_mps, grip_n) <= taken_w:
            low_n = middle_n
        else:
            high_n = middle_n
    left_w = max(-power_at_grip_w(train, share, -low_n, speed_mps, grip_n), 0.0)
    plant.energy_rejected_j += (back_w - left_w) * dt_s
    return low_n
