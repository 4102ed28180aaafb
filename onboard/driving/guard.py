"""The brake that keeps a train, as fast as it may be by its wheels, under the speed at which supervision would brake.

Laws, limits and the stop pattern go by the speed that the wheels show, supervision by what that may be worth at most. Where
wheels are in doubt, on a descent or with a weak brake the pattern to a stop lies over supervision's curve. This brake
follows that curve a little below it, on the state in which a command given now acts. It asks for nothing where the other
laws stay under it.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.supervision import (
    allowed_mps,
    fastest_share,
    furthest_m,
    motors_gain_mps2,
    nearest_m,
)
from onboard.driving.tasc import DesignRow, TascRow, predicted_motion
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled
from vehicle.records import TrainRow

CUSHION_MPS: Final = 0.3  # assumed: half of the margin at which the service brake comes
BRAKED_MPS2: Final = 0.1
AHEAD_S: Final = 1.0
GAIN_PER_S: Final = 2.0


@compiled
def kept_mps(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    run_m: float,
    gain_mps2: float,
) -> float:
    """Speed, as fast as the train may be, to stay under after `run_m` metres as long as they may be; m/s."""
    near_m = nearest_m(unit, unit.position_m)
    front_m = furthest_m(unit, unit.position_m) + run_m
    _, permitted, emergency = allowed_mps(unit, train, behaviour, path, near_m, front_m)
    emergency -= gain_mps2 * behaviour.emergency_reaction_s
    return float(max(min(permitted + behaviour.settings.service_margin_mps, emergency) - CUSHION_MPS, 0.0))


@compiled
def guard_demand_mps2(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    tasc: TascRow,
    design: DesignRow,
    path: NDArray[np.void],
    own_mps2: float,
) -> float:
    """Deceleration to be given, with what slows the train by itself, m/s^2; 0 where it stays under the curve."""
    worth = fastest_share(unit) / unit.odometer_scale
    fast_mps, run_m = predicted_motion(tasc, design, unit.train_mps * worth, own_mps2)
    pull_mps2 = unit.acceleration_mps2 + own_mps2
    gain_mps2 = 0.0
    if pull_mps2 > 0.0 and tasc.built_mps2 < BRAKED_MPS2:
        pulls_s = train.traction_dead_time_s + train.traction_lag_s
        if train.traction_jerk_max_mps3 > 0.0:
            pulls_s += pull_mps2 / (2.0 * train.traction_jerk_max_mps3)
        fast_mps += pull_mps2 * pulls_s
        run_m += pull_mps2 * pulls_s * pulls_s / 2.0
        gain_mps2 = motors_gain_mps2(unit, train, path, furthest_m(unit, unit.position_m))
    ahead_m = max(fast_mps * AHEAD_S, 1.0)
    here = kept_mps(unit, train, behaviour, path, run_m, gain_mps2)
    ahead = kept_mps(unit, train, behaviour, path, run_m + ahead_m, gain_mps2)
    falling = max((here * here - ahead * ahead) / (2.0 * ahead_m), 0.0)
    return float(max(falling + GAIN_PER_S * (fast_mps - here), 0.0))
