"""Rules C-1 to C-5: between stations (駅間走行制御, CSC). Yasunobu, Miyamoto and Ihara, 4.1 and 5.2."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.ahead import LOOK_AHEAD_S, pattern_mps
from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.fuzzy_choice import (
    STEPS_AT_ONCE,
    SURE,
    begin_choice,
    changed_by,
    comfort,
    half_way,
    offer_candidate,
    weaker_grade,
)
from onboard.driving.laws.fuzzy_model import STEP_S, run_on
from onboard.driving.laws.fuzzy_records import FuzzyRule, PredictiveFuzzyRow, Premise
from onboard.driving.laws.fuzzy_sets import dangerous, runs_exactly, runs_slowly, runs_well, safe, saves
from onboard.driving.supervision import furthest_m, path_index
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled
from vehicle.records import TrainRow

C_1, C_2, C_3 = int(FuzzyRule.C_1), int(FuzzyRule.C_2), int(FuzzyRule.C_3)
C_4, C_5 = int(FuzzyRule.C_4), int(FuzzyRule.C_5)
SAFETY, COMFORT = int(Premise.SAFETY), int(Premise.COMFORT)
ENERGY, SPEED = int(Premise.ENERGY), int(Premise.SPEED)
LEAST_TARGET_MPS: Final = 0.5  # no margin makes a train stand between stations


@compiled
def limit_in_s(
    own: PredictiveFuzzyRow, unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void]
) -> float:
    """t_s: until the present speed is above what is permitted, s; negative: what the brake needs to be under it.

    The paper's X_d is where a lower limit begins; the permitted speed falls towards it by the guaranteed brake.
    """
    speed = unit.train_mps
    permitted = min(unit.permitted_mps, unit.restricted_mps)
    if speed > permitted:
        return (permitted - speed) / behaviour.settings.stop_deceleration_mps2
    if speed <= 0.0:
        return np.inf
    front_m = furthest_m(unit, unit.position_m)
    for metre in range(1, int(speed * own.settings.safe_s) + 2):
        if path[path_index(unit, front_m + metre)].permitted_mps < speed:
            return metre / speed
    return np.inf


@compiled
def target_mps(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    position_m: float,
    speed_mps: float,
) -> float:
    """V_t where the train is predicted to be: a little less than limits leave here and there, or what it holds."""
    here = pattern_mps(unit, behaviour, path, position_m)
    ahead = pattern_mps(unit, behaviour, path, position_m + max(speed_mps * LOOK_AHEAD_S, 1.0))
    limit = min(here, ahead, cue.limit_mps)
    held = own.hold_mps if own.coasts == 0 else np.inf  # what a descent gives a coasting train costs nothing
    return max(min(limit - own.settings.target_margin_mps, held), LEAST_TARGET_MPS)


@compiled
def speed_off(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    notch: float,
) -> tuple[float, float]:
    """V_p(N) and its V_t, m/s."""
    steps = max(int(own.settings.foresight_s / STEP_S + 0.5), 1)
    speed, position, _ = run_on(own, cue, unit, train, path, notch, steps, False)
    return speed, target_mps(own, cue, unit, behaviour, path, position, speed)


@compiled
def energy_grade(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
) -> float:
    """ES: that coasting keeps the time. Where the train would become too fast by it (a descent), there is none to save.

    That lasts until coasting would leave it well below its target, so that a brake is not taken and left in turn.
    """
    if own.coasts == 0:
        own.descends = 0
        return 0.0
    grade = saves(unit.position_m, own.coast_to_m, own.settings.energy_m)
    if grade < 0.5:
        own.coasts = 0
    speed, target = speed_off(own, cue, unit, train, behaviour, path, 0.0)
    own.descends = 1 if speed > target + (0.5 - own.descends) * 2.0 * own.settings.allowed_mps else 0
    return 0.0 if own.descends == 1 else grade


@compiled
def choose_between(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
) -> None:
    """Try C-1 to C-5; what wins is in `best_rule` and `best_notch`."""
    begin_choice(own, unit.notch)
    in_s = limit_in_s(own, unit, behaviour, path)
    is_safe = safe(in_s, own.settings.safe_s)
    if own.settings.c_1 == 1:
        offer_candidate(own, C_1, half_way(train, unit.notch), dangerous(in_s, own.settings.safe_s), SAFETY)
    if own.settings.c_2 == 1:
        grade, premise = weaker_grade(is_safe, SAFETY, comfort(own, train, unit.notch, 0.0), COMFORT)
        saving = energy_grade(own, cue, unit, train, behaviour, path)
        grade, premise = weaker_grade(grade, premise, saving, ENERGY)
        offer_candidate(own, C_2, 0.0, grade, premise)
    if own.best_grade >= SURE:
        return
    full = train.power_notches
    if own.settings.c_3 == 1:
        grade, premise = weaker_grade(is_safe, SAFETY, comfort(own, train, unit.notch, full), COMFORT)
        speed, target = speed_off(own, cue, unit, train, behaviour, path, full)
        grade, premise = weaker_grade(grade, premise, runs_slowly(speed, target), SPEED)
        offer_candidate(own, C_3, full, grade, premise)
    if own.settings.c_4 == 1:
        speed, target = speed_off(own, cue, unit, train, behaviour, path, unit.notch)
        well = runs_well(speed, target, own.settings.allowed_mps)
        grade, premise = weaker_grade(is_safe, SAFETY, well, SPEED)
        offer_candidate(own, C_4, unit.notch, grade, premise)
    if own.settings.c_5 == 0 or own.best_grade >= SURE:
        return
    try_speeds(own, cue, unit, train, behaviour, path, is_safe)


@compiled
def try_speeds(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    is_safe: float,
) -> None:
    """C-5: the notch within n steps that meets the target exactly; where comfort decides, the more exact one."""
    best, best_grade, best_premise, best_exact = unit.notch, 0.0, SPEED, 0.0
    for n in range(-STEPS_AT_ONCE, STEPS_AT_ONCE + 1):
        candidate = changed_by(train, unit.notch, n)
        if n == 0 or candidate == unit.notch:
            continue
        speed, target = speed_off(own, cue, unit, train, behaviour, path, candidate)
        exact = runs_exactly(speed, target, own.settings.allowed_mps)
        grade, premise = weaker_grade(is_safe, SAFETY, comfort(own, train, unit.notch, candidate), COMFORT)
        grade, premise = weaker_grade(grade, premise, exact, SPEED)
        if grade > best_grade or (grade == best_grade and exact > best_exact):
            best, best_grade, best_premise, best_exact = candidate, grade, premise, exact
    offer_candidate(own, C_5, best, best_grade, best_premise)
