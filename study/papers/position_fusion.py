"""`branchline reproduce position-fusion`: random runs in which the true position must never leave the stated bounds.

What is drawn for a run is told in `study.papers.fusion_runs`; each is one train through the kernel and the real unit,
with bounds judged in every step. Beside the rule that units have stand the same runs with that rule switched off by
name: bounds that trust every tag, and bounds that do not grow, must be broken, or the runs would show nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import median
from typing import Final

import numpy as np

from onboard.localisation.table import READER_NAMES
from simulation.settings import Carried
from simulation.setup import Setup
from study.papers.fusion_runs import (
    AS_UNITS_ARE,
    CONICITY,
    CREEP_MAX,
    FAULT_SHARE,
    LINES,
    MOVED_M,
    SLIPPERY,
    UNPROTECTED_SHARE,
    WHEEL_SIGMA,
    Ill,
    Outcome,
    Rule,
    base_setup,
    outcome,
)
from study.papers.joint_faults import SETS, carried_in, joint_outcome, rule_of
from study.papers.position_run import PositionRun
from study.papers.reproduction import Figure, NullMethod, Options, Parameter, Reproduction, Row
from study.run.forks import Died, Forks, jobs_of

NAME: Final = "position-fusion"
RUNS: Final = 1000
QUICK_RUNS: Final = 20
BROKEN_RUNS: Final = 100  # with a rule switched off
MEDIAN_LINE: Final = "karasuyama_weekday"
MEDIAN_BEYOND_M: Final = 2.0
TRUSTING: Final = Rule("every tag that can be is trusted", tags_wrong_together=0)
NO_GROWTH: Final = Rule("bounds do not grow", wheel_error_share=0.0)
SWITCHED_OFF: Final = (TRUSTING, NO_GROWTH)
SET_RUNS: Final = 100  # with each further set of sensors
QUICK_SET_RUNS: Final = 4
MEDIAN_CURVED_M: Final = 2.0
CURVED: Final = ", outside long straights"
STRAIGHT_OVER_M: Final = 1000.0
HELD: Final = "runs with a step out of bounds, {}, {}"
NULL: Final = NullMethod(TRUSTING.name, (HELD.format(AS_UNITS_ARE.name, " and ".join(AS_UNITS_ARE.carries)),))
JOINT_RUNS: Final = 2000
QUICK_JOINT_RUNS: Final = 28
JOINT: Final = Rule("several sensors fail at once")
FORGIVING: Final = Rule("receivers forgive what may hide in slides", forgives=True)
JUMPS_FORGIVEN: Final = Rule("curvature forgives a bias that jumps", forgives_jumps=True)
BESIDE_RUNS: Final = 420  # of the joint ones, made again with each sensor of their sets alone
QUICK_BESIDE_RUNS: Final = 14
WIDER_MOST: Final = 1.1  # a fusion's median over that of its best member
WITH_CURVATURE: Final = ("tags", Carried.CURVATURE)


def sensor_sets() -> tuple[Rule, ...]:
    """Tags with each other sensor that units can read, and with all of them."""
    others = tuple(str(kind) for kind in Carried if kind in READER_NAMES)
    pairs = [Rule(carries=("tags", other)) for other in others]
    return (*pairs, Rule(carries=("tags", *others))) if len(others) > 1 else tuple(pairs)


@dataclass(frozen=True, slots=True)
class Found:
    """The outcomes of some runs under one rule, by number, and those that came to nothing."""

    rule: Rule
    outcomes: tuple[Outcome, ...]
    died: tuple[str, ...] = ()

    @property
    def steps(self) -> int:
        """Steps in which the unit stated bounds."""
        return sum(one.known_steps for one in self.outcomes)

    @property
    def broken(self) -> tuple[Outcome, ...]:
        """Runs in which the truth was out of them in any step; what is no number counts."""
        return tuple(one for one in self.outcomes if one.known_steps and not one.out_m <= 0.0)


def run_all(
    seed: int,
    numbers: Sequence[int],
    rule: Rule = AS_UNITS_ARE,
    jobs: int | None = None,
    of: Callable[[int, int, Rule], Outcome] = outcome,
) -> Found:
    """The runs of these numbers, in copies of this process; the first one here, which compiles what all need."""
    first = of(seed, numbers[0], rule)
    for line in LINES:
        base_setup(line)
    with Forks(Outcome, jobs_of(jobs)) as copies:
        for number in numbers[1:]:
            copies.start((rule.name, number), lambda number=number: of(seed, number, rule))  # type: ignore[misc]
        copies.wait()
        found = [copies.results[rule.name, number] for number in numbers[1:]]
    died = [
        f"run {n}: {one.text}" for n, one in zip(numbers[1:], found, strict=True) if isinstance(one, Died)
    ]
    return Found(rule, (first, *(one for one in found if isinstance(one, Outcome))), tuple(died))


def held_row(found: Found) -> Row:
    """Whether the truth was inside in every step of every run."""
    ours = f"{len(found.broken)} of {len(found.outcomes)} runs, {found.steps} steps; {len(found.died)} died"
    return Row(
        HELD.format(found.rule.name, " and ".join(found.rule.carries)),
        None,
        ours,
        not found.broken and not found.died,
        "none",
    )


def broken_row(found: Found) -> Row:
    """The same runs with a rule switched off: bounds must be broken."""
    worst_m = max((one.out_m for one in found.broken), default=0.0)
    ours = f"{len(found.broken)} of {len(found.outcomes)} runs, by {worst_m:.1f} m at most"
    return Row(f"the same where {found.rule.name}", None, ours, bool(found.broken), "at least one")


def joint_rows(found: Found, forgiven: Sequence[Found]) -> tuple[Row, ...]:
    """Whether the truth stayed inside while several sensors failed at once; where readers forgive, it must not."""
    case = f"runs with a step out of bounds, {JOINT.name}, {len(SETS)} sets of sensors"
    held = replace(held_row(found), case=case)
    return (held, *map(broken_row, forgiven))


def median_half_m(outcomes: Sequence[Outcome]) -> float:
    """Median half-width of the bounds in these runs, each second in motion while the position was known, m."""
    halves_m = [half_m for one in outcomes for half_m in one.halves_m]
    return median(halves_m) if halves_m else math.inf


def beside_rows(fused: Found, alone: Mapping[Carried, Found]) -> tuple[Row, ...]:
    """Each set's median half-width beside that of each of its sensors alone, in the same runs."""
    rows: list[Row] = []
    for each in (one for one in SETS if len(one) > 1):
        mine = [one for one in fused.outcomes if carried_in(one.number) == each]
        if not mine:
            continue
        members = {
            kind: [one for one in alone[kind].outcomes if carried_in(one.number) == each] for kind in each
        }
        best_m = min(median_half_m(outcomes) for outcomes in members.values())
        ours_m = median_half_m(mine)
        told = ", ".join(f"{kind} {_told(outcomes)}" for kind, outcomes in members.items())
        missed = f"; missed: {ours_m / best_m:.2f}" if not ours_m <= WIDER_MOST * best_m else ""
        rows.append(
            Row(
                f"median half-width of the bounds, m, {JOINT.name}, {' and '.join(each)}",
                None,
                f"{_told(mine)}; alone: {told}",
                not missed,
                f"at most {WIDER_MOST:g} times that of its best member alone{missed}",
            )
        )
    return tuple(rows)


