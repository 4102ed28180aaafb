"""Curvature collation (曲率照合) in the tick: a yaw gyro and the wheels against a map of curvature.

Harada, Maki, Kazato and Ishiguri, section 3. The yaw rate, summed up over the distance that the wheels count, is the
heading; its difference over each metre is the curvature, which goes through the spatial filter into a ring of the last
metres. Every `every_m` the ring is compared with the map (equation (2)) over the window that the bounds leave. No fix
is taken without transition curves in what is compared (3.4), and none while the least mean square of the difference
passes a threshold (equation (3), 3.5): then the track is another than the map's, or the wheels have slid.

Invariant: the fix's interval holds the front while gyro and rails are no worse than stated. It is the hull of all
shifts that noise explains (the sum of squares, without a constant difference such as a bias, is no greater than the
least by more than `sure_sigmas` deviations can make it), widened by what pulls a fit aside: the wheels' run since the
curves that it rests on, gain, a bias that is another at another speed, what a foreign track may have added in the
newest metres without being noticed, the body's delay. Look-alike curves give a wide fix instead of a wrong one. From
two fixes and the wheels' count between them follows an interval of the wheels' scale, and from that how far the run
since a curve may be wrong: less than the guarantee for worn wheels.
"""

from __future__ import annotations

import math
from typing import Annotated, Final, Protocol

import numpy as np

from onboard.localisation.collation import Floats, all_squares, explained, nearest
from onboard.localisation.fix import FOREIGN, MISSED, NOTHING, TAKEN, taken
from onboard.localisation.spatial_filter import SETTLES_M, passed, settle
from onboard.records import Chart, UnitRow
from vehicle.compiled import compiled

BY_SPACE: Final = 0  # what run and map are filtered by
BY_TIME: Final = 1
UNFILTERED: Final = 2

WINDOW_MAX: Final = 800
SEARCH_MAX: Final = 200
MARGIN_M: Final = 5  # searched beyond the bounds
SHIFTS: Final = 2 * (SEARCH_MAX + MARGIN_M) + 4
BLOCK_M: Final = 25  # what is judged by itself: a wave that the filter damps
NEAR_M: Final = 8  # shifts nearer than this are of one curve
STRETCH_M: Final = 4.0  # the wheels' scale may stretch what is compared by no more
JOLT_M: Final = 0.5  # nor a slide or slip within it
HOLD_MPS: Final = 0.5  # slower than this the curvature is held: a yaw rate over nothing says nothing
STANDS_S: Final = 1.0  # a body that has stood for this turns no more: what shows is bias
STOOD_STEPS: Final = 1000  # of a train that stands when its path is taken up: it has for long
SAME_MAX: Final = 20  # readings in a row that are equal to the last bit: the gyro is stuck
TRANSITION_PER_M2: Final = 1.0e-5  # filtered curvature that changes faster than this is a transition
FLOOR_M: Final = 0.3  # of an interval: metres are whole, and pulses
CALIBRATES_M: Final = 300.0  # wheels are compared over no less
VARIES_OVER_M: Final = 1000.0  # what they count over longer ways differs from their mean by less, in proportion
SURE_OF_BLOCK: Final = 4.0  # deviations of the root mean square of a block
WHITE_PER_M: Final = 0.058  # variance that the filter leaves of white noise of 1 a metre


class CurvatureReading(Protocol):
    """What the gyro shows."""

    taken: Annotated[int, "0: it shows nothing"]
    yaw_radps: Annotated[float, "mean yaw rate of the step, to the right"]


