"""A proven lower bound of the energy (双対): what no run of the course can save, whatever its form.

Weak duality. With z = v^2/2, force f per equivalent mass, z' = f - r(z) - g(s) and the energy phi(f, z) by metre, take
any price lambda >= 0 of a second and any costate mu(s), straight on each stretch between points s_i and with jumps
J_i = mu(s_i+) - mu(s_i-) at them. For every run that keeps the limits and takes at most T,

    E >= E + lambda (t - T) + int mu (z' - f + r + g) ds
      = -lambda T + mu(S) z(S) - mu(0) z(0) - sum J_i z(s_i) + int mu g ds
        + int phi + lambda / v - mu (f - r) - mu' z  ds,

integrated by parts. Each term is bounded from below by itself: z(s_i) by its box, and the last integrand by

    H(s) = min over v in the stretch's box and f within the train's limits of the integrand.

On a stretch mu' is constant and mu straight, so H is the least of functions that are straight in s: it is concave, and
the trapezoid of its two ends is below its integral. No convexity of the problem is used; a poor mu gives a poor bound
and never a wrong one.

The minimum by f is a closed form, as phi is convex in f: straight, then square (`costs`, `spent`). That by v is taken
cell by cell (`cells`). On a cell the laws are below their chords and the costs at their cheapest; the rest,
lambda / v + mu r - mu' v^2/2, is above its chord less h^2/8 times its greatest second derivative, which is at most
2 lambda / v^3 + mu r'' - mu'; what the force saves adds its own bend (`capped`). In the first cell, where
lambda / v has no bound, that term is taken at its least. This cut is subtracted: the grid of speeds makes the bound a
little poorer, and never wrong.

Relaxed, so that the bound stays one: a stretch's limit is the greatest on it, no lower than the fastest run; held back
deceleration counts with its least gradient, held back acceleration with its greatest, tunnels with their least share
(for mu < 0: their greatest). Small forces may be given in turns (`costs`). The way is that of `way.Way`: heights
below the train straight from metre to metre.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from vehicle.optimum.cells import Cells, cells_of, corners_mps
from vehicle.optimum.course import Course, Optimum
from vehicle.optimum.laws import PULL, RESIST, STEP_MPS
from vehicle.optimum.local import Mesh, costs_at, local
from vehicle.optimum.mesh import CourseOnMesh, laid_course, mesh_of
from vehicle.optimum.way import WayTable
from vehicle.resistance import KMH_PER_MPS, STARTING_BAND_KMH

Floats = NDArray[np.float64]


class Term(IntEnum):
    """A term of the bound by name: left out on purpose, what is found is no bound any more, and tests see it."""

    TIME = 0
    GRADIENT = 1
    JUMPS = 2


BAND_MPS: Final = STARTING_BAND_KMH / KMH_PER_MPS


NONE_LEFT_OUT: Final = -1
TIME, GRADIENT, JUMPS = int(Term.TIME), int(Term.GRADIENT), int(Term.JUMPS)
GRADES: Final = 12  # halvings of the stretch at a stand
STANDS_MPS: Final = 1e-4


class Prices(NamedTuple):
    """A choice of the dual: each stretch's costate at both its ends, and the price of a second, W/kg."""

    left: Floats
    right: Floats
    second: float


class StretchBound(NamedTuple):
    """What holds on a whole stretch."""

    top: float  # m/s
    held_back: float  # greatest deceleration less the least gradient
    held_down: float  # greatest acceleration plus the greatest gradient
    drag_least: float
    drag_most: float


class CostsBesideForces(NamedTuple):
    """What else counts: W/kg for the time itself, the friction brake (m/s^2), the share of what comes back."""

    auxiliary: float
    friction: float
    regeneration: float


class CellEnds(NamedTuple):
    """A quantity at both ends of a cell."""

    low: float
    high: float


@compiled
def least_of_curve(over: float, bend: float, curve: float, most: float) -> float:
    """Least of curve max(p - bend, 0)^2 - over p for p up to `most`; `most` may be below 0."""
    p = most
    if curve > 0.0:
        p = min(p, bend + 0.5 * over / curve)
    beyond = max(p - bend, 0.0)
    return curve * beyond * beyond - over * p


