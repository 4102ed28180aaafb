"""Newton's method for the run of least energy: an interior point method with a tridiagonal matrix.

Unknown is z = v^2/2 at the mesh's points; on a stretch z is straight, so acceleration a is constant and the time
2 h / (v + v') exact. The motors' force per mass is f = a + r + g, r at the mean of z and g the mean gradient:

    minimise  sum h (eta_r f + kappa p + eta_r q)  subject to  sum 2 h / (v + v') <= T,
    p >= f, p >= 0 (traction),  q >= -f - e, q >= 0 (air brake),  limits of f, a and z,

with kappa = 1 / eta - eta_r. Every limit c >= 0 has a slack s and a price y; the step solves the perturbed conditions
c = s, s y = weight, linearised, all but z eliminated stretch by stretch; the time is one row more. Where the matrix is
not positive, each stretch's own part is made so.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from vehicle.optimum.laws import ALL_MOTORS
from vehicle.optimum.local import (
    AIR,
    LIMITS,
    SLOWING,
    SPEEDING,
    STRONG,
    TRACTION,
    WEAK,
    Mesh,
    braking,
    costs_at,
    local,
    terms,
    traction,
)
from vehicle.records import TrainRow
from vehicle.wire import wire_power_w

Floats = NDArray[np.float64]

WEIGHT_LAST: Final = 1e-7
RESIDUAL_LAST: Final = 1e-3  # m/s^2
RESIDUAL_ROUNDED: Final = 0.1
FULL_STEPS: Final = 3
STEPS_MAX: Final = 120
TO_THE_EDGE: Final = 0.99
SLACK_FIRST: Final = 0.05


class InteriorPoint(NamedTuple):
    """Slacks and prices; changed in place. `ends` has the time's slack and price, and the weight."""

    slack: Floats  # (stretches, LIMITS)
    price: Floats
    top_slack: Floats  # points
    top_price: Floats
    ends: Floats
    costate: Floats  # stretches: what z is worth


@compiled
def starting_slacks(mesh: Mesh, table: Floats, z: Floats, weight: float) -> InteriorPoint:
    """Slacks at a start, off their edges, with the prices that the weight asks for."""
    n = len(mesh.h_m)
    slack, price = np.ones((n, LIMITS)), np.zeros((n, LIMITS))
    time_s = 0.0
    for i in range(n):
        h = mesh.h_m[i]
        a = (z[i + 1] - z[i]) / h
        x = local(mesh, table, i, a, 0.5 * (z[i] + z[i + 1]))
        paid = costs_at(mesh, table, 0.5 * (z[i] + z[i + 1]))
        time_s += 2.0 * h / (math.sqrt(2.0 * z[i]) + math.sqrt(2.0 * z[i + 1]))
        slack[i, TRACTION] = max(x.f, 0.0) + SLACK_FIRST
        slack[i, TRACTION + 1] = slack[i, TRACTION] - x.f
        slack[i, AIR] = max(-x.f - x.elec, 0.0) + SLACK_FIRST
        slack[i, AIR + 1] = slack[i, AIR] + x.f + x.elec
        slack[i, STRONG] = max(x.pull - x.f, SLACK_FIRST)
        slack[i, WEAK] = max(x.f + x.elec + mesh.brake_extra, SLACK_FIRST)
        slack[i, SLOWING] = max(a + mesh.deceleration, SLACK_FIRST)
        slack[i, SPEEDING] = max(mesh.acceleration - a, SLACK_FIRST)
        for k in range(2):
            price[i, TRACTION + k] = 0.5 * paid.kink.value if mesh.kinked else 0.0
            price[i, AIR + k] = 0.5 * paid.gain.value if mesh.regenerates else 0.0
        for k in range(STRONG, LIMITS):
            price[i, k] = weight / slack[i, k]
        if mesh.brake_extra == math.inf:
            price[i, WEAK] = 0.0
        if mesh.acceleration == math.inf:
            price[i, SPEEDING] = 0.0
    top_slack = np.maximum((mesh.top - z) / np.maximum(mesh.top, 1e-9), SLACK_FIRST)
    top_price = weight / top_slack
    length = np.sum(mesh.h_m)
    ends = np.empty(3)
    ends[0] = max(mesh.time_s - time_s, 0.01 * mesh.time_s)
    ends[1] = 5.0 * weight * length / ends[0]
    ends[2] = weight
    return InteriorPoint(slack, price, top_slack, top_price, ends, np.zeros(n))


