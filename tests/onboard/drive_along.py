"""A unit and the plant that it drives, on plain track."""

from dataclasses import dataclass, field

import numpy as np

from onboard.board import SENSED, BoardRow, SensedRow
from onboard.driving.laws.cue import PLAN
from onboard.records import NO_INTERVENTION, NO_PLACES, Chart
from onboard.tick import tick
from tests.rows import Rows
from vehicle.dynamics import step
from vehicle.train_file import new_plant

NO_PLAN = np.zeros(0, dtype=PLAN)

START_M = 100.0
TRACK_M = 4000


@dataclass
class Course:
    position_m: list[float] = field(default_factory=list)
    speed_mps: list[float] = field(default_factory=list)
    target_mps: list[float] = field(default_factory=list)
    notch: list[float] = field(default_factory=list)
    interventions: int = 0
    emergency: bool = False  # in the last step


def drive_along(
    board: BoardRow,
    path: Rows,
    permille: float,
    load_share: float,
    speed_mps: float,
    steps: int,
    worth: float = 1.0,
) -> Course:
    """Run the unit and the plant on a steady gradient until the train stands, or for `steps` of 0.1 s.

    `worth`: what a metre that the wheels show is truly worth; `speed_mps` is as they show it.
    """
    plant = new_plant(1, speed_mps * worth).view(np.recarray)[0]
    plant.load_share = load_share
    sensed: SensedRow = np.zeros(1, dtype=SENSED).view(np.recarray)[0]
    sensed.load_share = load_share
    unit, train = board.unit, board.kind
    unit.speed_mps, unit.path_rows = speed_mps, path.size
    course = Course()
    for _ in range(steps):
        step(plant, train, unit.notch, unit.emergency != 0, permille, 0.0, 0.1)
        sensed.odometer_m, sensed.speed_mps = plant.wheel_travelled_m / worth, plant.wheel_speed_mps / worth
        tick(board, sensed, Chart(path, NO_PLACES), NO_PLAN)
        course.position_m.append(START_M + float(plant.travelled_m))
        course.speed_mps.append(float(plant.speed_mps))
        course.target_mps.append(float(unit.target_mps))
        course.notch.append(float(unit.notch))
        course.emergency = unit.emergency != 0
        course.interventions += unit.intervention != NO_INTERVENTION
        if plant.speed_mps == 0.0 and len(course.notch) > 50:
            break
    return course