@compiled
def least_of_cell(
    width: float,
    bend: float,
    over: float,
    knee: float,
    curve: float,
    rest: CellEnds,
    most: CellEnds,
    bowed: float,
) -> float:
    """Least on a cell of `rest` and what a force up to `most` saves; both are given at its ends.

    `bend` bounds the second derivative of the rest, `bowed` that of -most; most is else straight. What is saved falls
    with most, at a rate of at most `over`, and bends by twice the curve times the slope of most squared.
    """
    slope = abs(most.high - most.low) / width + abs(bowed) * width
    more = bend + over * max(bowed, 0.0) + 2.0 * curve * slope * slope
    low = min(
        rest.low + least_of_curve(over, knee, curve, most.low),
        rest.high + least_of_curve(over, knee, curve, most.high),
    )
    return low - max(more, 0.0) * width * width / 8.0


@compiled
def least_pulling(
    cells: Cells, j: int, stretch: StretchBound, mu: float, rest: CellEnds, bend: float, bend_r: float
) -> float:
    """Least on cell `j` where a force is worth more than it costs; the greatest is that of motors, or a held one."""
    v, w = cells.speed[j], cells.speed[j + 1]
    over, knee, curve = mu - cells.cost[j, 0], cells.cost[j, 2], cells.cost[j, 3]
    resist = CellEnds(
        cells.resist[j] + stretch.drag_most * v * v, cells.resist[j + 1] + stretch.drag_most * w * w
    )
    motors = CellEnds(cells.pull[j, 0], cells.pull[j, 1])
    held = CellEnds(stretch.held_down + resist.low, stretch.held_down + resist.high)
    return max(
        least_of_cell(w - v, bend, over, knee, curve, rest, motors, 0.0),
        least_of_cell(w - v, bend, over, knee, curve, rest, held, -bend_r),
    )


@compiled
def least_braking(
    cells: Cells,
    costs: CostsBesideForces,
    j: int,
    stretch: StretchBound,
    mu: float,
    rest: CellEnds,
    bend: float,
    bend_r: float,
) -> float:
    """Least on cell `j` where braking gives back more than speed is worth; below mu = 0 also by friction."""
    v, w = cells.speed[j], cells.speed[j + 1]
    gain, knee = costs.regeneration * cells.cost[j, 1], cells.cost[j, 2]
    curve = costs.regeneration * cells.cost[j, 3]
    motors = CellEnds(cells.electric[j, 0], cells.electric[j, 1])
    held = CellEnds(
        stretch.held_back - cells.resist[j] - stretch.drag_least * v * v,
        stretch.held_back - cells.resist[j + 1] - stretch.drag_least * w * w,
    )
    if mu >= 0.0:
        return max(
            least_of_cell(w - v, bend, gain - mu, knee, curve, rest, motors, 0.0),
            least_of_cell(w - v, bend, gain - mu, knee, curve, rest, held, bend_r),
        )
    best = -math.inf
    for whole in range(2):
        low, high = (
            (held.low, held.high) if whole else (motors.low + costs.friction, motors.high + costs.friction)
        )
        both = CellEnds(rest.low + mu * low, rest.high + mu * high)
        more = bend - mu * bend_r * whole
        best = max(best, least_of_cell(w - v, more, gain, knee, curve, both, motors, 0.0))
        best = max(best, least_of_cell(w - v, more, gain, knee, curve, both, held, bend_r))
    return best


@compiled
def least_integrand(
    cells: Cells, costs: CostsBesideForces, stretch: StretchBound, mu: float, slope: float, second: float
) -> float:
    """H of one end of a stretch: a lower bound of the integrand over all speeds and forces."""
    speed, resist = cells.speed, cells.resist
    drag = stretch.drag_least if mu >= 0.0 else stretch.drag_most
    worth = second + costs.auxiliary
    bend_r = cells.curving + 2.0 * stretch.drag_most
    best = math.inf
    for j in range(len(speed) - 1):
        if speed[j] >= stretch.top:
            break
        v, w = speed[j], speed[j + 1]
        bend = max(mu, 0.0) * bend_r - slope
        rest = CellEnds(
            mu * (resist[j] + drag * v * v) - slope * 0.5 * v * v + worth / (v if j > 0 else w),
            mu * (resist[j + 1] + drag * w * w) - slope * 0.5 * w * w + worth / w,
        )
        if j > 0:
            bend += 2.0 * worth / (v * v * v)
        idle = cells.cost[j, 4]
        found = min(rest.low, rest.high) - max(bend, 0.0) * (w - v) * (w - v) / 8.0 + idle
        if mu > cells.cost[j, 0]:
            found = min(found, least_pulling(cells, j, stretch, mu, rest, bend, bend_r) + idle)
        if mu < costs.regeneration * cells.cost[j, 1]:
            # Instead of nothing: no force at all is among what it looks at, unless one is needed.
            least = least_braking(cells, costs, j, stretch, mu, rest, bend, bend_r)
            found = min(found, least + costs.regeneration * idle)
        best = min(best, found)
    return best


