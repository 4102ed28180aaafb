"""Newton's method for the run of least energy: log barriers, a tridiagonal Hessian, one row for the time.

Unknown is z = v^2/2 at the mesh's points; on a stretch z is straight, so acceleration a is constant and the time
2 h / (v + v') exact. The motors' force per mass is f = a + r + g, r at the mean of z and g the mean gradient:

    minimise  sum h phi(f, z)  subject to  sum 2 h / (v + v') <= T, limits of f, a and z,
    phi = f / eta for f > 0, eta_r max(f, -e) below.

Both kinks of phi are rounded by a width that goes to zero with the barrier. Outside its domain a barrier goes on as a
parabola, so a start need not be feasible. Where the Hessian is not positive, each stretch's own part is made so.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from vehicle.optimum.laws import ELECTRIC, PULL, RESIST, law_slopes

Floats = NDArray[np.float64]

WEIGHT_LAST: Final = 2e-7
WEIGHT_RATIO: Final = 0.2
STEPS_MAX: Final = 400
STEPS_A_WEIGHT: Final = 25
RELAXED: Final = 0.02  # below this share of the weight-dependent scale a barrier is a parabola


class Mesh(NamedTuple):
    """What Newton's method works on; per stretch, points are one more."""

    h_m: Floats
    grade: Floats
    drag: Floats
    top: Floats  # of z, at the points
    inverse_traction: float  # 1 / efficiency
    regenerated: float  # efficiency times the share that counts
    brake_extra: float
    deceleration: float
    acceleration: float
    auxiliary: float  # W/kg, what time itself costs
    time_s: float
    force_scale: float


class Part(NamedTuple):
    """A stretch's cost by metre and its derivatives by a and mean z."""

    value: float
    by_a: float
    by_z: float
    by_aa: float
    by_az: float
    by_zz: float


@compiled
def barrier(x: float, weight: float, width: float) -> tuple[float, float, float]:
    """-weight log(x) with two derivatives; below `width` the parabola that joins it smoothly."""
    if x > width:
        q = weight / x
        return -weight * math.log(x), -q, q / x
    u = (x - 2.0 * width) / width
    return weight * (0.5 * (u * u - 1.0) - math.log(width)), weight * u / width, weight / (width * width)


@compiled
def plus(x: float, width: float) -> tuple[float, float, float]:
    """max(x, 0) rounded by `width`, with two derivatives."""
    root = math.sqrt(x * x + width * width)
    return 0.5 * (x + root), 0.5 * (1.0 + x / root), 0.5 * width * width / (root * root * root)


@compiled
def part(mesh: Mesh, table: Floats, i: int, a: float, z: float, weight: float) -> Part:
    """The cost of stretch `i` by metre, barriers included."""
    speed = math.sqrt(2.0 * z)
    r, r_z, r_zz = law_slopes(table, RESIST, speed)
    pull, pull_z, pull_zz = law_slopes(table, PULL, speed)
    elec, elec_z, elec_zz = law_slopes(table, ELECTRIC, speed)
    f = a + r + 2.0 * mesh.drag[i] * z + mesh.grade[i]
    f_z = r_z + 2.0 * mesh.drag[i]
    round_off = max(3.0 * weight, 1e-7)
    width = max(RELAXED * weight, 1e-10)

    # electricity: u = f - plus(-f - e) is what the motors do
    kink = mesh.inverse_traction - mesh.regenerated
    up, up1, up2 = plus(f, round_off)
    air, air1, air2 = plus(-f - elec, round_off)
    value = mesh.regenerated * (f + air) + kink * up
    by_f = mesh.regenerated * (1.0 - air1) + kink * up1
    by_ff = mesh.regenerated * air2 + kink * up2
    by_e = -mesh.regenerated * air1
    by_fe = mesh.regenerated * air2
    by_ee = mesh.regenerated * air2

    # x = pull - f, and f + electric + friction
    b, b1, b2 = barrier(pull - f, weight, width)
    value += b
    by_f -= b1
    by_ff += b2
    by_p, by_fp, by_pp = b1, -b2, b2
    if mesh.brake_extra < math.inf:
        b, b1, b2 = barrier(f + elec + mesh.brake_extra, weight, width)
        value += b
        by_f += b1
        by_ff += b2
        by_e += b1
        by_fe += b2
        by_ee += b2

    by_a, by_aa = by_f, by_ff
    b, b1, b2 = barrier(a + mesh.deceleration, weight, width)
    value += b
    by_a += b1
    by_aa += b2
    if mesh.acceleration < math.inf:
        b, b1, b2 = barrier(mesh.acceleration - a, weight, width)
        value += b
        by_a -= b1
        by_aa += b2
    by_z = by_f * f_z + by_p * pull_z + by_e * elec_z
    by_az = by_ff * f_z + by_fp * pull_z + by_fe * elec_z
    by_zz = by_ff * f_z * f_z + by_pp * pull_z * pull_z + by_ee * elec_z * elec_z
    by_zz += 2.0 * f_z * (by_fp * pull_z + by_fe * elec_z)
    by_zz += by_f * r_zz + by_p * pull_zz + by_e * elec_zz
    return Part(value, by_a, by_z, by_aa, by_az, by_zz)


