"""`branchline reproduce position-fusion`: random runs in which the true position must never leave the stated bounds.

What is drawn for a run is told in `papers.fusion_runs`; each is one train through the kernel and the real unit,
with bounds judged in every step. Beside the rule that units have stand the same runs with that rule switched off by
name: bounds that trust every tag, and bounds that do not grow, must be broken, or the runs would show nothing.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import median
from typing import Final

import numpy as np

from onboard.localisation.table import READER_NAMES
from papers.fusion_runs import (
    AS_UNITS_ARE,
    CONICITY,
    CREEP_MAX,
    FAULT_SHARE,
    LINES,
    MOVED_M,
    SLIPPERY,
    UNPROTECTED_SHARE,
    WHEEL_SIGMA,
    FusionOutcome,
    FusionRule,
    TagDefect,
    base_setup,
    draw,
    outcome,
)
from papers.joint_faults import SETS, carried_in, joint_outcome, rule_of
from papers.parameter_sets import LINE
from papers.position_run import PositionRun, half_widths_m, in_motion
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import Findings, Specification
from simulation.settings import PositionSensor
from simulation.setup import Setup
from study.drilling.forks import CopyDied, Forks, jobs_of

NAME: Final = "position-fusion"
RUNS: Final = 1000
QUICK_RUNS: Final = 20
BROKEN_RUNS: Final = 100  # with a rule switched off
MEDIAN_LINE: Final = "karasuyama_weekday"
MEDIAN_BEYOND_M: Final = 2.0
TRUSTING: Final = FusionRule("every tag that can be is trusted", tags_wrong_together=0)
NO_GROWTH: Final = FusionRule("bounds do not grow", wheel_error_share=0.0)
SWITCHED_OFF: Final = (TRUSTING, NO_GROWTH)
SET_RUNS: Final = 100  # with each further set of sensors
QUICK_SET_RUNS: Final = 4
MEDIAN_CURVED_M: Final = 2.0
CURVED: Final = ", outside long straights"
STRAIGHT_OVER_M: Final = 1000.0
HELD: Final = "runs with a step out of bounds, {}, {}"
JOINT_RUNS: Final = 2000
QUICK_JOINT_RUNS: Final = 28
JOINT: Final = FusionRule("several sensors fail at once")
FORGIVING: Final = FusionRule("receivers forgive what may hide in slides and gaps", forgives=True)
JUMPS_FORGIVEN: Final = FusionRule("curvature forgives a bias that jumps", forgives_jumps=True)
BESIDE_RUNS: Final = 420  # of the joint ones, made again with each sensor of their sets alone
QUICK_BESIDE_RUNS: Final = 14
WIDER_MOST: Final = 1.1  # a fusion's median over that of any of its members
STRETCH_M: Final = 200.0  # in which half-widths are compared: what a train runs in 10 s
SETS_LINE: Final = "kururi_weekday"  # of all pairs and triples: each sensor has something on it
SETS_RUNS: Final = 30
QUICK_SETS_RUNS: Final = 3
WITH_CURVATURE: Final = ("tags", PositionSensor.CURVATURE)


def other_sensors() -> tuple[str, ...]:
    """Those beside tags that units can read."""
    return tuple(str(kind) for kind in PositionSensor if kind in READER_NAMES)


def sensor_sets() -> tuple[FusionRule, ...]:
    """Tags with each other sensor that units can read, and with all of them."""
    others = other_sensors()
    pairs = [FusionRule(carries=("tags", other)) for other in others]
    return (*pairs, FusionRule(carries=("tags", *others))) if len(others) > 1 else tuple(pairs)


@dataclass(frozen=True, slots=True)
class RuleOutcomes:
    """The outcomes of some runs under one rule, by number, and those that came to nothing."""

    rule: FusionRule
    outcomes: tuple[FusionOutcome, ...]
    died: tuple[str, ...] = ()

    @property
    def steps(self) -> int:
        """Steps in which the unit stated bounds."""
        return sum(one.known_steps for one in self.outcomes)

    @property
    def broken(self) -> tuple[FusionOutcome, ...]:
        """Runs in which the truth was out of them in any step; what is no number counts."""
        return tuple(one for one in self.outcomes if one.known_steps and not one.out_m <= 0.0)


def run_all(
    seed: int,
    numbers: Sequence[int],
    rule: FusionRule = AS_UNITS_ARE,
    jobs: int | None = None,
    of: Callable[[int, int, FusionRule], FusionOutcome] = outcome,
) -> RuleOutcomes:
    """The runs of these numbers, in copies of this process; the first one here, which compiles what all need."""
    first = of(seed, numbers[0], rule)
    for line in LINES:
        base_setup(line)
    with Forks(FusionOutcome, jobs_of(jobs)) as copies:
        for number in numbers[1:]:
            copies.start((rule.name, number), lambda number=number: of(seed, number, rule))  # type: ignore[misc]
        copies.wait()
        found = [copies.results[rule.name, number] for number in numbers[1:]]
    died = [
        f"run {n}: {one.text}" for n, one in zip(numbers[1:], found, strict=True) if isinstance(one, CopyDied)
    ]
    return RuleOutcomes(rule, (first, *(one for one in found if isinstance(one, FusionOutcome))), tuple(died))


def held_row(found: RuleOutcomes) -> CaseRow:
    """Whether the truth was inside in every step of every run."""
    ours = f"{len(found.broken)} of {len(found.outcomes)} runs, {found.steps} steps; {len(found.died)} died"
    return CaseRow(
        HELD.format(found.rule.name, _sensors(found.rule)),
        None,
        ours,
        not found.broken and not found.died,
        "none",
    )


def broken_row(found: RuleOutcomes) -> CaseRow:
    """The same runs with a rule switched off: bounds must be broken."""
    worst_m = max((one.out_m for one in found.broken), default=0.0)
    ours = f"{len(found.broken)} of {len(found.outcomes)} runs, by {worst_m:.1f} m at most"
    return CaseRow(f"the same where {found.rule.name}", None, ours, bool(found.broken), "at least one")


def joint_rows(found: RuleOutcomes, forgiven: Sequence[RuleOutcomes]) -> tuple[CaseRow, ...]:
    """Whether the truth stayed inside while several sensors failed at once; where readers forgive, it must not."""
    case = f"runs with a step out of bounds, {JOINT.name}, {len(SETS)} sets of sensors"
    held = replace(held_row(found), case=case)
    return (held, *map(broken_row, forgiven))


def median_half_m(outcomes: Sequence[FusionOutcome]) -> float:
    """Median half-width of the bounds in these runs, each second in motion while the position was known, m."""
    halves_m = [half_m for one in outcomes for half_m in one.halves_m]
    return median(halves_m) if halves_m else math.inf


def beside_rows(fused: RuleOutcomes, alone: Mapping[PositionSensor, RuleOutcomes]) -> tuple[CaseRow, ...]:
    """Each set's median half-width beside that of each of its sensors alone, in the same runs."""
    rows: list[CaseRow] = []
    for each in (one for one in SETS if len(one) > 1):
        mine = [one for one in fused.outcomes if carried_in(one.number) == each]
        if not mine:
            continue
        members = {
            str(kind): [one for one in alone[kind].outcomes if carried_in(one.number) == each]
            for kind in each
        }
        rows.append(wider_row(f"{JOINT.name}, {' and '.join(each)}", mine, members))
    return tuple(rows)


