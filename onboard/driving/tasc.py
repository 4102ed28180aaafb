"""Stop at the mark (定位置停止制御, TASC) in Oda's four parts (2.1): position, target speed, following, brake.

Invariant: a command given now acts only after the brake's dead time (無駄時間), so every decision is taken on the
state predicted for that moment from the commands already under way, never on the present one.

Positions are distances ahead to the mark, m; decelerations are positive, m/s^2. All laws are compiled and work
on a DESIGN row (what was chosen or learned for this train) and a TASC row (what this stop has come to).
"""

from __future__ import annotations

import math
from enum import IntEnum, IntFlag
from typing import Annotated, Final, Protocol

from vehicle.compiled import compiled
from vehicle.record import dtype_of
from vehicle.response import approach, dead_time_steps

PENDING_MAX: Final = 64
WEAK_TOLERANCE_M: Final = (
    1.0  # Oda, 2.2: the accuracy asked of a stop; beyond it the stop counts as impossible
)
STRENGTH_MEAN_S: Final = 2.0  # assumed: over this a brake's strength is judged,
STRENGTH_FROM_MPS2: Final = 0.3  # once it has been applied this much
WEAK_S: Final = 2.0  # assumed: found too weak for this long; when a brake begins, its model is no measure yet
BISECTIONS: Final = 30
NEWTON_STEPS: Final = 6
LEAST_BRAKE_MPS2: Final = 0.02  # of the train's whole deceleration: it never rolls at a mark it has reached


class StopVerdict(IntEnum):
    """Whether the stop at the mark is possible; the first impossibility found stands."""

    POSSIBLE = 0
    BRAKE_TOO_WEAK = 1  # even the full brake would pass the mark by more than the tolerance
    TARGET_NOT_SEEN = 2  # no beacon or sign where one was due: stops by the tachometer alone
    SIGN_BEYOND_LIMIT = 3  # the mark lies beyond the stop limit: stops at the limit instead


class StopLawPart(IntFlag):
    """What the law consists of beyond proportional following; a train has all, an experiment may leave some out."""

    PREDICTION = 1  # decides on the state in which its command will act, not on the present one
    REDRAWING = 2  # draws the pattern anew where a fix has moved the estimate
    FEED_FORWARD = 4  # asks for the pattern's own deceleration, and by the gain only for what is off it
    RESISTANCE = 8  # takes gradient and running resistance off the brake demand
    SOFT_END = 16  # lets the pattern end in a weaker brake


WHOLE_LAW: Final = (
    StopLawPart.PREDICTION
    | StopLawPart.REDRAWING
    | StopLawPart.FEED_FORWARD
    | StopLawPart.RESISTANCE
    | StopLawPart.SOFT_END
)
PREDICTION: Final = int(StopLawPart.PREDICTION)  # compiled code reads plain integers
REDRAWING: Final = int(StopLawPart.REDRAWING)
FEED_FORWARD: Final = int(StopLawPart.FEED_FORWARD)
RESISTANCE: Final = int(StopLawPart.RESISTANCE)
SOFT_END: Final = int(StopLawPart.SOFT_END)

POSSIBLE: Final = int(StopVerdict.POSSIBLE)
BRAKE_TOO_WEAK: Final = int(StopVerdict.BRAKE_TOO_WEAK)
TARGET_NOT_SEEN: Final = int(StopVerdict.TARGET_NOT_SEEN)
SIGN_BEYOND_LIMIT: Final = int(StopVerdict.SIGN_BEYOND_LIMIT)


class DesignRow(Protocol):
    """How one train stops at the mark: what was chosen for it, and what it has learned."""

    parts: Annotated[int, "of Part: what the law consists of"]
    pattern_mps2: Annotated[float, "deceleration of the target-speed pattern (目標速度パターン)"]
    pattern_least_mps2: Annotated[
        float, "a corrected pattern is never flatter: the brake is released instead"
    ]
    brake_max_mps2: float
    command_jerk_mps3: float
    end_mps2: Annotated[float, "deceleration left when the train comes to rest"]
    end_jerk_mps3: Annotated[float, "at which the pattern falls to it"]
    gain_per_s: Annotated[float, "proportional; the other two make it PID"]
    integral_gain_per_s2: float
    derivative_gain: float
    dead_time_s: Annotated[float, "the brake as the controller believes it: file values, then learned ones"]
    lag_s: float
    offset_mps2: Annotated[float, "actual less designed deceleration at the pattern's (減速度偏差)"]
    correction_least_m: Annotated[float, "a fix that moves the estimate by less leaves the pattern as it is"]
    step_s: float