class CurvatureRow(Protocol):
    """What the unit knows of its gyro and its line, and keeps of the last metres."""

    # known beforehand
    fitted: int
    filtered: Annotated[int, "BY_SPACE, BY_TIME or UNFILTERED"]
    numbers: Annotated[list[float], 10, "of the filter's sections, by metre or by step"]
    window_m: float
    window_least_m: float
    search_m: float
    every_m: float
    transition_m: float
    mismatch_per_m: float
    sure_sigmas: float
    worn_share: Annotated[float, "most that wheels are worn by"]
    varies_share: Annotated[float, "most that their count over a while differs from their mean: creep, the tread's slope"]
    doubtful_share: Annotated[float, "bounds that grow faster are those of a unit in doubt of its wheels"]
    gain_share: Annotated[float, "the gyro's gain may be wrong by this"]
    bias_walk_radps: Annotated[float, "deviation of the bias in the long run"]
    bias_walk_s: float
    yaw_density: Annotated[float, "variance of the yaw rate times the step: white noise, rad^2/s"]
    body_delay_s: float
    delay_share: Annotated[float, "what body_delay_s may be wrong by"]
    filter_delay_m: Annotated[float, "of the filter, where it is not the map's; 0: it is"]
    filter_mps: float
    map_error_m: float
    rail_level: Annotated[float, "variance of the rails' heading a metre, as of white noise"]
    rail_peak: Annotated[float, "greatest spectral density of their filtered curvature, as a variance a metre"]
    rail_variance_per_m2: Annotated[float, "of their filtered curvature"]
    rail_heading_rad: Annotated[float, "deviation of their filtered heading"]
    # now
    path: Annotated[int, "unit.paths_taken_up as it was"]
    odometer_m: float
    slid_ahead_m: Annotated[float, "unit's, as it was"]
    slipped_behind_m: float
    along_m: Annotated[float, "run since the path was taken up, by the calibrated wheels"]
    heading_rad: Annotated[float, "turned since then"]
    reached_m: Annotated[float, "where along the heading has come to"]
    metre: Annotated[int, "the last whole metre in the ring"]
    metre_rad: Annotated[float, "heading there"]
    metres: Annotated[int, "in the ring without a break"]
    settling_m: Annotated[float, "until the filter has settled"]
    held_per_m: Annotated[float, "the last curvature, while the train crawls"]
    kept: Annotated[list[float], 4, "of the filter"]
    next_m: Annotated[float, "along, of the next comparison"]
    bias_radps: float
    bias_radps2: Annotated[float, "its variance"]
    bias_metre: Annotated[int, "in the ring, when map and run last told of it"]
    stood_steps: int
    last_radps: float
    same: int
    ahead_m: Annotated[float, "what the run may be short by in all"]
    behind_m: float
    scale_low: Annotated[float, "true way over the wheels' count, at least"]
    scale_high: float
    anchored: Annotated[int, "1: there is a fix to compare the wheels with"]
    anchor_odometer_m: float
    anchor_low_m: float
    anchor_high_m: float
    anchor_slid_m: float
    anchor_slipped_m: float
    mismatch: Annotated[float, "least mean square of the difference at the last comparison, 1/m^2"]
    compared_m: Annotated[float, "way that the last fix rests on"]
    why: Annotated[int, "dbg"]
    dbg: Annotated[list[float], 12, "dbg"]
    at: Annotated[int, "where the next metre goes"]
    bent_per_m: Annotated[list[float], 2 * WINDOW_MAX, "the ring, twice, so that every window lies in one piece"]
    slow_s_per_m: Annotated[list[float], 2 * WINDOW_MAX, "one over the speed then"]
    then_ahead_m: Annotated[list[float], 2 * WINDOW_MAX, "ahead_m then"]
    then_behind_m: Annotated[list[float], 2 * WINDOW_MAX]
    then_jolt_m: Annotated[list[float], 2 * WINDOW_MAX, "slides and slips until then"]
    known_per_m: Annotated[list[float], WINDOW_MAX + SHIFTS, "the map in the window"]
    energy: Annotated[list[float], SHIFTS]
    free: Annotated[list[float], SHIFTS]


@compiled
def begin_anew(own: CurvatureRow, unit: UnitRow) -> None:
    """Nothing of the last metres holds any more: another path, or a gyro that was silent."""
    own.path = unit.paths_taken_up
    own.odometer_m = unit.odometer_m
    own.slid_ahead_m, own.slipped_behind_m = unit.slid_ahead_m, unit.slipped_behind_m
    own.along_m = own.heading_rad = own.reached_m = own.metre_rad = own.held_per_m = 0.0
    own.metre = own.metres = own.at = 0
    own.settling_m = -1.0
    own.bias_metre = 0
    own.stood_steps = STOOD_STEPS if unit.speed_mps == 0.0 else 0
    own.next_m = own.every_m
    own.anchored = 0


