"""One run to rest at a mark through the kernel, compiled: what is asked of it, how it is made, what came of it.

A stop begins coasting at a speed, a hop at a stand with an ordered running time. Beyond the tick the unit takes fixes
by the one rule there is (`onboard.localisation.fix`), from beacons (`tags`) and from signs that a camera sees
(`sighting`), and judges the stop as on the line. The mark is at 0 in a record and in what comes out; inside, path
coordinates grow from the path's beginning.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from onboard.driving.stopping import aim_within, limit_is_short
from onboard.driving.tasc import SIGN_BEYOND_LIMIT, TARGET_NOT_SEEN, WEAK_TOLERANCE_M, judge
from onboard.localisation.fix import TAKEN, cut_interval
from onboard.localisation.sighting import front_by_sign, sign_is_missing, sign_sighted
from onboard.localisation.tags import front_by_tag
from simulation.ride import COASTS
from simulation.sensors.slide_protection import rolls_at
from simulation.world.kernel import PathArrays, sample, step_one
from simulation.world.records import PASSED_TAG, StockRow
from vehicle.compiled import compiled
from vehicle.record import dtype_of

FIXES_MAX: Final = 8
STEPS_MAX: Final = 50_000
FAR_M: Final = 1.0e5  # a stop limit that is none
NONE_S: Final = np.inf  # running time of a train that never came to rest

Floats = NDArray[np.float64]
Rows = NDArray[np.void]


class Heights(NamedTuple):
    """Of each metre of the path, m: of the track, and of front and middle of the train by the unit's map."""

    elevation_m: Floats
    climb_m: Floats
    body_m: Floats


class BenchRunRow(Protocol):
    """One run to be made, and what passes with it; distances in m before the mark where not said otherwise."""

    speed_mps: Annotated[float, "at the beginning, coasting; 0: at a stand, brakes released"]
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
    gradient_permille: Annotated[float, "of the real track, beyond what the way has"]
    gradient_believed_permille: Annotated[float, "the same of the unit's map"]
    load_share: float
    load_shown: Annotated[int, "1: the unit's load sensor shows it; 0: it shows an empty train"]
    adhesion_factor: float
    brake_factor: float
    brake_dead_time_off_s: Annotated[float, "the body's brake dead time less that of the bench's train"]
    brake_lag_off_s: Annotated[float, "the same of its lag"]
    order_s: Annotated[float, "running time handed to the law: the unit is due so long after its departure"]
    cruise_mps: Annotated[float, "cruising speed that the unit has chosen for it"]
    plan_offset: int
    plan_rows: Annotated[int, "0: no plan"]
    plan_due_s: Annotated[float, "when the train stands at the mark by its plan"]


class BenchOutcomeRow(Protocol):
    """What came of one run."""

    error_m: Annotated[float, "where the front stopped; positive: past the mark"]
    time_s: Annotated[float, "running time; +inf: it never came to rest"]
    energy_traction_j: Annotated[float, "at the wire"]
    energy_regenerated_j: float
    energy_auxiliary_j: float
    power_changes: Annotated[int, "counted as on the line (`simulation.ride`), as are the next four"]
    brake_changes: int
    coasting_s: float
    jerk_max_mps3: float
    jolt_mps2: Annotated[float, "deceleration that ends when the train comes to rest"]
    speed_max_mps: float
    deceleration_max_mps2: float
    rest_mps2: Annotated[float, "deceleration of the last step in which the train moves"]
    within_limit: int
    verdict: int
    intervention: Annotated[int, "the strongest of supervision"]
    events: Annotated[int, "all that the tick reported"]
    slid_steps: int
    refused: Annotated[int, "fixes that missed the bounds"]
    out_of_bounds_m: Annotated[float, "by how much the front was beyond its bounds at most; negative: never"]
    steps: int


BENCH_RUN: Final = dtype_of(BenchRunRow)
BENCH_OUTCOME: Final = dtype_of(BenchOutcomeRow)


@compiled
def lay_track(track: PathArrays, heights: Heights, run: BenchRunRow, row: StockRow, mark_m: float) -> None:
    """Lay this run's path into the scratch arrays: the way's heights and one gradient more, and its beacons."""
    true_slope, slope = run.gradient_permille / 1000.0, run.gradient_believed_permille / 1000.0
    half_m = row.board.kind.length_m / 2.0
    for i in range(track.profile.size):
        track.profile[i].elevation_m = heights.elevation_m[i] + true_slope * i
        track.pattern[i].climb_m = heights.climb_m[i] + slope * i
        track.pattern[i].body_elevation_m = heights.body_m[i] + slope * (i - half_m)
    for i in range(run.beacons):
        track.tag_positions_m[i] = mark_m - run.beacon_m[i]