DESIGN: Final = dtype_of(DesignRow)


class TascRow(Protocol):
    """What one stop at the mark has come to."""

    braking: int
    pattern_mps2: Annotated[float, "of the pattern as corrected; 0: not begun"]
    built_mps2: Annotated[float, "what the brake gives now, by the controller's model"]
    demand_mps2: Annotated[float, "last brake demand, before the bias correction"]
    integral_m: float
    error_mps: float
    speed_mps: Annotated[float, "at the last step; 0: none"]
    actual_mean_mps2: Annotated[float, "what the brake gave of late, and below what the model expected,"]
    expected_mean_mps2: Annotated[float, "both under the same first-order mean"]
    weak_s: Annotated[float, "for how long the brake has been found too weak"]
    verdict: int
    head: int
    pending_mps2: Annotated[list[float], PENDING_MAX, "what the model expects of each command under way"]


TASC: Final = dtype_of(TascRow)


@compiled
def reset(tasc: TascRow) -> None:
    """Forget the last stop; to be called when a new mark is set while the brake is released."""
    tasc.braking = 0
    tasc.pattern_mps2 = 0.0
    tasc.built_mps2 = 0.0
    tasc.demand_mps2 = 0.0
    tasc.integral_m = 0.0
    tasc.error_mps = 0.0
    tasc.speed_mps = 0.0
    tasc.actual_mean_mps2 = 0.0
    tasc.expected_mean_mps2 = 0.0
    tasc.weak_s = 0.0
    tasc.verdict = POSSIBLE
    tasc.head = 0
    for i in range(PENDING_MAX):
        tasc.pending_mps2[i] = 0.0


# 1. position (位置推定部)


@compiled
def aim_m(distance_m: float, limit_distance_m: float, margin_m: float) -> float:
    """Distance to where the train shall stop, m: the mark, or `margin_m` before the stop limit if that is nearer."""
    return min(distance_m, limit_distance_m - margin_m)


# 2. target-speed pattern (目標速度算出部)


@compiled
def pattern(design: DesignRow, pattern_mps2: float, distance_m: float) -> tuple[float, float]:
    """Target speed (m/s) and the pattern's deceleration (m/s^2) at a distance before the mark.

    v = sqrt(2 b distance), with a soft end: in the last moments, at time T before rest, the deceleration is
    end + jerk T, so the train comes to rest with `end_mps2` alone and nothing has to be released abruptly.
    """
    end, jerk = design.end_mps2, design.end_jerk_mps3
    if design.parts & SOFT_END == 0:
        end = pattern_mps2
    if distance_m <= 0.0:
        return 0.0, min(end, pattern_mps2)
    rise_s = (pattern_mps2 - end) / jerk
    if rise_s <= 0.0:
        return math.sqrt(2.0 * pattern_mps2 * distance_m), pattern_mps2
    soft_mps = end * rise_s + jerk * rise_s**2 / 2.0
    soft_m = end * rise_s**2 / 2.0 + jerk * rise_s**3 / 6.0
    if distance_m >= soft_m:
        return math.sqrt(soft_mps**2 + 2.0 * pattern_mps2 * (distance_m - soft_m)), pattern_mps2
    # end T^2/2 + jerk T^3/6 = distance: convex, so Newton's steps from above never pass the root
    left_s = math.sqrt(2.0 * distance_m / end)
    for _ in range(NEWTON_STEPS):
        excess_m = end * left_s**2 / 2.0 + jerk * left_s**3 / 6.0 - distance_m
        left_s -= excess_m / (end * left_s + jerk * left_s**2 / 2.0)
    return end * left_s + jerk * left_s**2 / 2.0, end + jerk * left_s


