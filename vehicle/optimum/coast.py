"""The simplest run that saves: power to one speed, hold it, shut off at one place, coast, brake (惰行).

What a driver can be told in two figures, the speed to hold and the place to shut off. Of all such runs that take no
longer than the time given, `coast_run` finds the one of least energy, and `cruise_run` the one that never shuts off.
Limits and the braking to them and to the stop are those of the fastest run, under which every run stays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2
from vehicle.optimum.course import Course, Profile, TooShort
from vehicle.optimum.laws import ALL_MOTORS, ELECTRIC, PULL, RESIST, law_value
from vehicle.optimum.mesh import CourseOnMesh, laid_course, mesh_of, places_m
from vehicle.optimum.way import HALVINGS, WayTable, times_s
from vehicle.records import TrainRow
from vehicle.wire import wire_power_w

Floats = NDArray[np.float64]

SMALLEST_PERMILLE: Final = 0.01  # of gradient: what a metre counts as coasting
PLACES: Final = 32  # of shutting off that are tried first: on a descent sooner may be faster
POINTS: Final = 300  # on which the speed is looked for
SPEEDS: Final = 12  # that are tried first
REFINEMENTS: Final = 12  # of the golden section between the best three of them
SPEED_TO_MPS: Final = 1e-4  # to which the slowest speed is found
NEAR: Final = 0.01  # the coarse points' slowest speed is this near that of all, else it is looked for anew
GOLDEN: Final = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True, slots=True)
class CoastRun:
    """A run and the two figures that it is told by: the greatest speed under power, and where it shuts off.

    `rim_mps2`: what motors and brakes give on each stretch.
    """

    profile: Profile
    rim_mps2: Floats
    energy_j: float
    cruise_mps: float
    coast_from_m: float  # the stop: nowhere

    @property
    def time_s(self) -> float:
        """Running time."""
        return float(self.profile.time_s[-1])


def coast_run(course: Course, time_s: float) -> CoastRun:
    """The run of least energy of its kind in at most `time_s`; TooShort, with the least time, where there is none.

    ValueError where the train cannot get to the stop. The speed is looked for on fewer points: a percent may be left;
    the place of shutting off is a metre of the grid, so the running time is short of `time_s` by what one metre makes.
    """
    return coast_on(laid_course(course), time_s)


def coast_on(found: CourseOnMesh, time_s: float) -> CoastRun:
    """`coast_run` of a course laid out."""
    _refuse(found, time_s)
    coarse = _coarse(found)
    slowest = _slowest_cruise(found, coarse, time_s)
    # Evenly in speed, not in its square; the slowest leaves no time to coast.
    speeds = np.linspace(math.sqrt(slowest), math.sqrt(float(found.fastest.max())), SPEEDS)
    energies = [_energy_j(coarse, float(v * v), time_s)[0] for v in speeds]
    best = int(np.argmin(energies))
    low, high = speeds[max(best - 1, 0)], speeds[min(best + 1, SPEEDS - 1)]
    between = _least_between(coarse, float(low), float(high), time_s)
    tried = [(*_energy_j(found, z, time_s), z) for z in (between**2, float(speeds[best] ** 2), slowest)]
    _, shut_off, cruise = min(tried)
    return _told(found, cruise, shut_off)


def cruise_run(course: Course, time_s: float) -> CoastRun:
    """The run that holds the lowest constant speed that is fast enough; errors as `coast_run`."""
    return cruise_on(laid_course(course), time_s)


def cruise_on(found: CourseOnMesh, time_s: float) -> CoastRun:
    """`cruise_run` of a course laid out."""
    _refuse(found, time_s)
    return _told(found, _slowest_cruise(found, _coarse(found), time_s), len(found.way.limit))


def fastest_j(found: CourseOnMesh) -> float:
    """Energy of the fastest run of a course laid out, J."""
    course, way = found.course, found.way
    spent_j = time_and_energy(
        course.train, found.inertia_kg, course.regeneration, found.table, way, found.fastest
    )[1]
    auxiliary_w = float(course.train["auxiliary_power_w"]) if course.auxiliaries else 0.0
    return float(spent_j[-1]) + auxiliary_w * found.least_s


def _refuse(found: CourseOnMesh, time_s: float) -> None:
    if time_s < found.least_s:
        raise TooShort(time_s, found.least_s)


def _coarse(found: CourseOnMesh) -> CourseOnMesh:
    """The course on fewer points, to look for the speed on."""
    at_m = places_m(found, POINTS)
    mesh, fast = mesh_of(found, at_m, found.least_s)
    lift = np.interp(at_m, found.way.at_m, found.way.lift)
    way = found.way._replace(at_m=at_m, lift=lift, limit=mesh.top[:-1], drag=mesh.drag)
    return replace(found, way=way, fastest=fast)


def _slowest_cruise(found: CourseOnMesh, coarse: CourseOnMesh, time_s: float) -> float:
    """v^2/2 of the lowest speed that, held to the end, is fast enough: between two near it of the coarse points."""
    top = math.sqrt(2.0 * float(found.fastest.max()))
    low, high = _bisected(coarse, time_s, 0.0, top)
    low, high = (1.0 - NEAR) * low, min((1.0 + NEAR) * high, top)
    if not _fast_enough(found, time_s, high) or _fast_enough(found, time_s, low):
        low, high = 0.0, top
    return 0.5 * _bisected(found, time_s, low, high)[1] ** 2


def _bisected(found: CourseOnMesh, time_s: float, low: float, high: float) -> tuple[float, float]:
    """Two speeds next to each other: held to the end, the lower is too slow."""
    while high - low > SPEED_TO_MPS:
        middle = 0.5 * (low + high)
        if _fast_enough(found, time_s, middle):
            high = middle
        else:
            low = middle
    return low, high


def _fast_enough(found: CourseOnMesh, time_s: float, speed_mps: float) -> bool:
    z = cruising_run(found.table, found.way, found.fastest, 0.5 * speed_mps * speed_mps)
    return bool(z[-2] > 0.0 and times_s(found.way.at_m, z)[-1] <= time_s)


def _ways(found: CourseOnMesh, cruise: float) -> Ways:
    """The course with the run that holds this v^2/2."""
    train, regeneration = found.course.train, found.course.regeneration
    holding = cruising_run(found.table, found.way, found.fastest, cruise)
    laws = (train, found.inertia_kg, regeneration, found.table, found.way)
    fast_s, fast_j, _ = time_and_energy(*laws, found.fastest)
    hold_s, hold_j, _ = time_and_energy(*laws, holding)
    begin = brakes_from(found.table, found.way, found.fastest)
    return Ways(*laws, found.fastest, fast_s, fast_j, begin, holding, hold_s, hold_j)


def _energy_j(found: CourseOnMesh, cruise: float, time_s: float) -> tuple[float, int]:
    """Least energy with this v^2/2 as the speed to hold, and the point where it shuts off."""
    return cheapest(_ways(found, cruise), time_s)


def _least_between(found: CourseOnMesh, low: float, high: float, time_s: float) -> float:
    """Golden section for the square root of v^2/2."""

    def energy_j(v: float) -> float:
        return _energy_j(found, v * v, time_s)[0]

    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = energy_j(left), energy_j(right)
    for _ in range(REFINEMENTS):
        if at_left <= at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = energy_j(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = energy_j(right)
    return left if at_left <= at_right else right


def _told(found: CourseOnMesh, cruise: float, shut_off: int) -> CoastRun:
    """The run with these two figures."""
    way, course = found.way, found.course
    z = cruising_run(found.table, way, found.fastest, cruise)
    if shut_off < len(way.limit):
        coast_down(found.table, way, found.fastest, z, shut_off)
    train: Any = course.train
    _, energy, rim = time_and_energy(train, found.inertia_kg, course.regeneration, found.table, way, z)
    profile = Profile(way.at_m, np.sqrt(2.0 * z), times_s(way.at_m, z))
    auxiliary_w = float(train["auxiliary_power_w"]) if course.auxiliaries else 0.0
    return CoastRun(
        profile,
        rim,
        float(energy[-1]) + auxiliary_w * float(profile.time_s[-1]),
        math.sqrt(2.0 * min(cruise, float(z[: shut_off + 1].max()))),
        float(way.at_m[shut_off]),
    )


@compiled
def powered_stretch(table: Floats, way: WayTable, i: int, z: float, share: float) -> float:
    """v^2/2 after a stretch with a share of the full pull."""
    h = way.at_m[i + 1] - way.at_m[i]
    grade = (way.lift[i + 1] - way.lift[i]) / h
    mean, after = z, z
    for _ in range(HALVINGS):
        speed = math.sqrt(2.0 * max(mean, 0.0))
        rate = share * law_value(table, PULL, speed) - law_value(table, RESIST, speed)
        after = z + h * min(rate - way.drag[i] * speed * speed - grade, way.acceleration)
        mean = 0.5 * (z + after)
    return after


@compiled
def cruising_run(table: Floats, way: WayTable, fastest: Floats, cruise: float) -> Floats:
    """v^2/2 at each point of the run that holds one speed to the end; brakes hold it on descents."""
    z = np.empty(len(fastest))
    z[0] = way.first
    for i in range(len(way.limit)):
        if z[i] <= cruise:
            after = min(powered_stretch(table, way, i, z[i], 1.0), cruise)
        else:  # too fast at the start: let it fall
            after = max(min(powered_stretch(table, way, i, z[i], 0.0), z[i]), cruise)
        z[i + 1] = min(max(after, 0.0), fastest[i + 1])
    return z


@compiled
def coast_down(table: Floats, way: WayTable, fastest: Floats, z: Floats, first: int) -> None:
    """Coast from a point on, braking where limits and stop ask for it: v^2/2 at the points beyond, in place."""
    for i in range(first, len(way.limit)):
        z[i + 1] = min(max(powered_stretch(table, way, i, z[i], 0.0), 0.0), fastest[i + 1])


@compiled
def stretch_cost(
    train: TrainRow,
    inertia_kg: float,
    regeneration: float,
    table: Floats,
    way: WayTable,
    i: int,
    z: float,
    after: float,
) -> tuple[float, float, float]:
    """Time, s, energy at the wire, J, and what motors and brakes give, m/s^2, on one stretch."""
    h = way.at_m[i + 1] - way.at_m[i]
    speed = math.sqrt(z + after)
    resist = law_value(table, RESIST, speed) + way.drag[i] * speed * speed
    rim = (after - z + way.lift[i + 1] - way.lift[i]) / h + resist
    if abs(rim) < 1e-3 * GRAVITY_MPS2 * SMALLEST_PERMILLE:  # what the halvings leave of a coast
        rim = 0.0
    motors_n = inertia_kg * max(rim, -law_value(table, ELECTRIC, speed))
    power_w = wire_power_w(train, ALL_MOTORS, motors_n, speed)
    energy_j = h / speed * (power_w if power_w > 0.0 else regeneration * power_w)
    return 2.0 * h / (math.sqrt(2.0 * z) + math.sqrt(2.0 * after)), energy_j, rim


@compiled
def time_and_energy(
    train: TrainRow, inertia_kg: float, regeneration: float, table: Floats, way: WayTable, z: Floats
) -> tuple[Floats, Floats, Floats]:
    """Time, s, and energy at the wire, J, up to each point; what motors and brakes give on each stretch, m/s^2."""
    time, energy, rim = np.zeros(len(z)), np.zeros(len(z)), np.empty(len(way.limit))
    for i in range(len(way.limit)):
        dt, de, rim[i] = stretch_cost(train, inertia_kg, regeneration, table, way, i, z[i], z[i + 1])
        time[i + 1], energy[i + 1] = time[i] + dt, energy[i] + de
    return time, energy, rim


@compiled
def brakes_from(table: Floats, way: WayTable, fastest: Floats) -> int:
    """The point from which the fastest run brakes to the end: who coasts there brakes with it."""
    i = len(way.limit)
    while i > 0 and powered_stretch(table, way, i - 1, fastest[i - 1], 0.0) >= fastest[i]:
        i -= 1
    return i


class Ways(NamedTuple):
    """One course, its fastest run and one that holds a speed, with what they cost up to each point."""

    train: TrainRow
    inertia_kg: float
    regeneration: float
    table: Floats
    way: WayTable
    fastest: Floats
    fast_s: Floats
    fast_j: Floats
    brakes_from: int
    holding: Floats
    hold_s: Floats
    hold_j: Floats


@compiled
def coasting(ways: Ways, first: int) -> tuple[float, float]:
    """Time, s, and energy, J, of the run that shuts off at a point; infinite where it comes to a stand too soon."""
    last = len(ways.way.limit)
    z = ways.holding[first]
    time_s, energy_j = ways.hold_s[first], ways.hold_j[first]
    for i in range(first, last):
        if i >= ways.brakes_from and z >= ways.fastest[i]:
            return time_s + ways.fast_s[last] - ways.fast_s[i], energy_j + ways.fast_j[last] - ways.fast_j[i]
        after = min(powered_stretch(ways.table, ways.way, i, z, 0.0), ways.fastest[i + 1])
        if after <= 0.0 and (i + 1 < last or ways.way.last > 0.0 or z <= 0.0):
            return math.inf, math.inf
        after = max(after, 0.0)
        dt, de, _ = stretch_cost(
            ways.train, ways.inertia_kg, ways.regeneration, ways.table, ways.way, i, z, after
        )
        time_s, energy_j, z = time_s + dt, energy_j + de, after
    if z < ways.way.last * (1.0 - 1e-9):
        return math.inf, math.inf
    return time_s, energy_j


@compiled
def cheapest(ways: Ways, time_s: float) -> tuple[float, int]:
    """Energy, J, of the best place to shut off that keeps the time, and its point; infinite where none does.

    The soonest is not always the best: on a descent a run that holds its speed gives back to the wire.
    """
    last = len(ways.way.limit)
    if not ways.hold_s[last] <= time_s:
        return math.inf, last
    best_j, best, early, late = ways.hold_j[last], last, -1, last
    for place in range(0, last, max(last // PLACES, 1)):
        taken_s, energy_j = coasting(ways, place)
        if taken_s > time_s:
            if late == last:
                early = place
            continue
        late = min(late, place)
        if energy_j < best_j:
            best_j, best = energy_j, place
    while late - early > 1:
        middle = (late + early) // 2
        taken_s, energy_j = coasting(ways, middle)
        if taken_s > time_s:
            early = middle
            continue
        late = middle
        if energy_j < best_j:
            best_j, best = energy_j, middle
    return best_j, best
