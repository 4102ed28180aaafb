"""One stretch of the mesh: its forces, what they cost, and what its own unknowns leave to Newton's step.

Traction p and air brake q are eliminated stretch by stretch; what they leave are slopes and curvatures by the force f
and the mean z, and with those of the limits by the acceleration a and z alone.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled
from vehicle.optimum.laws import BEND, CURVE, ELECTRIC, GAIN, IDLE, PULL, RESIST, SLOPE, law_slopes

Floats = NDArray[np.float64]

# places of a stretch's slacks and prices
TRACTION: Final = 0  # p >= 0, then p >= f
AIR: Final = 2  # q >= 0, then q >= -f - e
STRONG: Final = 4  # f below the greatest pull
WEAK: Final = 5  # and above what all brakes give
SLOWING: Final = 6
SPEEDING: Final = 7
LIMITS: Final = 8


class Mesh(NamedTuple):
    """What the method works on; per stretch, points are one more."""

    h_m: Floats
    grade: Floats
    drag: Floats
    top: Floats  # of z, at the points
    regeneration: float  # share of what comes back that counts
    kinked: bool  # pulling costs more than braking gives back
    regenerates: bool
    plain: bool  # costs that no speed changes
    brake_extra: float
    deceleration: float
    acceleration: float
    auxiliary: float  # W/kg, what time itself costs
    time_s: float


class CostWithSlopes(NamedTuple):
    """A quantity of the costs with two derivatives by z."""

    value: float
    by_z: float
    by_zz: float


class ForceCosts(NamedTuple):
    """The costs of forces on a stretch: of traction above what braking gives back, that itself, and the rest."""

    kink: CostWithSlopes
    gain: CostWithSlopes
    bend: CostWithSlopes
    curve: CostWithSlopes
    idle: CostWithSlopes


class Local(NamedTuple):
    """A stretch at a and mean z: forces and their slopes by z."""

    f: float
    f_z: float
    f_zz: float
    pull: float
    pull_z: float
    pull_zz: float
    elec: float
    elec_z: float
    elec_zz: float


@compiled
def local(mesh: Mesh, table: Floats, i: int, a: float, z: float) -> Local:
    """Forces of stretch `i`."""
    speed = math.sqrt(2.0 * z)
    r, r_z, r_zz = law_slopes(table, RESIST, speed)
    pull, pull_z, pull_zz = law_slopes(table, PULL, speed)
    elec, elec_z, elec_zz = law_slopes(table, ELECTRIC, speed)
    drag = 2.0 * mesh.drag[i]
    f = a + r + drag * z + mesh.grade[i]
    return Local(f, r_z + drag, r_zz, pull, pull_z, pull_zz, elec, elec_z, elec_zz)


@compiled
def cost(table: Floats, law: int, speed: float) -> CostWithSlopes:
    """One quantity at a speed."""
    value, by_z, by_zz = law_slopes(table, law, speed)
    return CostWithSlopes(value, by_z, by_zz)


@compiled
def costs_at(mesh: Mesh, table: Floats, z: float) -> ForceCosts:
    """The costs at a mean z."""
    if mesh.plain:
        slope, gain = table[0, SLOPE, 0], table[0, GAIN, 0]
        none = CostWithSlopes(0.0, 0.0, 0.0)
        return ForceCosts(
            CostWithSlopes(slope - gain, 0.0, 0.0), CostWithSlopes(gain, 0.0, 0.0), none, none, none
        )
    speed = math.sqrt(2.0 * z)
    pull, gain_at = cost(table, SLOPE, speed), cost(table, GAIN, speed)
    kink = CostWithSlopes(pull.value - gain_at.value, pull.by_z - gain_at.by_z, pull.by_zz - gain_at.by_zz)
    return ForceCosts(
        kink, gain_at, cost(table, BEND, speed), cost(table, CURVE, speed), cost(table, IDLE, speed)
    )


class Reduced(NamedTuple):
    """What a stretch's own unknown leaves when it is eliminated, by f and z, and how it follows them."""

    by_f: float
    by_z: float
    ff: float
    fz: float
    zz: float
    own: float  # its step without any of f and z
    with_f: float
    with_z: float
    paid_f: float  # slopes by f and z at the prices themselves
    paid_z: float
    paid_zz: float