@compiled
def dual(
    cells: Cells,
    costs: CostsBesideForces,
    at_m: Floats,
    stretches: Floats,
    tops: Floats,
    pulled: Floats,
    ends: Floats,
    prices: Prices,
    time_s: float,
    left_out: int,
) -> float:
    """The bound, m^2/s^2 (J per kg of equivalent mass).

    `stretches`: a row of Stretch each; `tops`: greatest z at the points; `pulled`: (stretches, 2) integrals of g and
    of g times the way since the stretch's start; `ends`: z at start and stop.
    """
    n = len(at_m) - 1
    left, right = prices.left, prices.right
    total = right[n - 1] * ends[1] - left[0] * ends[0]
    if left_out != TIME:
        total -= prices.second * time_s
    for i in range(1, n):
        jump = left[i] - right[i - 1]
        if jump > 0.0 and left_out != JUMPS:
            total -= jump * tops[i]
    for i in range(n):
        h = at_m[i + 1] - at_m[i]
        slope = (right[i] - left[i]) / h
        row = stretches[i]
        stretch = StretchBound(row[0], row[1], row[2], row[3], row[4])
        low = least_integrand(cells, costs, stretch, left[i], slope, prices.second)
        high = least_integrand(cells, costs, stretch, right[i], slope, prices.second)
        total += 0.5 * h * (low + high)
        if left_out != GRADIENT:
            total += left[i] * pulled[i, 0] + slope * pulled[i, 1]
    return float(total)


@compiled
def values_around(table: Floats, law: int, speed_mps: float) -> tuple[float, float]:
    """The lesser and the greater of a law's values at the table's speeds below and above."""
    i = min(int(speed_mps / STEP_MPS), len(table) - 2)
    return min(table[i, law, 0], table[i + 1, law, 0]), max(table[i, law, 0], table[i + 1, law, 0])


@compiled
def ceilings(way: WayTable, table: Floats) -> Floats:
    """Upper bounds of v^2/2 at the way's points: no run gets above, by steps with the greatest rate on each."""
    n = len(way.limit)
    most = np.empty(n + 1)
    most[0] = way.first
    band = values_around(table, RESIST, BAND_MPS)[0]
    for i in range(n):
        h = way.at_m[i + 1] - way.at_m[i]
        grade = (way.lift[i + 1] - way.lift[i]) / h
        v = math.sqrt(2.0 * most[i])
        w = math.sqrt(2.0 * (most[i] + h * max(way.acceleration, 0.0)))
        w = min(w, math.sqrt(2.0 * way.limit[i]))
        pull = max(values_around(table, PULL, v)[1], values_around(table, PULL, w)[1])
        resist = min(values_around(table, RESIST, v)[0], values_around(table, RESIST, w)[0], band)
        rate = pull - resist - grade
        # what loses speed is pulled harder at the end, if it has fallen as far as with this rate
        if rate < 0.0:
            u = math.sqrt(2.0 * max(most[i] + h * rate, 0.0))
            pull = max(pull, values_around(table, PULL, u)[1])
            rate = pull - min(resist, values_around(table, RESIST, u)[0]) - grade
        rate = min(rate, way.acceleration)
        top = way.limit[i] if i + 1 >= n else min(way.limit[i], way.limit[i + 1])
        most[i + 1] = min(max(most[i] + h * rate, 0.0), top)
    most[n] = min(most[n], way.last)
    for i in range(n - 1, -1, -1):
        h = way.at_m[i + 1] - way.at_m[i]
        most[i] = min(most[i], most[i + 1] + h * way.deceleration)
    return most


