"""A hop's energy over its running time from a few runs of a style."""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from typing import Final

from vehicle.optimum.coast import coast_on, cruise_on, fastest_j
from vehicle.optimum.course import Course, TooShort
from vehicle.optimum.mesh import CourseOnMesh, laid_course, places_m
from vehicle.optimum.pareto import HopCurve, ParetoPoint, curve_of
from vehicle.optimum.solve import optimum_of

# of the least time: denser where prices fall fast
STRETCHES: Final = (1.01, 1.03, 1.06, 1.1, 1.16, 1.25, 1.4, 1.7)
FEW: Final = (1.02, 1.06, 1.14, 1.3, 1.7)  # as many as a unit has time for
POINTS: Final = 150


def optimal_curve(course: Course, stretches: Iterable[float] = FEW) -> HopCurve:
    """The optimum's energies at these multiples of the least time; at that itself, the fastest run's."""
    found = laid_course(course)
    at_m = places_m(found, POINTS)
    points = [_fastest(found)]
    for stretch in stretches:
        with suppress(TooShort):  # so near to the least time that the mesh has no run
            best = optimum_of(found, stretch * found.least_s, at_m)
            points.append(ParetoPoint(stretch * found.least_s, best.energy_j, best.price_w))
    return curve_of(points)


def coast_curve(course: Course, stretches: Iterable[float] = FEW) -> HopCurve:
    """The same for runs that shut off once."""
    found = laid_course(course)
    runs = (coast_on(found, stretch * found.least_s) for stretch in stretches)
    return curve_of([_fastest(found), *(ParetoPoint(run.time_s, run.energy_j, math.nan) for run in runs)])


def cruise_curve(course: Course, stretches: Iterable[float] = FEW) -> HopCurve:
    """The same for runs that hold one speed."""
    found = laid_course(course)
    runs = (cruise_on(found, stretch * found.least_s) for stretch in stretches)
    return curve_of([_fastest(found), *(ParetoPoint(run.time_s, run.energy_j, math.nan) for run in runs)])


def _fastest(found: CourseOnMesh) -> ParetoPoint:
    return ParetoPoint(found.least_s, fastest_j(found), math.nan)