@compiled
def doubt_of_scale(own: CurvatureRow, unit: UnitRow) -> tuple[float, float]:
    """What a metre by the calibrated wheels may be longer and shorter by, m; no less than a unit in doubt says."""
    scale = unit.odometer_scale
    longer = (own.scale_high + own.varies_share) / scale - 1.0
    shorter = 1.0 - (own.scale_low - own.varies_share) / scale
    if unit.bound_growth > own.doubtful_share:
        return max(longer, unit.bound_growth), max(shorter, unit.bound_growth)
    return longer, shorter


@compiled
def ran(own: CurvatureRow, unit: UnitRow) -> float:
    """Take up the wheels' run of this step and how wrong it may be; returns it, m."""
    counted_m = unit.odometer_m - own.odometer_m
    own.odometer_m = unit.odometer_m
    longer, shorter = doubt_of_scale(own, unit)
    run_m = counted_m * unit.odometer_scale
    own.ahead_m += abs(run_m) * longer + unit.slid_ahead_m - own.slid_ahead_m
    own.behind_m += abs(run_m) * shorter + unit.slipped_behind_m - own.slipped_behind_m
    own.slid_ahead_m, own.slipped_behind_m = unit.slid_ahead_m, unit.slipped_behind_m
    own.along_m += run_m
    return run_m


@compiled
def stand(own: CurvatureRow, yaw_radps: float, step_s: float) -> None:
    """A train that stands turns no more: what the gyro shows is its bias."""
    own.stood_steps += 1
    if own.stood_steps * step_s <= STANDS_S:
        return
    noise = own.yaw_density / step_s
    share = own.bias_radps2 / (own.bias_radps2 + noise)
    own.bias_radps += share * (yaw_radps - own.bias_radps)
    own.bias_radps2 *= 1.0 - share


@compiled
def keep(own: CurvatureRow, bent_per_m: float, slow_s_per_m: float) -> None:
    """One metre into the ring."""
    value = bent_per_m
    if own.filtered == BY_SPACE:
        if own.settling_m < 0.0:
            settle(own.numbers, own.kept, bent_per_m)
        value = passed(own.numbers, own.kept, bent_per_m)
    if own.settling_m < 0.0:
        own.settling_m = SETTLES_M
    own.settling_m = max(own.settling_m - 1.0, 0.0)
    at = own.at
    for half in range(2):
        own.bent_per_m[at + half * WINDOW_MAX] = value
        own.slow_s_per_m[at + half * WINDOW_MAX] = slow_s_per_m
        own.then_ahead_m[at + half * WINDOW_MAX] = own.ahead_m
        own.then_behind_m[at + half * WINDOW_MAX] = own.behind_m
        own.then_jolt_m[at + half * WINDOW_MAX] = own.slid_ahead_m + own.slipped_behind_m
    own.at = (at + 1) % WINDOW_MAX
    if own.settling_m == 0.0:
        own.metres = min(own.metres + 1, WINDOW_MAX)


@compiled
def measure(own: CurvatureRow, unit: UnitRow, yaw_radps: float, step_s: float) -> None:
    """What this step's yaw rate says of the metres that it brought (resampled by distance, 3.3)."""
    speed_mps = max(unit.speed_mps * unit.odometer_scale, 0.0)
    turned_rad = (yaw_radps - own.bias_radps) * step_s
    to_m = own.along_m - speed_mps * own.body_delay_s
    gained_m = to_m - own.reached_m
    if own.filtered == BY_TIME and speed_mps > HOLD_MPS:
        turned_rad = passed(own.numbers, own.kept, turned_rad / (speed_mps * step_s)) * max(gained_m, 0.0)
    if speed_mps < HOLD_MPS:
        turned_rad = own.held_per_m * max(gained_m, 0.0)
    before_rad = own.heading_rad
    own.heading_rad += turned_rad
    if gained_m <= 0.0:
        return
    slow_s_per_m = 1.0 / max(speed_mps, HOLD_MPS)
    while own.metre + 1.0 <= to_m:
        own.metre += 1
        share = (own.metre - own.reached_m) / gained_m
        here_rad = before_rad + share * turned_rad
        own.held_per_m = here_rad - own.metre_rad
        own.metre_rad = here_rad
        keep(own, own.held_per_m, slow_s_per_m)
    own.reached_m = to_m


