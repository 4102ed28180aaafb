"""Curvature collation (曲率照合) in the tick: a yaw gyro and the wheels against a map of curvature.

Harada, Maki, Kazato and Ishiguri, section 3. Every `every_m` the ring of the last metres (`curvature_ring`) is
compared with the map (equation (2)) over the range that the bounds leave, at most N_s. The window N_r grows with the
path, up to `window_m`, as long as the wheels' scale error stretches it only slightly. No fix is taken without
transition curves in the window (3.4), or if the least mean square of the difference exceeds a threshold (equation (3),
3.5): then the track is not the one in the map, or the wheels have slid.

Invariant: the fix's interval contains the front while gyro, rails and wheels are no worse than stated. It is the hull
of all shifts that noise can explain: at the true shift the sum of squares (without a constant difference, which is
bias) exceeds the least one by no more than `sure_sigmas` standard deviations of noise can cause, allowing for one jump
of the gyro's bias, which may look like the beginning of a curve. It is widened by systematic errors
(`curvature_bounds`). Similar curves give a wide fix instead of a wrong one. Of the window the fix uses the part that
gives the narrowest interval, because older curves say less. A filter other than by distance is for experiments; its
delay at other speeds widens the interval too.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from onboard.localisation.collation import Samples, all_squares, explained_shifts, least_shift
from onboard.localisation.curvature_bounds import (
    BLOCK_M,
    WHITE_PER_M,
    WORSE,
    best_count,
    beyond_in_block,
    calibrate,
    explained_by_jump,
    explains,
    learn_bias,
    noise_of,
    weigh_shift,
    without_jump,
)
from onboard.localisation.curvature_ring import begin_anew, measure, stand, take_up_run
from onboard.localisation.curvature_row import (
    MARGIN_M,
    WINDOW_MAX,
    CurvatureReading,
    CurvatureRow,
)
from onboard.localisation.fix import FOREIGN, MISSED, NOTHING, TAKEN, taken_towards
from onboard.localisation.spatial_filter import SETTLES_M
from onboard.records import Chart, UnitRow
from vehicle.compiled import compiled, compiled_when_called

NEAR_M: Final = 8  # shifts nearer than this are of one curve
STRETCH_M: Final = 4.0  # the wheels' scale may stretch what is compared by no more
JOLT_M: Final = 0.5  # nor a slide or slip what a fix goes by
SAME_MAX: Final = 3  # readings in a row that are equal to the last bit to the one before: the gyro is stuck
TRANSITION_PER_M2: Final = 1.0e-5  # filtered curvature that changes faster than this is a transition
FLOOR_M: Final = 0.3  # of an interval: metres are whole


@compiled
def lay_map(own: CurvatureRow, unit: UnitRow, chart: Chart, from_m: float, count: int) -> int:
    """Copy `count` metres of the map from a path coordinate (m), between its own; returns how many not to go by.

    Those are all up to the last one that is missing.
    """
    begin = math.floor(from_m)
    share = from_m - begin
    missing = 0
    for k in range(count):
        i = int(begin) + k
        value = np.nan
        if 0 <= i < unit.path_rows - 1:
            first = chart.path[unit.path_offset + i].curvature_per_m
            value = first + share * (chart.path[unit.path_offset + i + 1].curvature_per_m - first)
        own.known_per_m[k] = value
        if np.isnan(value):
            missing = k + 1
    return missing


@compiled
def comparable_metres(own: CurvatureRow, longest: int) -> tuple[int, int]:
    """Metres of the ring that the wheels' scale stretches by little, and those of them since the last slide or slip.

    Of the latter the first are what the filter makes of those before: no fix goes by them.
    """
    end = own.at + WINDOW_MAX
    jolts_m = own.slid_ahead_m + own.slipped_behind_m
    doubts_m = own.ahead_m + own.behind_m - jolts_m
    since = 0
    for k in range(longest):
        i = end - 1 - k
        doubt_m = doubts_m - (own.then_ahead_m[i] + own.then_behind_m[i] - own.then_jolt_m[i])
        if doubt_m > 2.0 * STRETCH_M:
            return k, since
        if since == k and jolts_m - own.then_jolt_m[i] <= JOLT_M:
            since = k + 1
    return longest, since


@compiled
def transitions_m(seen: Samples, begin: int, count: int) -> float:
    """Way of transition curve in the run (section 3.4): where its curvature changes fast."""
    found = 0.0
    for k in range(begin + 1, begin + count):
        if abs(seen[k] - seen[k - 1]) > TRANSITION_PER_M2:
            found += 1.0
    return found


@compiled
def lay_window(own: CurvatureRow, unit: UnitRow, chart: Chart) -> int:
    """Choose the metres to be compared and lay the map beside them; returns how many of them a fix may go by.

    Fills `whole` (0: there is nothing to compare), `low` and `span`. Bounds wider than what is searched give nothing:
    the front could be where nobody has looked.
    """
    own.whole = 0
    if unit.bound_ahead_m + unit.bound_behind_m > 2.0 * own.settings.search_m:
        return 0
    longest, since = comparable_metres(own, min(own.metres, int(own.settings.window_m)))
    own.low = -math.ceil(unit.bound_behind_m) - MARGIN_M
    own.span = math.ceil(unit.bound_ahead_m) + MARGIN_M - own.low
    newest_m = unit.position_m - (own.along_m - own.metre)
    missing = lay_map(own, unit, chart, newest_m - (longest - 1) + own.low, longest + own.span)
    if longest - missing < own.settings.window_least_m:
        return 0
    own.whole = longest - missing
    if missing > 0:
        for k in range(own.whole + own.span):
            own.known_per_m[k] = own.known_per_m[k + missing]
    return min(own.whole, since - int(SETTLES_M))


@compiled_when_called
def collate_with_map(own: CurvatureRow, unit: UnitRow, chart: Chart) -> int:
    """Compare the last metres with the map; a fix, FOREIGN, or NOTHING where there is nothing to go by."""
    most = lay_window(own, unit, chart)
    if own.whole == 0:
        return NOTHING
    own.compared += 1
    begin = own.at + WINDOW_MAX - own.whole
    least = all_squares(own.known_per_m, own.bent_per_m, begin, own.whole, own.span, own.energy, own.free)
    own.mismatch_per_m = math.sqrt(np.min(own.energy[: own.span + 1]) / own.whole)
    if own.mismatch_per_m > own.settings.mismatch_per_m:
        return FOREIGN
    if transitions_m(own.bent_per_m, begin, own.whole) < own.settings.transition_m:
        return NOTHING
    count = best_count(own, least, most)
    return NOTHING if count == 0 else fix_by(own, unit, count)


@compiled
def fix_by(own: CurvatureRow, unit: UnitRow, count: int) -> int:
    """The fix that the last `count` metres give, if noise explains what is left and leaves it within one curve."""
    begin = own.at + WINDOW_MAX - count
    known = own.known_per_m[own.whole - count :]
    least = all_squares(known, own.bent_per_m, begin, count, own.span, own.energy, own.free)
    known_mean = np.mean(known[least : least + count])
    own.mean_per_m = float(known_mean - np.mean(own.bent_per_m[begin : begin + count]))
    weigh_shift(own, least, count)
    # what is left beyond what is stated counts as white noise: a gyro that has gone worse
    beyond = own.free[least] / count - WORSE * own.rail_variance_per_m2 - own.misfit / count
    white = max(beyond, beyond_in_block(own, least, count), 0.0) / WHITE_PER_M
    noise = noise_of(own, own.slope2, own.bend2, own.slow_mean_s_per_m) + white
    sure_m = own.settings.sure_sigmas * math.sqrt(noise / own.left) if own.left > 0.0 else np.inf
    if not (sure_m <= NEAR_M and explains(own, least, count, white)):
        return NOTHING
    limit = own.free[least] + own.settings.sure_sigmas * own.settings.sure_sigmas * noise
    far = own.settings.sure_sigmas * math.sqrt(own.rail_peak + noise) + math.sqrt(own.misfit)
    hull = explained_shifts(own.free, own.span, least, NEAR_M, limit, own.free[least] + far * far)
    from_m, to_m = hull
    first, last = math.floor(from_m), min(math.ceil(to_m), own.span)
    shift_m = least_shift(known, own.bent_per_m, begin, count, first, last, own.mean_per_m, own.energy)
    shift_m = min(max(shift_m, from_m), to_m)
    if own.metre >= own.bias_metre + count and count > 2 * BLOCK_M:
        learn_bias(own, count)
    floor_m = FLOOR_M + unit.pulse_m + own.map_error_m + own.unseen_m
    own.count = count
    its_m = (to_m - from_m + own.pull_behind_m + own.pull_ahead_m) / 2.0 + floor_m
    if own.forgives_jumps == 0:
        most = without_jump(own, known, count, least) + limit - own.free[least]
        from_m, to_m = explained_by_jump(own, known, count, hull, most)
    return take_fix(
        own,
        unit,
        unit.position_m + own.low + shift_m,
        shift_m - from_m + own.pull_behind_m + floor_m,
        to_m - shift_m + own.pull_ahead_m + floor_m,
        its_m,
    )


@compiled
def take_fix(
    own: CurvatureRow, unit: UnitRow, position_m: float, behind_m: float, ahead_m: float, its_m: float
) -> int:
    """Cut the bounds; move the estimate only as far as the fix is better than what it came from and the run since.

    Windows overlap, so fixes are not independent of one another: nothing is gained by taking the mean of two.
    `its_m`: half the interval of a gyro in order, by which the estimate goes.
    """
    within_m = own.within_m if own.within_m > 0.0 else (unit.bound_behind_m + unit.bound_ahead_m) / 2.0
    weight = max(1.0 - its_m * its_m / (within_m * within_m), 0.0)
    outcome = taken_towards(unit, position_m, behind_m, ahead_m, weight)
    if outcome == TAKEN:
        own.within_m = within_m + weight * (its_m - within_m)
        own.bounds_m = unit.bound_behind_m + unit.bound_ahead_m
        calibrate(own, unit)
    return outcome


@compiled
def is_silent(own: CurvatureRow, reading: CurvatureReading) -> bool:
    """Whether the gyro shows nothing, or has shown the same to the last bit for too long."""
    own.same = own.same + 1 if reading.yaw_radps == own.last_radps else 0
    own.last_radps = reading.yaw_radps
    return bool(reading.taken == 0 or own.same >= SAME_MAX or not np.isfinite(reading.yaw_radps))


@compiled
def curvature(
    own: CurvatureRow, reading: CurvatureReading, unit: UnitRow, chart: Chart, step_s: float
) -> int:
    """Take in one yaw rate; every `every_m` a comparison with the map."""
    if own.fitted == 0:
        return NOTHING
    if is_silent(own, reading):
        begin_anew(own, unit)
        return MISSED
    if own.path != unit.paths_taken_up:
        begin_anew(own, unit)
        return NOTHING
    run_m = take_up_run(own, unit)
    own.bias_radps2 += own.bias_walk_radps * own.bias_walk_radps * 2.0 * step_s / own.bias_walk_s
    # wheels that show nothing may be locked
    if run_m == 0.0 and unit.speed_mps == 0.0 and unit.may_run_mps <= 0.0:
        stand(own, reading.yaw_radps, step_s)
        return NOTHING
    own.stood_steps = 0
    measure(own, unit, reading.yaw_radps, step_s)
    if own.along_m < own.next_m or unit.position_known == 0 or own.same > 0:
        return NOTHING
    own.next_m = own.along_m + own.settings.every_m
    return collate_with_map(own, unit, chart)