def wider_row(
    case: str, fused: Sequence[FusionOutcome], members: Mapping[str, Sequence[FusionOutcome]]
) -> CaseRow:
    """A set's median half-width beside that of each of its sensors alone, in the same runs.

    Judged where both state a position: what a set states where a sensor alone states none is no reason against it.
    """
    ratios = {kind: times_as_wide(fused, alone) for kind, alone in members.items()}
    widths = ", ".join(
        f"{kind} {_width_text(members[kind])}, {ratio:.2f} times" for kind, ratio in ratios.items()
    )
    most = max((ratio for ratio in ratios.values() if math.isfinite(ratio)), default=math.inf)
    missed = f"; missed: {most:.2f}" if not most <= WIDER_MOST else ""
    return CaseRow(
        f"median half-width of the bounds, m, {case}",
        None,
        f"{_width_text(fused)}; alone: {widths}",
        not missed,
        f"at most {WIDER_MOST:g} times that of each member alone, where both state a position{missed}",
    )


def times_as_wide(fused: Sequence[FusionOutcome], alone: Sequence[FusionOutcome]) -> float:
    """Median half-width of a set over that of a member, where both state a position; inf: nowhere."""
    ours, its = half_by_place(fused), half_by_place(alone)
    both = ours.keys() & its.keys()
    return median(ours[key] for key in both) / median(its[key] for key in both) if both else math.inf


