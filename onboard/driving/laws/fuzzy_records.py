"""What the predictive fuzzy law is set to (`[law.predictive_fuzzy]`) and what it keeps: model, rules, account."""

from __future__ import annotations

from enum import IntEnum
from typing import Annotated, Final, Protocol

from network.files.kinds import about
from network.files.quantities import Distance, Reaction, Share, ShareAbove0, SpeedMarginMps, Wait
from network.files.toml_input import Record


class FuzzyRule(IntEnum):
    """The rules of the paper's section 5.2, as the journal and the row count them."""

    NONE = 0
    C_1 = 1  # too fast soon: half-way to the strongest brake
    C_2 = 2  # coasting keeps the time: coast
    C_3 = 3  # far below the target: full power
    C_4 = 4  # this notch keeps the speed: keep it
    C_5 = 5  # it does not: the notch within n that does
    T_1 = 6  # this brake stops at the mark: keep it
    T_2_1 = 7  # before the stop begins: no brake
    T_2_2 = 8  # the stop begins: the first brake notch
    T_3 = 9  # this brake misses the mark: the notch within n that does not


class Premise(IntEnum):
    """The index whose grade was the least in a rule, so that it made the rule's."""

    NONE = 0
    SAFETY = 1
    COMFORT = 2
    ENERGY = 3
    SPEED = 4
    RUNNING_TIME = 5
    ACCURACY = 6


RULES: Final = len(FuzzyRule)
KEPT_CHANGES: Final = 48  # changes of the winning rule that a hop's note can tell; the first ones stay
RING: Final = 64  # commands under way, one a step


class PredictiveFuzzy(Record):
    """`[law.predictive_fuzzy]`: constants of the fuzzy sets, none of which the paper gives, and its rules by name."""

    safe_s: Annotated[
        Wait,
        about("T_s: danger begins this long before the speed is no longer permitted", "assumed: a second"),
    ] = 1.0
    half_comfort_s: Annotated[
        Share,
        about(
            "C_c: comfort is half again this long after a change, a step; whole after a second a step",
            "assumed: half of it; per step, since with one constant a greater change would be the better one",
        ),
    ] = 0.5
    energy_m: Annotated[
        Distance,
        about(
            "E_s: coasting is half as good this far beyond where it keeps the time",
            "assumed: 3 s at 60 km/h, which a timetable has to spare",
        ),
    ] = 50.0
    allowed_mps: Annotated[
        SpeedMarginMps, about("V_s: speed allowed about the target", "assumed: 1.4 km/h, a glance")
    ] = 0.4
    target_margin_mps: Annotated[
        SpeedMarginMps,
        about(
            "the target V_t lies this far below what limits leave for driving",
            "assumed: V_s, so that what is allowed ends at the limit",
        ),
    ] = 0.4
    early_s: Annotated[
        Wait,
        about(
            "R_t: the first brake notch comes this long before the brake of the stop has to",
            "assumed: comfort is whole again after a change by one",
        ),
    ] = 1.0
    stop_allowed_m: Annotated[
        Distance,
        about("X_s: miss of the mark that is allowed", "assumed: half of what a notch makes 2 m before it"),
    ] = 0.2
    stop_allowed_share: Annotated[
        Share,
        about(
            "the same as a share of the way left, where that is more",
            "assumed: half a notch of five, by which no held notch can do better",
        ),
    ] = 0.1
    foresight_s: Annotated[
        Reaction,
        about(
            "speeds are predicted this far ahead", "assumed: machinery answers within one, and three to act"
        ),
    ] = 4.0
    coast_share: Annotated[
        ShareAbove0,
        about(
            "a long coast is meant to end at this share of the speed held before it",
            "assumed: on the level the best is where holding and coasting cost alike, about half",
        ),
    ] = 0.5
    coast_least_share: Annotated[
        ShareAbove0,
        about(
            "a train coasts down to this share of the speed that it holds",
            "assumed: slower, it hinders what follows",
        ),
    ] = 0.3
    estimates: Annotated[
        bool,
        about("what the brake gives is estimated where a notch has been kept", "Yasunobu and others, 6.2"),
    ] = True
    estimate_s: Annotated[
        Wait, about("time constant of that estimate", "assumed: as long as the brake takes to answer")
    ] = 1.0
    c_1: Annotated[bool, about("rule C-1: half-way to the strongest brake before a limit is passed")] = True
    c_2: Annotated[bool, about("rule C-2: coast where that keeps the time; without it, hold the cruise")] = (
        True
    )
    c_3: Annotated[bool, about("rule C-3: full power far below the target speed")] = True
    c_4: Annotated[bool, about("rule C-4: keep a notch that keeps the speed")] = True
    c_5: Annotated[bool, about("rule C-5: change to the notch that keeps the speed exactly")] = True
    t_1: Annotated[bool, about("rule T-1: keep a brake that stops well")] = True
    t_2_1: Annotated[bool, about("rule T-2.1: no brake for the stop before its time")] = True
    t_2_2: Annotated[bool, about("rule T-2.2: a slight brake first")] = True
    t_3: Annotated[bool, about("rule T-3: change to the brake that stops exactly")] = True


class PredictiveFuzzyRow(Protocol):
    """What this law is set to, its model of the train, and which rules have won since it last stood."""

    settings: PredictiveFuzzy
    # model of the train: what has been commanded, what that has built up
    awake: Annotated[int, "0: never asked yet"]
    last_s: Annotated[float, "time of the last tick"]
    head: int
    notches: Annotated[list[float], RING, "commands, one a step"]
    brake_mps2: Annotated[float, "built up by now"]
    pull_mps2: float
    speed_mps: Annotated[float, "at the last tick"]
    braking_off_mps2: Annotated[float, "estimated beyond the model, without power"]
    pulling_off_mps2: Annotated[float, "the same with power"]
    held_s: Annotated[float, "t_c: since the last change of notch"]
    changed: Annotated[float, "N_c: by so many steps"]
    # the hop
    cruise_mps: Annotated[float, "for which that was worked out"]
    hold_mps: Annotated[float, "speed to hold, limits apart"]
    coasts: Annotated[int, "1: coasting from here to the brake keeps the time, or did when it began"]
    coast_to_m: Annotated[float, "X_k"]
    descends: Annotated[int, "1: coasting would become too fast"]
    look_s: Annotated[float, "when that is looked at next"]
    stops: Annotated[int, "1: the brake for the stop has begun"]
    # the rule that is winning while rules are tried, and those of the last tick
    best_rule: int
    best_notch: float
    best_grade: float
    best_premise: int
    second_rule: int
    second_grade: float
    rule: Annotated[int, "that won in the last tick"]
    grade: float
    # account since the train last stood
    rule_s: Annotated[list[float], RULES, "for how long each rule has won"]
    notch_changes: int
    power_changes: Annotated[int, "of them, those from or to power"]
    changes: Annotated[int, "of the winning rule"]
    changed_at_s: Annotated[list[float], KEPT_CHANGES, "when"]
    changed_to: Annotated[list[int], KEPT_CHANGES, "the rule that won"]
    changed_grade: Annotated[list[float], KEPT_CHANGES, "with this grade"]
    changed_premise: Annotated[list[int], KEPT_CHANGES, "which this index made"]
    changed_over: Annotated[list[int], KEPT_CHANGES, "the best of the others"]
    changed_over_grade: Annotated[list[float], KEPT_CHANGES, "with this grade"]
    changed_notch: Annotated[list[float], KEPT_CHANGES, "the notch that it asked for"]
