"""What a train can pull at a speed, and what its way sets against it: the balance that decides whether it gets on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vehicle.adhesion import adhesion_coefficient
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2, mass_kg
from vehicle.records import TrainRow
from vehicle.resistance import gradient_force_n, resistance_n
from vehicle.traction import full_force_n, motored_grip_n


@compiled
def grip_n(train: TrainRow, load_share: float, adhesion_factor: float, speed_mps: float) -> float:
    """What the rail passes on to all driven axles at a speed, N."""
    weight_n = mass_kg(train, load_share) * GRAVITY_MPS2
    return motored_grip_n(train, weight_n, adhesion_coefficient(train, adhesion_factor, speed_mps))


@compiled
def full_pull_n(
    train: TrainRow, load_share: float, motors_share: float, adhesion_factor: float, speed_mps: float
) -> float:
    """Most pull at a speed, N, with `motors_share` of the motors: what the plant settles at, at full notch."""
    rail_n = grip_n(train, load_share, adhesion_factor, speed_mps)
    return motors_share * min(full_force_n(train, load_share, speed_mps), rail_n)


@compiled
def held_back_n(
    train: TrainRow, load_share: float, climb_m: NDArray[np.float64], front_m: float, speed_mps: float
) -> float:
    """What resistance, gradient and curves set against a train at a place, N; `climb_m` as for `mean_gradient`."""
    mass = mass_kg(train, load_share)
    gradient = mean_gradient_permille(climb_m, front_m, train.length_m)
    return resistance_n(train, mass, speed_mps) + gradient_force_n(mass, gradient)


@compiled
def mean_gradient_permille(climb_m: NDArray[np.float64], front_m: float, length_m: float) -> float:
    """Mean gradient below the train, permille; the ends of the grid of metres continue level."""
    top = len(climb_m) - 1
    front = min(max(front_m, 0.0), float(top))
    rear = min(max(front_m - length_m, 0.0), float(top))
    i = min(int(front), top - 1)
    j = min(int(rear), top - 1)
    high: float = climb_m[i] + (climb_m[i + 1] - climb_m[i]) * (front - i)
    low: float = climb_m[j] + (climb_m[j + 1] - climb_m[j]) * (rear - j)
    return (high - low) / length_m * 1e3