def half_by_place(outcomes: Sequence[FusionOutcome]) -> dict[tuple[int, int], float]:
    """Half-width by run and stretch of its way, m: what was stated there last."""
    return {
        (one.number, int(at_m // STRETCH_M)): half_m
        for one in outcomes
        for at_m, half_m in zip(one.halves_at_m, one.halves_m, strict=True)
    }


def set_rows(seed: int, count: int) -> tuple[CaseRow, ...]:
    """All pairs and triples of sensors on a line, none of which fails, in its first `count` runs."""
    numbers = list(
        itertools.islice((n for n in itertools.count() if draw(seed, n).scenario == SETS_LINE), count)
    )
    sensors = ("tags", *other_sensors())
    sets = [each for size in (1, 2, 3) for each in itertools.combinations(sensors, size)]
    found = {each: run_all(seed, numbers, FusionRule(carries=each)) for each in sets}
    rows: list[CaseRow] = []
    for each in (one for one in sets if len(one) > 1):
        members = {kind: found[kind,] for kind in each}
        died = found[each].died or any(one.died for one in members.values())
        alone = {kind: one.outcomes for kind, one in members.items()}
        row = wider_row(f"{SETS_LINE}, {' and '.join(each)}", found[each].outcomes, alone)
        rows.append(replace(row, passed=row.passed and not died))
    return tuple(rows)


def _width_text(outcomes: Sequence[FusionOutcome]) -> str:
    known = sum(one.known_steps for one in outcomes) / max(sum(one.steps for one in outcomes), 1)
    return f"{median_half_m(outcomes):.1f} (known in {known:.0%} of the steps)"


def median_row(setup: Setup, rule: FusionRule = AS_UNITS_ARE) -> CaseRow:
    """Median half-width on the line as it stands, with tags alone, against the way since the last tag."""
    run = PositionRun(rule.with_rule(setup))
    seen = in_motion(run.run().trace)
    half_m = float(np.median(half_widths_m(seen)))
    tags_m = np.array([run.mission.targets[0].mark_m, *(tag.position_m for tag in run.mission.tags)])
    passed_m = tags_m[np.searchsorted(tags_m, seen["position_m"], side="right") - 1]
    since_m = float(np.median(seen["position_m"] - passed_m))
    most_m = setup.unit.wheel_error_share * since_m + MEDIAN_BEYOND_M
    return CaseRow(
        f"median half-width of the bounds, m, {setup.name}, {_sensors(rule)}",
        None,
        round(half_m, 2),
        half_m < most_m,
        f"below {most_m:.1f}: stated growth times the median way since the last tag, {since_m:.0f} m, and 2 m",
    )


def curved_row(setup: Setup, rule: FusionRule) -> CaseRow:
    """The same with curvature, but for straights so long that there is nothing to compare."""
    run = PositionRun(rule.with_rule(setup))
    rows = run.trains.rows_of(0, run.trains.true_path(0))
    turn_rad = run.trains.pool.profile["turn_rad"][rows.offset : rows.offset + rows.rows]
    bends_m = np.flatnonzero(np.diff(turn_rad) > 0.0).astype(float)
    ends_m = np.concatenate([[0.0], bends_m, [float(rows.rows)]])
    seen = in_motion(run.run().trace)
    after = np.clip(np.searchsorted(ends_m, seen["position_m"], side="right"), 1, ends_m.size - 1)
    seen = seen[ends_m[after] - ends_m[after - 1] <= STRAIGHT_OVER_M]
    half_m = float(np.median(half_widths_m(seen)))
    missed = f"; missed by {half_m - MEDIAN_CURVED_M:.2f} m" if half_m >= MEDIAN_CURVED_M else ""
    return CaseRow(
        f"median half-width of the bounds, m, {setup.name}, {_sensors(rule)}{CURVED}",
        None,
        round(half_m, 2),
        half_m < MEDIAN_CURVED_M,
        f"below {MEDIAN_CURVED_M:g}; straights of more than {STRAIGHT_OVER_M:g} m are left out{missed}",
    )


def figures(found: RuleOutcomes) -> tuple[UnjudgedFigure, ...]:
    """What the runs had in them."""
    outcomes = found.outcomes
    ills = {str(ill): sum(one.ills[str(ill)] for one in outcomes) for ill in TagDefect}
    halves_m = [half_m for one in outcomes for half_m in one.halves_m]
    return (
        *(UnjudgedFigure(f"tags {name}", number, "laid in all runs") for name, number in ills.items()),
        UnjudgedFigure("tags believed", sum(one.read for one in outcomes), "read and believed"),
        UnjudgedFigure("tags doubted", sum(one.doubted for one in outcomes), "read and not believed yet"),
        UnjudgedFigure(
            "position faults", sum(one.faults for one in outcomes), "the unit did not know where it is"
        ),
        UnjudgedFigure(
            "runs that arrived", sum(one.arrived for one in outcomes), "the others end past their last tag"
        ),
        UnjudgedFigure(
            "median half-width", round(median(halves_m), 2) if halves_m else None, "m, of all runs"
        ),
    )


def parameters() -> tuple[Parameter, ...]:
    """What is drawn, and why so."""
    return (
        Parameter(
            "beacons, markers, tunnels",
            "as in position-compare",
            "",
            "assumed: none of the lines has any of its own",
        ),
        Parameter("lines", ", ".join(LINES), "", "those shipped; half the runs with tags at random places"),
        Parameter("tags with something wrong", FAULT_SHARE, "share", "assumed: far more than any line has"),
        MOVED_M.parameter,
        Parameter(
            "wear of wheels", WHEEL_SIGMA, "share (sigma, cut at 3)", "assumed: as far as units allow for"
        ),
        Parameter(
            "creep", f"0 to {CREEP_MAX:g}", "share at full adhesion", "assumed: see [sensors] creep_share"
        ),
        Parameter("slope of treads", ", ".join(map(str, CONICITY)), "", "Harada, 2.1; assumed: new and worn"),
        SLIPPERY.parameter,
        Parameter("runs without slide protection", UNPROTECTED_SHARE, "share", "assumed: wheels may lock"),
        Parameter(
            "where a train begins", "as its crew says", "", "the premise: a portal's own tag is not moved"
        ),
        Parameter(
            "tags wrong one after another", 1, "", "the premise: unit.tags_wrong_together, or two swapped"
        ),
    )


def experiment(options: Options) -> Findings:
    """All runs by the rule as it is, some with the rule switched off, and the width of the bounds on one line."""
    seed, quick = options.seed, options.quick
    numbers = range(QUICK_RUNS if quick else RUNS)
    found = run_all(seed, numbers)
    off = [run_all(seed, range(min(len(numbers), BROKEN_RUNS)), rule) for rule in SWITCHED_OFF]
    sets = [run_all(seed, range(QUICK_SET_RUNS if quick else SET_RUNS), rule) for rule in sensor_sets()]
    runs = range(QUICK_JOINT_RUNS if quick else JOINT_RUNS)
    joint = run_all(seed, runs, JOINT, of=joint_outcome)
    forgiven = [
        run_all(seed, runs, rule, of=joint_outcome) for rule in (() if quick else (FORGIVING, JUMPS_FORGIVEN))
    ]
    beside = range(QUICK_BESIDE_RUNS if quick else BESIDE_RUNS)  # the joint runs that each sensor makes alone
    joint_first = replace(joint, outcomes=tuple(one for one in joint.outcomes if one.number in beside))
    line = base_setup(MEDIAN_LINE)
    curved = [one.rule for one in sets if one.rule.carries == WITH_CURVATURE]
    return Findings(
        (
            held_row(found),
            *map(broken_row, off),
            median_row(line),
            *map(held_row, sets),
            *(curved_row(line, rule) for rule in curved),
            *joint_rows(joint, forgiven),
            *beside_rows(joint_first, alone_of(seed, beside)),
            *set_rows(seed, QUICK_SETS_RUNS if quick else SETS_RUNS),
        ),
        parameters(),
        (
            "With curvature the half-width is that of what wheels may vary by, which units are told and do not see: of"
            " wheels known neither to creep nor to have a slope it would be below the 2 m asked for (told beside).",
            "A run is drawn from (seed, number): papers.fusion_runs.outcome(seed, number) is that run again.",
            *(f"OUT: {how_to_repeat(one)}" for one in found.broken),
            *(
                f"OUT with {_sensors(each.rule)}: {how_to_repeat(one)}"
                for each in sets
                for one in each.broken
            ),
            *(
                f"OUT with {_sensors(rule_of(one.number, JOINT))}: {how_to_repeat(one)}"
                for one in joint.broken
            ),
            *joint.died,
            *found.died,
        ),
        (*figures(found), *(evenly_turning(line, rule) for rule in curved)),
        [trusted_row(off[SWITCHED_OFF.index(TRUSTING)])],
    )


def trusted_row(found: RuleOutcomes) -> CaseRow:
    """The null method's runs, judged as those of units as they are."""
    return held_row(replace(found, rule=AS_UNITS_ARE))


def _sensors(rule: FusionRule) -> str:
    return " and ".join(rule.carries)


def alone_of(seed: int, numbers: Sequence[int]) -> Mapping[PositionSensor, RuleOutcomes]:
    """These joint runs with each sensor of their sets alone."""
    kinds = {kind for each in SETS if len(each) > 1 for kind in each}
    return {
        kind: run_all(
            seed,
            [n for n in numbers if len(carried_in(n)) > 1 and kind in carried_in(n)],
            replace(JOINT, alone=str(kind)),
            of=joint_outcome,
        )
        for kind in sorted(kinds)
    }


def evenly_turning(setup: Setup, rule: FusionRule) -> UnjudgedFigure:
    """How much of the width comes from what wheels may creep: the same with wheels that are taken not to."""
    even = setup.unit.model_copy(update={"wheel_scale_limit": setup.unit.wheel_error_share})
    return UnjudgedFigure(
        "median half-width with curvature, outside long straights, of wheels that never creep",
        curved_row(replace(setup, unit=even), rule).ours,
        "m; the rest of that row's is what unit.wheel_error_share has beyond unit.wheel_scale_limit",
    )


def how_to_repeat(one: FusionOutcome) -> str:
    """How to have a run again, and what was wrong in it."""
    return f"seed {one.seed}, number {one.number} ({one.scenario}): {one.out_m:.3f} m at {one.out_at_m:.0f} m"


reproduce: Final = Specification(
    NAME,
    "Where a train is: the truth within the stated bounds, whatever wheels and tags do",
    experiment,
    NullMethod(
        TRUSTING.name,
        (HELD.format(AS_UNITS_ARE.name, _sensors(AS_UNITS_ARE)),),
        lambda options: [trusted_row(run_all(options.seed, range(QUICK_RUNS), TRUSTING))],
    ),
    LINE,
    f"A short slice: {QUICK_RUNS} runs of {RUNS}.",
)