@compiled
def begin(row: StockRow, run: BenchRunRow, begin_m: float, standoff_m: float) -> None:
    """Put body, sensors and unit into the state that a run begins with, `begin_m` along the path."""
    truth, plant, tachometer, unit = row.truth, row.plant, row.sensors.tachometer, row.board.unit
    plant.load_share = run.load_share
    plant.adhesion_factor = run.adhesion_factor
    plant.brake_factor = run.brake_factor
    plant.speed_mps = plant.wheel_speed_mps = plant.last_wheel_speed_mps = run.speed_mps
    rolls_at(row.sensors.slide_protection, run.speed_mps)
    row.body.brake_dead_time_s = max(row.body.brake_dead_time_s + run.brake_dead_time_off_s, 0.0)
    row.body.brake_lag_s = max(row.body.brake_lag_s + run.brake_lag_off_s, 0.0)
    row.sensed.load_share = run.load_share * run.load_shown
    tachometer.wheel_factor = 1.0 / (1.0 + run.wheel_error)
    tachometer.miscount_share = run.count_error
    truth.position_m = truth.offset_m = begin_m
    truth.tag_next, truth.tag_end = 0, run.beacons
    counted_m = run.since_fix_m * (1.0 + run.wheel_error) * (1.0 + run.count_error)
    unit.position_m = begin_m + counted_m - run.since_fix_m + run.fix_error_m
    unit.bound_ahead_m += abs(counted_m) * unit.bound_growth
    unit.bound_behind_m = unit.bound_ahead_m
    shown_mps = run.speed_mps * (1.0 + run.wheel_error)
    unit.speed_mps = unit.train_mps = unit.may_run_mps = shown_mps
    mark_m = begin_m + run.start_m
    unit.stop_limit_m = mark_m + run.stop_limit_m
    unit.target_stop_m = aim_within(mark_m, unit.stop_limit_m, standoff_m)
    unit.due_s, unit.cruise_mps = run.order_s, run.cruise_mps
    unit.plan_offset, unit.plan_rows, unit.plan_due_s = run.plan_offset, run.plan_rows, run.plan_due_s


@compiled
def take_fixes(
    row: StockRow, run: BenchRunRow, found: int, mark_m: float, tag_accuracy_m: float
) -> tuple[int, int]:
    """Let the unit take what its reader and its camera show after a step: fixes taken, and refused."""
    truth, unit = row.truth, row.board.unit
    accepted = refused = 0
    if found & PASSED_TAG != 0:
        beacon_m = mark_m - run.beacon_m[truth.tag_next] + run.beacon_error_m[truth.tag_next]
        truth.tag_next += 1
        position_m, bound_m = front_by_tag(unit, beacon_m, row.sensors.tag_reader.latched_m, tag_accuracy_m)
        if cut_interval(unit, position_m, bound_m, bound_m) <= 0.0:
            accepted += 1
        else:
            refused += 1
    for i in range(run.signs):
        sign_m = mark_m - run.sign_m[i]
        ahead_m = sign_m - truth.position_m
        if 0.0 <= ahead_m <= run.detection_m:
            seen_m = ahead_m - row.plant.speed_mps * run.frame_s
            position_m, bound_m = front_by_sign(unit, sign_m, seen_m)
            if sign_sighted(row.board.readers.sign, unit, position_m, bound_m) == TAKEN:
                accepted += 1
            else:
                refused += 1
    return accepted, refused


@compiled
def keep_step(outcome: BenchOutcomeRow, row: StockRow, events: int, refused: int) -> None:
    """Take one more step into the outcome; the last one, in which the train comes to rest, only as time."""
    plant, unit = row.plant, row.board.unit
    outcome.steps += 1
    outcome.slid_steps += plant.sliding
    outcome.events |= events
    outcome.refused += refused
    outcome.intervention = max(outcome.intervention, unit.intervention)
    outcome.speed_max_mps = max(outcome.speed_max_mps, plant.speed_mps)
    beyond_m = row.truth.position_m - unit.position_m
    out_m = max(beyond_m - unit.bound_ahead_m, -beyond_m - unit.bound_behind_m)
    outcome.out_of_bounds_m = max(outcome.out_of_bounds_m, out_m)
    if plant.speed_mps > 0.0:
        outcome.deceleration_max_mps2 = max(outcome.deceleration_max_mps2, -plant.acceleration_mps2)
        outcome.rest_mps2 = -plant.acceleration_mps2


