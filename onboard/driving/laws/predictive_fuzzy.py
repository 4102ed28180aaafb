"""Predictive fuzzy ATO (予見Fuzzy制御): from a stand to a stand at the mark. Yasunobu, Miyamoto and Ihara 1984.

Every 100 ms the rules between stations (`fuzzy_between`) and those at the station (`fuzzy_station`) choose a notch
each, by what the unit's model (`fuzzy_model`) predicts of it; the more restrictive of both is given (5.3).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.fuzzy_between import choose_between
from onboard.driving.laws.fuzzy_choice import forget_hop, steps_of, write_down
from onboard.driving.laws.fuzzy_knowledge import hold_mps, look_ahead
from onboard.driving.laws.fuzzy_model import GAP_S, STEP_S, keep_up, reset_model
from onboard.driving.laws.fuzzy_records import PredictiveFuzzyRow
from onboard.driving.laws.fuzzy_station import choose_at_station
from onboard.driving.stopping import LIMIT_MARGIN_M
from onboard.driving.tasc import aim_m
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled, compiled_when_called
from vehicle.records import TrainRow

AT_MARK_M: Final = 0.5  # assumed: a train that stands this near its mark stays there

__all__ = ["PredictiveFuzzyRow", "predictive_fuzzy"]


@compiled_when_called
def predictive_fuzzy(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    plan: NDArray[np.void],
) -> float:
    """The notch of the rule that wins."""
    follow_commands(own, cue, unit, train)
    mark_m = unit.position_m + aim_m(
        unit.target_stop_m - unit.position_m,
        unit.stop_limit_m - unit.position_m - unit.bound_ahead_m,
        LIMIT_MARGIN_M,
    )
    due_m = max(unit.mark_m, unit.target_stop_m)  # a stop limit may still lie before it
    if unit.cruise_mps != own.cruise_mps:
        own.cruise_mps = unit.cruise_mps
        own.hold_mps = hold_mps(own, cue, unit, train, due_m)
    if unit.train_mps <= 0.0 and (mark_m - unit.position_m < AT_MARK_M or unit.braking_to_stop == 1):
        return -behaviour.standing_brake_notch
    look_ahead(own, cue, unit, train, behaviour, path, due_m)
    cue.ceiling_mps = own.hold_mps if own.coasts == 0 else np.inf
    notch_at_most = train.power_notches
    if np.isfinite(mark_m):
        notch_at_most = choose_at_station(own, cue, unit, train, behaviour, path, mark_m)
    else:
        own.stops = 0
    station = (own.best_rule, own.best_notch, own.best_grade, own.best_premise)
    others = (own.second_rule, own.second_grade)
    choose_between(own, cue, unit, train, behaviour, path)
    if notch_at_most < own.best_notch or (own.stops == 1 and notch_at_most == own.best_notch):
        own.best_rule, own.best_notch, own.best_grade, own.best_premise = station
        own.second_rule, own.second_grade = others
        own.best_notch = notch_at_most
    write_down(own, cue.now_s, behaviour.step_s)
    return own.best_notch


@compiled
def follow_commands(own: PredictiveFuzzyRow, cue: CueRow, unit: UnitRow, train: TrainRow) -> None:
    """Take up what was given in the last tick: the model one step on, and when a notch last changed."""
    if own.awake == 0 or not 0.0 < cue.now_s - own.last_s < GAP_S:
        own.awake = 1
        reset_model(own, cue, unit, train)
        forget_hop(own)
        own.coasts = own.stops = 0
        own.cruise_mps = -1.0  # none yet
        own.look_s = cue.now_s
    else:
        before = own.notches[own.head]
        keep_up(own, cue, unit, train)
        own.held_s += STEP_S
        if unit.notch != before:
            own.held_s = 0.0
            own.changed = abs(steps_of(train, unit.notch) - steps_of(train, before))
            own.notch_changes += 1
            if unit.notch > 0.0 or before > 0.0:
                own.power_changes += 1
    own.last_s = cue.now_s
