"""Where am I, and within what bounds (位置検知機能, Sugiyama table 1): tachometer between tags, fixes at tags.

Invariant: the true front lies within [position - bound_behind, position + bound_ahead] as long as the wheels'
error stays within `bound_growth` metres per metre run, and while they slide or slip within what their protection
allows. Bounds only grow until a tag is read where it may be. A tachometer that shows what no train can do is
reported (速度発電機の出力異常・出力なし, table 5): no output, output that does not answer power or brake.
"""

from __future__ import annotations

import numpy as np

from onboard.records import EVENT_SAFE_REAR, EVENT_TACHOMETER, EVENT_TAG_OVERDUE, UnitRow
from vehicle.compiled import compiled
from vehicle.records import TrainRow

ACCELERATION_SMOOTHING_S = 0.5
TACHOMETER_DOUBT_S = 4.0  # assumed: well over dead time and lag of traction and brakes
LOST_SHARE = 0.5  # slide protection keeps the wheel above this share of the train's speed
LOST_FROM_MPS = 1.0
GAINED_MPS = 2.5  # wheels spin up by less than this, and than their speed again, within a step
ANSWERS_MPS2 = 0.1  # half the service brake slows a train by more than this on any gradient here


@compiled
def locate(unit: UnitRow, train: TrainRow, odometer_m: float, speed_mps: float, step_s: float) -> int:
    """Take one tachometer reading (distance m, speed m/s); returns event bits."""
    run_m = odometer_m - unit.odometer_m
    unit.odometer_m = odometer_m
    unit.position_m += run_m * unit.odometer_scale
    growth_m = abs(run_m) * unit.bound_growth
    unit.bound_ahead_m += growth_m
    unit.bound_behind_m += growth_m
    share = min(train.wheel_slide_share_max, LOST_SHARE)
    if unit.wheel_slide < 0:
        unit.bound_ahead_m += abs(run_m) * share / (1.0 - share)
    elif unit.wheel_slide > 0:
        unit.bound_behind_m += abs(run_m)
    events = doubt_tachometer(unit, train, speed_mps, step_s)
    smoothing = step_s / (ACCELERATION_SMOOTHING_S + step_s)
    unit.acceleration_mps2 += smoothing * ((speed_mps - unit.speed_mps) / step_s - unit.acceleration_mps2)
    unit.speed_mps = speed_mps
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
def doubt_tachometer(unit: UnitRow, train: TrainRow, speed_mps: float, step_s: float) -> int:
    """Whether the new reading (m/s) cannot be true after the last one, or readings do not answer the command.

    Reports once; again only after the doubt has been cleared by a reading that answers.
    """
    before_mps = unit.speed_mps
    lost = before_mps > LOST_FROM_MPS and speed_mps < LOST_SHARE * before_mps
    gained = speed_mps > 2.0 * before_mps + GAINED_MPS
    silent = speed_mps == 0.0 and before_mps == 0.0 and unit.notch > 0.0
    braked = unit.emergency != 0 or unit.notch <= -0.5 * train.brake_notches
    deaf = speed_mps > 0.0 and braked and unit.acceleration_mps2 > -ANSWERS_MPS2
    doubt_s = unit.tachometer_doubt_s
    unit.tachometer_doubt_s = doubt_s + step_s if silent or deaf else 0.0
    limit_s = TACHOMETER_DOUBT_S
    if lost or gained or doubt_s < limit_s <= unit.tachometer_doubt_s:
        return EVENT_TACHOMETER
    return 0


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
