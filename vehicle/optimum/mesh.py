"""From a course to its way by the metre and to the mesh."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.mass import equivalent_mass_kg
from vehicle.optimum.course import Course
from vehicle.optimum.laws import GAIN, SLOPE, law_table
from vehicle.optimum.local import Mesh
from vehicle.optimum.way import WayTable, fastest, mean_lift, times_s

Floats = NDArray[np.float64]

FRICTION_ENOUGH_MPS2: Final = 50.0  # an unlimited friction brake, for sums
EVEN_SHARE: Final = 0.4  # of the points by distance; the rest by time and by change of speed
TIME_SHARE: Final = 0.2


@dataclass(frozen=True, slots=True)
class CourseOnMesh:
    """A course laid out: laws, way by the metre, the fastest run over it."""

    course: Course
    inertia_kg: float
    table: Floats
    way: WayTable
    fastest: Floats  # v^2/2

    @property
    def least_s(self) -> float:
        """The least running time, s."""
        return float(times_s(self.way.at_m, self.fastest)[-1])


def laid_course(course: Course) -> CourseOnMesh:
    """Lay a course out; ValueError where the train cannot get to the stop."""
    train = course.train
    inertia = equivalent_mass_kg(train, course.load_share)
    first, last = math.floor(course.start_m), math.ceil(course.stop_m)
    at_m = np.arange(first, last + 1, dtype=np.float64)
    at_m[0], at_m[-1] = course.start_m, course.stop_m
    if len(at_m) > 2 and at_m[1] <= at_m[0]:
        at_m = at_m[1:]
    stretches = np.arange(first, last)[-(len(at_m) - 1) :]
    limit_mps = np.minimum(course.limit_mps[stretches], float(train["speed_max_mps"]))
    drag = np.zeros(len(stretches))
    if course.drag_n_per_mps2 is not None:
        drag = course.drag_n_per_mps2[stretches] / inertia
    way = WayTable(
        at_m,
        mean_lift(train, course.load_share, np.ascontiguousarray(course.climb_m), at_m),
        0.5 * limit_mps * limit_mps,
        drag,
        min(course.friction_brake_n / inertia, FRICTION_ENOUGH_MPS2),
        course.deceleration_mps2,
        min(course.acceleration_mps2, FRICTION_ENOUGH_MPS2),
        0.5 * course.initial_mps**2,
        0.5 * course.final_mps**2,
    )
    table = law_table(train, course.load_share, course.regeneration, float(limit_mps.max()))
    best = fastest(table, way)
    _refuse_what_cannot_run(course, way, best)
    return CourseOnMesh(course, inertia, table, way, best)


def _refuse_what_cannot_run(course: Course, way: WayTable, best: Floats) -> None:
    """ValueError where the train stalls, or is too fast at the start or too slow at the end for what is asked."""
    stalled = np.flatnonzero(np.isnan(best) | (best <= 0.0))
    inner = stalled[(stalled > 0) & (stalled < len(best) - 1)]
    if inner.size:
        why = "climb" if course.friction_brake_n > 0.0 else "climb, or brake with its motors alone"
        after_m = way.at_m[inner[0]] - course.start_m
        raise ValueError(f"the train cannot {why}: it stalls {after_m:.0f} m after its start")
    if best[0] < way.first * (1.0 - 1e-9):
        raise ValueError(f"{course.initial_mps:.2f} m/s at the start is too fast for what lies ahead")
    if best[-1] < way.last * (1.0 - 1e-9):
        raise ValueError(f"{course.final_mps:.2f} m/s at the end cannot be reached")


def shares_of(sums: Floats) -> Floats:
    """Running sums as shares of the last; even where that is nothing (one speed) or has no end (a stand)."""
    return sums / sums[-1] if 0.0 < sums[-1] < np.inf else np.linspace(0.0, 1.0, sums.size)


def places_m(laid: CourseOnMesh, points: int) -> Floats:
    """The mesh's points: wherever the limit changes, else dense where the fastest run is slow or changes speed."""
    at_m, z = laid.way.at_m, laid.fastest
    speed = np.sqrt(2.0 * z)
    time_s = times_s(at_m, z)
    change = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(speed)))))
    place = EVEN_SHARE * shares_of(at_m - at_m[0]) + TIME_SHARE * shares_of(time_s)
    place += (1.0 - EVEN_SHARE - TIME_SHARE) * shares_of(change)
    kept = np.concatenate(([0], np.flatnonzero(np.diff(laid.way.limit)) + 1, [len(at_m) - 1]))
    if len(kept) > points // 2:  # a limit that changes at every metre: what lies under it all counts
        kept = np.array([0, len(at_m) - 1])
    spare = max(points - len(kept), 1)
    shares = np.diff(place[kept])
    found: list[Floats] = [at_m[:1]]
    for k, share in enumerate(shares):
        inner = max(round(float(spare * share)), 1)
        wanted: Floats = place[kept[k]] + share * np.arange(1, inner + 2) / (inner + 1)
        wanted[-1] = place[kept[k + 1]]
        found.append(np.interp(wanted, place, at_m))
    whole = np.concatenate(found)
    whole[-1] = at_m[-1]
    return whole[np.concatenate(([True], np.diff(whole) > 1e-6))]


def mesh_of(laid: CourseOnMesh, at_m: Floats, time_s: float) -> tuple[Mesh, Floats]:
    """The mesh on these points, and v^2/2 of the fastest run there."""
    course, way = laid.course, laid.way
    h = np.diff(at_m)
    lift = np.interp(at_m, way.at_m, way.lift)
    carried = np.concatenate(([0.0], np.cumsum(way.drag * np.diff(way.at_m))))
    drag = np.diff(np.interp(at_m, way.at_m, carried)) / h
    # the lowest limit that any part of a stretch has
    first = np.searchsorted(way.at_m, at_m[:-1] + 1e-9, side="right") - 1
    last = np.searchsorted(way.at_m, at_m[1:] - 1e-9, side="left")
    pairs = np.stack((first, np.maximum(last, first + 1)), axis=1).ravel()
    limit = np.minimum.reduceat(np.append(way.limit, math.inf), pairs)[::2]
    top = np.empty(len(at_m))
    top[0], top[-1] = limit[0], limit[-1]
    top[1:-1] = np.minimum(limit[:-1], limit[1:])
    train = course.train
    mesh = Mesh(
        h,
        np.diff(lift) / h,
        drag,
        top,
        course.regeneration,
        bool(np.any(laid.table[:, SLOPE, 0] > laid.table[:, GAIN, 0])),
        bool(np.any(laid.table[:, GAIN, 0] > 0.0)),
        not train["losses_given"] > 0.0,
        way.brake_extra if way.brake_extra < FRICTION_ENOUGH_MPS2 else math.inf,
        way.deceleration,
        way.acceleration if way.acceleration < FRICTION_ENOUGH_MPS2 else math.inf,
        float(train["auxiliary_power_w"]) / laid.inertia_kg if course.auxiliaries else 0.0,
        time_s,
    )
    return mesh, np.minimum(np.interp(at_m, way.at_m, laid.fastest), top)
