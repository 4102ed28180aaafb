"""Curvature collation (曲率照合) on contiguous metres: the sums of equations (2) and (3), and what they can mean.

Harada, Maki, Kazato and Ishiguri, 3.1 and 3.5. `seen` are the last metres of the run, the oldest first, `known` those
of the map that they may lie on, `count + span` of them for `span + 1` shifts. Nothing here knows of trains.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vehicle.compiled import compiled

Samples = NDArray[np.float64] | list[float]  # a part of a record is an array, and said to be a list


@compiled
def difference_sum(known: Samples, first: int, seen: Samples, begin: int, count: int, away: float) -> float:
    """Equation (2) for one shift: the sum of |map - run - away| over `count` metres from `known[first]`, `seen[begin]`.

    Four sums side by side: the order of adding stays the same, and the processor has something to do meanwhile.
    """
    a = b = c = d = 0.0
    whole = count - count % 4
    for k in range(0, whole, 4):
        a += abs(known[first + k] - seen[begin + k] - away)
        b += abs(known[first + k + 1] - seen[begin + k + 1] - away)
        c += abs(known[first + k + 2] - seen[begin + k + 2] - away)
        d += abs(known[first + k + 3] - seen[begin + k + 3] - away)
    for k in range(whole, count):
        a += abs(known[first + k] - seen[begin + k] - away)
    return (a + b) + (c + d)


@compiled
def all_squares(
    known: Samples, seen: Samples, begin: int, count: int, span: int, energy: Samples, free: Samples
) -> int:
    """Fill for each of `span + 1` shifts equation (3), and what is left of it without a constant difference.

    Returns the shift at which the latter is least. The inner loop is that over the shifts: their sums do not depend on
    one another, so the processor adds several at once, each in the same order.
    """
    for shift in range(span + 1):
        energy[shift] = free[shift] = 0.0  # the latter are the plain sums, until the end
    whole = count - count % 4
    for k in range(0, whole, 4):
        p, q, r, s = seen[begin + k], seen[begin + k + 1], seen[begin + k + 2], seen[begin + k + 3]
        for shift in range(span + 1):
            w = known[k + shift] - p
            x = known[k + shift + 1] - q
            y = known[k + shift + 2] - r
            z = known[k + shift + 3] - s
            energy[shift] += (w * w + x * x) + (y * y + z * z)
            free[shift] += (w + x) + (y + z)
    for k in range(whole, count):
        for shift in range(span + 1):
            w = known[k + shift] - seen[begin + k]
            energy[shift] += w * w
            free[shift] += w
    least = 0
    for shift in range(span + 1):
        free[shift] = energy[shift] - free[shift] * free[shift] / count
        if free[shift] < free[least]:
            least = shift
    return least


@compiled
def least_shift(
    known: Samples, seen: Samples, begin: int, count: int, low: int, high: int, away: float, sums: Samples
) -> float:
    """The shift from `low` to `high` at which equation (2) is least, between metres by the parabola through three."""
    best = low
    for shift in range(low, high + 1):
        sums[shift] = difference_sum(known, shift, seen, begin, count, away)
        if sums[shift] < sums[best]:
            best = shift
    if best in (low, high):
        return float(best)
    before, here, after = sums[best - 1], sums[best], sums[best + 1]
    bend = before - 2.0 * here + after
    return best + (0.5 * (before - after) / bend if bend > 0.0 else 0.0)


@compiled
def limit_crossing(free: Samples, inside: int, outside: int, limit: float) -> float:
    """Where between two neighbouring shifts the sum passes a limit."""
    rise = free[outside] - free[inside]
    share = (limit - free[inside]) / rise if rise > 0.0 else 1.0
    return inside + (outside - inside) * min(max(share, 0.0), 1.0)


@compiled
def explained_shifts(
    free: Samples, span: int, least: int, near: int, limit: float, far_limit: float
) -> tuple[float, float]:
    """The hull of all shifts that noise explains: at most `limit` within `near` of the least, `far_limit` beyond."""
    low = high = least
    for shift in range(span + 1):
        most = limit if abs(shift - least) <= near else far_limit
        if free[shift] <= most:
            low, high = min(low, shift), max(high, shift)
    low_limit = limit if least - low < near else far_limit
    high_limit = limit if high - least < near else far_limit
    from_m = float(low) if low == 0 else limit_crossing(free, low, low - 1, low_limit)
    to_m = float(high) if high == span else limit_crossing(free, high, high + 1, high_limit)
    return from_m, to_m
