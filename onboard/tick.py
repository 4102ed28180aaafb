"""One tick of the on-board unit: where am I, what may I do, how do I drive."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from onboard.driving import drive
from onboard.localisation import locate
from onboard.records import EVENT_MOVING, EVENT_POSITION, EVENT_STOPPED
from onboard.rows import BehaviourRow, UnitRow
from onboard.supervision import supervise
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
) -> int:
    """Take the tachometer's reading, set `unit.notch` and `unit.emergency`; returns event bits."""
    before_mps = unit.speed_mps
    events = locate(unit, train, odometer_m, speed_mps, behaviour.step_s)
    events |= supervise(unit, train, behaviour, path)
    drive(unit, train, behaviour, path, load_share)
    if before_mps > 0.0 and speed_mps == 0.0:
        events |= EVENT_STOPPED
    elif before_mps == 0.0 and speed_mps > 0.0:
        events |= EVENT_MOVING
    if unit.position_m >= unit.position_trigger_m:
        unit.position_trigger_m = np.inf
        events |= EVENT_POSITION
    return events
