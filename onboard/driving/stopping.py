"""TASC in the tick (定位置停止制御): aims, keeps the model of the brake true, rides over slides, keeps the waves.

The model's commands under way are always those that were really issued, by whomever: TASC, the driving between
stations, or supervision. So whoever braked before, the prediction is right when TASC takes over.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from onboard.driving.slides import LET_GO_S
from onboard.driving.supervision import RESERVE_M
from onboard.driving.tasc import (
    POSSIBLE,
    DesignRow,
    TascRow,
    aim_m,
    command_mps2,
    expected_mps2,
    pattern,
    reset,
    tasc_step,
)
from onboard.localisation.tachometer import LOST_SHARE
from onboard.records import EVENT_VERDICT, NO_INTERVENTION, UnitRow
from vehicle.adhesion import SLIP_FLOOR_MPS
from vehicle.brakes import service_target_mps2
from vehicle.compiled import compiled
from vehicle.record import dtype_of
from vehicle.records import TrainRow
from vehicle.response import approach

LIMIT_MARGIN_M: Final = (
    5.0  # aiming this far before the stop limit the pattern stays under supervision's curve
)
FAR_S: Final = 4.0  # beyond this running time and twice the braking distance there is nothing to decide yet
WAVE_STEPS: Final = 640  # of 0.1 s: a stop from 130 km/h with half the usual deceleration
ASKED_LEAST_MPS2: Final = 2e-3  # a lag never quite dies away: less than this counts as no brake


class WaveRow(Protocol):
    """The last minute of a train's deceleration as designed and as it was, m/s^2."""

    head: int
    steps: Annotated[int, "since TASC began to brake"]
    disturbed: Annotated[int, "in this stop wheels slid, or supervision braked"]
    speed_mps: Annotated[float, "at the last step"]
    built_mps2: Annotated[float, "what the command gives after the designed lag, without dead time"]
    designed_mps2: Annotated[list[float], WAVE_STEPS, "設計減速度"]
    actual_mps2: Annotated[list[float], WAVE_STEPS, "発生減速度, gradient and running resistance taken off"]


WAVE: Final = dtype_of(WaveRow)


@compiled
def aim_within(mark_m: float, limit_m: float, standoff_m: float) -> float:
    """Where the front shall stop, m: at the mark, or `standoff_m` before the stop limit if that comes first."""
    return mark_m if mark_m < limit_m else limit_m - standoff_m


@compiled
def limit_is_short(unit: UnitRow, mark_m: float) -> bool:
    """Whether the mark lies further than the stop limit lets the train go."""
    return mark_m >= unit.stop_limit_m - unit.bound_ahead_m - LIMIT_MARGIN_M - RESERVE_M


@compiled
def ride_over_slide(
    unit: UnitRow, train: TrainRow, tasc: TascRow, own_mps2: float, run_m: float, step_s: float
) -> None:
    """Set `unit.train_mps`: the wheel's speed, or what the train may have while its wheels do not roll.

    While they slide it falls as the brake should make it fall, but not below the axle that is let go; while they slip
    it holds, each within what the protection allows. Localisation has taken that into its bounds: the estimate moves
    within them, so the interval of possible positions stays the same.
    """
    rolled_mps = unit.speed_mps * unit.odometer_scale
    if unit.wheel_slide == 0 or unit.believes_wheels != 0:
        unit.train_mps = rolled_mps
        return
    share = min(train.wheel_slide_share_max, LOST_SHARE)
    before_mps = unit.train_mps
    if unit.wheel_slide < 0:
        falling_mps = before_mps - max(tasc.built_mps2 + own_mps2, 0.0) * step_s
        if unit.let_go_s >= LET_GO_S:  # that axle rolls, or comes back: the train is no slower
            falling_mps = max(falling_mps, unit.last_axle_mps * unit.odometer_scale)
        after_mps = min(max(falling_mps, rolled_mps), rolled_mps / (1.0 - share))
    else:
        after_mps = min(max(before_mps, (rolled_mps - SLIP_FLOOR_MPS) / (1.0 + share)), rolled_mps)
    beyond_m = (before_mps + after_mps) / 2.0 * step_s - run_m * unit.odometer_scale
    if unit.wheel_slide < 0:
        beyond_m = min(max(beyond_m, 0.0), run_m * share / (1.0 - share))
    else:
        beyond_m = max(min(beyond_m, 0.0), -run_m)
    unit.train_mps = after_mps
    unit.position_m += beyond_m
    unit.bound_ahead_m -= beyond_m
    unit.bound_behind_m += beyond_m


