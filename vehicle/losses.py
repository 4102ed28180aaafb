"""What motors, inverters and gears lose (損失), and how many motors run (電動機高効率点制御). SI units.

One motor with its share of inverter and gear, at the force f at the rim and the speed v loses

    standby + flux^2 (magnetising + hysteresis u + eddy u^2) + inverter x / flux + copper (x / flux)^2 + gear |f| v

with u = v / base speed, x = |f| / reference force, and flux = 1 up to the base speed, base speed / v above it. The
first two terms are the no-load loss, what a magnetised motor takes without a force. It is linear in its coefficients,
so measured losses give them by least squares; each is a loss in W at full flux, base speed or reference force; none is
negative, so no force comes out at more than 100 %, and braking makes no energy; it is smooth in v and convex in f.
Bearings and windage are in the running resistance, which is measured with motors that turn.

Running only as many motors as are needed, at their efficient point, is what Oda names in chapter 1 (figures 2 and 3).
The rule there is the least number that overcomes the resistance; here it is the number that loses least, which is
the same where the no-load loss outweighs the copper.
"""

from __future__ import annotations

import math

from vehicle.brakes import regenerative_limit_n
from vehicle.compiled import compiled
from vehicle.records import TrainRow
from vehicle.traction import full_force_n


@compiled
def flux_share(train: TrainRow, speed_mps: float) -> float:
    """Flux of a motor, of the full one."""
    base_mps = train.loss_base_speed_mps
    return 1.0 if speed_mps <= base_mps else base_mps / speed_mps


@compiled
def no_load_w(train: TrainRow, speed_mps: float) -> float:
    """What one magnetised motor loses without a force, W."""
    flux, u = flux_share(train, speed_mps), speed_mps / train.loss_base_speed_mps
    turning_w = u * (train.loss_hysteresis_w + u * train.loss_eddy_w)
    return train.loss_standby_w + flux * flux * (train.loss_magnetising_w + turning_w)


@compiled
def copper_w(train: TrainRow, force_n: float, speed_mps: float) -> float:
    """Loss in the copper, W, if one motor alone gave the force; n motors lose an nth of it."""
    x = force_n / (train.loss_force_n * flux_share(train, speed_mps))
    return train.loss_copper_w * x * x


@compiled
def motors_needed(train: TrainRow, force_n: float, speed_mps: float, grip_n: float) -> float:
    """How many motors a force takes at least: by the force of a motor, and by the grip of its axle.

    `grip_n` is what the rail passes on to all driven axles; not a whole number.
    """
    most_n = full_force_n(train, 1.0, speed_mps) if force_n > 0.0 else regenerative_limit_n(train, speed_mps)
    most_n = min(most_n, grip_n)
    return train.motors * abs(force_n) / most_n if most_n > 0.0 else train.motors


@compiled
def running_motors(
    train: TrainRow, motors_share: float, force_n: float, speed_mps: float, grip_n: float
) -> float:
    """How many motors are magnetised: all in service, or where the equipment cuts motors out, those that lose least."""
    in_service = motors_share * train.motors
    if force_n == 0.0:
        coasts_without = train.motors_cut_out > 0.0 or train.magnetised_coasting <= 0.0
        return 0.0 if coasts_without or speed_mps <= 0.0 else in_service
    whole = float(math.floor(in_service + 1e-9))
    if train.motors_cut_out <= 0.0 or whole <= 1.0:
        return in_service
    idle_w = no_load_w(train, speed_mps)
    burnt_w = copper_w(train, force_n, speed_mps)
    # n idle + burnt / n is least at one of the whole numbers around the root: at n while burnt <= n (n + 1) idle.
    least = float(math.floor(math.sqrt(burnt_w / idle_w)) if idle_w > 0.0 else whole)
    if burnt_w > least * (least + 1.0) * idle_w:
        least += 1.0
    needed = float(math.ceil(motors_needed(train, force_n, speed_mps, grip_n) - 1e-9))
    return min(max(least, needed, 1.0), whole)


@compiled
def losses_w(train: TrainRow, running: float, force_n: float, speed_mps: float) -> float:
    """What `running` motors lose together at a force of the whole train, W."""
    if running <= 0.0:
        return 0.0
    pull_n = abs(force_n)
    current = pull_n / (train.loss_force_n * flux_share(train, speed_mps))
    return (
        running * no_load_w(train, speed_mps)
        + train.loss_inverter_w * current
        + copper_w(train, pull_n, speed_mps) / running
        + train.loss_gear_share * pull_n * speed_mps
    )
