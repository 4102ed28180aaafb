"""Where am I, and within what bounds (位置検知機能, Sugiyama table 1): tachometer between tags, fixes at tags.

Invariant: the true front lies within [position - bound_behind, position + bound_ahead] as long as the wheels'
error stays within `bound_growth` metres per metre run, and while they slide or slip within what their protection
allows. Wheels that may be locked tell nothing: the bound ahead then grows with time, by the speed that the train had
when they last rolled, less what it surely brakes, until they have rolled again for `ROLLS_S`. Bounds only grow until a
fix cuts them. A tachometer that shows what no train can do is reported (速度発電機の出力異常・出力なし, table 5): no
output, output that does not answer power or brake, output that another axle contradicts
(`onboard.localisation.axles`).
"""

from __future__ import annotations

import numpy as np

from onboard.localisation.axles import (
    NO_AXLE_MPS,
    SURE_BRAKE_MPS2,
    TACHOMETER_LIES,
    come_apart,
    compare,
    contradict,
    last_run_m,
    speed_to_go_by_mps,
    turn_alike,
)
from onboard.records import EVENT_SAFE_REAR, EVENT_TACHOMETER, EVENT_TAG_OVERDUE, UnitRow
from vehicle.compiled import compiled
from vehicle.records import TrainRow

ACCELERATION_SMOOTHING_S = 0.5
TACHOMETER_DOUBT_S = 4.0  # assumed: well over dead time and lag of traction and brakes
LOST_SHARE = 0.5  # slide protection keeps the wheel above this share of the train's speed
LOST_FROM_MPS = 1.0
GAINED_MPS = 2.5  # wheels spin up by less than this, and than their speed again, within a step
BY_TURNS_S = 1.0  # a slip that was seen may go on this long under the name of a slide
ROLLS_S = (
    1.0  # so long wheels have to turn as rolling ones do: they may slide by turns, or come back from a lock
)
DESCENT_MPS2 = 0.4  # assumed: 40 permille make of a train no more
ANSWERS_MPS2 = 0.1  # half the service brake slows a train by more than this on any gradient here


@compiled
def locate(
    unit: UnitRow,
    train: TrainRow,
    odometer_m: float,
    shown_mps: float,
    step_s: float,
    last_mps: float = NO_AXLE_MPS,
) -> int:
    """Take one tachometer reading (distance m, speed m/s), and the last axle's speed, if shown; returns event bits."""
    run_m = odometer_m + unit.odometer_off_m - unit.odometer_m
    short_m = long_m = last_m = off_m = 0.0
    shown = last_mps >= 0.0
    events = 0
    if shown:
        last_m = last_run_m(unit, last_mps, step_s)
        if unit.wheel_slide == 0:
            short_m, long_m = compare(unit, run_m, last_m)
            events |= EVENT_TACHOMETER if come_apart(unit, shown_mps, last_mps, last_m) else 0
        else:  # the last axle may slide and slip as well
            short_m, long_m = max(last_m - run_m, 0.0), max(run_m - last_m - unit.pulse_m, 0.0)
    if unit.apart == 0:
        events |= doubt_tachometer(unit, train, shown_mps, step_s)
        if shown and events != 0 and not turn_alike(unit, shown_mps, last_mps):
            contradict(unit, shown_mps, last_mps)
    speed_mps = speed_to_go_by_mps(unit, shown_mps, last_mps, step_s) if shown else shown_mps
    if unit.liar == TACHOMETER_LIES:
        off_m = last_m - run_m
        unit.odometer_off_m += off_m
        run_m, short_m, long_m = last_m, 0.0, 0.0
    unit.odometer_m = odometer_m + unit.odometer_off_m
    count_run(unit, train, run_m, speed_mps, step_s, short_m, long_m)
    unit.step_short_m += max(off_m, 0.0)
    unit.step_long_m += max(-off_m, 0.0)
    smoothing = step_s / (ACCELERATION_SMOOTHING_S + step_s)
    unit.acceleration_mps2 += smoothing * ((speed_mps - unit.speed_mps) / step_s - unit.acceleration_mps2)
    unit.speed_mps = speed_mps
    return events | passed_bits(unit, train)