@compiled
def pattern_through(design: DesignRow, speed_mps: float, distance_m: float) -> float:
    """Deceleration (m/s^2) of the pattern that passes through this speed and distance; 0 where it is too flat.

    At most the full brake, which then does not suffice.
    """
    low, high = design.pattern_least_mps2, design.brake_max_mps2
    if pattern(design, low, distance_m)[0] > speed_mps:
        return 0.0
    if pattern(design, high, distance_m)[0] <= speed_mps:
        return high
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        if pattern(design, middle, distance_m)[0] > speed_mps:
            high = middle
        else:
            low = middle
    return low


# 3. following control (追従制御部)


@compiled
def predicted_motion(
    tasc: TascRow, design: DesignRow, speed_mps: float, own_mps2: float
) -> tuple[float, float]:
    """Speed (m/s) when a command given now begins to act, and the distance run until then, m.

    Follows the commands under way through dead time, then through the lag with the last of them held.
    `own_mps2` is what gradient and running resistance take off the speed without any brake.
    """
    if design.parts & PREDICTION == 0:
        return speed_mps, 0.0
    steps = dead_time_steps(design.dead_time_s, design.step_s)
    lag_steps = round(design.lag_s / design.step_s)
    built = tasc.built_mps2
    run_m = 0.0
    for i in range(steps + lag_steps):
        slot = (tasc.head - max(steps - 1 - i, 0)) % PENDING_MAX
        target = tasc.pending_mps2[slot]
        built = approach(built, target, design.lag_s, design.command_jerk_mps3, design.step_s)
        after_mps = max(0.0, speed_mps - (built + own_mps2) * design.step_s)
        run_m += (speed_mps + after_mps) / 2.0 * design.step_s
        speed_mps = after_mps
    return speed_mps, run_m


@compiled
def pattern_demand_mps2(
    tasc: TascRow, design: DesignRow, speed_mps: float, distance_m: float, own_mps2: float, moved_m: float
) -> float:
    """Brake demand, m/s^2, that follows the pattern from a predicted speed and distance.

    `moved_m`: by how much a fix has just moved the estimate. The pattern is then drawn anew through the predicted
    state, so that the demand changes no more than it must; where that is too flat, the brake is released until
    the designed pattern is met again.
    """
    redraws = design.parts & REDRAWING != 0
    if redraws and tasc.braking == 1 and abs(moved_m) >= design.correction_least_m:
        tasc.pattern_mps2 = pattern_through(design, speed_mps, distance_m)
        tasc.integral_m = 0.0
        if tasc.pattern_mps2 == 0.0:
            tasc.braking = 0
    if tasc.braking == 0:
        # The brake needs b/jerk to build up: half of that is lost as running time.
        lost_m = speed_mps * design.pattern_mps2 / design.command_jerk_mps3 / 2.0
        if speed_mps < pattern(design, design.pattern_mps2, distance_m - lost_m)[0]:
            return 0.0
        tasc.braking = 1
        tasc.pattern_mps2 = design.pattern_mps2
        tasc.integral_m = 0.0
        tasc.error_mps = 0.0
    target_mps, slope_mps2 = pattern(design, tasc.pattern_mps2, distance_m)
    error = speed_mps - target_mps
    change_mps2 = (error - tasc.error_mps) / design.step_s
    wanted = slope_mps2 if design.parts & FEED_FORWARD != 0 else 0.0
    wanted += design.gain_per_s * error + design.derivative_gain * change_mps2
    wanted += design.integral_gain_per_s2 * tasc.integral_m
    tasc.error_mps = error
    demand = max(wanted, LEAST_BRAKE_MPS2)
    if design.parts & RESISTANCE != 0:
        demand -= own_mps2
    if 0.0 < demand < design.brake_max_mps2:  # no winding up where the brake has nothing more to give
        tasc.integral_m += error * design.step_s
    return demand


# 4. brake (ブレーキ制御部)


