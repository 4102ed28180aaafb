"""From yaw rates and the wheels' count to a ring of curvatures a metre apart (Harada et al., sections 3.1 and 3.3).

The yaw rate without its bias, summed up, is the heading; its difference from whole metre to whole metre is the
curvature, whatever the speed. The body turns later than its bogies, so a yaw rate belongs to where the train was a
delay ago. While a train crawls its curvature is held; while it stands the gyro shows its bias and no metre comes.
Each metre keeps what the wheels' count could be wrong by until then.
"""

from __future__ import annotations

from typing import Final

from onboard.localisation.curvature_row import BY_SPACE, BY_TIME, WINDOW_MAX, CurvatureRow
from onboard.localisation.spatial_filter import SETTLES_M, filtered_sample, settle_filter
from onboard.records import UnitRow
from vehicle.compiled import compiled, compiled_when_called

HOLD_MPS: Final = 0.5  # slower than this the curvature is held: a yaw rate over nothing says nothing
STANDS_S: Final = 1.0  # a body that has stood for this turns no more: what shows is bias
STOOD_STEPS: Final = 1000  # of a train that stands when its path is taken up: it has for long


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
    own.next_m = own.settings.every_m
    own.anchored = 0
    own.within_m = 0.0


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
def take_up_run(own: CurvatureRow, unit: UnitRow) -> float:
    """Take up the wheels' run of this step and how wrong it may be; returns it, m.

    While the unit doubts its wheels, what was learned of them is worth nothing: they may have lied then already.
    """
    if unit.bound_growth > own.doubtful_share:
        own.scale_low, own.scale_high = 1.0 - own.worn_share, 1.0 + own.worn_share
        own.anchored = 0
    counted_m = unit.odometer_m - own.odometer_m
    own.odometer_m = unit.odometer_m
    longer, shorter = doubt_of_scale(own, unit)
    run_m = counted_m * unit.odometer_scale
    ahead_m = abs(run_m) * longer + unit.slid_ahead_m - own.slid_ahead_m
    behind_m = abs(run_m) * shorter + unit.slipped_behind_m - own.slipped_behind_m
    own.ahead_m += ahead_m
    own.behind_m += behind_m
    keep_within(own, unit, (ahead_m + behind_m) / 2.0)
    own.slid_ahead_m, own.slipped_behind_m = unit.slid_ahead_m, unit.slipped_behind_m
    own.along_m += run_m
    return run_m


@compiled
def keep_within(own: CurvatureRow, unit: UnitRow, grown_m: float) -> None:
    """What the estimate may be wrong by grows with the run; bounds that others have cut hold it too."""
    bounds_m = unit.bound_ahead_m + unit.bound_behind_m
    if own.within_m > 0.0:
        own.within_m += grown_m
        if bounds_m < own.bounds_m:
            own.within_m = min(own.within_m, bounds_m / 2.0)
    own.bounds_m = bounds_m


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
def keep_metre(own: CurvatureRow, bent_per_m: float, slow_s_per_m: float) -> None:
    """One metre into the ring."""
    value = bent_per_m
    if own.filtered == BY_SPACE:
        if own.settling_m < 0.0:
            settle_filter(own.numbers, own.kept, bent_per_m)
        value = filtered_sample(own.numbers, own.kept, bent_per_m)
    if own.settling_m < 0.0:
        own.settling_m = SETTLES_M
    own.settling_m = max(own.settling_m - 1.0, 0.0)
    for at in (own.at, own.at + WINDOW_MAX):
        own.bent_per_m[at] = value
        own.slow_s_per_m[at] = slow_s_per_m
        own.then_ahead_m[at] = own.ahead_m
        own.then_behind_m[at] = own.behind_m
        own.then_jolt_m[at] = own.slid_ahead_m + own.slipped_behind_m
    own.at = (own.at + 1) % WINDOW_MAX
    if own.settling_m == 0.0:
        own.metres = min(own.metres + 1, WINDOW_MAX)


@compiled_when_called
def measure(own: CurvatureRow, unit: UnitRow, yaw_radps: float, step_s: float) -> None:
    """What this step's yaw rate says of the metres that it brought, resampled by distance."""
    speed_mps = max(unit.speed_mps * unit.odometer_scale, 0.0)
    turned_rad = (yaw_radps - own.bias_radps) * step_s
    to_m = own.along_m - speed_mps * own.body_delay_s
    gained_m = to_m - own.reached_m
    if speed_mps < HOLD_MPS:
        turned_rad = own.held_per_m * max(gained_m, 0.0)
    elif own.filtered == BY_TIME:
        turned_rad = filtered_sample(own.numbers, own.kept, turned_rad / (speed_mps * step_s)) * max(
            gained_m, 0.0
        )
    before_rad = own.heading_rad
    own.heading_rad += turned_rad
    if gained_m <= 0.0:
        return
    slow_s_per_m = 1.0 / max(speed_mps, HOLD_MPS)
    while own.metre + 1.0 <= to_m:
        own.metre += 1
        here_rad = before_rad + (own.metre - own.reached_m) / gained_m * turned_rad
        own.held_per_m = here_rad - own.metre_rad
        own.metre_rad = here_rad
        keep_metre(own, own.held_per_m, slow_s_per_m)
    own.reached_m = to_m