class LinearSystem(NamedTuple):
    """The linear system at the inner points, and how far its right side is from none."""

    diagonal: Floats
    beside: Floats
    right: Floats
    by_time: Floats
    residual: float


@compiled
def assembled(mesh: Mesh, table: Floats, z: Floats, inner: InteriorPoint, tamed: bool) -> LinearSystem:
    """The condensed system of one step."""
    n = len(mesh.h_m)
    diagonal, beside = np.zeros(n + 1), np.zeros(n + 1)
    right, by_time, exact = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    weight = inner.ends[2]
    worth = inner.ends[1] + mesh.auxiliary
    for i in range(n):
        h = mesh.h_m[i]
        a = (z[i + 1] - z[i]) / h
        mean = 0.5 * (z[i] + z[i + 1])
        x = local(mesh, table, i, a, mean)
        got = terms(mesh, x, costs_at(mesh, table, mean), a, inner.slack[i], inner.price[i], weight)
        zz = max(got.zz, got.az * got.az / got.aa) if tamed else got.zz
        inner.costate[i] = got.paid_a
        exact[i] += -got.paid_a + 0.5 * h * got.paid_z
        exact[i + 1] += got.paid_a + 0.5 * h * got.paid_z
        right[i] -= -got.by_a + 0.5 * h * got.by_z
        right[i + 1] -= got.by_a + 0.5 * h * got.by_z
        diagonal[i] += got.aa / h - got.az + 0.25 * h * zz
        diagonal[i + 1] += got.aa / h + got.az + 0.25 * h * zz
        beside[i] += -got.aa / h + 0.25 * h * zz
        _add_time(z, i, h, worth, diagonal, beside, by_time)
    residual = 0.0
    for i in range(1, n):
        step = 0.5 * (mesh.h_m[i - 1] + mesh.h_m[i])
        k = 1.0 / mesh.top[i]
        d = inner.top_price[i] / inner.top_slack[i]
        t = (weight - inner.top_price[i] * (1.0 - z[i] * k - inner.top_slack[i])) / inner.top_slack[i]
        right[i] -= step * k * t
        diagonal[i] += step * k * k * d
        exact[i] += step * k * inner.top_price[i] + worth * by_time[i]
        residual = max(residual, abs(exact[i]) / step * mesh.top[i])
    return LinearSystem(diagonal, beside, right, by_time, residual)


@compiled
def _add_time(
    z: Floats, i: int, h: float, worth: float, diagonal: Floats, beside: Floats, by_time: Floats
) -> None:
    """What the time 2 h / (v + w) of stretch `i` adds, dv/dz = 1/v."""
    n = len(z) - 1
    v, w = math.sqrt(2.0 * z[i]), math.sqrt(2.0 * z[i + 1])
    s = v + w
    t1 = -2.0 * h / (s * s)
    t2 = 4.0 * h / (s * s * s)
    if i > 0:
        by_time[i] += t1 / v
        diagonal[i] += worth * (t2 / (v * v) - t1 / (v * v * v))
    if i + 1 < n:
        by_time[i + 1] += t1 / w
        diagonal[i + 1] += worth * (t2 / (w * w) - t1 / (w * w * w))
    if 0 < i < n - 1:
        beside[i] += worth * t2 / (v * w)


@compiled
def solved_for(found: LinearSystem, constant: float, curvature: float, out: Floats) -> bool:
    """Step at the inner points into `out`; the time adds `constant` x its gradient to the right side's opposite.

    False where the matrix is not positive.
    """
    n = len(out) - 1
    pivot, left, right = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    for i in range(1, n):
        pivot[i] = found.diagonal[i]
        left[i] = found.right[i] - constant * found.by_time[i]
        right[i] = found.by_time[i]
        if i > 1:
            share = found.beside[i - 1] / pivot[i - 1]
            pivot[i] -= share * found.beside[i - 1]
            left[i] -= share * left[i - 1]
            right[i] -= share * right[i - 1]
        if not pivot[i] > 1e-13 * abs(found.diagonal[i]):
            return False
    across_left = 0.0
    across_right = 0.0
    for i in range(n - 1, 0, -1):
        if i < n - 1:
            left[i] -= found.beside[i] * left[i + 1]
            right[i] -= found.beside[i] * right[i + 1]
        left[i] /= pivot[i]
        right[i] /= pivot[i]
        across_left += found.by_time[i] * left[i]
        across_right += found.by_time[i] * right[i]
    share = curvature * across_left / (1.0 + curvature * across_right)
    out[0] = 0.0
    out[n] = 0.0
    for i in range(1, n):
        out[i] = left[i] - share * right[i]
    return True


