"""The train's laws as bounds on cells of speed, for the proven bound: each is below its chord, or by how much above.

A cell runs from one speed to the next; the speeds contain every corner of the laws (force to power, weak field, fade
of the electric brake, points of a measured curve, the end of the starting resistance), so between them a law is one
formula. The greatest pull and the greatest electric brake are each the lesser of what motors and rail give; either
alone is an upper bound, and the one that is lower amid the cell is taken.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.adhesion import DRY, adhesion_coefficient
from vehicle.brakes import regenerative_limit_n
from vehicle.compiled import compiled
from vehicle.losses import flux_share
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg, mass_kg
from vehicle.optimum.costs import SLOWEST_MPS as SLOWEST_COST_MPS
from vehicle.optimum.costs import cost_terms
from vehicle.records import TrainRow
from vehicle.resistance import KMH_PER_MPS, STARTING_BAND_KMH, resistance_n
from vehicle.traction import full_force_n, motored_grip_n

Floats = NDArray[np.float64]

SLOWEST_MPS: Final = 0.002
RATIO: Final = 1.05  # of neighbouring speeds, up to where they are COARSE_MPS apart
COARSE_MPS: Final = 0.1


class Cells(NamedTuple):
    """Speeds, and per cell upper bounds of the laws at both ends, per equivalent mass, straight between them."""

    speed: Floats
    resist: Floats  # at the speeds
    curving: float  # second derivative of the resistance by speed, at most
    pull: Floats  # (cells, 2)
    electric: Floats  # (cells, 2)
    cost: Floats  # per cell: least slope, greatest gain, greatest bend, least curve, least idle (`costs`)


def corners_mps(train: Any, load_share: float, limits_mps: Floats) -> Floats:  # noqa: ANN401 - a record of TRAIN
    """Every speed at which a law changes its formula, and the limits, so that no cell reaches beyond one."""
    top = float(limits_mps.max())
    figures = [name for name in train.dtype.names if train.dtype[name] == np.float64]
    row = {name: float(train[name]) for name in figures}
    force = row["traction_force_max_n"]
    if row["traction_load_compensated"] > 0.0:
        force *= mass_kg(train, load_share) / row["mass_empty_kg"]
    power, weak = row["traction_power_max_w"], row["traction_weak_field_speed_mps"]
    found = [
        STARTING_BAND_KMH / KMH_PER_MPS,
        weak,
        row["regenerative_fade_from_mps"],
        row["regenerative_fade_to_mps"],
    ]
    if force > 0.0:
        found += [power / force, math.sqrt(power * weak / force)]
    if row["regenerative_force_max_n"] > 0.0:
        found.append(row["regenerative_power_max_w"] / row["regenerative_force_max_n"])
    if row["losses_given"] > 0.0:
        found.append(row["loss_base_speed_mps"])
        found.append(SLOWEST_COST_MPS)
    curve = np.arange(row["traction_curve_points"]) * row["traction_curve_step_mps"]
    even_from = COARSE_MPS / (RATIO - 1.0)
    steps = math.ceil(math.log(even_from / SLOWEST_MPS) / math.log(RATIO))
    fine = even_from * RATIO ** -np.arange(0.0, steps + 1.0)
    coarse = np.arange(even_from, top, COARSE_MPS)
    speeds = np.unique(np.concatenate(([0.0], found, curve, fine, coarse, limits_mps)))
    return speeds[(speeds >= 0.0) & (speeds <= top)]


@compiled
def cells_of(train: TrainRow, load_share: float, speed: Floats) -> Cells:
    """The cells between these speeds."""
    n = len(speed) - 1
    mass = mass_kg(train, load_share)
    inertia = equivalent_mass_kg(train, load_share)
    resist = np.empty(n + 1)
    force, brake, grip = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    for j in range(n + 1):
        v = speed[j]
        resist[j] = resistance_n(train, mass, v) / inertia
        force[j] = full_force_n(train, load_share, v) / inertia
        brake[j] = regenerative_limit_n(train, v) / inertia
        adhesion = adhesion_coefficient(train, DRY, v)
        grip[j] = motored_grip_n(train, mass * GRAVITY_MPS2, adhesion) / inertia
    pull, electric = np.empty((n, 2)), np.empty((n, 2))
    from_mps, to_mps = train.regenerative_fade_from_mps, train.regenerative_fade_to_mps
    for j in range(n):
        # Fading at constant power is the one formula that lies above its chord.
        bump = 0.0
        if brake[j + 1] > 0.0 and speed[j] < from_mps:
            h = speed[j + 1] - speed[j]
            bend = 2.0 * train.regenerative_power_max_w * to_mps / (from_mps - to_mps) / speed[j] ** 3
            bump = bend / inertia * h * h / 8.0
        for end in range(2):
            pull[j, end] = force[j + end]
            electric[j, end] = brake[j + end] + bump
        slip = grip[j] + grip[j + 1]
        if slip < force[j] + force[j + 1]:
            pull[j, 0], pull[j, 1] = grip[j], grip[j + 1]
        if slip < brake[j] + brake[j + 1] + 2.0 * bump:
            electric[j, 0], electric[j, 1] = grip[j], grip[j + 1]
    curving = 2.0 * train.resistance.air_n_per_kmh2 * KMH_PER_MPS * KMH_PER_MPS / inertia
    return Cells(speed, resist, curving, pull, electric, cost_bounds(train, load_share, speed))


@compiled
def cost_bounds(train: TrainRow, load_share: float, speed: Floats) -> Floats:
    """The costs on each cell, each at its cheapest; between corners each is a sum of terms that only rise or only fall.

    Slope falls with the speed and gain rises: the loss by force does not grow with the speed, nor does the no-load
    loss times the copper's. Bend and curve are single terms of the flux. Idle is taken term by term.
    """
    n = len(speed) - 1
    found = np.empty((n, 5))
    below, above = np.empty(5), np.empty(5)
    inertia = equivalent_mass_kg(train, load_share)
    for j in range(n):
        # At a stand a force by metre costs without end: the first cell is as its upper speed.
        v = speed[j] if j > 0 else speed[1]
        below[0], below[1], below[2], below[3], below[4] = cost_terms(train, load_share, v)
        above[0], above[1], above[2], above[3], above[4] = cost_terms(train, load_share, speed[j + 1])
        found[j, 0] = min(below[0], above[0])
        found[j, 1] = max(below[1], above[1])
        found[j, 2] = max(below[2], above[2])
        found[j, 3] = min(below[3], above[3])
        found[j, 4] = 0.0
        if above[4] > 0.0:
            found[j, 4] = least_idle(train, inertia, v, speed[j + 1])
    return found


@compiled
def least_idle(train: TrainRow, inertia_kg: float, low_mps: float, high_mps: float) -> float:
    """What magnetised motors lose by metre without a force, each term at its least between two speeds, m/s^2."""
    total = 0.0
    for term in range(4):
        least = math.inf
        for end in range(2):
            v = low_mps if end == 0 else high_mps
            flux, u = flux_share(train, v), v / train.loss_base_speed_mps
            turning = (train.loss_magnetising_w, u * train.loss_hysteresis_w, u * u * train.loss_eddy_w)
            lost_w = train.loss_standby_w if term == 3 else flux * flux * turning[term]
            least = min(least, lost_w / v)
        total += least
    return train.motors * total / inertia_kg
