"""How a rule wins (Yasunobu and others, 2.2): the least grade of its premises is its own, the greatest one counts."""

from __future__ import annotations

import math
from typing import Final

from onboard.driving.laws.fuzzy_records import KEPT_CHANGES, RULES, FuzzyRule, PredictiveFuzzyRow
from onboard.driving.laws.fuzzy_sets import comfortable
from vehicle.compiled import compiled
from vehicle.records import TrainRow

POWER_STEPS: Final = 7.0  # the paper's train has seven steps of traction and nine of brake
BRAKE_STEPS: Final = 9.0
STEPS_AT_ONCE: Final = 3  # n
SURE: Final = 0.999  # no other rule can win against this
NONE = int(FuzzyRule.NONE)


@compiled
def power_step(train: TrainRow) -> float:
    """Notches in one step n of power: whole ones, about as many steps as in the paper."""
    return max(math.floor(train.power_notches / POWER_STEPS + 0.5), 1.0)


@compiled
def brake_step(train: TrainRow) -> float:
    """Notches in one step n of the brake: one, or a ninth of a stepless brake."""
    return train.brake_notches / BRAKE_STEPS if train.brake_stepless > 0.0 else 1.0


@compiled
def steps_of(train: TrainRow, notch: float) -> float:
    """A notch counted in steps, power above 0 and brake below."""
    return notch / power_step(train) if notch > 0.0 else notch / brake_step(train)


@compiled
def changed_by(train: TrainRow, notch: float, steps: int) -> float:
    """N + n: the notch that many whole steps on, within what the train has."""
    at = math.floor(steps_of(train, notch) + 0.5) + steps
    if at > 0.0:
        return min(at * power_step(train), train.power_notches)
    return max(at * brake_step(train), -train.brake_notches)


@compiled
def half_way(train: TrainRow, notch: float) -> float:
    """(N + B_max) / 2, the stronger brake where that is between two steps."""
    strongest = math.floor(steps_of(train, -train.brake_notches) + 0.5)
    at = math.floor((math.floor(steps_of(train, notch) + 0.5) + strongest) / 2.0)
    if at > 0.0:
        return min(at * power_step(train), train.power_notches)
    return max(at * brake_step(train), -train.brake_notches)


@compiled
def comfort(own: PredictiveFuzzyRow, train: TrainRow, notch: float, candidate: float) -> float:
    """CG of a candidate: of the last change and of the one that it would be, the greater counts.

    One that changes nothing is comfortable.
    """
    if candidate == notch:
        return 1.0
    change = abs(steps_of(train, candidate) - steps_of(train, notch))
    return comfortable(own.held_s, max(own.changed, change), own.settings.half_comfort_s)


@compiled
def begin_choice(own: PredictiveFuzzyRow, notch: float) -> None:
    """No rule has been tried yet: the present notch stays."""
    own.best_rule, own.best_premise, own.second_rule = NONE, NONE, NONE
    own.best_notch, own.best_grade, own.second_grade = notch, 0.0, 0.0


@compiled
def offer_candidate(own: PredictiveFuzzyRow, rule: int, notch: float, grade: float, premise: int) -> None:
    """Take a rule with its candidate and grade: of equal grades the one that was tried first wins."""
    if grade > own.best_grade:
        if own.best_rule != rule:
            own.second_rule, own.second_grade = own.best_rule, own.best_grade
        own.best_rule, own.best_notch, own.best_grade, own.best_premise = rule, notch, grade, premise
    elif rule != own.best_rule and grade > own.second_grade:
        own.second_rule, own.second_grade = rule, grade


@compiled
def weaker_grade(grade: float, premise: int, other: float, others: int) -> tuple[float, int]:
    """The lesser of two grades, and whose it is."""
    return (other, others) if other < grade else (grade, premise)


@compiled
def forget_hop(own: PredictiveFuzzyRow) -> None:
    """The account of a new hop."""
    for rule in range(RULES):
        own.rule_s[rule] = 0.0
    own.notch_changes = own.power_changes = own.changes = 0
    own.rule = NONE


@compiled
def write_down(own: PredictiveFuzzyRow, now_s: float, step_s: float) -> None:
    """Keep which rule has won in this tick, and why where it is another than before."""
    own.rule_s[own.best_rule] += step_s
    if own.best_rule != own.rule:
        if own.changes < KEPT_CHANGES:
            at = own.changes
            own.changed_at_s[at], own.changed_to[at] = now_s, own.best_rule
            own.changed_grade[at], own.changed_premise[at] = own.best_grade, own.best_premise
            own.changed_over[at], own.changed_over_grade[at] = own.second_rule, own.second_grade
            own.changed_notch[at] = own.best_notch
        own.changes += 1
    own.rule, own.grade = own.best_rule, own.best_grade