@compiled
def slope_of(
    mesh: Mesh, table: Floats, i: int, low: float, high: float, a: float, mu: float, second: float
) -> float:
    """mu' for which the run's own speed is where H is least, on a piece of stretch `i` from z = `low` to `high`."""
    x = local(mesh, table, i, a, 0.5 * (low + high))
    v, w = math.sqrt(2.0 * low), math.sqrt(2.0 * high)
    slope = mu * x.f_z
    if v > STANDS_MPS and w > STANDS_MPS:
        slope -= (second + mesh.auxiliary) * 2.0 / (v * w * (v + w))
    paid = costs_at(mesh, table, 0.5 * (low + high))
    over, under = mu - paid.kink.value - paid.gain.value, paid.gain.value - mu
    held = mesh.deceleration - (x.f - a)
    slope += paid.idle.by_z
    if over > 0.0:
        pull = max(x.f, 0.0)
        beyond = max(pull - paid.bend.value, 0.0)
        slope += (paid.kink.by_z + paid.gain.by_z) * pull + paid.curve.by_z * beyond * beyond
        slope -= 2.0 * paid.curve.value * beyond * paid.bend.by_z
        slope -= max(over - 2.0 * paid.curve.value * beyond, 0.0) * x.pull_z
    elif under > 0.0:
        curve, curve_z = mesh.regeneration * paid.curve.value, mesh.regeneration * paid.curve.by_z
        brake = min(max(-x.f, 0.0), x.elec)
        beyond = max(brake - paid.bend.value, 0.0)
        slope += curve_z * beyond * beyond - paid.gain.by_z * brake - 2.0 * curve * beyond * paid.bend.by_z
        worth = paid.gain.value - 2.0 * curve * beyond
        motors_z = -x.f_z if held < x.elec else x.elec_z
        if mu >= 0.0:
            slope -= max(worth - mu, 0.0) * motors_z
        else:
            whole_z = -x.f_z if held < x.elec + mesh.brake_extra else x.elec_z
            slope -= max(worth, 0.0) * motors_z - mu * whole_z
    return slope


def graded_mesh(at_m: Floats, z: Floats) -> Floats:
    """The mesh's points and, towards a stand, ever nearer ones: the costate grows there without end."""
    shares = 0.5 ** np.arange(1, GRADES + 1)
    more = [at_m]
    if z[0] <= 0.0:
        more.append(at_m[0] + shares * (at_m[1] - at_m[0]))
    if z[-1] <= 0.0:
        more.append(at_m[-1] - shares * (at_m[-1] - at_m[-2]))
    return np.unique(np.concatenate(more))


@compiled
def choice(
    mesh: Mesh, table: Floats, at_m: Floats, z: Floats, costate: Floats, second: float, fine_m: Floats
) -> Prices:
    """Costates at both ends of each fine stretch, the optimum's own in the middle of each of its stretches."""
    n = len(fine_m) - 1
    last = len(at_m) - 2
    left, right = np.empty(n), np.empty(n)
    i = 0
    first_pieces = 0
    for k in range(n):
        while i < last and fine_m[k] >= at_m[i + 1]:
            i += 1
        if i == 0:
            first_pieces = k + 1
        h = at_m[i + 1] - at_m[i]
        a = (z[i + 1] - z[i]) / h
        low = z[i] + a * (fine_m[k] - at_m[i])
        high = z[i] + a * (fine_m[k + 1] - at_m[i])
        piece = fine_m[k + 1] - fine_m[k]
        if piece >= h or k == 0 or i == 0:
            mu = costate[i]
            slope = slope_of(mesh, table, i, low, high, a, mu, second)
            left[k], right[k] = mu - 0.5 * slope * piece, mu + 0.5 * slope * piece
        else:  # on from the piece before
            mu = right[k - 1]
            slope = slope_of(mesh, table, i, low, high, a, mu, second)
            left[k], right[k] = mu, mu + slope * piece
    if first_pieces > 1 and first_pieces < n:  # back from the piece ahead
        for k in range(first_pieces - 1, -1, -1):
            h = at_m[1] - at_m[0]
            a = (z[1] - z[0]) / h
            low = z[0] + a * (fine_m[k] - at_m[0])
            high = z[0] + a * (fine_m[k + 1] - at_m[0])
            piece = fine_m[k + 1] - fine_m[k]
            mu = left[k + 1]
            slope = slope_of(mesh, table, 0, low, high, a, mu, second)
            left[k], right[k] = mu - slope * piece, mu
    return Prices(left, right, max(second, 0.0))