@compiled
def objective(mesh: Mesh, table: Floats, z: Floats, weight: float) -> float:
    """What Newton's method lowers: energy and barriers, m^2/s^2."""
    total = 0.0
    time_s = 0.0
    n = len(mesh.h_m)
    length = 0.0
    for i in range(n):
        h = mesh.h_m[i]
        length += h
        mean = 0.5 * (z[i] + z[i + 1])
        if mean <= 0.0:
            return math.inf
        total += h * part(mesh, table, i, (z[i + 1] - z[i]) / h, mean, weight).value
        time_s += 2.0 * h / (math.sqrt(2.0 * z[i]) + math.sqrt(2.0 * z[i + 1]))
    for i in range(1, n):
        step = 0.5 * (mesh.h_m[i - 1] + mesh.h_m[i])
        scale = mesh.force_scale / mesh.top[i]
        total += step * barrier((mesh.top[i] - z[i]) * scale, weight, RELAXED * weight)[0]
    spare = (mesh.time_s - time_s) / mesh.time_s
    total += length * barrier(spare, weight, RELAXED * weight)[0]
    return total + mesh.auxiliary * time_s


class Slopes(NamedTuple):
    """Gradient and Hessian of the objective at the inner points, the time's own gradient, and more."""

    gradient: Floats
    diagonal: Floats
    beside: Floats
    time_gradient: Floats
    time_weight: float
    price: float
    time_s: float


@compiled
def slopes(mesh: Mesh, table: Floats, z: Floats, weight: float, tamed: bool) -> Slopes:
    """Derivatives of the objective; `tamed`: each stretch's Hessian made positive by itself."""
    n = len(mesh.h_m)
    gradient, diagonal, beside, by_time = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    time_s = 0.0
    length = 0.0
    for i in range(n):
        h = mesh.h_m[i]
        length += h
        speeds = math.sqrt(2.0 * z[i]) + math.sqrt(2.0 * z[i + 1])
        time_s += 2.0 * h / speeds
    spare = (mesh.time_s - time_s) / mesh.time_s
    _, b1, b2 = barrier(spare, weight, RELAXED * weight)
    time_price = -length * b1 / mesh.time_s
    price = time_price + mesh.auxiliary
    for i in range(n):
        h = mesh.h_m[i]
        p = part(mesh, table, i, (z[i + 1] - z[i]) / h, 0.5 * (z[i] + z[i + 1]), weight)
        zz = p.by_zz
        if tamed:
            zz = max(zz, p.by_az * p.by_az / p.by_aa)
        gradient[i] += -p.by_a + 0.5 * h * p.by_z
        gradient[i + 1] += p.by_a + 0.5 * h * p.by_z
        diagonal[i] += p.by_aa / h - p.by_az + 0.25 * h * zz
        diagonal[i + 1] += p.by_aa / h + p.by_az + 0.25 * h * zz
        beside[i] += -p.by_aa / h + 0.25 * h * zz
        # time: 2 h / (v + w), with dv/dz = 1/v
        v, w = math.sqrt(2.0 * z[i]), math.sqrt(2.0 * z[i + 1])
        s = v + w
        t1 = -2.0 * h / (s * s)
        t2 = 4.0 * h / (s * s * s)
        if i > 0:
            by_time[i] += t1 / v
            diagonal[i] += price * (t2 / (v * v) - t1 / (v * v * v))
        if i + 1 < n:
            by_time[i + 1] += t1 / w
            diagonal[i + 1] += price * (t2 / (w * w) - t1 / (w * w * w))
        if 0 < i < n - 1:
            beside[i] += price * t2 / (v * w)
    for i in range(1, n):
        step = 0.5 * (mesh.h_m[i - 1] + mesh.h_m[i])
        scale = mesh.force_scale / mesh.top[i]
        _, c1, c2 = barrier((mesh.top[i] - z[i]) * scale, weight, RELAXED * weight)
        gradient[i] += -step * c1 * scale + price * by_time[i]
        diagonal[i] += step * c2 * scale * scale
    return Slopes(
        gradient, diagonal, beside, by_time, length * b2 / mesh.time_s**2, time_price, time_s
    )


