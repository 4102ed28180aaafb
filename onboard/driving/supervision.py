"""The speed that may not be passed (速度制御機能, Sugiyama table 1); it may only brake harder than the driver.

Invariant: with the guaranteed brakes, a train supervised here never brings its front past `stop_limit_m`, because
the permitted speed leaves room for the reaction time, for what the train gains in it while the motors pull on as
they do now, and for the position's bound ahead. It counts as fast as it may be by wheels that are as large as the
bounds allow for. (Motors that only begin to pull are within the reaction's reserve.) A limit holds from where the front
may be at the furthest until the rear has left it, wherever the train may be.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.localisation.tachometer import ACCELERATION_SMOOTHING_S
from onboard.records import (
    EMERGENCY_INTERVENTION,
    EVENT_INTERVENTION,
    NO_INTERVENTION,
    SERVICE_INTERVENTION,
    BehaviourRow,
    UnitRow,
)
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2
from vehicle.records import TrainRow

RESERVE_M: Final = (
    1.0  # assumed: a descent adds at most g*i*t^2/2 in the reaction time, 0.3 m at 30 permille and 1.4 s
)

SMOOTHED_S: Final = 2.0 * ACCELERATION_SMOOTHING_S


@compiled
def path_index(unit: UnitRow, position_m: float) -> int:
    """Row of the path database at a path coordinate, clamped to the path."""
    return int(unit.path_offset + int(min(max(position_m, 0.0), unit.path_rows - 1.0)))


@compiled
def body_elevation_m(unit: UnitRow, path: NDArray[np.void], position_m: float) -> float:
    """Mean elevation under the train with its front at a path coordinate, between the rows by proportion, m."""
    position_m = min(max(position_m, 0.0), float(unit.path_rows))  # a stop limit may be infinitely far
    low = path_index(unit, position_m)
    high = path_index(unit, position_m + 1.0)
    share = min(max(position_m - int(position_m), 0.0), 1.0)
    below = path[low].body_elevation_m
    return float(below + share * (path[high].body_elevation_m - below))


@compiled
def slope_at(unit: UnitRow, path: NDArray[np.void], position_m: float) -> float:
    """Mean slope (m per m) under the train with its front at a path coordinate, m."""
    return body_elevation_m(unit, path, position_m) - body_elevation_m(unit, path, position_m - 1.0)


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
def fastest_share(unit: UnitRow) -> float:
    """What a metre that the wheels show is worth at most, as far as they are known."""
    return float(unit.odometer_scale + unit.bound_growth)


@compiled
def fastest_mps(unit: UnitRow, rolled_mps: float) -> float:
    """How fast the train may run at most: by its wheels, and by what is known of it while they do not roll."""
    return float(max(unit.slid_mps, rolled_mps))


@compiled
def nearest_m(unit: UnitRow, position_m: float) -> float:
    """Where the front is at least when it is believed at a path coordinate, m: from there back the train lies."""
    return float(position_m - unit.bound_behind_m)


@compiled
def furthest_m(unit: UnitRow, position_m: float) -> float:
    """Where the front is at most when it is believed at a path coordinate, m."""
    return float(position_m + unit.bound_ahead_m + RESERVE_M)


@compiled
def least_permitted_mps(unit: UnitRow, path: NDArray[np.void], from_m: float, to_m: float) -> float:
    """The least permitted speed of the rows from one path coordinate to another, m."""
    least_mps = np.inf
    for row in range(path_index(unit, from_m), path_index(unit, to_m) + 1):
        least_mps = min(least_mps, path[row].permitted_mps)
    return float(least_mps)


@compiled
def motors_gain_mps2(unit: UnitRow, train: TrainRow, path: NDArray[np.void], far_m: float) -> float:
    """What the motors give a train that is as fast as it may be, m/s^2; gravity apart, which is in the climb.

    The smoothed acceleration may still be that of the gradient a second ago.
    """
    fastest = fastest_share(unit)
    gravity_share = GRAVITY_MPS2 / (1.0 + train.rotating_mass_factor)
    before_m = far_m - unit.speed_mps * fastest * SMOOTHED_S
    slope = max(slope_at(unit, path, far_m), slope_at(unit, path, before_m))
    return float(max(unit.acceleration_mps2 * fastest + gravity_share * slope, 0.0))


@compiled
def allowed_mps(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    near_m: float,
    far_m: float,
    gain_mps2: float,
) -> tuple[float, float, float]:
    """The least limit, the permitted speed and the one above which the emergency brake comes, m/s.

    Of a train whose front is between two path coordinates (m) and that gains `gain_mps2` until its brake acts.
    """
    gravity_share = GRAVITY_MPS2 / (1.0 + train.rotating_mass_factor)
    distance_m = unit.stop_limit_m - far_m
    climb_m = body_elevation_m(unit, path, unit.stop_limit_m) - body_elevation_m(unit, path, far_m)
    ceiling = min(least_permitted_mps(unit, path, near_m, np.ceil(far_m)), unit.restricted_mps)
    service_stop = stop_curve_mps(
        distance_m,
        climb_m,
        behaviour.service_guaranteed_mps2,
        behaviour.service_reaction_s,
        gravity_share,
    )
    emergency_stop = stop_curve_mps(
        distance_m,
        climb_m,
        behaviour.emergency_guaranteed_mps2,
        behaviour.emergency_reaction_s,
        gravity_share,
    )
    emergency = min(
        ceiling + behaviour.settings.emergency_margin_mps,
        emergency_stop - gain_mps2 * behaviour.emergency_reaction_s,
    )
    return ceiling, min(ceiling, service_stop), emergency


@compiled
def supervise(unit: UnitRow, train: TrainRow, behaviour: BehaviourRow, path: NDArray[np.void]) -> int:
    """Set the permitted speed and the intervention of this step; returns event bits."""
    near_m, far_m = nearest_m(unit, unit.position_m), furthest_m(unit, unit.position_m)
    gain_mps2 = motors_gain_mps2(unit, train, path, far_m)
    ceiling, service, emergency = allowed_mps(unit, train, behaviour, path, near_m, far_m, gain_mps2)
    unit.ceiling_mps, unit.permitted_mps = ceiling, service
    before = unit.intervention
    speed = fastest_mps(unit, unit.speed_mps * fastest_share(unit))
    if before == EMERGENCY_INTERVENTION:
        after = EMERGENCY_INTERVENTION  # kept until the event-driven part releases it at a stand
    elif speed > emergency and speed > 0.0:
        after = EMERGENCY_INTERVENTION
    elif speed > service + behaviour.settings.service_margin_mps or (
        before == SERVICE_INTERVENTION and speed > max(service - behaviour.settings.release_margin_mps, 0.0)
    ):
        after = SERVICE_INTERVENTION
    else:
        after = NO_INTERVENTION
    unit.intervention = after
    return EVENT_INTERVENTION if after != before else 0
