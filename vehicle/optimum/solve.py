"""Least time and least energy."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.optimum.course import Course, NotFound, Optimum, Profile, TooShort
from vehicle.optimum.interior import follow_path, forces_and_energy, starting_slacks
from vehicle.optimum.mesh import CourseOnMesh, laid_course, mesh_of, places_m
from vehicle.optimum.way import times_s

Floats = NDArray[np.float64]

EASY_SHARE: Final = (
    1.1  # of the least time; beyond it, the optimum of a shorter time is a start where others fail
)
WEIGHTS_FIRST: Final = (0.02, 0.2, 0.002)  # tried in turn


def least_time(course: Course) -> Profile:
    """The fastest run; ValueError where the train cannot get there."""
    found = laid_course(course)
    return Profile(found.way.at_m, np.sqrt(2.0 * found.fastest), times_s(found.way.at_m, found.fastest))


def least_energy(course: Course, time_s: float, points: int = 300, warm: Optimum | None = None) -> Optimum:
    """The run of least energy in at most `time_s`; TooShort, with the least time, where there is none.

    `warm` is the optimum of a course much like this one; it saves some of the steps.
    """
    found = laid_course(course)
    return optimum_of(found, time_s, places_m(found, points), warm)


def optimum_of(found: CourseOnMesh, time_s: float, at_m: Floats, warm: Optimum | None = None) -> Optimum:
    """The optimum of a course laid out, on these points."""
    if time_s <= found.least_s:
        raise TooShort(time_s, found.least_s)
    mesh, fast = mesh_of(found, at_m, time_s)
    rounds = 0
    for weight in WEIGHTS_FIRST:
        z = _slower(at_m, fast, time_s) if warm is None else _like(at_m, fast, warm)
        inner = starting_slacks(mesh, found.table, z, weight)
        rounds = follow_path(mesh, found.table, z, inner)
        if rounds:
            break
    else:
        if warm is not None or time_s < EASY_SHARE * found.least_s:
            raise NotFound(time_s, found.least_s)
        return optimum_of(found, time_s, at_m, optimum_of(found, 0.5 * (time_s + found.least_s), at_m))
    course = found.course
    motors, air, energy_j = forces_and_energy(
        mesh, found.table, course.train, found.inertia_kg, course.regeneration, z
    )
    at_s = times_s(at_m, z)
    energy_j += mesh.auxiliary * found.inertia_kg * at_s[-1]
    price_w = float(inner.ends[1]) * found.inertia_kg
    return Optimum(at_m, np.sqrt(2.0 * z), at_s, motors, air, energy_j, price_w, inner.costate, rounds)


def _slower(at_m: Floats, fast: Floats, time_s: float) -> Floats:
    """The fastest run with all speeds between the ends lowered alike, so that it takes about the time."""
    least_s = float(times_s(at_m, fast)[-1])
    share = min(least_s / time_s, 1.0)
    z: Floats = fast * (share * share * 1.02 if share < 0.99 else share * share)
    z[0], z[-1] = fast[0], fast[-1]
    np.minimum(z, fast, out=z)
    return z


def _like(at_m: Floats, fast: Floats, warm: Optimum) -> Floats:
    """The speeds of another optimum, below the fastest run."""
    z = np.interp(at_m, warm.position_m, 0.5 * warm.speed_mps**2)
    z[1:-1] = np.clip(z[1:-1], 1e-3 * fast[1:-1], fast[1:-1])
    z[0], z[-1] = fast[0], fast[-1]
    return z