@compiled
def edge(share: float, value: float, change: float) -> float:
    """The share of a step that keeps a value above 0."""
    return min(share, -TO_THE_EDGE * value / change) if change < 0.0 else share


@compiled
def slack_steps(
    mesh: Mesh,
    table: Floats,
    z: Floats,
    inner: InteriorPoint,
    out: Floats,
    ds: Floats,
    dy: Floats,
    shares: Floats,
) -> None:
    """Steps of slacks and prices that go with the step `out` of z, and the shares of both that stay inside."""
    n = len(mesh.h_m)
    s, y = inner.slack, inner.price
    weight = inner.ends[2]
    primal = 1.0
    dual = 1.0
    for i in range(n):
        h = mesh.h_m[i]
        a = (z[i + 1] - z[i]) / h
        da = (out[i + 1] - out[i]) / h
        dz = 0.5 * (out[i] + out[i + 1])
        x = local(mesh, table, i, a, 0.5 * (z[i] + z[i + 1]))
        df = da + x.f_z * dz
        de = x.elec_z * dz
        paid = costs_at(mesh, table, 0.5 * (z[i] + z[i + 1]))
        ds[i, 0] = ds[i, 1] = ds[i, 2] = ds[i, 3] = 0.0
        if mesh.kinked:
            one = traction(x, paid, s[i, 0], s[i, 1], y[i, 0], y[i, 1], weight)
            ds[i, 0] = one.own + one.with_f * df + one.with_z * dz
            ds[i, 1] = ds[i, 0] - df + s[i, 0] - x.f - s[i, 1]
        if mesh.regenerates:
            two = braking(x, paid, mesh.regeneration, s[i, 2], s[i, 3], y[i, 2], y[i, 3], weight)
            ds[i, 2] = two.own + two.with_f * df + two.with_z * dz
            ds[i, 3] = ds[i, 2] + df + de + s[i, 2] + x.f + x.elec - s[i, 3]
        ds[i, STRONG] = x.pull_z * dz - df + x.pull - x.f - s[i, STRONG]
        ds[i, SLOWING] = da + a + mesh.deceleration - s[i, SLOWING]
        ds[i, WEAK] = 0.0
        ds[i, SPEEDING] = 0.0
        if mesh.brake_extra < math.inf:
            ds[i, WEAK] = df + de + x.f + x.elec + mesh.brake_extra - s[i, WEAK]
        if mesh.acceleration < math.inf:
            ds[i, SPEEDING] = -da + mesh.acceleration - a - s[i, SPEEDING]
        for k in range(LIMITS):
            dy[i, k] = 0.0
            if y[i, k] > 0.0:
                dy[i, k] = (weight - y[i, k] * ds[i, k]) / s[i, k] - y[i, k]
                primal = edge(primal, s[i, k], ds[i, k])
                dual = edge(dual, y[i, k], dy[i, k])
        if i > 0 and out[i] < 0.0:
            primal = min(primal, -0.9 * z[i] / out[i])
    shares[0] = primal
    shares[1] = dual


