"""Speed curves along a path: the permitted speed for supervision and the driving speed for the ATO.

Curves towards lower limits are overlaid backwards from each limit with a constant braking deceleration and the
gradient's part by the mean elevation under the train, so v^2/2 falls by (b + g*slope/(1 + rotating mass)) per metre.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.records import PATTERN, BehaviourRow
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2
from vehicle.records import TrainRow
from vehicle.resistance import climb_m

CRAWL_MPS: Final = 1.0  # no margin below a limit makes a train slower than this,
CRAWL_SHARE: Final = 0.5  # or than this share of the limit


@compiled
def braking_curve(
    limit_mps: NDArray[np.float64],
    elevation_m: NDArray[np.float64],
    deceleration_mps2: float,
    gravity_share_mps2: float,
) -> NDArray[np.float64]:
    """Highest speed at each metre from which every later limit can still be met, m/s; shape (n,).

    On a descent that outweighs the brake the curve falls no faster than the brake alone could hold: it is then
    level at the lower limit.
    """
    curve = limit_mps.copy()
    for i in range(curve.size - 2, -1, -1):
        drop = deceleration_mps2 + gravity_share_mps2 * (elevation_m[i + 1] - elevation_m[i])
        reachable = np.sqrt(curve[i + 1] ** 2 + 2.0 * max(drop, 0.0))
        curve[i] = min(curve[i], reachable)
    return curve


def least_between(
    values: NDArray[np.float64], first: NDArray[np.int64], last: NDArray[np.int64]
) -> NDArray[np.float64]:
    """The least of `values` from each row of `first` to that of `last`, both within; the ends go on; shape (n,)."""
    first, last = (np.clip(rows, 0, values.size - 1) for rows in (first, last))
    found, least, over = np.empty(first.size), values, 1  # two stretches make one of up to twice their length
    rows = last - first + 1
    while (rows >= over).any():
        here = (rows >= over) & (rows < 2 * over)
        found[here] = np.minimum(least[first[here]], least[last[here] + 1 - over])
        least, over = np.minimum(least[over:], least[:-over]), 2 * over
    return found


def limit_for_length(limit_mps: NDArray[np.float64], length_m: float) -> NDArray[np.float64]:
    """Limit for the front of a train of `length_m` that must obey each limit with its whole length; shape (n,)."""
    front = np.arange(limit_mps.size)
    return least_between(limit_mps, front - round(np.ceil(length_m)), front)


def limit_for_train(limit_mps: NDArray[np.float64], train: TrainRow) -> NDArray[np.float64]:
    """Greatest speed of a train with its front at each metre: the limits over its whole length, and its own; (n,)."""
    return np.minimum(limit_for_length(limit_mps, train.length_m), train.speed_max_mps)


def lowered_by(limit_mps: NDArray[np.float64], margin_mps: float) -> NDArray[np.float64]:
    """Limits less the distance that driving keeps from them; no train stands for it."""
    return np.maximum(limit_mps - margin_mps, np.minimum(CRAWL_MPS, CRAWL_SHARE * limit_mps))


@compiled
def lowered_mps(speed_mps: float, limit_mps: float, margin_mps: float) -> float:
    """A speed less the distance that driving keeps from a limit, as `lowered_by`; m/s."""
    return float(max(speed_mps - min(margin_mps, limit_mps - min(CRAWL_MPS, CRAWL_SHARE * limit_mps)), 0.0))


def mean_over_length(elevation_m: NDArray[np.float64], length_m: float) -> NDArray[np.float64]:
    """Mean elevation below a train with its front at each metre; the path's beginning continues level; shape (n,)."""
    rear_m = max(round(length_m), 1)
    levelled = np.concatenate([np.full(rear_m, elevation_m[0]), elevation_m])
    trapezia = np.concatenate([[0.0], np.cumsum((levelled[1:] + levelled[:-1]) / 2.0)])
    return np.asarray((trapezia[rear_m:] - trapezia[:-rear_m]) / rear_m, dtype=np.float64)


def pattern_of(
    elevation_m: NDArray[np.float64],
    turn_rad: NDArray[np.float64],
    limit_mps: NDArray[np.float64],
    train: TrainRow,
    behaviour: BehaviourRow,
) -> NDArray[np.void]:
    """The path database of one kind of train on one path: rows of PATTERN on the 1 m grid; shape (n,).

    `turn_rad`: integral of |curvature|. Curves slow a train, so supervision leaves them out.
    """
    gravity_share = GRAVITY_MPS2 / (1.0 + train.rotating_mass_factor)
    whole = limit_for_train(limit_mps, train)
    body_m = mean_over_length(elevation_m, train.length_m)
    permitted = braking_curve(whole, body_m, behaviour.service_guaranteed_mps2, gravity_share)
    lowered = lowered_by(whole, behaviour.settings.driving_margin_mps)
    driving = braking_curve(lowered, body_m, behaviour.settings.stop_deceleration_mps2, gravity_share)
    rows = np.zeros(elevation_m.size, dtype=PATTERN)
    rows["climb_m"] = climb_m(train, elevation_m, turn_rad)
    rows["body_elevation_m"] = body_m
    rows["permitted_mps"] = permitted
    rows["driving_mps"] = driving
    return rows
