"""Automatic driving between stations with notches, and the stop at the mark (ATO and TASC, 定位置停止制御).

Between stations notches hold the cruising speed that the timetable asks for, and the brake follows the curves
down to lower limits. At the station `onboard.driving.stopping` asks for the brake that follows the target-speed
pattern; the stronger of the two demands counts. Gradient and running resistance are taken off the brake demand,
since the train's own brake control is calibrated on the level.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from onboard.driving.stopping import stop_command_mps2
from onboard.driving.supervision import RESERVE_M, path_index
from onboard.driving.tasc import DesignRow, TascRow
from onboard.records import EMERGENCY_INTERVENTION, MODE_DRIVE, NO_INTERVENTION, BehaviourRow, UnitRow
from vehicle.brakes import service_notch
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg, mass_kg
from vehicle.records import TrainRow
from vehicle.resistance import resistance_n
from vehicle.traction import full_force_n, notch_share

LOOK_AHEAD_S = 1.0
BRAKE_OVERSPEED_MPS = 0.5  # between stations the brake is left alone below this
HOLD_BAND_MPS = (
    0.25  # the speed swings this far about the target: notches are whole, and each is worth 0.1 m/s2
)
CURVE_BAND_MPS = 0.5  # this near a falling curve the brake follows it


@compiled
def power_notch(train: TrainRow, load_share: float, speed_mps: float, force_n: float) -> float:
    """The lowest power notch whose force at this speed reaches `force_n`; 0 where none is wanted."""
    if force_n <= 0.0:
        return 0.0
    full_n = full_force_n(train, load_share, speed_mps)
    highest = int(train.power_notches)
    for notch in range(1, highest + 1):
        if notch_share(train, float(notch), speed_mps) * full_n >= force_n:
            return float(notch)
    return float(highest)


@compiled
def own_deceleration_mps2(unit: UnitRow, train: TrainRow, path: NDArray[np.void], load_share: float) -> float:
    """What slows the train without any brake: gradient under it and running resistance, by the unit's own map."""
    here = path[path_index(unit, unit.position_m)]
    behind = path[path_index(unit, unit.position_m - train.length_m)]
    climb_m = here.elevation_m - behind.elevation_m
    gravity_share = GRAVITY_MPS2 / (1.0 + train.rotating_mass_factor)
    resistance = resistance_n(train, mass_kg(train, load_share), unit.speed_mps)
    slope_mps2 = gravity_share * climb_m / train.length_m
    return float(slope_mps2 + resistance / equivalent_mass_kg(train, load_share))


@compiled
def pattern_mps(unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void], position_m: float) -> float:
    """Speed to keep at a path coordinate by the limits: the driving curve, and well under the permitted speed.

    That one counts from where the front may be at the furthest, so with a wide bound it is the lower.
    """
    furthest_m = position_m + unit.bound_ahead_m + RESERVE_M
    permitted = path[path_index(unit, furthest_m)].permitted_mps - 2.0 * behaviour.service_margin_mps
    return float(max(min(path[path_index(unit, position_m)].driving_mps, permitted), 0.0))


@compiled
def target_speed_mps(unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void]) -> float:
    """Speed to hold between stations: under the limits ahead, the permitted speed and the cruising speed."""
    here = pattern_mps(unit, behaviour, path, unit.position_m)
    ahead = pattern_mps(unit, behaviour, path, unit.position_m + max(unit.speed_mps * LOOK_AHEAD_S, 1.0))
    target = min(here, ahead, unit.cruise_mps)
    target = min(target, unit.permitted_mps - behaviour.service_margin_mps)
    target = min(target, unit.restricted_mps - behaviour.driving_margin_mps)
    return float(max(target, 0.0))


@compiled
def overspeed_mps(unit: UnitRow, reaction_s: float) -> float:
    """How far above the target the train will be when the machinery answers, m/s; negative below."""
    return float(max(unit.speed_mps + unit.acceleration_mps2 * reaction_s, 0.0) - unit.target_mps)


