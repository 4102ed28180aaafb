"""A proven bound of the least time: what no run of a course can be faster than."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from vehicle.optimum.bound import ceilings
from vehicle.optimum.course import Course
from vehicle.optimum.laws import PULL
from vehicle.optimum.mesh import laid_course
from vehicle.optimum.way import WayTable

Floats = NDArray[np.float64]


def least_time_bound_s(course: Course) -> float:
    """No run of the course is faster, s. ValueError where the train cannot get to the stop."""
    found = laid_course(course)
    pull_most = float(found.table[:, PULL, 0].max())
    return float(time_under_s(found.way, ceilings(found.way, found.table), pull_most))


@compiled
def time_under_s(way: WayTable, most: Floats, pull_most: float) -> float:
    """Time of the line that is above every run: up from each point at the greatest rate, down to the next."""
    total = 0.0
    for i in range(len(way.limit)):
        h = way.at_m[i + 1] - way.at_m[i]
        grade = (way.lift[i + 1] - way.lift[i]) / h
        rise = max(min(way.acceleration, pull_most - grade), 0.0)
        z, after = most[i], most[i + 1]
        # Where the two lines meet; the limit is left out, which makes it faster still.
        meet = min(max((after + way.deceleration * h - z) / (rise + way.deceleration), 0.0), h)
        top = math.sqrt(2.0 * min(z + rise * meet, after + way.deceleration * (h - meet)))
        total += 2.0 * meet / (math.sqrt(2.0 * z) + top) if meet > 0.0 else 0.0
        total += 2.0 * (h - meet) / (math.sqrt(2.0 * after) + top) if meet < h else 0.0
    return total
