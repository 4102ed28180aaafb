"""The way of a run: what gradients are worth, the fastest run over it, and the mesh for the optimum."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg, mass_kg
from vehicle.optimum.laws import ELECTRIC, PULL, RESIST, law_value
from vehicle.records import TrainRow

Floats = NDArray[np.float64]
HALVINGS: Final = 3


class WayTable(NamedTuple):
    """A course per equivalent mass, for compiled code.

    `lift` is the mean height below the train times what lifting it by 1 m takes, m^2/s^2, at `at_m`; `drag` 1/m.
    """

    at_m: Floats
    lift: Floats
    limit: Floats  # of v^2/2, on each stretch
    drag: Floats  # further resistance over v^2, on each stretch
    brake_extra: float  # friction brake, m/s^2
    deceleration: float
    acceleration: float
    first: float  # v^2/2
    last: float


@compiled
def mean_lift(train: TrainRow, load_share: float, climb_m: Floats, at_m: Floats) -> Floats:
    """Mean height below the train with its front at each position, times its weight per equivalent mass, m^2/s^2.

    Its slope is the gradient's deceleration, mean over the train's length; the grid's ends continue level.
    """
    worth = GRAVITY_MPS2 * mass_kg(train, load_share) / equivalent_mass_kg(train, load_share)
    length = train.length_m
    top = len(climb_m) - 1
    # Summed from the start of the run: heights of the sea level would cost digits.
    total = np.empty(top + 1)
    total[0] = 0.0
    base: float = climb_m[0]
    for i in range(top):
        total[i + 1] = total[i] + 0.5 * (climb_m[i] + climb_m[i + 1]) - base
    lift = np.empty(len(at_m))
    for k in range(len(at_m)):
        both = 0.0
        for end in range(2):
            x = at_m[k] - end * length
            if x <= 0.0:
                area = 0.0
            elif x >= top:
                area = total[top] + (climb_m[top] - base) * (x - top)
            else:
                i = int(x)
                u = x - i
                rise = climb_m[i + 1] - climb_m[i]
                area = total[i] + u * (climb_m[i] - base + 0.5 * u * rise)
            both += area if end == 0 else -area
        lift[k] = worth * both / length
    return lift


@compiled
def fastest(table: Floats, way: WayTable) -> Floats:
    """v^2/2 of the fastest run at each of the way's points; nan where the train cannot get any further."""
    n = len(way.limit)
    best = np.empty(n + 1)
    best[0] = way.first
    for i in range(n):
        h = way.at_m[i + 1] - way.at_m[i]
        grade = (way.lift[i + 1] - way.lift[i]) / h
        mean = best[i]
        after = mean
        top = way.limit[i] if i + 1 >= n else min(way.limit[i], way.limit[i + 1])
        for _ in range(HALVINGS):
            speed = math.sqrt(2.0 * max(mean, 0.0))
            rate = law_value(table, PULL, speed) - law_value(table, RESIST, speed)
            rate = min(rate - way.drag[i] * speed * speed - grade, way.acceleration)
            after = best[i] + h * rate
            if rate >= 0.0 and best[i] >= top:  # held at the limit, as most of the way
                break
            mean = 0.5 * (best[i] + after)
        if after <= 0.0 and i + 1 < n:
            best[i + 1 :] = np.nan
            return best
        best[i + 1] = min(max(after, 0.0), top)
    back = min(way.last, best[n])
    best[n] = back
    for i in range(n - 1, -1, -1):
        h = way.at_m[i + 1] - way.at_m[i]
        grade = (way.lift[i + 1] - way.lift[i]) / h
        mean = back
        before = mean
        for _ in range(HALVINGS):
            speed = math.sqrt(2.0 * max(mean, 0.0))
            rate = law_value(table, ELECTRIC, speed) + way.brake_extra + law_value(table, RESIST, speed)
            rate = min(rate + way.drag[i] * speed * speed + grade, way.deceleration)
            before = back + h * rate
            if rate >= 0.0 and best[i] <= back:  # nothing to brake for
                break
            mean = 0.5 * (before + back)
        best[i] = min(best[i], max(before, 0.0))
        back = best[i]
    return best


@compiled
def times_s(at_m: Floats, z: Floats) -> Floats:
    """Time at each point of a run straight in z = v^2/2 between them."""
    found = np.zeros(len(z))
    for i in range(len(z) - 1):
        speeds = math.sqrt(2.0 * z[i]) + math.sqrt(2.0 * z[i + 1])
        found[i + 1] = found[i] + 2.0 * (at_m[i + 1] - at_m[i]) / speeds
    return found
