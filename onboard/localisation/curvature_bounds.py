"""How wrong a fix by curvature may be: what noise can do, what pulls it aside, and whether noise explains what is left.

A fix is a least sum of squares, so to first order whatever adds to the difference pulls it by the sum of that times
the map's change from metre to metre, over the sum of the squares of this change. A constant difference (bias) pulls
nothing: sums are taken without their mean. Noise of the rails' heading that is white and the gyro's own have a known
variance under such a sum. What a difference could hide is taken from the tests that it has passed, metre by metre
backwards from the front: blocks of `BLOCK_M` by their mean square, and all from the front on by what they turn in sum.

A bias that jumps on the way looks like the beginning of a curve, and no test of what is left at the least shift shows
it while the map has one within the search: the shift explains it. So all shifts count that noise and one jump of the
gyro's bias explain together, of any size, anywhere in what is compared. One before that is bias.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from onboard.localisation.collation import Samples
from onboard.localisation.curvature_row import BY_SPACE, RISES_M, WINDOW_MAX, CurvatureRow
from onboard.localisation.spatial_filter import shift_filter
from onboard.records import UnitRow
from vehicle.compiled import compiled

BLOCK_M: Final = 25  # what is judged by itself: a wave that the filter damps
SURE_OF_BLOCK: Final = 4.0  # deviations of the root mean square of a block
WHITE_PER_M: Final = 0.058  # variance that the filter leaves of white noise of 1 a metre
CALIBRATES_M: Final = 300.0  # wheels are compared over no less
JUMPS_EVERY: Final = 3  # metres at which a jump is looked for: far less than the filter takes over one
WORSE: Final = (
    2.0  # what is left may be so many times the rails' stated variance, before the gyro counts as worse
)


WORSE_IN_BLOCK: Final = 5.0  # the same of a block, of some three independent values


@compiled
def gain_doubt(own: CurvatureRow) -> float:
    """What a curvature by gyro and wheels may be wrong by, as a share."""
    return float(own.gain_share + (own.scale_high - own.scale_low) / 2.0 + own.varies_share)


@compiled
def noise_of(own: CurvatureRow, slope2: float, bend2: float, slow_s_per_m: float) -> float:
    """Variance a metre of the noise against curves with these sums of squares of their first and second differences."""
    rails = min(own.rail_level * bend2 / slope2, own.rail_peak) if slope2 > 0.0 else own.rail_peak
    return float(rails + own.yaw_density * slow_s_per_m)


@compiled
def best_count(own: CurvatureRow, shift: int, most: int) -> int:
    """How many metres, of at most `most`, promise the narrowest fix: more curves, but longer ago. 0: none."""
    end, newest = own.at + WINDOW_MAX, own.whole - 1 + shift
    known = own.known_per_m
    slope2 = bend2 = pull = slow = 0.0
    best, least_m = 0, np.inf
    for k in range(most - 1):
        t, i = newest - k, end - 1 - k
        slope = known[t] - known[t - 1]
        bend = known[t + 1] - known[t] - slope if k > 0 else 0.0
        slope2 += slope * slope
        bend2 += bend * bend
        slow += own.slow_s_per_m[i]
        pull += (
            slope * slope * (own.ahead_m - own.then_ahead_m[i] + own.behind_m - own.then_behind_m[i]) / 2.0
        )
        count = k + 2
        if count < own.settings.window_least_m or (count % BLOCK_M != 0 and count != most):
            continue
        turned = known[newest] - known[t - 1]
        left = slope2 - turned * turned / count - own.map_slope2_per_m * count
        if left > 0.0:
            noise = noise_of(own, slope2, bend2, slow / count)
            half_m = own.settings.sure_sigmas * math.sqrt(noise / left) + pull / slope2
            if half_m < least_m:
                best, least_m = count, half_m
    return best


@compiled
def late_m(own: CurvatureRow, slow_s_per_m: float) -> float:
    """By how much a metre may lie elsewhere than its delay says, m: the body's, and that of a filter by time."""
    speed_mps = 1.0 / slow_s_per_m
    late = own.delay_share * own.body_delay_s * speed_mps
    if own.filter_delay_m > 0.0:
        late += own.filter_delay_m * abs(speed_mps / own.filter_mps - 1.0)
    return float(late)