def _told(outcomes: Sequence[Outcome]) -> str:
    known = sum(one.known_steps for one in outcomes) / max(sum(one.steps for one in outcomes), 1)
    return f"{median_half_m(outcomes):.1f} (known in {known:.0%} of the steps)"


def median_row(setup: Setup, rule: Rule = AS_UNITS_ARE) -> Row:
    """Median half-width on the line as it stands, with tags alone, against the way since the last tag."""
    run = PositionRun(rule.of(setup))
    trace = run.run().trace
    seen = trace[(trace["speed_mps"] > 0.0) & np.isfinite(trace["bound_ahead_m"])]
    half_m = float(np.median((seen["bound_ahead_m"] + seen["bound_behind_m"]) / 2.0))
    tags_m = np.array([run.mission.targets[0].mark_m, *(tag.position_m for tag in run.mission.tags)])
    passed_m = tags_m[np.searchsorted(tags_m, seen["position_m"], side="right") - 1]
    since_m = float(np.median(seen["position_m"] - passed_m))
    most_m = setup.unit.wheel_error_share * since_m + MEDIAN_BEYOND_M
    return Row(
        f"median half-width of the bounds, m, {setup.name}, {' and '.join(rule.carries)}",
        None,
        round(half_m, 2),
        half_m < most_m,
        f"below {most_m:.1f}: stated growth times the median way since the last tag, {since_m:.0f} m, and 2 m",
    )


