"""The speed that may not be passed (速度制御機能, Sugiyama table 1); it may only brake harder than the driver.

Invariant: with the guaranteed brakes, a train supervised here never brings its front past `stop_limit_m`, because
the permitted speed leaves room for the reaction time and for the position's bound ahead.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from onboard.records import (
    EMERGENCY_INTERVENTION,
    EVENT_INTERVENTION,
    NO_INTERVENTION,
    SERVICE_INTERVENTION,
)
from onboard.rows import BehaviourRow, UnitRow
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2
from vehicle.rows import TrainRow


@compiled
def path_index(unit: UnitRow, position_m: float) -> int:
    """Row of the path database at a path coordinate, clamped to the path."""
    index = int(position_m)
    return int(unit.path_offset + min(max(index, 0), unit.path_rows - 1))


@compiled
def stop_curve_mps(
    distance_m: float, climb_m: float, deceleration_mps2: float, reaction_s: float, gravity_share_mps2: float
) -> float:
    """Speed from which the train stops within `distance_m`, reaction time included; a climb of `climb_m` helps.

    Solves v*reaction + v^2/(2b) = distance + g*climb/(b*(1 + rotating mass)).
    """
    if distance_m <= 0.0:
        return 0.0
    room = distance_m + gravity_share_mps2 * climb_m / deceleration_mps2
    if room <= 0.0:
        return 0.0
    loss = deceleration_mps2 * reaction_s
    return float(np.sqrt(loss * loss + 2.0 * deceleration_mps2 * room) - loss)


@compiled
def supervise(unit: UnitRow, train: TrainRow, behaviour: BehaviourRow, path: NDArray[np.void]) -> int:
    """Set the permitted speed and the intervention of this step; returns event bits."""
    front_m = unit.position_m + unit.bound_ahead_m
    gravity_share = GRAVITY_MPS2 / (1.0 + train.rotating_mass_factor)
    here = path[path_index(unit, front_m)]
    distance_m = unit.stop_limit_m - front_m
    climb_m = path[path_index(unit, unit.stop_limit_m)].elevation_m - here.elevation_m
    ceiling = min(here.permitted_mps, unit.restricted_mps)
    service = min(
        ceiling,
        stop_curve_mps(
            distance_m,
            climb_m,
            behaviour.service_guaranteed_mps2,
            behaviour.service_reaction_s,
            gravity_share,
        ),
    )
    emergency = min(
        ceiling + behaviour.emergency_margin_mps,
        stop_curve_mps(
            distance_m,
            climb_m,
            behaviour.emergency_guaranteed_mps2,
            behaviour.emergency_reaction_s,
            gravity_share,
        ),
    )
    unit.permitted_mps = service
    before = unit.intervention
    speed = unit.speed_mps
    if before == EMERGENCY_INTERVENTION:
        after = EMERGENCY_INTERVENTION  # kept until the event-driven part releases it at a stand
    elif speed > emergency and speed > 0.0:
        after = EMERGENCY_INTERVENTION
    elif speed > service + behaviour.service_margin_mps or (
        before == SERVICE_INTERVENTION and speed > max(service - behaviour.release_margin_mps, 0.0)
    ):
        after = SERVICE_INTERVENTION
    else:
        after = NO_INTERVENTION
    unit.intervention = after
    return EVENT_INTERVENTION if after != before else 0
