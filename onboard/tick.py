"""One tick of the on-board unit: where am I, what may I do, how do I drive."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.board import BoardRow, SensedRow
from onboard.driving.ahead import own_deceleration_mps2
from onboard.driving.slides import bound_slid_speed
from onboard.driving.stopping import ride_over_slide, stop_anew, take_up_command
from onboard.driving.supervision import supervise
from onboard.localisation.axles import NO_AXLE_MPS
from onboard.localisation.table import read_all
from onboard.localisation.tachometer import locate
from onboard.notches import drive
from onboard.records import (
    EMERGENCY_INTERVENTION,
    EVENT_FOUND,
    EVENT_IDLE,
    EVENT_MOVING,
    EVENT_OFF_PLAN,
    EVENT_POSITION,
    EVENT_STOPPED,
    EVENT_TACHOMETER,
    EVENT_TAG_OVERDUE,
    MODE_DRIVE,
    Chart,
    UnitRow,
)
from vehicle.compiled import compiled

IDLE_S: Final = 10.0  # assumed: longer than a driving law takes to ask for power


@compiled
def stands_idle(unit: UnitRow, speed_mps: float, step_s: float) -> int:
    """Whether it has stood for some time without power, brakes released, its mark within the stop limit; event bits."""
    drives = unit.mode == MODE_DRIVE and unit.intervention != EMERGENCY_INTERVENTION
    idle = drives and speed_mps == 0.0 and unit.notch <= 0.0
    if not idle or not np.isfinite(unit.mark_m) or unit.mark_m > unit.stop_limit_m:
        unit.idle_s = 0.0
        return 0
    unit.idle_s += step_s
    if unit.idle_s < IDLE_S:
        return 0
    unit.idle_s = 0.0
    return EVENT_IDLE


@compiled
def tick(board: BoardRow, sensed: SensedRow, chart: Chart, plan: NDArray[np.void]) -> int:
    """Take what the sensors show, set `unit.notch` and `unit.emergency`; returns event bits."""
    path = chart.path
    unit, train, behaviour, tasc = board.unit, board.kind, board.behaviour, board.tasc
    step_s = behaviour.step_s
    before_mps, axle_before_mps = unit.speed_mps, unit.last_axle_mps
    run_m = sensed.odometer_m - unit.odometer_m
    unit.wheel_slide = sensed.wheel_slide
    last_mps = sensed.last_axle_mps if sensed.last_axle_taken != 0 else NO_AXLE_MPS
    events = locate(unit, train, sensed.odometer_m, sensed.speed_mps, step_s, last_mps)
    speed_mps = unit.speed_mps
    if events & (EVENT_TACHOMETER | EVENT_TAG_OVERDUE) != 0:
        unit.intervention = (
            EMERGENCY_INTERVENTION  # at once, whatever the event-driven part does of it, and when
        )
    known = unit.position_known
    events |= read_all(board.readers, sensed.readings, unit, chart, step_s)
    unit.found = 1 if known == 0 and unit.position_known != 0 else 0
    if unit.found != 0:
        events |= EVENT_FOUND
    moves = unit.mode == MODE_DRIVE or speed_mps > 0.0
    own_mps2 = own_deceleration_mps2(unit, train, path, sensed.load_share) if moves else 0.0
    ride_over_slide(unit, train, tasc, own_mps2, run_m, step_s)
    bound_slid_speed(
        unit, train, behaviour, before_mps, axle_before_mps, tasc.built_mps2, own_mps2, sensed.load_share
    )
    events |= supervise(unit, train, behaviour, path)
    cue = board.cue
    cue.now_s, cue.due_s = sensed.now_s, unit.due_s
    cue.load_share, cue.own_mps2 = sensed.load_share, own_mps2
    drive(board, path, plan)
    if moves and abs(cue.late_s) > unit.replan_s:
        unit.replan_s = np.inf
        events |= EVENT_OFF_PLAN
    if moves:
        events |= take_up_command(unit, train, tasc, board.design, board.wave, own_mps2)
    else:
        stop_anew(tasc, board.wave)
    if before_mps > 0.0 and speed_mps == 0.0:
        events |= EVENT_STOPPED
    elif before_mps == 0.0 and speed_mps > 0.0:
        events |= EVENT_MOVING
    events |= stands_idle(unit, speed_mps, step_s)
    if unit.position_m >= unit.position_trigger_m:
        unit.position_trigger_m = np.inf
        events |= EVENT_POSITION
    if sensed.now_s >= unit.look_s:
        unit.look_s = np.inf
        if unit.position_m - unit.bound_behind_m < unit.look_before_m:
            events |= EVENT_POSITION
    return events