def curved_row(setup: Setup, rule: Rule) -> Row:
    """The same with curvature, but for straights so long that there is nothing to compare."""
    run = PositionRun(rule.of(setup))
    rows = run.trains.rows_of(0, run.trains.true_path(0))
    turn_rad = run.trains.pool.profile["turn_rad"][rows.offset : rows.offset + rows.rows]
    bends_m = np.flatnonzero(np.diff(turn_rad) > 0.0).astype(float)
    ends_m = np.concatenate([[0.0], bends_m, [float(rows.rows)]])
    trace = run.run().trace
    seen = trace[(trace["speed_mps"] > 0.0) & np.isfinite(trace["bound_ahead_m"])]
    after = np.clip(np.searchsorted(ends_m, seen["position_m"], side="right"), 1, ends_m.size - 1)
    seen = seen[ends_m[after] - ends_m[after - 1] <= STRAIGHT_OVER_M]
    half_m = float(np.median((seen["bound_ahead_m"] + seen["bound_behind_m"]) / 2.0))
    missed = f"; missed by {half_m - MEDIAN_CURVED_M:.2f} m" if half_m >= MEDIAN_CURVED_M else ""
    return Row(
        f"median half-width of the bounds, m, {setup.name}, {' and '.join(rule.carries)}{CURVED}",
        None,
        round(half_m, 2),
        half_m < MEDIAN_CURVED_M,
        f"below {MEDIAN_CURVED_M:g}; straights of more than {STRAIGHT_OVER_M:g} m are left out{missed}",
    )


def figures(found: Found) -> tuple[Figure, ...]:
    """What the runs had in them."""
    outcomes = found.outcomes
    ills = {str(ill): sum(one.ills[str(ill)] for one in outcomes) for ill in Ill}
    halves_m = [half_m for one in outcomes for half_m in one.halves_m]
    return (
        *(Figure(f"tags {name}", number, "laid in all runs") for name, number in ills.items()),
        Figure("tags believed", sum(one.read for one in outcomes), "read and believed"),
        Figure("tags doubted", sum(one.doubted for one in outcomes), "read and not believed yet"),
        Figure("position faults", sum(one.faults for one in outcomes), "the unit did not know where it is"),
        Figure(
            "runs that arrived", sum(one.arrived for one in outcomes), "the others end past their last tag"
        ),
        Figure("median half-width", round(median(halves_m), 2) if halves_m else None, "m, of all runs"),
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
        Parameter(
            "tags moved", f"{MOVED_M[0]:g} to {MOVED_M[1]:g}", "m", "assumed: maintenance of the track"
        ),
        Parameter(
            "wear of wheels", WHEEL_SIGMA, "share (sigma, cut at 3)", "assumed: as far as units allow for"
        ),
        Parameter(
            "creep", f"0 to {CREEP_MAX:g}", "share at full adhesion", "assumed: see [sensors] creep_share"
        ),
        Parameter("slope of treads", ", ".join(map(str, CONICITY)), "", "Harada, 2.1; assumed: new and worn"),
        Parameter(
            "slippery stretches", f"{SLIPPERY[0]:g} to {SLIPPERY[1]:g}", "of the dry rail", "assumed: leaves"
        ),
        Parameter("runs without slide protection", UNPROTECTED_SHARE, "share", "assumed: wheels may lock"),
        Parameter(
            "where a train begins", "as its crew says", "", "the premise: a portal's own tag is not moved"
        ),
        Parameter(
            "tags wrong one after another", 1, "", "the premise: unit.tags_wrong_together, or two swapped"
        ),
    )