@compiled
def count_run(
    unit: UnitRow,
    train: TrainRow,
    run_m: float,
    speed_mps: float,
    step_s: float,
    short_m: float,
    long_m: float,
) -> None:
    """Move the estimate by what was counted and widen the bounds: by their growth, by slides and slips, and by what
    another axle says that it was too short or too long by.
    """
    unit.position_m += run_m * unit.odometer_scale
    growth_m = abs(run_m) * unit.bound_growth
    unit.bound_ahead_m += growth_m
    unit.bound_behind_m += growth_m
    share = min(train.wheel_slide_share_max, LOST_SHARE)
    unseen_m = unseen_run_m(unit, train, run_m * unit.odometer_scale, speed_mps, step_s)
    slid_m, slipped_m = short_m * (unit.odometer_scale + unit.bound_growth), long_m * unit.odometer_scale
    if unit.wheel_slide != 0:  # on such a rail wheels slip and slide by turns
        held_m = abs(run_m) * (unit.odometer_scale + unit.bound_growth) * share / (1.0 - share)
        slid_m = max(held_m, unseen_m, slid_m)
    elif unseen_m > 0.0:
        slid_m = max(unseen_m, slid_m)
    if unit.wheel_slide > 0:
        unit.may_slip_s = BY_TURNS_S
    if unit.wheel_slide != 0 and unit.may_slip_s > 0.0:
        slipped_m = max(abs(run_m), slipped_m)
    unit.may_slip_s -= step_s
    unit.bound_ahead_m += slid_m
    unit.bound_behind_m += slipped_m
    unit.slid_ahead_m += slid_m
    unit.slipped_behind_m += slipped_m
    unit.step_short_m, unit.step_long_m = slid_m, slipped_m


@compiled
def passed_bits(unit: UnitRow, train: TrainRow) -> int:
    """What the front or the rear has surely passed; event bits."""
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
def unseen_run_m(unit: UnitRow, train: TrainRow, run_m: float, speed_mps: float, step_s: float) -> float:
    """How far the train may have run in this step beyond what its wheels counted, m; keeps `unit.may_run_mps`.

    Wheels that roll show its speed. Standing ones may be locked, and turning ones that slide or slip may turn at any
    speed, where the train has no protection that keeps them above a share of its own. Those that turn again after
    that come up to its speed first. What sees the speed otherwise (`unit.seen_speed_mps`) bounds it.
    """
    rolled_mps = speed_mps * unit.odometer_scale
    locks = train.wheel_slide_share_max > LOST_SHARE
    turns = speed_mps > 0.0 and (unit.wheel_slide == 0 or not locks)
    if not turns:
        unit.turns_s = 0.0
    elif not (locks and comes_back(unit, rolled_mps, speed_mps, step_s)):
        unit.turns_s = ROLLS_S
        unit.may_run_mps = (
            rolled_mps / (1.0 - train.wheel_slide_share_max) if unit.wheel_slide != 0 else rolled_mps
        )
        return 0.0
    may_mps = unit.may_run_mps
    if unit.seen_within_mps > 0.0:
        may_mps = min(may_mps, unit.seen_speed_mps + unit.seen_within_mps)
    before_mps = max(may_mps, rolled_mps)
    brakes = unit.notch < 0.0 or unit.emergency != 0
    unit.may_run_mps = max(before_mps - SURE_BRAKE_MPS2 * step_s, rolled_mps) if brakes else before_mps
    return max((before_mps + unit.may_run_mps) / 2.0 * step_s - run_m, 0.0)


@compiled
def comes_back(unit: UnitRow, rolled_mps: float, speed_mps: float, step_s: float) -> bool:
    """Whether wheels that stood or slid and now turn may still turn slower than the train runs, as they gain speed.

    A slide protection that compares axles does not see it where all of them were locked.
    """
    if unit.turns_s >= ROLLS_S or rolled_mps >= unit.may_run_mps:
        return False
    if unit.turns_s == 0.0:
        unit.turned_mps = speed_mps
    unit.turns_s += step_s
    if unit.turns_s < ROLLS_S:
        return True
    if unit.notch <= 0.0 and speed_mps - unit.turned_mps > DESCENT_MPS2 * ROLLS_S:
        unit.turns_s = 0.0
    return bool(unit.turns_s == 0.0)


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
    # Power notches are whole, hence no train under power keeps its speed to the last bit.
    stuck = speed_mps > 0.0 and speed_mps == before_mps and unit.notch > 0.0
    doubt_s = unit.tachometer_doubt_s
    unit.tachometer_doubt_s = doubt_s + step_s if silent or deaf or stuck else 0.0
    limit_s = TACHOMETER_DOUBT_S
    if lost or gained or doubt_s < limit_s <= unit.tachometer_doubt_s:
        return EVENT_TACHOMETER
    return 0


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
