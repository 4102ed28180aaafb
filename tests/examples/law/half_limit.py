"""Hold half of what is allowed, with whole notches: for days on which nobody is in a hurry."""

from __future__ import annotations

from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray

from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.hold_speed import holding_notch
from onboard.driving.laws.power import overspeed_mps
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled_when_called
from vehicle.records import TrainRow

SHARE = 0.5


class HalfLimitRow(Protocol):
    """What this law keeps."""

    held_mps: Annotated[float, "the speed that it holds now"]


@compiled_when_called
def half_limit(
    own: HalfLimitRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    plan: NDArray[np.void],
) -> float:
    """The notch that holds half the limit."""
    own.held_mps = SHARE * cue.limit_mps
    cue.ceiling_mps = own.held_mps
    return holding_notch(unit, train, behaviour, cue, overspeed_mps(unit, own.held_mps, cue.reaction_s))
