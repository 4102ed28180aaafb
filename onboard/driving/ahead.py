"""What lies ahead by the unit's own map: the speed that the limits leave, and what slows the train by itself."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.pattern import least_between, lowered_by, lowered_mps
from onboard.driving.supervision import (
    RESERVE_M,
    fastest_share,
    furthest_m,
    least_permitted_mps,
    nearest_m,
    path_index,
)
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg, mass_kg
from vehicle.records import TrainRow
from vehicle.resistance import resistance_n

LOOK_AHEAD_S: Final = 1.0


def kept_along_mps(
    path: NDArray[np.void], behaviour: BehaviourRow, bound_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """`limit_mps` on each metre of a path, for a train that goes as fast as it may; shape (n,).

    `bound_m`: by how much its front may be off where it is believed, on each metre; shape (n,).
    """
    metres = np.arange(path.size)
    driving_mps = np.ascontiguousarray(path["driving_mps"])
    permitted_mps = lowered_by(path["permitted_mps"], 2.0 * behaviour.settings.service_margin_mps)

    def pattern(at_m: NDArray[np.int64]) -> NDArray[np.float64]:
        near_m, far_m = at_m - bound_m, at_m + bound_m + RESERVE_M
        first, last = np.floor(near_m).astype(np.int64), np.floor(far_m).astype(np.int64)
        least_mps = least_between(permitted_mps, first, last)
        return np.minimum(least_between(driving_mps, first, at_m), least_mps)

    ahead_m = np.maximum(path["driving_mps"] * LOOK_AHEAD_S, 1.0).astype(np.int64)
    return np.maximum(np.minimum(pattern(metres), pattern(metres + ahead_m)), 0.0)


@compiled
def own_deceleration_mps2(unit: UnitRow, train: TrainRow, path: NDArray[np.void], load_share: float) -> float:
    """What slows the train without any brake: gradient, curves and running resistance, by the unit's own map."""
    return own_at_mps2(unit, train, path, load_share, unit.position_m, unit.speed_mps)


@compiled
def own_at_mps2(
    unit: UnitRow,
    train: TrainRow,
    path: NDArray[np.void],
    load_share: float,
    position_m: float,
    speed_mps: float,
) -> float:
    """The same with the front at a path coordinate, at a speed."""
    here = path[path_index(unit, position_m)]
    behind = path[path_index(unit, position_m - train.length_m)]
    climb_m = here.climb_m - behind.climb_m
    gravity_share = GRAVITY_MPS2 / (1.0 + train.rotating_mass_factor)
    resistance = resistance_n(train, mass_kg(train, load_share), speed_mps)
    slope_mps2 = gravity_share * climb_m / train.length_m
    return float(slope_mps2 + resistance / equivalent_mass_kg(train, load_share))


@compiled
def pattern_mps(unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void], position_m: float) -> float:
    """Speed to keep at a path coordinate by the limits: the driving curve, and well under the permitted speed.

    Each holds until the rear has left it wherever the train may be, and the permitted speed counts from where the front
    may be at the furthest: with wide bounds it is the lower.
    """
    near_m = nearest_m(unit, position_m)
    permitted = least_permitted_mps(unit, path, near_m, furthest_m(unit, position_m))
    driving = lowered_mps(permitted, permitted, 2.0 * behaviour.settings.service_margin_mps)
    for row in range(path_index(unit, near_m), path_index(unit, position_m) + 1):
        driving = min(driving, path[row].driving_mps)
    return float(driving)


@compiled
def limit_mps(unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void]) -> float:
    """Speed that driving stays under, whatever its law: the limits here and ahead, and the permitted speed."""
    here = pattern_mps(unit, behaviour, path, unit.position_m)
    ahead = pattern_mps(unit, behaviour, path, unit.position_m + max(unit.speed_mps * LOOK_AHEAD_S, 1.0))
    settings = behaviour.settings
    # Supervision brakes a margin above what is permitted, by the speed that there may be; driving stays below both.
    braked_mps = (unit.permitted_mps + settings.service_margin_mps) / fastest_share(unit)
    shown_mps = min(unit.permitted_mps, braked_mps)
    limit = min(here, ahead, lowered_mps(shown_mps, unit.ceiling_mps, settings.service_margin_mps))
    return float(
        min(limit, lowered_mps(unit.restricted_mps, unit.restricted_mps, settings.driving_margin_mps))
    )
