"""An optimum as a run that the train can really make, to the last metre, beside the proven bound.

The mesh holds forces within their limits in the middle of each stretch, and knows the laws by their table. Here its
speeds are an upper line: the run is followed on points a metre apart at most, never faster than that line, and no
harder than what the true laws give at the worse end of each piece. That takes a little longer, so the mesh is asked
for a little less time, until the run that is possible takes no more than the time asked for. Its energy is above the
least and the bound is below: what lies between them is all that is not known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from vehicle.optimum.bound import bound_of
from vehicle.optimum.course import Course, EndsNotKept, NotFound, Optimum
from vehicle.optimum.laws import ALL_MOTORS, laws_at
from vehicle.optimum.mesh import laid_course, places_m
from vehicle.optimum.solve import optimum_of
from vehicle.optimum.way import times_s
from vehicle.records import TrainRow
from vehicle.wire import wire_power_w

Floats = NDArray[np.float64]

PIECES: Final = 4  # of each stretch, at least
GRADES: Final = 14  # halvings of the pieces at a stand
TRIES: Final = 8
SLOWER: Final = 1e-9  # share of v^2/2 at the ends that rounding may cost
EARLY: Final = 2e-5  # share of the time within which the run that is possible has to be early


@dataclass(frozen=True, slots=True)
class ProvenRun:
    """What a run that is possible costs, and what none can cost less than, J."""

    time_s: float
    energy_j: float
    bound_j: float
    mesh_energy_j: float  # what the mesh said of the same run
    optimum: Optimum

    @property
    def gap(self) -> float:
        """How far the run may be above the least, as a share of the bound."""
        return (self.energy_j - self.bound_j) / abs(self.bound_j)


def pieces_m(way_m: Floats, at_m: Floats, stands: tuple[bool, bool]) -> Floats:
    """Points of the way by the metre, parts of each stretch, and ever nearer points towards a stand."""
    shares = np.arange(PIECES) / PIECES
    inner = (at_m[:-1, None] + shares[None, :] * np.diff(at_m)[:, None]).ravel()
    halves = 0.5 ** np.arange(GRADES)
    near = [at_m[0] + halves * (inner[1] - inner[0])] if stands[0] else []
    near += [at_m[-1] - halves * (at_m[-1] - inner[-1])] if stands[1] else []
    points = np.unique(np.concatenate([way_m, inner, at_m, *near]))
    return points[np.concatenate((np.diff(points) > 1e-9, [True]))]


@compiled
def possible_speeds2(
    train: TrainRow,
    load_share: float,
    inertia_kg: float,
    at_m: Floats,
    held: Floats,
    limits: Floats,
    line: Floats,
) -> Floats:
    """v^2/2 on or below `line` that the true laws allow.

    `held`: mean gradient and drag of each piece, (pieces, 2); `limits`: friction brake, deceleration and acceleration.
    """
    n = len(at_m) - 1
    z = line.copy()
    for i in range(n):
        h = at_m[i + 1] - at_m[i]
        v, w = math.sqrt(2.0 * z[i]), math.sqrt(2.0 * z[i + 1])
        resist_v, pull_v, _ = laws_at(train, load_share, v)
        resist_w, pull_w, _ = laws_at(train, load_share, w)
        drag = held[i, 1] * max(v, w) ** 2
        rate = (min(pull_v, pull_w) - max(resist_v, resist_w)) / inertia_kg - drag - held[i, 0]
        z[i + 1] = min(z[i + 1], max(z[i] + h * min(rate, limits[2]), 0.0))
    for i in range(n - 1, -1, -1):
        h = at_m[i + 1] - at_m[i]
        v, w = math.sqrt(2.0 * z[i]), math.sqrt(2.0 * z[i + 1])
        resist_v, _, brake_v = laws_at(train, load_share, v)
        resist_w, _, brake_w = laws_at(train, load_share, w)
        drag = held[i, 1] * min(v, w) ** 2
        rate = (min(brake_v, brake_w) + min(resist_v, resist_w)) / inertia_kg + limits[0] + drag + held[i, 0]
        z[i] = min(z[i], max(z[i + 1] + h * min(rate, limits[1]), 0.0))
    return z


@compiled
def consumed_j(
    train: TrainRow,
    load_share: float,
    inertia_kg: float,
    regeneration: float,
    at_m: Floats,
    held: Floats,
    z: Floats,
) -> float:
    """Energy at the wire of a run with the true laws, J, auxiliaries apart."""
    total = 0.0
    for i in range(len(at_m) - 1):
        h = at_m[i + 1] - at_m[i]
        speed = math.sqrt(z[i] + z[i + 1])
        if speed <= 0.0:
            continue
        resist, _, brake = laws_at(train, load_share, speed)
        force = (z[i + 1] - z[i]) / h + held[i, 0] + held[i, 1] * speed * speed
        motors_n = max(inertia_kg * force + resist, -brake)
        power_w = wire_power_w(train, ALL_MOTORS, motors_n, speed)
        total += h / speed * (power_w if power_w > 0.0 else regeneration * power_w)
    return total


def proven_run(course: Course, time_s: float, points: int = 300) -> ProvenRun:
    """The optimum of a course as a run that is possible within `time_s`, and its bound.

    TooShort where the time is below the least, NotFound where the mesh leads to no such run; EndsNotKept where the run
    that is possible is slower at an end than asked for: its energy would be that of another course.
    """
    found = laid_course(course)
    way, train, inertia = found.way, course.train, found.inertia_kg
    at_m = places_m(found, points)
    asked_s = time_s
    limits = np.array([way.brake_extra, way.deceleration, way.acceleration])
    fine = pieces_m(way.at_m, at_m, (way.first <= 0.0, way.last <= 0.0))
    h = np.diff(fine)
    carried = np.concatenate(([0.0], np.cumsum(way.drag * np.diff(way.at_m))))
    held = np.stack(
        (np.diff(np.interp(fine, way.at_m, way.lift)) / h, np.diff(np.interp(fine, way.at_m, carried)) / h),
        axis=1,
    )
    # The mesh's force is held through each stretch, so the speed follows the gradients within.
    bowed = np.interp(fine, way.at_m, way.lift) - np.interp(fine, at_m, np.interp(at_m, way.at_m, way.lift))
    metre = np.clip(np.searchsorted(way.at_m, fine, side="right") - 1, 0, len(way.limit) - 1)
    ceiling = np.minimum(way.limit[metre], way.limit[np.maximum(metre - (fine <= way.at_m[metre]), 0)])
    for _ in range(TRIES):
        optimum = optimum_of(found, asked_s, at_m)
        line = np.minimum(np.interp(fine, at_m, 0.5 * optimum.speed_mps**2) - bowed, ceiling)
        if not np.all(line[1:-1] > 0.0):  # over a hump within a stretch a slow run stalls with one force
            raise NotFound(time_s, found.least_s)
        z = possible_speeds2(train, course.load_share, inertia, fine, held, limits, line)
        took_s = float(times_s(fine, z)[-1])
        if time_s * (1.0 - EARLY) <= took_s <= time_s:
            break
        asked_s -= took_s - time_s * (1.0 - 0.5 * EARLY)
        if asked_s <= found.least_s:
            raise NotFound(time_s, found.least_s)
    else:
        raise NotFound(time_s, found.least_s)
    if z[0] < way.first * (1.0 - SLOWER) or z[-1] < way.last * (1.0 - SLOWER):
        raise EndsNotKept(time_s, found.least_s)
    energy_j = consumed_j(train, course.load_share, inertia, course.regeneration, fine, held, z)
    if course.auxiliaries:
        energy_j += float(train["auxiliary_power_w"]) * took_s
    return ProvenRun(took_s, energy_j, bound_of(found, optimum, time_s), optimum.energy_j, optimum)
