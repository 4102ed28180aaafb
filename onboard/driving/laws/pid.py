"""Follow a target-speed pattern by PID: what automatic train operation did before anything was predicted (ATO).

The pattern (目標速度パターン) is the lowest of the limits, the cruising speed and the parabola of constant deceleration
to the mark. What is off it is fed back in proportion, summed and by its change; the demand, an acceleration, becomes
the nearest notch, power or brake. It knows neither gradient nor running resistance: the sum learns them on the way.
Yasunobu, Miyamoto and Ihara compare theirs with such a one (6.2: 一定減速度で変化する目標速度パターン追従方式).
"""

from __future__ import annotations

from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray

from network.files.kinds import about
from network.files.quantities import (
    AccelerationBand,
    DerivativeGain,
    Gain,
    IntegralGain,
    Lag,
    SpeedMarginMps,
    Wait,
)
from network.files.toml_input import Record
from onboard.driving.laws.cue import CueRow
from onboard.records import BehaviourRow, UnitRow
from vehicle.brakes import service_notch, service_target_mps2
from vehicle.compiled import compiled, compiled_when_called
from vehicle.mass import equivalent_mass_kg
from vehicle.records import TrainRow
from vehicle.traction import full_force_n, notch_share

TUNED = "papers.pid_tuning: least ITAE in the nominal case of Yasunobu and others"


TUNED_ANSWER_S = 0.8  # dead time and lag of brake and power of the train that they are tuned on


class Pid(Record):
    """`[law.pid]`: gains of the feedback, and how its demand becomes notches."""

    gain_per_s: Annotated[Gain, about("acceleration demanded for each m/s off the pattern", TUNED)] = 1.4
    integral_gain_per_s2: Annotated[
        IntegralGain, about("the same for the integral of the deviation; 0: no integral", TUNED)
    ] = 0.1
    derivative_gain: Annotated[
        DerivativeGain, about("the same for the change of the deviation; 0: no derivative", TUNED)
    ] = 0.8
    derivative_lag_s: Annotated[
        Lag, about("time constant of the change's smoothing", "assumed: three readings of the tachometer")
    ] = 0.3
    brake_above_mps: Annotated[
        SpeedMarginMps,
        about(
            "at a constant target, no braking until the speed exceeds it by this",
            "assumed: 1.8 km/h, as for every law",
        ),
    ] = 0.5
    dead_band_mps2: Annotated[
        AccelerationBand,
        about(
            "a notch is kept while its deceleration or acceleration is this near the demand",
            "assumed: half a brake notch",
        ),
    ] = 0.08
    notch_hold_s: Annotated[
        Wait, about("a moving train's notch is kept at least this long", "assumed: what switchgear needs")
    ] = 0.5


class PidRow(Protocol):
    """What this law keeps."""

    settings: Pid
    stops: Annotated[int, "1: the pattern is that of the stop"]
    error_mps: Annotated[float, "pattern less speed, at the last step"]
    integral_m: Annotated[float, "its sum over time"]
    change_mps2: Annotated[float, "its change, smoothed"]
    wanted_mps2: Annotated[float, "the demand: acceleration, negative to brake"]


