"""Follow a plan laid on the path grid: its speed, its coasting, and the time that it leaves.

A train that is later than the plan gives up coasting until it has caught up; one without a plan holds its speed.
"""

from __future__ import annotations

from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray

from network.files.kinds import about
from network.files.quantities import Wait
from network.files.toml_input import Record
from onboard.driving.laws.cue import PLAN_COAST, PLAN_NONE, CueRow
from onboard.driving.laws.hold_speed import holding_notch
from onboard.driving.laws.power import overspeed_mps
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled_when_called
from vehicle.records import TrainRow


class FollowPlan(Record):
    """`[law.follow_plan]`: when a train that is late gives up coasting."""

    coasts_until_late_s: Annotated[
        Wait, about("a train later than its plan by this no longer coasts", "assumed: what a driver notices")
    ] = 3.0
    coasts_again_late_s: Annotated[
        Wait, about("a train no later than this coasts again", "assumed: so that it does not swing")
    ] = 1.0


class FollowPlanRow(Protocol):
    """What this law keeps."""

    settings: FollowPlan
    late_s: Annotated[float, "behind the plan; negative: ahead of it"]
    catching_up: Annotated[int, "1: too late to coast"]


@compiled_when_called
def follow_plan(
    own: FollowPlanRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    plan: NDArray[np.void],
) -> float:
    """The notch that keeps to the plan."""
    mode, speed_mps, left_s = PLAN_NONE, unit.cruise_mps, 0.0
    if unit.plan_rows > 0:
        here = plan[unit.plan_offset + min(max(int(unit.position_m), 0), unit.plan_rows - 1)]
        mode, left_s = here.mode, here.time_left_s
        if mode != PLAN_NONE:
            speed_mps = here.speed_mps
    own.late_s = cue.now_s + left_s - cue.due_s if mode != PLAN_NONE and np.isfinite(cue.due_s) else 0.0
    cue.late_s = own.late_s
    if own.late_s > own.settings.coasts_until_late_s:
        own.catching_up = 1
    elif own.late_s < own.settings.coasts_again_late_s:
        own.catching_up = 0
    if own.catching_up == 1:
        speed_mps = np.inf
    coasts = mode == PLAN_COAST and own.catching_up == 0
    cue.ceiling_mps = np.inf if coasts else speed_mps
    if coasts:
        return 0.0
    over_mps = overspeed_mps(unit, min(cue.limit_mps, speed_mps), cue.reaction_s)
    return holding_notch(unit, train, behaviour, cue, over_mps)