def reproduce(options: Options) -> Reproduction:
    """All runs by the rule as it is, some with the rule switched off, and the width of the bounds on one line."""
    numbers = range(QUICK_RUNS if options.quick else RUNS)
    found = run_all(options.seed, numbers)
    off = [run_all(options.seed, range(min(len(numbers), BROKEN_RUNS)), rule) for rule in SWITCHED_OFF]
    sets = [
        run_all(options.seed, range(QUICK_SET_RUNS if options.quick else SET_RUNS), r) for r in sensor_sets()
    ]
    runs = range(QUICK_JOINT_RUNS if options.quick else JOINT_RUNS)
    joint = run_all(options.seed, runs, JOINT, of=joint_outcome)
    switched_off = () if options.quick else (FORGIVING, JUMPS_FORGIVEN)
    forgiven = [run_all(options.seed, runs, rule, of=joint_outcome) for rule in switched_off]
    beside = alone_of(options.seed, numbers_beside(options))
    joint_first = replace(
        joint, outcomes=tuple(one for one in joint.outcomes if one.number in numbers_beside(options))
    )
    line = base_setup(MEDIAN_LINE)
    curved = [curved_row(line, one.rule) for one in sets if one.rule.carries == WITH_CURVATURE]
    remarks = [
        "With curvature the half-width is that of what wheels may vary by, which units are told and do not see: of"
        " wheels known neither to creep nor to have a slope it would be below the 2 m asked for (told beside).",
        "A run is drawn from (seed, number): study.papers.fusion_runs.outcome(seed, number) is that run again.",
        *(f"OUT: {again(one)}" for one in found.broken),
        *(
            f"OUT with {' and '.join(each.rule.carries)}: {again(one)}"
            for each in sets
            for one in each.broken
        ),
        *(
            f"OUT with {' and '.join(rule_of(one.number, JOINT).carries)}: {again(one)}"
            for one in joint.broken
        ),
        *joint.died,
        *found.died,
    ]
    if options.quick:
        remarks.append(f"A short slice: {QUICK_RUNS} runs of {RUNS}.")
    return Reproduction(
        NAME,
        "Where a train is: the truth within the stated bounds, whatever wheels and tags do",
        parameters(),
        (
            held_row(found),
            *map(broken_row, off),
            median_row(line),
            *map(held_row, sets),
            *curved,
            *NULL.rows([held_row(replace(off[SWITCHED_OFF.index(TRUSTING)], rule=AS_UNITS_ARE))]),
            *joint_rows(joint, forgiven),
            *beside_rows(joint_first, beside),
        ),
        tuple(remarks),
        (
            *figures(found),
            *(evenly_turning(line, one.rule) for one in sets if one.rule.carries == WITH_CURVATURE),
        ),
        null=NULL,
    )


def numbers_beside(options: Options) -> range:
    """The joint runs that are made again with each sensor alone."""
    return range(QUICK_BESIDE_RUNS if options.quick else BESIDE_RUNS)


def alone_of(seed: int, numbers: Sequence[int]) -> Mapping[Carried, Found]:
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


def evenly_turning(setup: Setup, rule: Rule) -> Figure:
    """How much of the width comes from what wheels may creep: the same with wheels that are taken not to."""
    even = setup.unit.model_copy(update={"wheel_scale_limit": setup.unit.wheel_error_share})
    return Figure(
        "median half-width with curvature, outside long straights, of wheels that never creep",
        curved_row(replace(setup, unit=even), rule).ours,
        "m; the rest of that row's is what unit.wheel_error_share has beyond unit.wheel_scale_limit",
    )


def again(one: Outcome) -> str:
    """How to have a run again, and what was wrong in it."""
    return f"seed {one.seed}, number {one.number} ({one.scenario}): {one.out_m:.3f} m at {one.out_at_m:.0f} m"