@compiled
def weigh_shift(own: CurvatureRow, shift: int, count: int) -> None:
    """What the map holds at a shift of the last `count` metres, and what pulls a fix by it: the wheels' run since,
    gain, a bias over changing speed, delay. Fills `slope2` to `pull_behind_m`.
    """
    end, newest = own.at + WINDOW_MAX, own.whole - 1 + shift
    known = own.known_per_m
    steady = (known[newest] - known[newest - count + 1]) / (count - 1.0)
    own.slow_mean_s_per_m = float(np.mean(own.slow_s_per_m[end - count : end]))
    # what shows as bias may be bias: it has jumped where it is more than was known
    shown_radps = own.mean_per_m / own.slow_mean_s_per_m / own.settings.sure_sigmas
    own.bias_radps2 = max(own.bias_radps2, shown_radps * shown_radps)
    gain, bias_radps = gain_doubt(own), own.settings.sure_sigmas * math.sqrt(own.bias_radps2)
    own.slope2 = own.bend2 = own.left = own.misfit = 0.0
    ahead = behind = by_gain = by_bias = by_delay = 0.0
    for k in range(count - 1):
        t, i = newest - k, end - 1 - k
        slope = known[t] - known[t - 1]
        bend = known[t + 1] - known[t] - slope if k > 0 else 0.0
        slow = own.slow_s_per_m[i]
        lean = slope - steady
        ahead_m, behind_m = own.ahead_m - own.then_ahead_m[i], own.behind_m - own.then_behind_m[i]
        own.slope2 += slope * slope
        own.bend2 += bend * bend
        own.left += lean * lean
        ahead += abs(lean * slope) * ahead_m
        behind += abs(lean * slope) * behind_m
        by_gain += lean * known[t]
        by_bias += lean * slow
        by_delay += abs(lean * slope) * late_m(own, slow)
        off = misfit_of(own, slope, known[t], i, gain, bias_radps)
        own.misfit += off * off
    own.left = max(own.left - own.map_slope2_per_m * count, 0.0)
    pull = gain * abs(by_gain) + bias_radps * abs(by_bias) + by_delay
    own.pull_ahead_m = (ahead + pull) / own.left if own.left > 0.0 else np.inf
    own.pull_behind_m = (behind + pull) / own.left if own.left > 0.0 else np.inf


@compiled
def misfit_of(
    own: CurvatureRow, slope: float, bent_per_m: float, i: int, gain: float, bias_radps: float
) -> float:
    """What map and run may differ by at one metre (the ring's `i`) for scale, gain and bias, 1/m."""
    doubt_m = own.ahead_m - own.then_ahead_m[i] + own.behind_m - own.then_behind_m[i]
    uneven = abs(own.slow_s_per_m[i] - own.slow_mean_s_per_m)
    return float(abs(slope) * doubt_m / 2.0 + gain * abs(bent_per_m) + bias_radps * uneven)


@compiled
def beyond_in_block(own: CurvatureRow, shift: int, count: int) -> float:
    """What is left beyond what is stated in the worst block, 1/m2, where that is more than chance makes of it: a gyro
    that has gone worse on the way, which the mean over all that is compared does not show yet.
    """
    end, newest = own.at + WINDOW_MAX, own.whole - 1 + shift
    worst = block2 = 0.0
    for k in range(count - 1):
        away = own.known_per_m[newest - k] - own.bent_per_m[end - 1 - k] - own.mean_per_m
        block2 += away * away
        if (k + 1) % BLOCK_M == 0:
            worst = max(worst, block2 / BLOCK_M)
            block2 = 0.0
    worst -= own.misfit / count
    noisy = worst > WORSE_IN_BLOCK * own.rail_variance_per_m2
    return float(worst - WORSE * own.rail_variance_per_m2) if noisy else 0.0


@compiled
def explains(own: CurvatureRow, shift: int, count: int, white: float) -> bool:
    """Whether noise explains all differences at a shift, in blocks and in sum; fills `unseen_m`.

    `white`: variance a metre of white noise beyond what is stated.
    """
    end, newest = own.at + WINDOW_MAX, own.whole - 1 + shift
    known = own.known_per_m
    steady = (known[newest] - known[newest - count + 1]) / (count - 1.0)
    gain, bias_radps = gain_doubt(own), own.settings.sure_sigmas * math.sqrt(own.bias_radps2)
    unseen = lean = total = allowed = block2 = block_most = 0.0
    for k in range(count - 1):
        t, i = newest - k, end - 1 - k
        slope = known[t] - known[t - 1]
        density = own.yaw_density * own.slow_s_per_m[i] + white
        off = misfit_of(own, slope, known[t], i, gain, bias_radps)
        away = known[t] - own.bent_per_m[i] - own.mean_per_m
        most = SURE_OF_BLOCK * math.sqrt(own.rail_variance_per_m2 + WHITE_PER_M * density)
        turns = 2.0 * own.rail_heading_rad * own.rail_heading_rad + density * (k + 1.0)
        turns_most = own.settings.sure_sigmas * math.sqrt(turns)
        block2 += away * away
        block_most = max(block_most, most + off + abs(slope))
        total += away
        allowed += off
        lean += slope - steady
        turns_most += allowed + 0.5 * abs(known[newest] - known[t - 1])
        hidden = (most + off) * math.sqrt(max(BLOCK_M / (k + 1.0), 1.0))  # in a part of the newest block
        unseen = max(unseen, min(hidden, turns_most / (k + 1.0)) * abs(lean))
        if abs(total) > turns_most:
            return False
        if (k + 1) % BLOCK_M == 0:
            if block2 > BLOCK_M * block_most * block_most:
                return False
            block2 = block_most = 0.0
    own.unseen_m = unseen / own.left
    return True


