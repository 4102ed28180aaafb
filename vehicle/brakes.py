"""Brake notch to deceleration (ブレーキ), and how much of it the motors supply (回生ブレーキ). SI units."""

from __future__ import annotations

import math

from vehicle.compiled import compiled
from vehicle.records import TrainRow


@compiled
def service_target_mps2(train: TrainRow, notch: float) -> float:
    """Deceleration that a service notch settles at (`notch` < 0), m/s^2, on level track without resistance.

    Load compensation (応荷重) holds it at any load. With a stepless brake a fraction lies between its
    neighbours; else it counts as the stronger notch, the safe one. Beyond the last notch nothing is added.
    """
    depth = min(-notch, train.brake_notches)
    if depth <= 0.0:
        return 0.0
    if train.brake_stepless <= 0.0:
        return train.brake_deceleration_mps2[math.ceil(depth - 1e-9)]
    index = min(int(depth), int(train.brake_notches) - 1)
    below = train.brake_deceleration_mps2[index]
    return below + (train.brake_deceleration_mps2[index + 1] - below) * (depth - index)


@compiled
def service_notch(train: TrainRow, deceleration_mps2: float) -> float:
    """Inverse of `service_target_mps2`: the notch (<= 0) for a deceleration, at most the last one.

    Without a stepless brake, the weakest notch that gives at least that deceleration.
    """
    if deceleration_mps2 <= 0.0:
        return 0.0
    last = int(train.brake_notches)
    for index in range(1, last + 1):
        above = train.brake_deceleration_mps2[index]
        if above >= deceleration_mps2 - 1e-9:
            if train.brake_stepless <= 0.0:
                return -float(index)
            below = train.brake_deceleration_mps2[index - 1]
            return -(index - 1 + min(1.0, (deceleration_mps2 - below) / (above - below)))
    return -float(last)


@compiled
def regenerative_limit_n(train: TrainRow, speed_mps: float) -> float:
    """Largest electric brake force, N: force limit, power limit, faded to nothing between two speeds."""
    force = train.regenerative_force_max_n
    power = train.regenerative_power_max_w
    if force * speed_mps > power:
        force = power / speed_mps
    fade_from = train.regenerative_fade_from_mps
    fade_to = train.regenerative_fade_to_mps
    if speed_mps <= fade_to:
        return 0.0
    if speed_mps < fade_from:
        force *= (speed_mps - fade_to) / (fade_from - fade_to)
    return force


@compiled
def electric_brake_n(
    train: TrainRow, motors_share: float, brake_n: float, grip_n: float, speed_mps: float
) -> float:
    """What the motors take of a brake force at the rim, N; air supplies the rest (電空協調).

    They brake driven axles alone, so no more than `grip_n`, which the rail passes on to those; `motors_share` of
    them is in service.
    """
    return min(brake_n, motors_share * regenerative_limit_n(train, speed_mps), motors_share * grip_n)