@compiled
def lay_map(own: CurvatureRow, unit: UnitRow, chart: Chart, from_m: float, count: int) -> int:
    """Copy `count` metres of the map from a path coordinate (m), between its own; returns how many are missing at first.

    Where one is missing among the last, all are.
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
def comparable(own: CurvatureRow, longest: int) -> tuple[int, int]:
    """Metres of the ring that wheels may stretch by little, and of these those since the last slide or slip."""
    end = own.at + WINDOW_MAX
    stretched = 0
    for k in range(longest):
        i = end - 1 - k
        jolts_m = own.slid_ahead_m + own.slipped_behind_m - own.then_jolt_m[i]
        doubt_m = own.ahead_m - own.then_ahead_m[i] + own.behind_m - own.then_behind_m[i] - jolts_m
        if doubt_m > 2.0 * STRETCH_M:
            break
        stretched = k + 1
    since = 0
    for k in range(stretched):
        i = end - 1 - k
        if own.slid_ahead_m + own.slipped_behind_m - own.then_jolt_m[i] > JOLT_M:
            break
        since = k + 1
    return stretched, since


@compiled
def transitions_m(seen: Floats, begin: int, count: int) -> float:
    """Way of transition curve in the run (section 3.4): where its curvature changes fast."""
    found = 0.0
    for k in range(begin + 1, begin + count):
        if abs(seen[k] - seen[k - 1]) > TRANSITION_PER_M2:
            found += 1.0
    return found


@compiled
def noise_of(own: CurvatureRow, slope2: float, bend2: float, slow_s_per_m: float) -> float:
    """Variance a metre of the noise against curves with these sums of squares of their first and second differences."""
    rails = min(own.rail_level * bend2 / slope2, own.rail_peak) if slope2 > 0.0 else own.rail_peak
    return rails + own.yaw_density * slow_s_per_m


@compiled
def best_count(own: CurvatureRow, shift: int, whole: int, most: int) -> int:
    """How many metres, of at most `most`, promise the narrowest fix: more curves, but longer ago."""
    end = own.at + WINDOW_MAX
    slope2 = bend2 = pull = slow = 0.0
    best, least_m = 0, np.inf
    for k in range(most - 1):
        t = whole - 1 - k + shift
        i = end - 1 - k
        slope = own.known_per_m[t] - own.known_per_m[t - 1]
        bend = slope - (own.known_per_m[t + 1] - own.known_per_m[t]) if k > 0 else 0.0
        slope2 += slope * slope
        bend2 += bend * bend
        slow += own.slow_s_per_m[i]
        doubt_m = own.ahead_m - own.then_ahead_m[i] + own.behind_m - own.then_behind_m[i]
        pull += slope * slope * doubt_m / 2.0
        count = k + 2
        if (count % BLOCK_M == 0 or count == most) and count >= own.window_least_m and slope2 > 0.0:
            turned = own.known_per_m[whole - 1 + shift] - own.known_per_m[t - 1]
            left = slope2 - turned * turned / count
            if left <= 0.0:
                continue
            half_m = own.sure_sigmas * math.sqrt(noise_of(own, slope2, bend2, slow / count) / left) + pull / slope2
            if half_m < least_m:
                best, least_m = count, half_m
    return best


@compiled
def judged(
    own: CurvatureRow, shift: int, whole: int, count: int, mean: float, white: float
) -> tuple[int, float, float, float, float]:
    """Whether noise explains the difference at a shift, block by block and in sum; what pulls a fit aside.

    Returns 1 if it does, variance a metre of the noise against these curves, room that misfits take in the sum of
    squares, and by how much the front may be ahead and behind beyond what noise does.
    """
    end = own.at + WINDOW_MAX
    first = whole - count
    steady = (own.known_per_m[whole - 1 + shift] - own.known_per_m[first + shift]) / (count - 1.0)
    gain = own.gain_share + (own.scale_high - own.scale_low) / 2.0 + own.varies_share
    middle = 0.0
    for k in range(count):
        middle += own.slow_s_per_m[end - 1 - k]
    middle /= count
    bias_radps = own.sure_sigmas * math.sqrt(own.bias_radps2)
    slope2 = bend2 = left = misfit = slow_sum = 0.0
    ahead = behind = by_gain = by_bias = by_delay = unseen = lean = 0.0
    total = allowed = 0.0
    block2 = block_most = 0.0
    fits = 1
    for k in range(count - 1):
        t = whole - 1 - k
        i = end - 1 - k
        here = own.known_per_m[t + shift]
        slope = here - own.known_per_m[t + shift - 1]
        bend = own.known_per_m[t + shift + 1] - here - slope if k > 0 else 0.0
        slow = own.slow_s_per_m[i]
        c = slope - steady
        slope2 += slope * slope
        bend2 += bend * bend
        left += c * c
        slow_sum += slow
        ahead_m = own.ahead_m - own.then_ahead_m[i]
        behind_m = own.behind_m - own.then_behind_m[i]
        ahead += abs(c * slope) * ahead_m
        behind += abs(c * slope) * behind_m
        by_gain += c * here
        by_bias += c * slow
        by_delay += abs(c * slope) * late_m(own, slow)
        off = abs(slope) * (ahead_m + behind_m) / 2.0 + gain * abs(here) + bias_radps * abs(slow - middle)
        misfit += off * off
        # what noise and all that may leave here
        sigma2 = own.rail_variance_per_m2 + WHITE_PER_M * (own.yaw_density * slow + white)
        away = here - own.bent_per_m[i] - mean
        block2 += away * away
        block_most = max(block_most, SURE_OF_BLOCK * math.sqrt(sigma2) + off + abs(slope))
        total += away
        allowed += off + 0.5 * abs(slope)
        lean += c
        heading = math.sqrt(2.0 * own.rail_heading_rad**2 + (own.yaw_density * slow + white) * (k + 1.0))
        most = own.sure_sigmas * heading
        unseen = max(unseen, min(SURE_OF_BLOCK * math.sqrt(sigma2), most / (k + 1.0)) * abs(lean))
        if abs(total) > most + allowed + abs(mean) * (k + 1.0):
            fits = 0
            own.why = 11
            own.dbg[8] = k
            own.dbg[9] = abs(total)
            own.dbg[10] = most
            own.dbg[11] = allowed
        if (k + 1) % BLOCK_M == 0:
            if block2 > BLOCK_M * block_most * block_most:
                fits = 0
                own.why = 12
                own.dbg[8] = k
                own.dbg[9] = math.sqrt(block2 / BLOCK_M)
                own.dbg[10] = block_most
            block2 = block_most = 0.0
    if left <= 0.0:
        return 0, 0.0, misfit, 0.0, 0.0
    noise = noise_of(own, slope2, bend2, slow_sum / count) + white
    if own.sure_sigmas * math.sqrt(noise / left) > NEAR_M:
        fits = 0
    both = (gain * abs(by_gain) + bias_radps * abs(by_bias) + by_delay + unseen) / left
    own.dbg[8] = gain * abs(by_gain) / left
    own.dbg[9] = bias_radps * abs(by_bias) / left
    own.dbg[10] = by_delay / left
    own.dbg[11] = unseen / left
    return fits, noise, misfit, ahead / left + both, behind / left + both


@compiled
def learn_bias(own: CurvatureRow, mean: float, count: int) -> None:
    """What map and run differ by over all that was compared is bias: what they turn in all is known well."""
    first = own.at + WINDOW_MAX - count
    slow = bent = 0.0
    for k in range(first, first + count):
        slow += own.slow_s_per_m[k]
        bent += own.bent_per_m[k]
    slow, bent = slow / count, bent / count
    gain = own.gain_share + (own.scale_high - own.scale_low) / 2.0 + own.varies_share
    rails = 2.0 * own.rail_heading_rad * own.rail_heading_rad / count / count
    change = own.bent_per_m[first + count - 1] - own.bent_per_m[first]
    doubt2 = rails + own.yaw_density * slow / count + (gain * bent) ** 2 + (change / count) ** 2
    doubt2 /= slow * slow
    share = own.bias_radps2 / (own.bias_radps2 + doubt2)
    own.bias_radps -= share * mean / slow
    own.bias_radps2 *= 1.0 - share
    own.bias_metre = own.metre


@compiled
def late_m(own: CurvatureRow, slow_s_per_m: float) -> float:
    """By how much a metre may lie elsewhere than its delay says, m: the body's, and that of a filter by time."""
    speed_mps = 1.0 / slow_s_per_m
    late = own.delay_share * own.body_delay_s * speed_mps
    if own.filter_delay_m > 0.0:
        late += own.filter_delay_m * abs(speed_mps / own.filter_mps - 1.0)
    return late