@compiled
def keep_whole(
    outcome: BenchOutcomeRow, row: StockRow, run: BenchRunRow, stands: bool, mark_m: float
) -> None:
    """Take what the whole run has come to into the outcome."""
    plant, ride = row.plant, row.ride
    outcome.error_m = row.truth.position_m - mark_m
    outcome.time_s = outcome.steps * row.board.behaviour.step_s if stands else NONE_S
    outcome.energy_traction_j = plant.energy_traction_j
    outcome.energy_regenerated_j = plant.energy_regenerated_j
    outcome.energy_auxiliary_j = plant.energy_auxiliary_j
    outcome.power_changes, outcome.brake_changes = ride.power_changes, ride.brake_changes
    outcome.coasting_s = ride.time_s[COASTS]
    outcome.jerk_max_mps3, outcome.jolt_mps2 = ride.jerk_max_mps3, ride.jolt_mps2
    outcome.within_limit = 1 if stands and outcome.error_m <= run.stop_limit_m else 0
    outcome.verdict = row.board.tasc.verdict


@compiled
def run_one(
    row: StockRow,
    run: BenchRunRow,
    track: PathArrays,
    heights: Heights,
    places: tuple[float, float, float],
    outcome: BenchOutcomeRow,
    trace: Rows,
) -> None:
    """Make one run to rest from a prepared row; fills `outcome` and, as far as it reaches, `trace` (of TRACE).

    `places`: path coordinate at which it begins, accuracy of a beacon and standoff before a stop limit, m.
    """
    unit, tasc = row.board.unit, row.board.tasc
    begin_m, tag_accuracy_m, standoff_m = places
    mark_m = begin_m + run.start_m
    lay_track(track, heights, run, row, mark_m)
    begin(row, run, begin_m, standoff_m)
    outcome.out_of_bounds_m = -np.inf
    fixed, moved = False, run.speed_mps > 0.0
    for i in range(STEPS_MAX):
        found, events = step_one(row, track, i + 1)
        if i < trace.shape[0]:
            sample(trace[i], row, i + 1, 0)
        accepted, refused = take_fixes(row, run, found, mark_m, tag_accuracy_m)
        fixed = fixed or accepted > 0
        if run.expects_sign != 0 and not fixed and sign_is_missing(mark_m, unit.position_m):
            judge(tasc, TARGET_NOT_SEEN)
        keep_step(outcome, row, events, refused)
        moved = moved or row.plant.speed_mps > 0.0
        if moved and row.plant.speed_mps <= 0.0:
            break
    if unit.position_m - mark_m < -WEAK_TOLERANCE_M and limit_is_short(unit, mark_m):
        judge(tasc, SIGN_BEYOND_LIMIT)
    keep_whole(outcome, row, run, moved and row.plant.speed_mps <= 0.0, mark_m)


@compiled
def run_all(
    work: Rows,
    prepared: Rows,
    runs: Rows,
    track: PathArrays,
    heights: Heights,
    places: tuple[float, float, float],
    outcomes: Rows,
    trace: Rows,
) -> None:
    """Make every run, each from the prepared row; `work` (one row) and `trace` are left as the last one left them."""
    for i in range(runs.shape[0]):
        work[0] = prepared[0]
        run_one(work[0], runs[i], track, heights, places, outcomes[i], trace)


def new_stops(n: int) -> Rows:
    """`n` stops: dry and level, an empty train, nominal brakes, no beacon, no sign, no stop limit."""
    rows = np.zeros(n, dtype=BENCH_RUN)
    rows["adhesion_factor"] = rows["brake_factor"] = 1.0
    rows["stop_limit_m"] = FAR_M
    rows["order_s"] = rows["cruise_mps"] = np.inf
    return rows


def new_hops(orders_s: Sequence[float]) -> Rows:
    """A hop for each of these ordered running times, s: the same from a stand, by a unit that is shown its load."""
    rows = new_stops(len(orders_s))
    rows["order_s"], rows["load_shown"] = orders_s, 1
    return rows