@compiled
def traction(
    x: Local, paid: ForceCosts, s0: float, s1: float, y0: float, y1: float, weight: float
) -> Reduced:
    """kink p + curve max(p - bend, 0)^2 with p = s0 >= 0 and p >= f."""
    k, bend, curve = paid.kink, paid.bend, paid.curve
    w = max(s0 - bend.value, 0.0)
    on = 1.0 if w > 0.0 else 0.0
    d0, d1 = y0 / s0, y1 / s1
    t0, t1 = weight / s0, (weight - y1 * (s0 - x.f - s1)) / s1
    g_p = k.value + 2.0 * curve.value * w - t0 - t1
    pp = d0 + d1 + 2.0 * curve.value * on
    pz = k.by_z + 2.0 * curve.by_z * w - 2.0 * curve.value * bend.by_z * on
    g_z = k.by_z * s0 + curve.by_z * w * w - 2.0 * curve.value * w * bend.by_z
    zz = k.by_zz * s0 + curve.by_zz * w * w - 4.0 * curve.by_z * w * bend.by_z
    zz += -2.0 * curve.value * w * bend.by_zz + 2.0 * curve.value * bend.by_z * bend.by_z * on
    return Reduced(
        t1 + d1 * g_p / pp,
        g_z - pz * g_p / pp,
        d1 - d1 * d1 / pp,
        d1 * pz / pp,
        zz - pz * pz / pp,
        -g_p / pp,
        d1 / pp,
        -pz / pp,
        y1,
        g_z,
        0.0,
    )


@compiled
def braking(
    x: Local, paid: ForceCosts, share: float, s0: float, s1: float, y0: float, y1: float, weight: float
) -> Reduced:
    """gain (f + q) + curve max(-f - q - bend, 0)^2 with q = s0 >= 0 and q >= -f - e.

    The gain has the share that counts in it, the curve takes it here.
    """
    gain, bend, curve = paid.gain, paid.bend, paid.curve
    c, c_z, c_zz = share * curve.value, share * curve.by_z, share * curve.by_zz
    motors = x.f + s0
    w = max(-motors - bend.value, 0.0)
    on = 1.0 if w > 0.0 else 0.0
    d0, d1 = y0 / s0, y1 / s1
    t0, t1 = weight / s0, (weight - y1 * (s0 + x.f + x.elec - s1)) / s1
    by_motors = gain.value - 2.0 * c * w
    g_q, g_f = by_motors - t0 - t1, by_motors - t1
    g_direct = gain.by_z * motors + c_z * w * w - 2.0 * c * w * bend.by_z
    g_z = g_direct - t1 * x.elec_z
    ff = 2.0 * c * on + d1
    qq = ff + d0
    qz = gain.by_z - 2.0 * c_z * w + 2.0 * c * bend.by_z * on + d1 * x.elec_z
    zz = gain.by_zz * motors + c_zz * w * w - 4.0 * c_z * w * bend.by_z - 2.0 * c * w * bend.by_zz
    zz += 2.0 * c * bend.by_z * bend.by_z * on + d1 * x.elec_z * x.elec_z
    return Reduced(
        g_f - ff * g_q / qq,
        g_z - qz * g_q / qq,
        ff - ff * ff / qq,
        qz - ff * qz / qq,
        zz - qz * qz / qq,
        -g_q / qq,
        -ff / qq,
        -qz / qq,
        by_motors - y1,
        g_direct - y1 * x.elec_z,
        -y1 * x.elec_zz,
    )


