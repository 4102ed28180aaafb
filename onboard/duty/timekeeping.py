"""The cruising speed that brings the train to its next stop on time: the lowest that is fast enough.

The running time is predicted with the unit's own model of the train, to a tenth of a km/h: on a long leg a whole
km/h is ten seconds.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vehicle.records import TrainRow
from vehicle.running_time import predicted_run

CRUISE_MIN_KMH: Final = 25
STEP_MPS: Final = 0.1 / 3.6
PREDICTION_STEP_S: Final = 1.0


def cruise_for(
    train: TrainRow,
    load_share: float,
    climb_m: NDArray[np.float64],
    driving_mps: NDArray[np.float64],
    start_m: float,
    stop_m: float,
    available_s: float,
    deceleration_mps2: float,
    initial_mps: float = 0.0,
    until_m: float = math.inf,
) -> float:
    """Cruising speed, m/s, for a run from `start_m` to a stop at `stop_m`, or to `until_m` before it, in `available_s`.

    The line's limit where the time is too short. `climb_m` and `driving_mps` are on the path's 1 m grid.
    """
    low = 10 * CRUISE_MIN_KMH
    high = max(int(np.ceil(float(driving_mps.max()) / STEP_MPS)), low)

    def time_s(cruise: int) -> float:
        return predicted_run(
            train,
            load_share,
            climb_m,
            driving_mps,
            start_m,
            stop_m,
            cruise * STEP_MPS,
            deceleration_mps2,
            PREDICTION_STEP_S,
            initial_mps,
            until_m,
        )[0]

    while low < high:
        middle = (low + high) // 2
        if time_s(middle) <= available_s:
            high = middle
        else:
            low = middle + 1
    return low * STEP_MPS