@compiled
def learn_bias(own: CurvatureRow, count: int) -> None:
    """What map and run differ by over all that was compared is bias: what both turn in all is known well."""
    first = own.at + WINDOW_MAX - count
    slow = own.slow_mean_s_per_m
    bent = float(np.mean(own.bent_per_m[first : first + count]))
    rails = 2.0 * own.rail_heading_rad * own.rail_heading_rad / count / count
    change = (own.bent_per_m[first + count - 1] - own.bent_per_m[first]) / count
    doubt2 = rails + own.yaw_density * slow / count + (gain_doubt(own) * bent) ** 2 + change * change
    doubt2 /= slow * slow
    share = own.bias_radps2 / (own.bias_radps2 + doubt2)
    turn_to_bias(own, own.bias_radps - share * own.mean_per_m / slow)
    own.bias_radps2 *= 1.0 - share
    own.bias_metre = own.metre


@compiled
def turn_to_bias(own: CurvatureRow, bias_radps: float) -> None:
    """Go by another bias, also over the metres in the ring and in the filter: a step there would pull fixes aside."""
    less_radps = own.bias_radps - bias_radps
    own.bias_radps = bias_radps
    for i in range(2 * WINDOW_MAX):
        own.bent_per_m[i] += less_radps * own.slow_s_per_m[i]
    if own.filtered == BY_SPACE:
        shift_filter(own.numbers, own.kept, less_radps * own.slow_s_per_m[own.at + WINDOW_MAX - 1])


@compiled
def calibrate(own: CurvatureRow, unit: UnitRow) -> None:
    """Two fixes and the wheels' count between them: an interval of their scale; the unit counts by its middle."""
    if unit.bound_growth > own.doubtful_share:
        return
    low_m, high_m = unit.position_m - unit.bound_behind_m, unit.position_m + unit.bound_ahead_m
    counted_m = unit.odometer_m - own.anchor_odometer_m
    if own.anchored != 0 and counted_m >= CALIBRATES_M:
        slid_m = unit.slid_ahead_m - own.anchor_slid_m
        slipped_m = unit.slipped_behind_m - own.anchor_slipped_m
        low = max(own.scale_low, (low_m - own.anchor_high_m - slid_m) / counted_m - own.varies_share)
        high = min(own.scale_high, (high_m - own.anchor_low_m + slipped_m) / counted_m + own.varies_share)
        if low > high:  # something was false: nothing is known but what is stated
            low, high = 1.0 - own.worn_share, 1.0 + own.worn_share
            own.anchored = 0
        own.scale_low, own.scale_high = low, high
        unit.odometer_scale = (low + high) / 2.0
        unit.bound_growth = (high - low) / 2.0 + own.varies_share
    if own.anchored == 0 or high_m - low_m < 0.5 * (own.anchor_high_m - own.anchor_low_m):
        own.anchored = 1
        own.anchor_odometer_m, own.anchor_low_m, own.anchor_high_m = unit.odometer_m, low_m, high_m
        own.anchor_slid_m, own.anchor_slipped_m = unit.slid_ahead_m, unit.slipped_behind_m


@compiled
def without_jump(own: CurvatureRow, known: Samples, count: int, shift: int) -> float:
    """Equation (3) for one shift of the last `count` metres, without a constant and one jump of the gyro's bias.

    The least over where the jump may be: on the map's metres `known`, what the filter makes of a step that is one over
    the speed high, by least squares.
    """
    begin = own.at + WINDOW_MAX - count
    total = total2 = 0.0
    for k in range(count):
        away = known[k + shift] - own.bent_per_m[begin + k]
        total += away
        total2 += away * away
    mean = total / count
    least = whole = total2 - mean * total
    turned = level = level2 = 0.0  # of the metres beyond those over which the filter takes it up
    for first in range(count - 1, -1, -1):
        done = first + RISES_M
        if done < count:
            slow = own.slow_s_per_m[begin + done]
            turned += slow * (known[done + shift] - own.bent_per_m[begin + done] - mean)
            level += slow
            level2 += slow * slow
        if first % JUMPS_EVERY != 0:
            continue
        product, sums, squares = turned, level, level2
        for k in range(first, min(done, count)):
            step = own.slow_s_per_m[begin + k] * own.rises[k - first]
            product += step * (known[k + shift] - own.bent_per_m[begin + k] - mean)
            sums += step
            squares += step * step
        free = squares - sums * sums / count
        if free > 0.0:
            least = min(least, whole - product * product / free)
    return least


@compiled
def explained_by_jump(
    own: CurvatureRow, known: Samples, count: int, hull: tuple[float, float], most: float
) -> tuple[float, float]:
    """The hull of shifts, widened by all of which one jump of the bias leaves no more than `most`."""
    from_m, to_m = hull
    for one in range(math.floor(from_m)):
        if without_jump(own, known, count, one) <= most:
            from_m = max(one - 1.0, 0.0)
            break
    for one in range(own.span, math.ceil(to_m), -1):
        if without_jump(own, known, count, one) <= most:
            to_m = min(one + 1.0, float(own.span))
            break
    return from_m, to_m