@compiled
def calibrate(own: CurvatureRow, unit: UnitRow) -> None:
    """Two fixes and the wheels' count between them: an interval of the scale, and the unit's own in its middle."""
    if unit.bound_growth > own.doubtful_share:
        own.anchored = 0
        return
    low_m, high_m = unit.position_m - unit.bound_behind_m, unit.position_m + unit.bound_ahead_m
    if own.anchored != 0:
        counted_m = unit.odometer_m - own.anchor_odometer_m
        if counted_m >= CALIBRATES_M:
            slid_m = unit.slid_ahead_m - own.anchor_slid_m
            slipped_m = unit.slipped_behind_m - own.anchor_slipped_m
            while_share = own.varies_share * min(VARIES_OVER_M / counted_m, 1.0)
            low = max(own.scale_low, (low_m - own.anchor_high_m - slid_m) / counted_m - while_share)
            high = min(own.scale_high, (high_m - own.anchor_low_m + slipped_m) / counted_m + while_share)
            if low <= high:
                own.scale_low, own.scale_high = low, high
            else:
                own.scale_low, own.scale_high = 1.0 - own.worn_share, 1.0 + own.worn_share
                own.anchored = 0
            unit.odometer_scale = (own.scale_low + own.scale_high) / 2.0
            unit.bound_growth = (own.scale_high - own.scale_low) / 2.0 + own.varies_share
    if own.anchored == 0 or high_m - low_m < 0.5 * (own.anchor_high_m - own.anchor_low_m):
        own.anchored = 1
        own.anchor_odometer_m, own.anchor_low_m, own.anchor_high_m = unit.odometer_m, low_m, high_m
        own.anchor_slid_m, own.anchor_slipped_m = unit.slid_ahead_m, unit.slipped_behind_m