@compiled
def direction(found: Slopes, out: Floats) -> bool:
    """Newton's step at the inner points into `out`; False where the Hessian is not positive."""
    n = len(out) - 1
    pivot = np.empty(n + 1)
    left = np.empty(n + 1)  # -H^-1 gradient
    right = np.empty(n + 1)  # H^-1 time gradient
    for i in range(1, n):
        pivot[i] = found.diagonal[i]
        left[i] = -found.gradient[i]
        right[i] = found.time_gradient[i]
        if i > 1:
            share = found.beside[i - 1] / pivot[i - 1]
            pivot[i] -= share * found.beside[i - 1]
            left[i] -= share * left[i - 1]
            right[i] -= share * right[i - 1]
        if not pivot[i] > 1e-12 * found.diagonal[i]:
            return False
    across_left = 0.0
    across_right = 0.0
    for i in range(n - 1, 0, -1):
        if i < n - 1:
            left[i] -= found.beside[i] * left[i + 1]
            right[i] -= found.beside[i] * right[i + 1]
        left[i] /= pivot[i]
        right[i] /= pivot[i]
        across_left += found.time_gradient[i] * left[i]
        across_right += found.time_gradient[i] * right[i]
    share = found.time_weight * across_left / (1.0 + found.time_weight * across_right)
    out[0] = 0.0
    out[n] = 0.0
    for i in range(1, n):
        out[i] = left[i] - share * right[i]
    return True


@compiled
def descend(mesh: Mesh, table: Floats, z: Floats, weight: float, steps_max: int) -> int:
    """Lower the objective of one weight, `z` in place; the number of steps."""
    n = len(z) - 1
    out = np.zeros(n + 1)
    tried = np.empty(n + 1)
    length = np.sum(mesh.h_m)
    value = objective(mesh, table, z, weight)
    for step in range(steps_max):
        found = slopes(mesh, table, z, weight, False)
        good = direction(found, out)
        if not good:
            found = slopes(mesh, table, z, weight, True)
            direction(found, out)
        falls = 0.0
        share = 1.0
        for i in range(1, n):
            falls += found.gradient[i] * out[i]
            if out[i] < 0.0:
                share = min(share, -0.8 * z[i] / out[i])
        if -falls < 1e-2 * weight * weight * length or -falls < 1e-12 * abs(value):
            return step
        lowered = False
        for _ in range(30):
            for i in range(n + 1):
                tried[i] = z[i] + share * out[i]
            after = objective(mesh, table, tried, weight)
            if after <= value + 1e-4 * share * falls:
                lowered = True
                break
            share *= 0.5
        if not lowered:
            return step
        z[:] = tried
        value = after
    return steps_max


@compiled
def follow(mesh: Mesh, table: Floats, z: Floats, weight: float) -> tuple[int, Floats, float, float]:
    """Lower the weight to the last, `z` in place: steps taken, costate of the stretches, price W/kg, time s."""
    taken = 0
    while True:
        taken += descend(mesh, table, z, weight, STEPS_A_WEIGHT)
        if weight <= WEIGHT_LAST or taken >= STEPS_MAX:
            break
        weight = max(WEIGHT_RATIO * weight, WEIGHT_LAST)
    n = len(mesh.h_m)
    costate = np.empty(n)
    for i in range(n):
        h = mesh.h_m[i]
        costate[i] = part(mesh, table, i, (z[i + 1] - z[i]) / h, 0.5 * (z[i] + z[i + 1]), weight).by_a
    found = slopes(mesh, table, z, weight, False)
    return taken, costate, found.price, found.time_s
