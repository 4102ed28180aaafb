"""What the predictive fuzzy law tells the journal of a run: which rules drove it, and why each of them won."""

from __future__ import annotations

from typing import Final

from onboard.driving.laws.fuzzy_records import KEPT_CHANGES, FuzzyRule, PredictiveFuzzyRow, Premise
from onboard.notes import DrivenByRules, RuleHeld, RuleWon

LAW: Final = "predictive_fuzzy"


def rule_name(rule: int) -> str:
    """A rule as the paper writes it: C-1, T-2.1; empty for none."""
    family, _, number = FuzzyRule(rule).name.partition("_")
    return "" if rule == FuzzyRule.NONE else f"{family}-{number.replace('_', '.')}"


def fuzzy_run_note(own: PredictiveFuzzyRow) -> DrivenByRules | None:
    """Of the run since the train last stood; None where this law has not driven it."""
    if own.changes == 0:
        return None
    kept = range(min(int(own.changes), KEPT_CHANGES))
    return DrivenByRules(
        law=LAW,
        held=tuple(
            RuleHeld(rule=rule_name(rule), held_s=round(float(own.rule_s[rule]), 1))
            for rule in FuzzyRule
            if own.rule_s[rule] > 0.0
        ),
        notch_changes=int(own.notch_changes),
        changes=int(own.changes),
        won=tuple(_won(own, at) for at in kept),
    )


def _won(own: PredictiveFuzzyRow, at: int) -> RuleWon:
    premise = Premise(int(own.changed_premise[at]))
    return RuleWon(
        t_s=round(float(own.changed_at_s[at]), 1),
        rule=rule_name(int(own.changed_to[at])),
        grade=round(float(own.changed_grade[at]), 3),
        premise="" if premise is Premise.NONE else premise.name.lower().replace("_", " "),
        over=rule_name(int(own.changed_over[at])),
        over_grade=round(float(own.changed_over_grade[at]), 3),
        notch=round(float(own.changed_notch[at]), 2),
    )
