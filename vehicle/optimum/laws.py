"""The train's limits and resistance by speed, per equivalent mass, as a table that Newton's method can differentiate.

Cubic Hermite pieces on an even grid: value, slope and curvature belong together, and a corner of the true laws is
rounded within one step of the grid. What a run really costs is integrated with the true laws (`integrated`).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.adhesion import DRY, adhesion_coefficient
from vehicle.brakes import electric_brake_n
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg, mass_kg
from vehicle.records import TrainRow
from vehicle.resistance import resistance_n
from vehicle.traction import full_force_n, motored_grip_n

ALL_MOTORS: Final = 1.0
STEP_MPS: Final = 0.1
RESIST: Final = 0
PULL: Final = 1
ELECTRIC: Final = 2
LAWS: Final = 3


@compiled
def laws_at(train: TrainRow, load_share: float, speed_mps: float) -> tuple[float, float, float]:
    """Resistance on the level, greatest pull and greatest electric brake at a speed, N."""
    mass = mass_kg(train, load_share)
    grip_n = motored_grip_n(train, mass * GRAVITY_MPS2, adhesion_coefficient(train, DRY, speed_mps))
    pull_n = min(full_force_n(train, load_share, speed_mps), grip_n)
    electric_n = electric_brake_n(train, ALL_MOTORS, np.inf, grip_n, speed_mps)
    return resistance_n(train, mass, speed_mps), pull_n, electric_n


@compiled
def law_table(train: TrainRow, load_share: float, top_mps: float) -> NDArray[np.float64]:
    """Value and slope (by step) of each law at multiples of STEP_MPS to beyond `top_mps`: (speeds, LAWS, 2), m/s^2."""
    rows = int(top_mps / STEP_MPS) + 3
    inertia = equivalent_mass_kg(train, load_share)
    table = np.empty((rows, LAWS, 2))
    for i in range(rows):
        resist_n, pull_n, electric_n = laws_at(train, load_share, i * STEP_MPS)
        table[i, RESIST, 0] = resist_n / inertia
        table[i, PULL, 0] = pull_n / inertia
        table[i, ELECTRIC, 0] = electric_n / inertia
    for i in range(rows):
        below, above = max(i - 1, 0), min(i + 1, rows - 1)
        for law in range(LAWS):
            table[i, law, 1] = (table[above, law, 0] - table[below, law, 0]) / (above - below)
    return table


@compiled
def law_value(table: NDArray[np.float64], law: int, speed_mps: float) -> float:
    """A law at a speed, straight between the grid's points, m/s^2."""
    place = speed_mps / STEP_MPS
    i = min(int(place), len(table) - 2)
    below: float = table[i, law, 0]
    return below + (table[i + 1, law, 0] - below) * (place - i)


@compiled
def law_slopes(table: NDArray[np.float64], law: int, speed_mps: float) -> tuple[float, float, float]:
    """A law at a speed > 0 with its first two derivatives by z = v^2/2."""
    place = speed_mps / STEP_MPS
    i = min(int(place), len(table) - 2)
    u = place - i
    a, b = table[i, law, 0], table[i + 1, law, 0]
    p, q = table[i, law, 1], table[i + 1, law, 1]
    c2 = 3.0 * (b - a) - 2.0 * p - q
    c3 = 2.0 * (a - b) + p + q
    value = a + u * (p + u * (c2 + u * c3))
    first = (p + u * (2.0 * c2 + 3.0 * u * c3)) / STEP_MPS
    second = (2.0 * c2 + 6.0 * u * c3) / (STEP_MPS * STEP_MPS)
    by_z = first / speed_mps
    return value, by_z, (second - by_z) / (speed_mps * speed_mps)