@compiled
def join_costate(prices: Prices, limits: Floats) -> None:
    """Close the jumps of the costate in place, but where the limit changes: on one limit its price is spread evenly."""
    for k in range(1, len(limits)):
        if limits[k] == limits[k - 1]:
            mean = 0.5 * (prices.right[k - 1] + prices.left[k])
            prices.right[k - 1] = mean
            prices.left[k] = mean


@compiled
def laid_under(way: WayTable, most: Floats, pull_most: float, at_m: Floats) -> tuple[Floats, Floats, Floats]:
    """Rows of Stretch, greatest z at the points, and integrals of the gradient (see `dual`)."""
    n = len(at_m) - 1
    stretches, tops, pulled = np.zeros((n, 6)), np.empty(n + 1), np.zeros((n, 2))
    k = 0
    for i in range(n):
        while way.at_m[k + 1] <= at_m[i]:
            k += 1
        top = 0.0
        limit = 0.0
        least, greatest = math.inf, -math.inf
        drag_least, drag_most = math.inf, -math.inf
        j = k
        while j < len(way.limit) and way.at_m[j] < at_m[i + 1]:
            a, b = max(way.at_m[j], at_m[i]), min(way.at_m[j + 1], at_m[i + 1])
            h = way.at_m[j + 1] - way.at_m[j]
            grade = (way.lift[j + 1] - way.lift[j]) / h
            # Up from the metre behind at the greatest rate, and down to the one ahead.
            rise = min(way.acceleration, pull_most - grade)
            rise_b = most[j] + max(rise, 0.0) * (b - way.at_m[j])
            fall_a = most[j + 1] + way.deceleration * (way.at_m[j + 1] - a)
            if j == k:
                fall_here = fall_a
                rise_here = most[j] + max(rise, 0.0) * (a - way.at_m[j])
                tops[i] = min(rise_here, fall_here, way.limit[j])
            top = max(top, min(rise_b, fall_a, way.limit[j]))
            limit = max(limit, way.limit[j])
            least, greatest = min(least, grade), max(greatest, grade)
            drag_least, drag_most = min(drag_least, way.drag[j]), max(drag_most, way.drag[j])
            pulled[i, 0] += grade * (b - a)
            pulled[i, 1] += grade * (b - a) * (0.5 * (a + b) - at_m[i])
            j += 1
        stretches[i, 0] = math.sqrt(2.0 * top)
        stretches[i, 1] = way.deceleration - least
        stretches[i, 2] = way.acceleration + greatest
        stretches[i, 3] = drag_least
        stretches[i, 4] = drag_most
        stretches[i, 5] = limit
    tops[0], tops[n] = way.first, way.last
    return stretches, tops, pulled


def lower_bound_j(course: Course, optimum: Optimum, time_s: float) -> float:
    """No run of the course within `time_s` needs less at the wire, J; the optimum only says where to look."""
    found = laid_course(course)
    return bound_of(found, optimum, time_s)


def bound_of(found: CourseOnMesh, optimum: Optimum, time_s: float, left_out: Term | None = None) -> float:
    """`lower_bound_j` of a course laid out; `left_out` makes it wrong on purpose."""
    course, way = found.course, found.way
    mesh, _ = mesh_of(found, optimum.position_m, time_s)
    second = optimum.price_w / found.inertia_kg
    z = 0.5 * optimum.speed_mps**2
    at_m = optimum.position_m
    fine_m = graded_mesh(at_m, z)
    prices = choice(mesh, found.table, at_m, z, optimum.costate, second, fine_m)
    limits = np.unique(np.sqrt(2.0 * way.limit))
    cells = cells_of(course.train, course.load_share, corners_mps(course.train, course.load_share, limits))
    stretches, tops, pulled = laid_under(
        way, ceilings(way, found.table), float(found.table[:, PULL, 0].max()), fine_m
    )
    join_costate(prices, stretches[:, 5])
    costs = CostsBesideForces(mesh.auxiliary, way.brake_extra, course.regeneration)
    ends = np.array([way.first, way.last])
    left = NONE_LEFT_OUT if left_out is None else int(left_out)
    bound = dual(cells, costs, fine_m, stretches, tops, pulled, ends, prices, time_s, left)
    return float(bound * found.inertia_kg)