@compiled
def newton_step(mesh: Mesh, table: Floats, z: Floats, inner: InteriorPoint) -> tuple[float, float, float]:
    """One step of everything, in place: the residual before it, the shares taken of primal and dual step."""
    n = len(mesh.h_m)
    length = np.sum(mesh.h_m)
    weight = inner.ends[2]
    time_s = 0.0
    for i in range(n):
        time_s += 2.0 * mesh.h_m[i] / (math.sqrt(2.0 * z[i]) + math.sqrt(2.0 * z[i + 1]))
    spare, price = inner.ends[0], inner.ends[1]
    off = mesh.time_s - time_s - spare
    # right side of the time: worth = auxiliaries + (weight - price * off) / spare
    constant = mesh.auxiliary + (weight * length - price * off) / spare
    out = np.zeros(n + 1)
    found = assembled(mesh, table, z, inner, False)
    if not solved_for(found, constant, price / spare, out):
        found = assembled(mesh, table, z, inner, True)
        solved_for(found, constant, price / spare, out)
    ds, dy, shares = np.empty((n, LIMITS)), np.empty((n, LIMITS)), np.empty(2)
    slack_steps(mesh, table, z, inner, out, ds, dy, shares)
    primal, dual = shares[0], shares[1]
    change_s = 0.0
    top_ds, top_dy = np.zeros(n + 1), np.zeros(n + 1)
    for i in range(1, n):
        change_s += found.by_time[i] * out[i]
        k = 1.0 / mesh.top[i]
        ts, ty = inner.top_slack[i], inner.top_price[i]
        top_ds[i] = 1.0 - z[i] * k - ts - k * out[i]
        top_dy[i] = (weight - ty * top_ds[i]) / ts - ty
        primal = edge(primal, ts, top_ds[i])
        dual = edge(dual, ty, top_dy[i])
    spare_d = off - change_s
    price_d = (weight * length - price * spare_d) / spare - price
    primal = edge(primal, spare, spare_d)
    dual = edge(dual, price, price_d)
    for i in range(1, n):
        z[i] += primal * out[i]
        inner.top_slack[i] += primal * top_ds[i]
        inner.top_price[i] += dual * top_dy[i]
    for i in range(n):
        for k in range(LIMITS):
            inner.slack[i, k] += primal * ds[i, k]
            inner.price[i, k] += dual * dy[i, k]
    inner.ends[0] += primal * spare_d
    inner.ends[1] += dual * price_d
    return found.residual, primal, dual


@compiled
def complementarity(mesh: Mesh, inner: InteriorPoint) -> float:
    """Mean of slack times price over all limits in force."""
    total = 0.0
    count = 0.0
    n = len(mesh.h_m)
    for i in range(n):
        for k in range(LIMITS):
            if inner.price[i, k] > 0.0:
                total += mesh.h_m[i] * inner.slack[i, k] * inner.price[i, k]
                count += mesh.h_m[i]
        if i > 0:
            total += mesh.h_m[i] * inner.top_slack[i] * inner.top_price[i]
            count += mesh.h_m[i]
    return float((total + inner.ends[0] * inner.ends[1]) / (count + np.sum(mesh.h_m)))


@compiled
def follow_path(mesh: Mesh, table: Floats, z: Floats, inner: InteriorPoint) -> int:
    """Step until weight and residual are at their last, `z` and `inner` in place; steps, 0 if it did not get there."""
    at_last = 0
    for step in range(STEPS_MAX):
        residual, primal, dual = newton_step(mesh, table, z, inner)
        mean = complementarity(mesh, inner)
        if mean < 2.0 * WEIGHT_LAST and min(primal, dual) > 0.9:
            at_last += 1
            # What is left after full steps is rounding: the residual is multiplied by the mesh's fineness.
            if residual < RESIDUAL_LAST or (at_last >= FULL_STEPS and residual < RESIDUAL_ROUNDED):
                return step + 1
        if not residual < math.inf:
            return 0
        share = 1.0 - min(primal, dual)
        inner.ends[2] = max(mean * min(max(0.1, share * share), 0.8), WEIGHT_LAST)
    return 0


@compiled
def forces_and_energy(
    mesh: Mesh, table: Floats, train: TrainRow, inertia_kg: float, regeneration: float, z: Floats
) -> tuple[Floats, Floats, float]:
    """Forces of motors and air brake on each stretch, N, and the energy at the wire, J, auxiliaries apart."""
    n = len(mesh.h_m)
    motors, air = np.empty(n), np.empty(n)
    energy_j = 0.0
    for i in range(n):
        h = mesh.h_m[i]
        mean = 0.5 * (z[i] + z[i + 1])
        x = local(mesh, table, i, (z[i + 1] - z[i]) / h, mean)
        motors[i] = inertia_kg * max(x.f, -x.elec)
        air[i] = inertia_kg * max(-x.elec - x.f, 0.0)
        speed = math.sqrt(2.0 * mean)
        power_w = wire_power_w(train, ALL_MOTORS, motors[i], speed)
        energy_j += h / speed * (power_w if power_w > 0.0 else regeneration * power_w)
    return motors, air, energy_j
