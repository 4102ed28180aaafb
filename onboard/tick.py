"""One tick of the on-board unit: where am I, what may I do, how do I drive."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from onboard.driving.notches import drive, own_deceleration_mps2
from onboard.driving.stopping import WaveRow, hold, issued, ride_over_slide
from onboard.driving.supervision import supervise
from onboard.driving.tasc import DesignRow, TascRow
from onboard.localisation.tachometer import locate
from onboard.records import EVENT_MOVING, EVENT_POSITION, EVENT_STOPPED, MODE_DRIVE
from onboard.rows import BehaviourRow, UnitRow
from vehicle.compiled import compiled
from vehicle.rows import TrainRow


@compiled
def tick(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    odometer_m: float,
    speed_mps: float,
    load_share: float,
    tasc: TascRow,
    design: DesignRow,
    wave: WaveRow,
) -> int:
    """Take the tachometer's reading, set `unit.notch` and `unit.emergency`; returns event bits."""
    before_mps = unit.speed_mps
    run_m = odometer_m - unit.odometer_m
    events = locate(unit, train, odometer_m, speed_mps, behaviour.step_s)
    moves = unit.mode == MODE_DRIVE or speed_mps > 0.0
    own_mps2 = own_deceleration_mps2(unit, train, path, load_share) if moves else 0.0
    ride_over_slide(unit, train, tasc, own_mps2, run_m, behaviour.step_s)
    events |= supervise(unit, train, behaviour, path)
    drive(unit, train, behaviour, path, load_share, own_mps2, tasc, design)
    if moves:
        events |= issued(unit, train, tasc, design, wave, own_mps2)
    else:
        hold(tasc, wave)
    if before_mps > 0.0 and speed_mps == 0.0:
        events |= EVENT_STOPPED
    elif before_mps == 0.0 and speed_mps > 0.0:
        events |= EVENT_MOVING
    if unit.position_m >= unit.position_trigger_m:
        unit.position_trigger_m = np.inf
        events |= EVENT_POSITION
    return events