@compiled_when_called
def pid(
    own: PidRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    plan: NDArray[np.void],
) -> float:
    """The notch that follows the target-speed pattern."""
    even_mps = min(cue.limit_mps, unit.cruise_mps)
    left_m = max(unit.target_stop_m - unit.position_m, 0.0)
    stop_mps = np.sqrt(2.0 * behaviour.settings.stop_deceleration_mps2 * left_m)
    stops = stop_mps < even_mps
    cue.ceiling_mps = min(stop_mps, unit.cruise_mps)
    feed_back(own, unit, min(stop_mps, even_mps) - unit.train_mps, int(stops), behaviour.step_s)
    quick = TUNED_ANSWER_S / answer_s(train, int(stops))
    demand_mps2 = quick * own.settings.gain_per_s * own.error_mps
    demand_mps2 += own.settings.derivative_gain * own.change_mps2
    demand_mps2 += quick * quick * own.settings.integral_gain_per_s2 * own.integral_m
    if stops:
        demand_mps2 -= behaviour.settings.stop_deceleration_mps2
    inertia_kg = equivalent_mass_kg(train, cue.load_share)
    most_mps2 = full_force_n(train, cue.load_share, unit.speed_mps) / inertia_kg
    least_mps2 = -service_target_mps2(train, -train.brake_notches)
    leaves_brake = not stops and demand_mps2 < 0.0 and own.error_mps > -own.settings.brake_above_mps
    # No winding up: nothing is summed while the train cannot, or may not, give what is asked for.
    if least_mps2 < demand_mps2 < most_mps2 and not leaves_brake:
        own.integral_m += own.error_mps * behaviour.step_s
    if leaves_brake:
        demand_mps2 = 0.0
    own.wanted_mps2 = min(max(demand_mps2, least_mps2), most_mps2)
    return notch_for(own, unit, train, most_mps2)


@compiled
def answer_s(train: TrainRow, stops: int) -> float:
    """Until what is asked for is there, s: dead time and lag of the brake at a stop, else of what answers later."""
    brake_s = train.brake_dead_time_s + train.brake_lag_s
    power_s = train.traction_dead_time_s + train.traction_lag_s
    return float(brake_s if stops == 1 else max(brake_s, power_s))


@compiled
def feed_back(own: PidRow, unit: UnitRow, error_mps: float, stops: int, step_s: float) -> None:
    """Take up what the speed is off the pattern now; at a stand, and where the pattern changes, all begins anew."""
    if unit.speed_mps == 0.0 or stops != own.stops:
        own.stops = stops
        own.integral_m = own.change_mps2 = 0.0
    else:
        share = step_s / (own.settings.derivative_lag_s + step_s)
        own.change_mps2 += share * ((error_mps - own.error_mps) / step_s - own.change_mps2)
    own.error_mps = error_mps


@compiled
def notch_for(own: PidRow, unit: UnitRow, train: TrainRow, most_mps2: float) -> float:
    """The notch nearest to the demand: kept while it is near enough, and power and brake change over by way of 0.

    `most_mps2` is what full power gives at this speed.
    """
    now = unit.notch
    given_mps2 = notch_share(train, now, unit.speed_mps) * most_mps2 - service_target_mps2(train, now)
    if abs(own.wanted_mps2 - given_mps2) <= own.settings.dead_band_mps2:
        return now
    if unit.speed_mps > 0.0 and unit.notch_held_s < own.settings.notch_hold_s:
        return now
    if own.wanted_mps2 * now < 0.0:
        return 0.0
    if own.wanted_mps2 < 0.0:
        return nearest_brake(train, -own.wanted_mps2)
    return nearest_power(train, own.wanted_mps2, most_mps2, unit.speed_mps)


@compiled
def nearest_power(train: TrainRow, wanted_mps2: float, most_mps2: float, speed_mps: float) -> float:
    """The power notch, 0 among them, whose acceleration at this speed is nearest to the demand."""
    nearest, off_mps2 = 0.0, wanted_mps2
    for notch in range(1, int(train.power_notches) + 1):
        beside_mps2 = abs(notch_share(train, float(notch), speed_mps) * most_mps2 - wanted_mps2)
        if beside_mps2 < off_mps2:
            nearest, off_mps2 = float(notch), beside_mps2
    return nearest


@compiled
def nearest_brake(train: TrainRow, wanted_mps2: float) -> float:
    """The brake notch, 0 among them, whose deceleration is nearest to the demand; a stepless brake gives just that."""
    stronger = service_notch(train, wanted_mps2)
    if train.brake_stepless > 0.0 or stronger == 0.0:
        return stronger
    weaker = stronger + 1.0
    middle_mps2 = (service_target_mps2(train, stronger) + service_target_mps2(train, weaker)) / 2.0
    return stronger if wanted_mps2 >= middle_mps2 else weaker
