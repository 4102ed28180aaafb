"""Rules T-1 to T-3: the stop at the mark (定位置停止制御, TASC). Yasunobu, Miyamoto and Ihara, 4.2 and 5.2."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.ahead import own_at_mps2
from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.fuzzy_choice import (
    STEPS_AT_ONCE,
    SURE,
    begin_choice,
    brake_step,
    changed_by,
    comfort,
    offer_candidate,
    weaker_grade,
)
from onboard.driving.laws.fuzzy_model import STEP_S, run_on, stops_at_m
from onboard.driving.laws.fuzzy_records import FuzzyRule, PredictiveFuzzyRow, Premise
from onboard.driving.laws.fuzzy_sets import in_free_zone, in_stop_zone, stops_exactly, stops_well
from onboard.records import BehaviourRow, UnitRow
from vehicle.brakes import service_target_mps2
from vehicle.compiled import compiled
from vehicle.records import TrainRow

T_1, T_2_1 = int(FuzzyRule.T_1), int(FuzzyRule.T_2_1)
T_2_2, T_3 = int(FuzzyRule.T_2_2), int(FuzzyRule.T_3)
COMFORT, RUNNING_TIME, ACCURACY = int(Premise.COMFORT), int(Premise.RUNNING_TIME), int(Premise.ACCURACY)
BRAKE_LEFT_SHARE: Final = 0.8  # of the full brake, at most, is what a stop is begun for


@compiled
def brake_in_s(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    mark_m: float,
) -> float:
    """t_b: until the train, its motors off, is where the brake for the stop has to begin (B地点), s.

    There the deceleration that stops are driven by leads to the mark, the machinery's answer included.
    """
    steps = int(cue.reaction_s / STEP_S + 0.5)
    speed, position, _ = run_on(own, cue, unit, train, path, 0.0, steps, False)
    strongest = service_target_mps2(train, -train.brake_notches)
    slowed = own_at_mps2(unit, train, path, cue.load_share, mark_m, speed)
    # a train that stands on a descent has somewhere to brake from as well
    least = own.settings.stop_allowed_m
    brake_mps2 = min(
        behaviour.settings.stop_deceleration_mps2, max(BRAKE_LEFT_SHARE * (strongest + slowed), 0.05)
    )
    begins_m = mark_m - speed * speed / (2.0 * brake_mps2)
    return (begins_m - position) / max(speed, least)


@compiled
def choose_at_station(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    mark_m: float,
) -> float:
    """Try T-1 to T-3; the notch that power must not pass, which is all there is before the stop begins."""
    begin_choice(own, unit.notch)
    in_s = brake_in_s(own, cue, unit, train, behaviour, path, mark_m)
    begun, free = in_stop_zone(in_s, own.settings.early_s), in_free_zone(in_s, own.settings.early_s)
    if begun <= 0.0:
        own.stops = 0
        if own.settings.t_2_1 == 1:
            offer_candidate(own, T_2_1, 0.0, free, RUNNING_TIME)
        return train.power_notches
    brakes = unit.notch < 0.0 or own.stops == 1
    if own.stops == 1:
        begun = (
            1.0  # B地点を過ぎ: it has been passed, also where the brake has since taken off more than planned
        )
    if own.settings.t_1 == 1 and brakes:
        miss_m = stops_at_m(own, cue, unit, train, path, min(unit.notch, 0.0)) - mark_m
        allowed_m = max(
            own.settings.stop_allowed_m, own.settings.stop_allowed_share * (mark_m - unit.position_m)
        )
        grade, premise = weaker_grade(begun, RUNNING_TIME, stops_well(miss_m, allowed_m), ACCURACY)
        offer_candidate(own, T_1, min(unit.notch, 0.0), grade, premise)
    if own.settings.t_2_1 == 1 and own.stops == 0:
        grade, premise = weaker_grade(free, RUNNING_TIME, comfort(own, train, unit.notch, 0.0), COMFORT)
        offer_candidate(own, T_2_1, 0.0, grade, premise)
    first = -brake_step(train)
    if own.settings.t_2_2 == 1 and not brakes:
        grade, premise = weaker_grade(begun, RUNNING_TIME, comfort(own, train, unit.notch, first), COMFORT)
        offer_candidate(own, T_2_2, first, grade, premise)
    if own.settings.t_3 == 1 and brakes and own.best_grade < SURE:
        try_changes(own, cue, unit, train, path, mark_m, begun)
    if own.best_notch < 0.0:
        own.stops = 1
    return min(own.best_notch, 0.0)


@compiled
def try_changes(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    path: NDArray[np.void],
    mark_m: float,
    begun: float,
) -> None:
    """T-3: the brake within n steps that stops exactly; where comfort decides, the more exact one."""
    allowed_m = max(own.settings.stop_allowed_m, own.settings.stop_allowed_share * (mark_m - unit.position_m))
    best, best_grade, best_premise, best_exact = unit.notch, 0.0, ACCURACY, 0.0
    for n in range(-STEPS_AT_ONCE, STEPS_AT_ONCE + 1):
        candidate = min(changed_by(train, unit.notch, n), 0.0)
        if n == 0 or candidate == unit.notch:
            continue
        miss_m = stops_at_m(own, cue, unit, train, path, candidate) - mark_m
        exact = stops_exactly(miss_m, allowed_m)
        grade, premise = weaker_grade(
            begun, RUNNING_TIME, comfort(own, train, unit.notch, candidate), COMFORT
        )
        grade, premise = weaker_grade(grade, premise, exact, ACCURACY)
        if grade > best_grade or (grade == best_grade and exact > best_exact):
            best, best_grade, best_premise, best_exact = candidate, grade, premise, exact
    offer_candidate(own, T_3, best, best_grade, best_premise)
