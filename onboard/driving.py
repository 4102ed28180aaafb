"""Automatic driving between stations with notches, and the stop at the mark (ATO and TASC, 定位置停止制御).

Between stations the notch holds the cruising speed that the timetable asks for. At the station a target-speed
pattern v = sqrt(2*b*distance) is followed by proportional control of the brake (Oda, section 2.1, 2 and 3), on
speed and distance predicted over the brake's dead time and lag. Gradient and running resistance are taken off
the brake demand, since the train's own brake control is calibrated on the level.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from onboard.records import EMERGENCY_INTERVENTION, MODE_DRIVE, NO_INTERVENTION
from onboard.rows import BehaviourRow, UnitRow
from onboard.supervision import path_index
from vehicle.brakes import service_notch
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg, mass_kg
from vehicle.resistance import resistance_n
from vehicle.rows import TrainRow
from vehicle.traction import full_force_n, notch_share

OVERSHOT_M = 0.02  # this near the mark the pattern has no slope left to follow
LEAST_BRAKE_MPS2 = 0.02
LOOK_AHEAD_S = 1.0
BRAKE_OVERSPEED_MPS = 0.15  # between stations the brake is left alone below this
COAST_BAND_MPS = 0.5


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
def stop_demand_mps2(unit: UnitRow, behaviour: BehaviourRow, reaction_s: float) -> float:
    """Deceleration wanted of the train to stop at the target, from the state predicted over the reaction time.

    Negative while the target-speed pattern has not been reached.
    """
    speed = unit.speed_mps
    change = unit.acceleration_mps2
    if unit.braking_to_stop == 0:
        change = min(change, 0.0)
    later_s = reaction_s
    if change < 0.0:
        later_s = min(reaction_s, speed / -change)
    predicted = max(speed + change * later_s, 0.0)
    distance_m = unit.target_stop_m - unit.position_m - (speed + predicted) / 2.0 * later_s
    design = behaviour.stop_deceleration_mps2
    if distance_m <= OVERSHOT_M:
        return 2.0 * design if predicted > 0.05 else design
    error = predicted - math.sqrt(2.0 * design * distance_m)
    if unit.braking_to_stop == 0 and error < 0.0:
        return -1.0
    return max(design + behaviour.stop_gain_per_s * error, LEAST_BRAKE_MPS2)


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
def target_speed_mps(unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void]) -> float:
    """Speed to hold between stations: under the limits ahead, the permitted speed and the cruising speed."""
    here = path[path_index(unit, unit.position_m)]
    ahead_m = max(unit.speed_mps * LOOK_AHEAD_S, 1.0)
    ahead = path[path_index(unit, unit.position_m + ahead_m)]
    target = min(here.driving_mps, ahead.driving_mps, unit.cruise_mps)
    target = min(target, unit.permitted_mps - behaviour.service_margin_mps)
    target = min(target, unit.restricted_mps - behaviour.driving_margin_mps)
    return float(max(target, 0.0))


@compiled
def wanted_acceleration_mps2(
    unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void], reaction_s: float
) -> float:
    """Acceleration (m/s^2) that brings the train to the target speed, and down the curve where that falls."""
    predicted = max(unit.speed_mps + unit.acceleration_mps2 * reaction_s, 0.0)
    over = predicted - unit.target_mps
    wanted = -behaviour.cruise_gain_per_s * over
    here = path[path_index(unit, unit.position_m)]
    ahead_m = max(unit.speed_mps * LOOK_AHEAD_S, 1.0)
    ahead = path[path_index(unit, unit.position_m + ahead_m)]
    falling = (here.driving_mps**2 - ahead.driving_mps**2) / (2.0 * ahead_m)
    if here.driving_mps <= unit.cruise_mps and falling > 0.0 and over > -COAST_BAND_MPS:
        wanted -= falling
    if -COAST_BAND_MPS < over < BRAKE_OVERSPEED_MPS and wanted < 0.0 and unit.braking_to_stop == 0:
        wanted = max(wanted, -falling) if falling > 0.0 else 0.0
    return float(wanted)


@compiled
def drive(
    unit: UnitRow, train: TrainRow, behaviour: BehaviourRow, path: NDArray[np.void], load_share: float
) -> None:
    """Choose this step's notch. `load_share` (0 empty, 1 full) is what the load sensor tells."""
    unit.emergency = 0
    if unit.mode != MODE_DRIVE:
        unit.target_mps = 0.0
        notch = -behaviour.standing_brake_notch
    else:
        reaction_s = train.brake_dead_time_s + train.brake_lag_s
        unit.target_mps = target_speed_mps(unit, behaviour, path)
        stop_mps2 = stop_demand_mps2(unit, behaviour, reaction_s)
        if stop_mps2 >= 0.0 and unit.speed_mps > 0.0:
            unit.braking_to_stop = 1
        wanted = wanted_acceleration_mps2(unit, behaviour, path, reaction_s)
        if stop_mps2 >= 0.0:
            wanted = min(wanted, -stop_mps2)
        effort = wanted + own_deceleration_mps2(unit, train, path, load_share)
        if wanted < 0.0 and effort < 0.0:
            notch = service_notch(train, -effort)
        elif unit.braking_to_stop == 1 or (wanted < 0.0 and unit.speed_mps > unit.target_mps):
            notch = 0.0
        else:
            force_n = effort * equivalent_mass_kg(train, load_share)
            notch = power_notch(train, load_share, unit.speed_mps, force_n)
        keeps = unit.notch > 0.0 and unit.notch_held_s < behaviour.notch_hold_s
        if keeps and notch > 0.0 and unit.speed_mps < unit.target_mps:
            notch = unit.notch
    if unit.intervention != NO_INTERVENTION:
        notch = -train.brake_notches
        unit.emergency = 1 if unit.intervention == EMERGENCY_INTERVENTION else 0
    unit.notch_held_s = unit.notch_held_s + behaviour.step_s if notch == unit.notch else 0.0
    unit.notch = notch
