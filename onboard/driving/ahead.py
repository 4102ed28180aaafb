"""What lies ahead by the unit's own map: the speed that the limits leave, and what slows the train by itself."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.pattern import lowered_by, lowered_mps
from onboard.driving.supervision import RESERVE_M, fastest_share, path_index
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

    `bound_m`: by how much its front may be further on than it believes, on each metre; shape (n,).
    """
    metres = np.arange(path.size)
    furthest_m = bound_m + RESERVE_M
    permitted_mps = lowered_by(path["permitted_mps"], 2.0 * behaviour.settings.service_margin_mps)

    def pattern(at_m: NDArray[np.int64]) -> NDArray[np.float64]:
        here, there = (np.minimum(m.astype(np.int64), path.size - 1) for m in (at_m, at_m + furthest_m))
        kept_mps = np.minimum(path["driving_mps"][here], permitted_mps[there])
        return np.asarray(kept_mps, dtype=np.float64)

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

    That one counts from where the front may be at the furthest, so with a wide bound it is the lower.
    """
    furthest_m = position_m + unit.bound_ahead_m + RESERVE_M
    permitted = path[path_index(unit, furthest_m)].permitted_mps
    permitted = lowered_mps(permitted, permitted, 2.0 * behaviour.settings.service_margin_mps)
    return float(min(path[path_index(unit, position_m)].driving_mps, permitted))


@compiled
def limit_mps(unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void]) -> float:
    """Speed that driving stays under, whatever its law: the limits here and ahead, and the permitted speed."""
    here = pattern_mps(unit, behaviour, path, unit.position_m)
    ahead = pattern_mps(unit, behaviour, path, unit.position_m + max(unit.speed_mps * LOOK_AHEAD_S, 1.0))
    ceiling = path[path_index(unit, unit.position_m + unit.bound_ahead_m + RESERVE_M)].permitted_mps
    ceiling, settings = min(ceiling, unit.restricted_mps), behaviour.settings
    # Supervision brakes a margin above what is permitted, by the speed that there may be; driving stays below both.
    braked_mps = (unit.permitted_mps + settings.service_margin_mps) / fastest_share(unit)
    shown_mps = min(unit.permitted_mps, braked_mps)
    limit = min(here, ahead, lowered_mps(shown_mps, ceiling, settings.service_margin_mps))
    return float(
        min(limit, lowered_mps(unit.restricted_mps, unit.restricted_mps, settings.driving_margin_mps))
    )