@compiled
def collate(own: CurvatureRow, unit: UnitRow, chart: Chart) -> int:
    """Compare the last metres with the map; a fix, FOREIGN, or NOTHING where there is nothing to go by."""
    if max(unit.bound_ahead_m, unit.bound_behind_m) > own.search_m:
        own.why = 1
        return NOTHING
    longest = min(own.metres, int(own.window_m))
    longest, since_jolt = comparable(own, longest)
    if longest < own.window_least_m:
        own.why = 2
        return NOTHING
    low = -int(math.ceil(unit.bound_behind_m)) - MARGIN_M
    high = int(math.ceil(unit.bound_ahead_m)) + MARGIN_M
    span = high - low
    newest_m = unit.position_m - (own.along_m - own.metre)
    missing = lay_map(own, unit, chart, newest_m - (longest - 1) + low, longest + span)
    whole = longest - missing
    if whole < own.window_least_m:
        own.why = 3
        return NOTHING
    if missing > 0:
        for k in range(whole + span):
            own.known_per_m[k] = own.known_per_m[k + missing]
    end = own.at + WINDOW_MAX
    least = all_squares(own.known_per_m, own.bent_per_m, end - whole, whole, span, own.energy, own.free)
    lowest = own.energy[least]
    for shift in range(span + 1):
        lowest = min(lowest, own.energy[shift])
    own.mismatch = lowest / whole
    if own.mismatch > own.mismatch_per_m * own.mismatch_per_m:
        own.why = 4
        return FOREIGN
    if transitions_m(own.bent_per_m, end - whole, whole) < own.transition_m:
        own.why = 5
        return NOTHING
    count = best_count(own, least, whole, min(whole, since_jolt))
    if count == 0:
        own.why = 6
        return NOTHING
    return fitted(own, unit, whole, count, span, low)