@compiled
def curve_demand_mps2(
    unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void], over_mps: float
) -> float:
    """Acceleration (< 0) that follows the curve down to a lower limit; 0 where the train is not on one."""
    ahead_m = max(unit.speed_mps * LOOK_AHEAD_S, 1.0)
    here = pattern_mps(unit, behaviour, path, unit.position_m)
    ahead = pattern_mps(unit, behaviour, path, unit.position_m + ahead_m)
    falling = (here * here - ahead * ahead) / (2.0 * ahead_m)
    if falling <= 0.0 or here > unit.cruise_mps or over_mps <= -CURVE_BAND_MPS:
        return 0.0
    return float(min(-behaviour.cruise_gain_per_s * over_mps - falling, 0.0))


@compiled
def holding_notch(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    load_share: float,
    own_mps2: float,
    over_mps: float,
) -> float:
    """The notch that holds the target between stations: the speed swings between the notches either side of it.

    A rising train keeps a notch that is stronger than what slows it up to the band's upper edge, then one that
    is weaker down to the lower edge; the brake is for descents, from further above the target down to it.
    """
    if over_mps > BRAKE_OVERSPEED_MPS or (unit.notch < 0.0 and over_mps > 0.0):
        needed = own_mps2 - behaviour.cruise_gain_per_s * over_mps
        return service_notch(train, -needed) if needed < 0.0 else 0.0
    inertia_kg = equivalent_mass_kg(train, load_share)
    strongest_n = full_force_n(train, load_share, unit.speed_mps)
    present_n = notch_share(train, unit.notch, unit.speed_mps) * strongest_n if unit.notch > 0.0 else 0.0
    rising = unit.notch > 0.0 and present_n > own_mps2 * inertia_kg
    upper = HOLD_BAND_MPS if rising else -HOLD_BAND_MPS
    if over_mps < upper:
        wanted = behaviour.cruise_gain_per_s * max(-over_mps, 0.0)
        return power_notch(train, load_share, unit.speed_mps, (own_mps2 + wanted) * inertia_kg)
    weaker = power_notch(train, load_share, unit.speed_mps, own_mps2 * inertia_kg) - 1.0
    return max(weaker, 0.0)


@compiled
def drive(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    load_share: float,
    own_mps2: float,
    tasc: TascRow,
    design: DesignRow,
) -> None:
    """Choose this step's notch. `load_share` (0 empty, 1 full) is what the load sensor tells."""
    unit.emergency = 0
    if unit.mode != MODE_DRIVE:
        unit.target_mps = 0.0
        notch = -behaviour.standing_brake_notch
    else:
        unit.target_mps = target_speed_mps(unit, behaviour, path)
        over_mps = overspeed_mps(unit, train.brake_dead_time_s + train.brake_lag_s)
        demand_mps2 = -curve_demand_mps2(unit, behaviour, path, over_mps)
        stop_mps2 = stop_command_mps2(unit, tasc, design, own_mps2)
        if unit.braking_to_stop == 1 and unit.speed_mps == 0.0:
            notch = -behaviour.standing_brake_notch
        elif demand_mps2 > 0.0 or unit.braking_to_stop == 1:
            notch = service_notch(train, max(demand_mps2 - own_mps2, stop_mps2, 0.0))
        else:
            notch = holding_notch(unit, train, behaviour, load_share, own_mps2, over_mps)
        keeps = unit.notch > 0.0 and unit.notch_held_s < behaviour.notch_hold_s
        if keeps and notch >= 0.0 and over_mps < BRAKE_OVERSPEED_MPS and unit.braking_to_stop == 0:
            notch = unit.notch
    if unit.intervention != NO_INTERVENTION:
        notch = -train.brake_notches
        unit.emergency = 1 if unit.intervention == EMERGENCY_INTERVENTION else 0
    unit.notch_held_s = unit.notch_held_s + behaviour.step_s if notch == unit.notch else 0.0
    unit.notch = notch