@compiled
def stop_command_mps2(unit: UnitRow, tasc: TascRow, design: DesignRow, own_mps2: float) -> float:
    """This step's command of TASC as designed deceleration, m/s^2; sets `braking_to_stop`.

    A `braking_to_stop` that the event-driven part has taken back means a new target.
    """
    if tasc.braking == 1 and unit.braking_to_stop == 0:
        tasc.braking = 0
        tasc.verdict = POSSIBLE
    distance_m = aim_m(
        unit.target_stop_m - unit.position_m,
        unit.stop_limit_m - unit.position_m - unit.bound_ahead_m,
        LIMIT_MARGIN_M,
    )
    moved_m = unit.fix_correction_m
    unit.fix_correction_m = 0.0
    speed_mps = unit.train_mps
    if tasc.braking == 0 and distance_m > speed_mps * (FAR_S + speed_mps / design.pattern_mps2):
        tasc.speed_mps = 0.0
        command_mps2(tasc, design, 0.0)
        return 0.0
    command = tasc_step(tasc, design, speed_mps, distance_m, moved_m, own_mps2)
    unit.braking_to_stop = tasc.braking
    if tasc.braking == 1:
        unit.target_mps = min(unit.target_mps, pattern(design, tasc.pattern_mps2, distance_m)[0])
    return command


@compiled
def stop_anew(tasc: TascRow, wave: WaveRow) -> None:
    """The train stands with its brakes applied: the next stop begins from nothing."""
    if tasc.head != 0 or tasc.braking != 0:
        reset(tasc)
    wave.built_mps2 = 0.0
    wave.speed_mps = 0.0


@compiled
def take_up_command(
    unit: UnitRow,
    train: TrainRow,
    tasc: TascRow,
    design: DesignRow,
    wave: WaveRow,
    own_mps2: float,
) -> int:
    """Take up what `unit.notch` and `unit.emergency` really ask for, and keep the waves; returns event bits."""
    given_mps2 = service_target_mps2(train, unit.notch)
    if unit.emergency != 0:
        given_mps2 = max(given_mps2, train.emergency_deceleration_mps2)
    tasc.pending_mps2[tasc.head] = expected_mps2(design, given_mps2)
    tasc.demand_mps2 = tasc.pending_mps2[tasc.head]
    if tasc.braking == 0:
        wave.steps = 0
        wave.disturbed = 0
    else:
        wave.steps = min(wave.steps + 1, WAVE_STEPS)
    if unit.wheel_slide != 0 or unit.intervention != NO_INTERVENTION:
        wave.disturbed = 1
    wave.head = (wave.head + 1) % WAVE_STEPS
    # The speed just read tells of the step before, in which the last command was the newest.
    actual_mps2 = (wave.speed_mps - unit.train_mps) / design.step_s - own_mps2
    wave.actual_mps2[wave.head] = actual_mps2
    wave.designed_mps2[wave.head] = wave.built_mps2 if wave.built_mps2 >= ASKED_LEAST_MPS2 else 0.0
    wave.speed_mps = unit.train_mps
    wave.built_mps2 = approach(
        wave.built_mps2, given_mps2, design.lag_s, train.brake_jerk_max_mps3, design.step_s
    )
    if tasc.verdict != unit.stop_verdict:
        unit.stop_verdict = tasc.verdict
        return EVENT_VERDICT if tasc.verdict != POSSIBLE else 0
    return 0