@compiled
def corrected_command_mps2(design: DesignRow, demand_mps2: float) -> float:
    """Command, as designed deceleration, that makes this train give `demand_mps2`: the learned bias taken off.

    The offset was learned at the pattern's deceleration and fades with the demand: no brake has none.
    """
    share = min(1.0, demand_mps2 / design.pattern_mps2)
    return min(max(demand_mps2 - design.offset_mps2 * share, 0.0), design.brake_max_mps2)


@compiled
def expected_mps2(design: DesignRow, command_mps2: float) -> float:
    """What the model expects of a command: the inverse of `corrected_command_mps2`."""
    knee = design.pattern_mps2 - design.offset_mps2
    if command_mps2 >= knee:
        return command_mps2 + design.offset_mps2
    return command_mps2 * design.pattern_mps2 / knee


@compiled
def command_mps2(tasc: TascRow, design: DesignRow, demand_mps2: float) -> float:
    """The command of this step, as designed deceleration; takes it up into the model's dead time.

    The demand moves by at most the jerk limit, and the model's brake is carried one step on.
    """
    change_max = design.command_jerk_mps3 * design.step_s
    demand = min(max(demand_mps2, 0.0), design.brake_max_mps2 + max(design.offset_mps2, 0.0))
    demand = min(max(demand, tasc.demand_mps2 - change_max), tasc.demand_mps2 + change_max)
    tasc.demand_mps2 = demand
    command = corrected_command_mps2(design, demand)
    tasc.head = (tasc.head + 1) % PENDING_MAX
    tasc.pending_mps2[tasc.head] = expected_mps2(design, command)
    acting = (tasc.head - dead_time_steps(design.dead_time_s, design.step_s)) % PENDING_MAX
    tasc.built_mps2 = approach(
        tasc.built_mps2, tasc.pending_mps2[acting], design.lag_s, design.command_jerk_mps3, design.step_s
    )
    return command


@compiled
def judge(tasc: TascRow, verdict: int) -> None:
    """Note an impossibility; the first one stands."""
    if tasc.verdict == POSSIBLE:
        tasc.verdict = verdict


@compiled
def brake_strength(tasc: TascRow, design: DesignRow, speed_mps: float, own_mps2: float) -> float:
    """Share of the expected deceleration that the brake gives, at most 1; 1 until it can be told."""
    share = design.step_s / STRENGTH_MEAN_S
    if tasc.speed_mps > 0.0:
        actual = (tasc.speed_mps - speed_mps) / design.step_s - own_mps2
        tasc.actual_mean_mps2 += share * (actual - tasc.actual_mean_mps2)
        tasc.expected_mean_mps2 += share * (tasc.built_mps2 - tasc.expected_mean_mps2)
    tasc.speed_mps = speed_mps
    if tasc.expected_mean_mps2 < STRENGTH_FROM_MPS2:
        return 1.0
    return min(1.0, max(0.0, tasc.actual_mean_mps2 / tasc.expected_mean_mps2))


@compiled
def tasc_step(
    tasc: TascRow,
    design: DesignRow,
    speed_mps: float,
    distance_m: float,
    moved_m: float,
    own_mps2: float,
) -> float:
    """One step of parts 2 to 4: the brake command as designed deceleration, m/s^2; 0 while the pattern is not met.

    `distance_m` is the estimate to where the front shall stop, `moved_m` the last fix's correction of it (0 in
    all other steps), `own_mps2` the deceleration by gradient and running resistance.
    """
    strength = brake_strength(tasc, design, speed_mps, own_mps2)
    later_mps, run_m = predicted_motion(tasc, design, speed_mps, own_mps2)
    left_m = distance_m - run_m
    demand = pattern_demand_mps2(tasc, design, later_mps, left_m, own_mps2, moved_m)
    strongest = expected_mps2(design, design.brake_max_mps2)
    room_m, energy = left_m + WEAK_TOLERANCE_M, later_mps**2 / 2.0
    weak = (strength * strongest + own_mps2) * room_m < energy
    tasc.weak_s = tasc.weak_s + design.step_s if weak else 0.0
    if tasc.weak_s >= WEAK_S or (strongest + own_mps2) * room_m < energy:
        judge(tasc, BRAKE_TOO_WEAK)
    return command_mps2(tasc, design, demand)