class LocalSlopes(NamedTuple):
    """Slopes and curvatures of a stretch by a and mean z, by metre; and its slopes at the prices themselves."""

    by_a: float
    by_z: float
    aa: float
    az: float
    zz: float
    paid_a: float
    paid_z: float


@compiled
def own_terms(mesh: Mesh, x: Local, paid: ForceCosts, s: Floats, y: Floats, weight: float) -> Reduced:
    """What traction, brakes and idle motors of a stretch leave together."""
    idle = paid.idle
    by_f = by_z = ff = fz = zz = paid_f = paid_z = paid_zz = 0.0
    if mesh.kinked:
        one = traction(x, paid, s[TRACTION], s[TRACTION + 1], y[TRACTION], y[TRACTION + 1], weight)
        by_f, by_z, ff, fz, zz = one.by_f, one.by_z, one.ff, one.fz, one.zz
        paid_f, paid_z, paid_zz = one.paid_f, one.paid_z, one.paid_zz
    if mesh.regenerates:
        two = braking(x, paid, mesh.regeneration, s[AIR], s[AIR + 1], y[AIR], y[AIR + 1], weight)
        by_f, by_z, ff, fz, zz = by_f + two.by_f, by_z + two.by_z, ff + two.ff, fz + two.fz, zz + two.zz
        paid_f, paid_z, paid_zz = paid_f + two.paid_f, paid_z + two.paid_z, paid_zz + two.paid_zz
    zz += idle.by_zz + paid_zz
    return Reduced(by_f, by_z + idle.by_z, ff, fz, zz, 0.0, 0.0, 0.0, paid_f, paid_z + idle.by_z, 0.0)


@compiled
def barrier_terms(slack: float, price: float, value: float, weight: float) -> tuple[float, float]:
    """Slope and curvature by its value that a limit leaves when its slack is eliminated."""
    return -(weight - price * (value - slack)) / slack, price / slack


@compiled
def terms(
    mesh: Mesh, x: Local, paid: ForceCosts, a: float, s: Floats, y: Floats, weight: float
) -> LocalSlopes:
    """All of a stretch: costs, greatest pull, all brakes, deceleration and acceleration."""
    own = own_terms(mesh, x, paid, s, y, weight)
    t, d = barrier_terms(s[STRONG], y[STRONG], x.pull - x.f, weight)
    by_f, ff, paid_f = own.by_f - t, own.ff + d, own.paid_f + y[STRONG]
    by_z = own.by_z + t * x.pull_z
    fz = own.fz - d * x.pull_z
    zz = own.zz + d * x.pull_z * x.pull_z - y[STRONG] * x.pull_zz
    paid_z = own.paid_z - y[STRONG] * x.pull_z
    if mesh.brake_extra < math.inf:
        t, d = barrier_terms(s[WEAK], y[WEAK], x.f + x.elec + mesh.brake_extra, weight)
        by_f, ff, paid_f = by_f + t, ff + d, paid_f - y[WEAK]
        by_z += t * x.elec_z
        fz += d * x.elec_z
        zz += d * x.elec_z * x.elec_z - y[WEAK] * x.elec_zz
        paid_z -= y[WEAK] * x.elec_z
    az = ff * x.f_z + fz
    zz += ff * x.f_z * x.f_z + 2.0 * x.f_z * fz + paid_f * x.f_zz
    t, d = barrier_terms(s[SLOWING], y[SLOWING], a + mesh.deceleration, weight)
    by_a, aa, paid_a = by_f + t, ff + d, paid_f - y[SLOWING]
    if mesh.acceleration < math.inf:
        t, d = barrier_terms(s[SPEEDING], y[SPEEDING], mesh.acceleration - a, weight)
        by_a, aa, paid_a = by_a - t, aa + d, paid_a + y[SPEEDING]
    return LocalSlopes(by_a, by_z + by_f * x.f_z, aa, az, zz, paid_a, paid_z + paid_f * x.f_z)
