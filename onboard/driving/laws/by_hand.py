"""The notch that a driver has set by hand (手動運転), whatever the timetable asks for."""

from __future__ import annotations

from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray

from onboard.driving.laws.cue import CueRow
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled_when_called
from vehicle.records import TrainRow


class ByHandRow(Protocol):
    """Where the handle is."""

    notch: Annotated[float, "> 0 power, < 0 brake"]


@compiled_when_called
def by_hand(
    own: ByHandRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    plan: NDArray[np.void],
) -> float:
    """The handle's notch, or the train's strongest beyond that."""
    return float(min(max(own.notch, -train.brake_notches), train.power_notches))
