"""The brake that keeps a train below the speed at which supervision brakes it, so that nothing has to intervene.

Laws, limits and the stop pattern go by what the wheels show, supervision by what that may be worth at most. With wheels
in doubt, a weak brake or a descent the pattern to a stop lies above supervision's curve, and no law knows how that
falls. This brake follows it half a service margin below, on the state that a train as fast as it may be has when a
command given now acts. Where the other laws stay lower it asks for nothing.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.supervision import (
    allowed_mps,
    fastest_mps,
    fastest_share,
    furthest_m,
    motors_gain_mps2,
    nearest_m,
)
from onboard.driving.tasc import DesignRow, TascRow, predicted_motion
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled
from vehicle.records import TrainRow

ROW_M: Final = 1.0  # rows of the path database are so far apart, and a curve to a crawl falls much within one
FALL_OVER_S: Final = 1.0  # over this running time it looks how the curve falls
GAIN_PER_S: Final = 2.0  # assumed: half a metre per second below a curve of the full brake it begins to brake
COMES_TO_REST_MPS: Final = 0.5  # assumed: what it would still run is half a metre
REST_MPS2: Final = 0.5  # assumed: half of a service brake
NO_BRAKE_MPS2: Final = 0.1  # with more brake than this the acceleration does not tell what the motors give


@compiled
def kept_mps(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    run_m: float,
    gain_mps2: float,
) -> float:
    """The speed under which a train as fast as it may be stays once it has run on by `run_m` at most, m/s."""
    near_m, far_m = nearest_m(unit, unit.position_m), furthest_m(unit, unit.position_m) + run_m + ROW_M
    _, permitted, emergency = allowed_mps(unit, train, behaviour, path, near_m, far_m, gain_mps2)
    margin_mps = behaviour.settings.service_margin_mps
    return float(max(min(permitted + margin_mps, emergency) - margin_mps / 2.0, 0.0))


@compiled
def below_supervision_mps2(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    tasc: TascRow,
    design: DesignRow,
    own_mps2: float,
    asked_mps2: float,
) -> float:
    """The train's whole deceleration, m/s^2, that keeps it below supervision; 0 where it needs none.

    `own_mps2` is what gradient and running resistance take off the speed without any brake. Motors go on as they do, or
    as they would with the power asked for (`asked_mps2`), for their dead time and lag, and then fade.
    """
    worth = fastest_share(unit) / unit.odometer_scale
    fast_mps = fastest_mps(unit, unit.train_mps * worth)
    fast_mps, run_m = predicted_motion(tasc, design, fast_mps, own_mps2)
    pull_mps2, gain_mps2 = max(unit.acceleration_mps2 + own_mps2, asked_mps2), 0.0
    if asked_mps2 > 0.0 or (pull_mps2 > 0.0 and tasc.built_mps2 < NO_BRAKE_MPS2):
        pulls_s = train.traction_dead_time_s + train.traction_lag_s
        if train.traction_jerk_max_mps3 > 0.0:
            pulls_s += pull_mps2 / (2.0 * train.traction_jerk_max_mps3)
        fast_mps += pull_mps2 * pulls_s
        run_m += pull_mps2 * pulls_s * pulls_s / 2.0
        gain_mps2 = motors_gain_mps2(unit, train, path, furthest_m(unit, unit.position_m))
        gain_mps2 = max(gain_mps2, asked_mps2 * fastest_share(unit))
    ahead_m = max(fast_mps * FALL_OVER_S, 1.0)
    here = kept_mps(unit, train, behaviour, path, run_m, gain_mps2)
    ahead = kept_mps(unit, train, behaviour, path, run_m + ahead_m, gain_mps2)
    falling = max((here * here - ahead * ahead) / (2.0 * ahead_m), 0.0)
    if here < COMES_TO_REST_MPS:  # such a curve ends in a creep that takes for ever
        falling = max(falling, REST_MPS2)
    return float(max(falling + GAIN_PER_S * (fast_mps - here), 0.0))