@compiled
def fitted(own: CurvatureRow, unit: UnitRow, whole: int, count: int, span: int, low: int) -> int:
    """The fix that the last `count` of `whole` metres give, if noise explains what is left."""
    begin = own.at + WINDOW_MAX - count
    known = own.known_per_m[whole - count :]
    least = all_squares(known, own.bent_per_m, begin, count, span, own.energy, own.free)
    own.why = 0
    plain = 0.0
    for k in range(count):
        plain += known[least + k] - own.bent_per_m[begin + k]
    mean = plain / count
    # noise beyond what is stated counts as white: a gyro that has gone worse
    _, _, misfit, _, _ = judged(own, least, whole, count, mean, 0.0)
    beyond = own.free[least] / count - 2.0 * own.rail_variance_per_m2 - misfit / count
    white = max(beyond, 0.0) / WHITE_PER_M
    fits, noise, misfit, ahead_m, behind_m = judged(own, least, whole, count, mean, white)
    if fits == 0:
        return NOTHING
    near = own.free[least] + own.sure_sigmas * own.sure_sigmas * noise
    peak = own.sure_sigmas * math.sqrt(own.rail_peak + noise) + math.sqrt(misfit)
    from_m, to_m = explained(own.free, span, least, NEAR_M, near, own.free[least] + peak * peak)
    first, last = int(math.floor(from_m)), int(math.ceil(to_m))
    shift_m = nearest(known, own.bent_per_m, begin, count, first, min(last, span), mean, own.energy)
    shift_m = min(max(shift_m, from_m), to_m)
    floor_m = FLOOR_M + unit.pulse_m + own.map_error_m
    own.compared_m = float(count)
    own.why = 10
    own.dbg[0] = shift_m + low
    own.dbg[1] = from_m + low
    own.dbg[2] = to_m + low
    own.dbg[3] = ahead_m
    own.dbg[4] = behind_m
    own.dbg[5] = noise
    own.dbg[6] = misfit
    own.dbg[7] = white
    if own.metre >= own.bias_metre + count and count > 2 * BLOCK_M:
        learn_bias(own, mean, count)
    outcome = taken(
        unit,
        unit.position_m + low + shift_m,
        shift_m - from_m + behind_m + floor_m,
        to_m - shift_m + ahead_m + floor_m,
    )
    if outcome == TAKEN:
        calibrate(own, unit)
    return outcome


@compiled
def curvature(
    own: CurvatureRow, reading: CurvatureReading, unit: UnitRow, chart: Chart, step_s: float
) -> int:
    """Take in one yaw rate; every `every_m` a comparison with the map."""
    if own.fitted == 0:
        return NOTHING
    own.same = own.same + 1 if reading.yaw_radps == own.last_radps else 0
    own.last_radps = reading.yaw_radps
    silent = reading.taken == 0 or own.same >= SAME_MAX or not np.isfinite(reading.yaw_radps)
    if silent or own.path != unit.paths_taken_up:
        begin_anew(own, unit)
        return MISSED if silent else NOTHING
    run_m = ran(own, unit)
    own.bias_radps2 += own.bias_walk_radps * own.bias_walk_radps * 2.0 * step_s / own.bias_walk_s
    if run_m == 0.0 and unit.speed_mps == 0.0:
        stand(own, reading.yaw_radps, step_s)
        return NOTHING
    own.stood_steps = 0
    measure(own, unit, reading.yaw_radps, step_s)
    if own.along_m < own.next_m or unit.position_known == 0:
        return NOTHING
    own.next_m = own.along_m + own.every_m
    return collate(own, unit, chart)
