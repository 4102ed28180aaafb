"""One stop at the mark through the kernel, compiled: what is asked of it, how it is made, what came of it.

Beyond the tick the unit takes fixes by the one rule there is (`onboard.localisation.fix`), from beacons (`tags`) and
from signs that a camera sees (`sighting`), and judges the stop as on the line. The mark is at 0 in a STOP record and
in what comes out; inside, path coordinates grow from the path's beginning.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from onboard.driving.stopping import aim_within, limit_is_short
from onboard.driving.tasc import SIGN_BEYOND_LIMIT, TARGET_NOT_SEEN, WEAK_TOLERANCE_M, judge
from onboard.localisation.fix import TAKEN, cut
from onboard.localisation.sighting import front_by_sign, sighted, sign_is_missing
from onboard.localisation.tags import front_by_tag
from simulation.sensors.slide_protection import rolls_at
from simulation.world.kernel import PathArrays, sample, step_one
from simulation.world.records import PASSED_TAG, StockRow
from vehicle.compiled import compiled
from vehicle.record import dtype_of

FIXES_MAX: Final = 8
STEPS_MAX: Final = 3000
FAR_M: Final = 1.0e5  # a stop limit that is none

Rows = NDArray[np.void]


class StopRow(Protocol):
    """One stop to be made, and what passes with it; distances in m before the mark where not said otherwise."""

    speed_mps: float
    start_m: Annotated[float, "distance to the mark at the beginning"]
    since_fix_m: Annotated[float, "run since the last fix before that"]
    fix_error_m: Annotated[float, "by which that fix put the train too far ahead"]
    wheel_error: Annotated[float, "share that the tachometer counts and shows too much"]
    count_error: Annotated[float, "share that it counts too much beyond that; its speed is right"]
    beacons: int
    beacon_m: Annotated[list[float], FIXES_MAX, "true places, falling"]
    beacon_error_m: Annotated[list[float], FIXES_MAX, "by which the unit takes them to lie further ahead"]
    signs: int
    sign_m: Annotated[list[float], FIXES_MAX, "true places, which the unit knows"]
    detection_m: Annotated[float, "a sign is seen from this far"]
    frame_s: Annotated[float, "the estimate is ahead of the truth by speed times this while a sign is seen"]
    expects_sign: Annotated[
        int, "1: the unit counts the target as not seen if nothing has fixed its position"
    ]
    stop_limit_m: Annotated[float, "停止限界, m past the mark"]
    gradient_permille: float
    gradient_believed_permille: float
    load_share: float
    adhesion_factor: float
    brake_factor: float
    brake_dead_time_off_s: Annotated[float, "the body's brake dead time less that of the bench's train"]
    brake_lag_off_s: Annotated[float, "the same of its lag"]


class OutcomeRow(Protocol):
    """What came of one stop."""

    error_m: Annotated[float, "where the front stopped; positive: past the mark"]
    time_s: float
    deceleration_max_mps2: float
    rest_mps2: Annotated[float, "deceleration that ends when the train comes to rest"]
    within_limit: int
    verdict: int
    intervention: Annotated[int, "the strongest of supervision"]
    events: Annotated[int, "all that the tick reported"]
    slid_steps: int
    refused: Annotated[int, "fixes that missed the bounds"]
    out_of_bounds_m: Annotated[float, "by how much the front was beyond its bounds at most; negative: never"]
    steps: int


STOP: Final = dtype_of(StopRow)
OUTCOME: Final = dtype_of(OutcomeRow)


@compiled
def lay_track(track: PathArrays, stop: StopRow, row: StockRow, mark_m: float) -> None:
    """Lay this stop's path into the scratch arrays: one gradient in truth, one on the unit's map, its beacons."""
    true_slope, slope = stop.gradient_permille / 1000.0, stop.gradient_believed_permille / 1000.0
    half_m = row.board.kind.length_m / 2.0
    for i in range(track.profile.size):
        track.profile[i].elevation_m = true_slope * i
        track.pattern[i].climb_m = slope * i
        track.pattern[i].body_elevation_m = slope * (i - half_m)
    for i in range(stop.beacons):
        track.tag_positions_m[i] = mark_m - stop.beacon_m[i]


@compiled
def begin(row: StockRow, stop: StopRow, begin_m: float, standoff_m: float) -> None:
    """Put body, sensors and unit into the state that a stop begins with, coasting, `begin_m` along the path."""
    truth, plant, tachometer, unit = row.truth, row.plant, row.sensors.tachometer, row.board.unit
    plant.load_share = stop.load_share
    plant.adhesion_factor = stop.adhesion_factor
    plant.brake_factor = stop.brake_factor
    plant.speed_mps = plant.wheel_speed_mps = plant.last_wheel_speed_mps = stop.speed_mps
    rolls_at(row.sensors.slide_protection, stop.speed_mps)
    row.body.brake_dead_time_s = max(row.body.brake_dead_time_s + stop.brake_dead_time_off_s, 0.0)
    row.body.brake_lag_s = max(row.body.brake_lag_s + stop.brake_lag_off_s, 0.0)
    tachometer.wheel_factor = 1.0 / (1.0 + stop.wheel_error)
    tachometer.miscount_share = stop.count_error
    truth.position_m = truth.offset_m = begin_m
    truth.tag_next, truth.tag_end = 0, stop.beacons
    counted_m = stop.since_fix_m * (1.0 + stop.wheel_error) * (1.0 + stop.count_error)
    unit.position_m = begin_m + counted_m - stop.since_fix_m + stop.fix_error_m
    unit.bound_ahead_m += abs(counted_m) * unit.bound_growth
    unit.bound_behind_m = unit.bound_ahead_m
    shown_mps = stop.speed_mps * (1.0 + stop.wheel_error)
    unit.speed_mps = unit.train_mps = unit.may_run_mps = shown_mps
    mark_m = begin_m + stop.start_m
    unit.stop_limit_m = mark_m + stop.stop_limit_m
    unit.target_stop_m = aim_within(mark_m, unit.stop_limit_m, standoff_m)


@compiled
def take_fixes(
    row: StockRow, stop: StopRow, found: int, mark_m: float, tag_accuracy_m: float
) -> tuple[int, int]:
    """Let the unit take what its reader and its camera show after a step: fixes taken, and refused."""
    truth, unit = row.truth, row.board.unit
    taken = refused = 0
    if found & PASSED_TAG != 0:
        beacon_m = mark_m - stop.beacon_m[truth.tag_next] + stop.beacon_error_m[truth.tag_next]
        truth.tag_next += 1
        position_m, bound_m = front_by_tag(unit, beacon_m, row.sensors.tag_reader.latched_m, tag_accuracy_m)
        if cut(unit, position_m, bound_m, bound_m) <= 0.0:
            taken += 1
        else:
            refused += 1
    for i in range(stop.signs):
        sign_m = mark_m - stop.sign_m[i]
        ahead_m = sign_m - truth.position_m
        if 0.0 <= ahead_m <= stop.detection_m:
            seen_m = ahead_m - row.plant.speed_mps * stop.frame_s
            position_m, bound_m = front_by_sign(unit, sign_m, seen_m)
            if sighted(row.board.readers.sign, unit, position_m, bound_m) == TAKEN:
                taken += 1
            else:
                refused += 1
    return taken, refused


@compiled
def keep_count(outcome: OutcomeRow, row: StockRow, events: int, refused: int) -> None:
    """Take one more step into the outcome; the last one, in which the train comes to rest, only as time."""
    plant, unit = row.plant, row.board.unit
    outcome.steps += 1
    outcome.slid_steps += plant.sliding
    outcome.events |= events
    outcome.refused += refused
    outcome.intervention = max(outcome.intervention, unit.intervention)
    beyond_m = row.truth.position_m - unit.position_m
    out_m = max(beyond_m - unit.bound_ahead_m, -beyond_m - unit.bound_behind_m)
    outcome.out_of_bounds_m = max(outcome.out_of_bounds_m, out_m)
    if plant.speed_mps > 0.0:
        outcome.deceleration_max_mps2 = max(outcome.deceleration_max_mps2, -plant.acceleration_mps2)
        outcome.rest_mps2 = -plant.acceleration_mps2


@compiled
def run_stop(
    row: StockRow,
    stop: StopRow,
    track: PathArrays,
    tag_accuracy_m: float,
    standoff_m: float,
    outcome: OutcomeRow,
    trace: Rows,
) -> None:
    """Run one stop to rest from a prepared row; fills `outcome` and, as far as it reaches, `trace` (of TRACE)."""
    unit, tasc = row.board.unit, row.board.tasc
    begin_m = np.ceil(row.body.length_m) + 1.0
    mark_m = begin_m + stop.start_m
    lay_track(track, stop, row, mark_m)
    begin(row, stop, begin_m, standoff_m)
    outcome.out_of_bounds_m = -np.inf
    fixed = False
    for i in range(STEPS_MAX):
        found, events = step_one(row, track, i + 1)
        if i < trace.shape[0]:
            sample(trace[i], row, i + 1, 0)
        taken, refused = take_fixes(row, stop, found, mark_m, tag_accuracy_m)
        fixed = fixed or taken > 0
        if stop.expects_sign != 0 and not fixed and sign_is_missing(mark_m, unit.position_m):
            judge(tasc, TARGET_NOT_SEEN)
        keep_count(outcome, row, events, refused)
        if row.plant.speed_mps <= 0.0:
            break
    if unit.position_m - mark_m < -WEAK_TOLERANCE_M and limit_is_short(unit, mark_m):
        judge(tasc, SIGN_BEYOND_LIMIT)
    outcome.error_m = row.truth.position_m - mark_m
    outcome.time_s = outcome.steps * row.board.behaviour.step_s
    stands = row.plant.speed_mps <= 0.0
    outcome.within_limit = 1 if stands and outcome.error_m <= stop.stop_limit_m else 0
    outcome.verdict = tasc.verdict


@compiled
def run_stops(
    work: Rows,
    prepared: Rows,
    stops: Rows,
    track: PathArrays,
    tag_accuracy_m: float,
    standoff_m: float,
    outcomes: Rows,
    trace: Rows,
) -> None:
    """Run every stop, each from the prepared row; `work` (one row) and `trace` are left as the last one left them."""
    for i in range(stops.shape[0]):
        work[0] = prepared[0]
        run_stop(work[0], stops[i], track, tag_accuracy_m, standoff_m, outcomes[i], trace)


def new_stops(n: int) -> Rows:
    """`n` rows of STOP: dry and level, nominal brakes, no beacon, no sign, no stop limit."""
    rows = np.zeros(n, dtype=STOP)
    rows["adhesion_factor"] = 1.0
    rows["brake_factor"] = 1.0
    rows["stop_limit_m"] = FAR_M
    return rows
