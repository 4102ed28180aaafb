"""Where am I, and within what bounds (位置検知機能, Sugiyama table 1): tachometer between tags, fixes at tags.

Invariant: the true front lies within [position - bound_behind, position + bound_ahead] as long as the wheels'
error stays within `bound_growth` metres per metre run. Bounds only grow until a tag is read where it may be.
"""

from __future__ import annotations

import numpy as np

from onboard.records import EVENT_SAFE_REAR, EVENT_TAG_OVERDUE
from onboard.rows import UnitRow
from vehicle.compiled import compiled
from vehicle.rows import TrainRow

ACCELERATION_SMOOTHING_S = 0.5


@compiled
def locate(unit: UnitRow, train: TrainRow, odometer_m: float, speed_mps: float, step_s: float) -> int:
    """Take one tachometer reading (distance m, speed m/s); returns event bits."""
    run_m = odometer_m - unit.odometer_m
    unit.odometer_m = odometer_m
    unit.position_m += run_m * unit.odometer_scale
    growth_m = abs(run_m) * unit.bound_growth
    unit.bound_ahead_m += growth_m
    unit.bound_behind_m += growth_m
    share = step_s / (ACCELERATION_SMOOTHING_S + step_s)
    unit.acceleration_mps2 += share * ((speed_mps - unit.speed_mps) / step_s - unit.acceleration_mps2)
    unit.speed_mps = speed_mps
    events = 0
    if unit.position_known == 1:
        certain_front_m = unit.position_m - unit.bound_behind_m
        if certain_front_m > unit.expected_tag_m + unit.tag_window_m:
            unit.expected_tag_m = np.inf
            events |= EVENT_TAG_OVERDUE
        if certain_front_m - train.length_m >= unit.rear_trigger_m:
            unit.rear_trigger_m = np.inf
            events |= EVENT_SAFE_REAR
    return events


@compiled
def within_window(unit: UnitRow, tag_m: float, odometer_at_tag_m: float, tolerance_m: float) -> bool:
    """Whether a tag at path coordinate `tag_m` may have been read when the tachometer stood at `odometer_at_tag_m`."""
    if unit.position_known == 0:
        return True
    estimate_m = unit.position_m - (unit.odometer_m - odometer_at_tag_m) * unit.odometer_scale
    earliest_m = estimate_m - unit.bound_behind_m - tolerance_m
    latest_m = estimate_m + unit.bound_ahead_m + tolerance_m
    return bool(earliest_m <= tag_m <= latest_m)


@compiled
def fix(unit: UnitRow, tag_m: float, odometer_at_tag_m: float, accuracy_m: float) -> float:
    """Fix the position at a tag read at `odometer_at_tag_m`; returns the correction, m (0 if none was known)."""
    since_m = (unit.odometer_m - odometer_at_tag_m) * unit.odometer_scale
    before_m = unit.position_m
    unit.position_m = tag_m + since_m
    bound_m = accuracy_m + abs(since_m) * unit.bound_growth
    unit.bound_ahead_m = bound_m
    unit.bound_behind_m = bound_m
    correction_m = unit.position_m - before_m if unit.position_known == 1 else 0.0
    unit.position_known = 1
    return float(correction_m)


def calibrated_scale(
    previous_scale: float, between_tags_m: float, odometer_run_m: float, scale_limit: float, accuracy_m: float
) -> float:
    """Scale of the tachometer from the distance between two tags, m.

    The correction is weighted by the distance, since each reading is uncertain by `accuracy_m`, and held within
    1 +- `scale_limit`, the largest error that worn wheels can have.
    """
    if odometer_run_m <= 0.0:
        return previous_scale
    measured = between_tags_m / odometer_run_m
    if abs(measured - 1.0) > scale_limit + 2.0 * accuracy_m / odometer_run_m:
        return previous_scale
    weight = between_tags_m / (between_tags_m + 500.0)
    scale = previous_scale + weight * (measured - previous_scale)
    return min(1.0 + scale_limit, max(1.0 - scale_limit, scale))
