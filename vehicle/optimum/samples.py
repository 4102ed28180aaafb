"""A hop's energy over its running time from a few runs of each style, and from optima with their bounds."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from vehicle.optimum.bound import lower_bound_j
from vehicle.optimum.coast import coast_run, cruise_run
from vehicle.optimum.course import Course, Optimum, Profile
from vehicle.optimum.pareto import HopCurve, ParetoPoint, curve_of
from vehicle.optimum.solve import least_energy

STRETCHES: Final = (
    1.01,
    1.03,
    1.06,
    1.1,
    1.16,
    1.25,
    1.4,
    1.7,
)  # of the least time: denser where prices fall fast


def optimal_points(
    course: Course,
    least_s: float,
    stretches: Iterable[float] = STRETCHES,
    *,
    proven: bool = False,
    points: int = 300,
) -> tuple[ParetoPoint, ...]:
    """Runs of least energy at these multiples of the least time; `proven`: each with its bound, which takes longer."""
    found: list[ParetoPoint] = []
    warm: Optimum | None = None
    for stretch in stretches:
        time_s = stretch * least_s
        warm = least_energy(course, time_s, points, warm)
        bound_j = lower_bound_j(course, warm, time_s) if proven else -math.inf
        found.append(ParetoPoint(time_s, warm.energy_j, warm.price_w, bound_j))
    return tuple(found)


def optimal_curve(course: Course, fastest: Profile, points: int = 150) -> HopCurve:
    """The curve of the optimum, its least time that of the `fastest` run, from as many solutions as STRETCHES has."""
    least_s = float(fastest.time_s[-1])
    found = optimal_points(course, least_s, points=points)
    return curve_of((*found, _at_least_time(course, least_s)))


def coast_curve(course: Course, fastest: Profile) -> HopCurve:
    """The same for runs that shut off once."""
    least_s = float(fastest.time_s[-1])
    runs = (coast_run(course, stretch * least_s) for stretch in (1.0, *STRETCHES))
    return curve_of(ParetoPoint(run.time_s, run.energy_j, math.nan) for run in runs)


def cruise_curve(course: Course, fastest: Profile) -> HopCurve:
    """The same for runs that hold one speed."""
    least_s = float(fastest.time_s[-1])
    runs = (cruise_run(course, stretch * least_s) for stretch in (1.0, *STRETCHES))
    return curve_of(ParetoPoint(run.time_s, run.energy_j, math.nan) for run in runs)


def _at_least_time(course: Course, least_s: float) -> ParetoPoint:
    run = cruise_run(course, least_s)
    return ParetoPoint(run.time_s, run.energy_j, math.nan)
