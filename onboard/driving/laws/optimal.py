"""Drive the optimal profile with whole notches: power, hold, coast and brake as the plan has them (省エネ運転).

The plan is laid by the unit at each departure (`onboard.driving.planner`), and anew whenever the train is off it by
more than `replan_after_s`; within that the law lets time be, since haste costs more than a few seconds are worth. The
stop at the mark is TASC's, whose pattern the plan ends in.
"""

from __future__ import annotations

from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray

from network.files.kinds import about
from network.files.quantities import Gain, Share, Wait
from network.files.toml_input import Record
from onboard.driving.laws.cue import PLAN_COAST, PLAN_FOLLOW, PLAN_HOLD, PLAN_NONE, CueRow
from onboard.driving.laws.hold_speed import holding_notch
from onboard.driving.laws.power import overspeed_mps, power_notch
from onboard.records import BehaviourRow, UnitRow
from vehicle.brakes import service_notch
from vehicle.compiled import compiled_when_called
from vehicle.mass import equivalent_mass_kg
from vehicle.records import TrainRow


class Optimal(Record):
    """`[law.optimal]`: how closely the optimal profile is driven."""

    replan_after_s: Annotated[
        Wait, about("a train off its plan by more than this makes a new plan", "the planner's wish: 5 s")
    ] = 5.0
    regeneration_share: Annotated[
        Share,
        about(
            "share of regenerated energy that counts in the plan",
            "assumed: battery or other trains take all of it",
        ),
    ] = 1.0
    follow_gain_per_s: Annotated[
        Gain,
        about(
            "acceleration demanded for each m/s off the plan, where the speed changes",
            "assumed: settles in 3 s",
        ),
    ] = 0.3
    force_reserve_share: Annotated[
        Share,
        about("share of the wanted force that a notch may lack", "assumed: half a notch of 15"),
    ] = 0.03


class OptimalRow(Protocol):
    """What this law keeps."""

    settings: Optimal
    off_mps: Annotated[float, "how far above its plan the train will be when its machinery answers"]


@compiled_when_called
def optimal(
    own: OptimalRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    plan: NDArray[np.void],
) -> float:
    """The notch that keeps to the optimal profile; a train without one holds its cruising speed."""
    mode, speed_mps, after_mps, share = PLAN_NONE, unit.cruise_mps, unit.cruise_mps, 0.0
    if unit.plan_rows > 1:
        answers_m = unit.position_m + unit.speed_mps * cue.reaction_s
        index = unit.plan_offset + min(max(int(answers_m), 0), unit.plan_rows - 2)
        mode = plan[index].mode
        if mode != PLAN_NONE:
            share = min(max(answers_m - int(answers_m), 0.0), 1.0)
            speed_mps, after_mps = plan[index].speed_mps, plan[index + 1].speed_mps
            left_s = plan[
                unit.plan_offset + min(max(int(unit.position_m), 0), unit.plan_rows - 1)
            ].time_left_s
            if unit.braking_to_stop == 0:
                cue.late_s = cue.now_s + left_s - unit.plan_due_s
    falls = mode == PLAN_COAST or (mode == PLAN_FOLLOW and after_mps <= speed_mps)
    if falls and unit.speed_mps == 0.0 and unit.braking_to_stop == 0:
        mode = PLAN_HOLD  # a plan on which the train already runs gets none away that stands there
    if mode == PLAN_COAST:
        cue.ceiling_mps = np.inf
        return 0.0
    if mode == PLAN_FOLLOW:
        cue.ceiling_mps = np.inf
        slope_mps2 = 0.5 * (after_mps * after_mps - speed_mps * speed_mps)
        at_mps = np.sqrt(max(speed_mps * speed_mps + 2.0 * share * slope_mps2, 0.0))
        own.off_mps = overspeed_mps(unit, min(cue.limit_mps, at_mps), cue.reaction_s)
        wanted_mps2 = slope_mps2 + cue.own_mps2 - own.settings.follow_gain_per_s * own.off_mps
        if unit.braking_to_stop == 1:
            return 0.0  # the stop is TASC's alone
        if slope_mps2 < 0.0:
            cue.ceiling_mps = (
                speed_mps  # on the plan's way down to a limit, not on the steeper one of the limits
            )
            return service_notch(train, -wanted_mps2) if wanted_mps2 < 0.0 else 0.0
        force_n = (
            wanted_mps2 * equivalent_mass_kg(train, cue.load_share) * (1.0 - own.settings.force_reserve_share)
        )
        return power_notch(train, cue.load_share, unit.speed_mps, force_n)
    cue.ceiling_mps = speed_mps
    own.off_mps = overspeed_mps(unit, min(cue.limit_mps, speed_mps), cue.reaction_s)
    return holding_notch(unit, train, behaviour, cue, own.off_mps)
