"""Sweeps: the same faults at every instant of a run, each run forked from the state before them (全時刻試験).

One process runs the scenario without any fault. Wherever a stretch begins, it forks a copy for each instant that may
lie in that stretch; the copy is told what happens, and when, and runs on to its end. The parent's stretches are not
cut at the instants, so a copy's run is, to the byte, the run of the drill that has the fault at that time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from typing import Final

from network.errors import InputError
from simulation.faults.script import DEFAULTS, Act, Script, ScriptedFault, Trigger
from simulation.late_day import late_day
from simulation.loop import Simulation
from simulation.setup import STEPS_PER_S, Setup, step_not_before
from simulation.world.roster import drawn_up
from study.drilling.forks import Forks, Key
from study.drilling.outcome_class import SweptRun, swept_run_of
from study.drilling.swept_rows import MadeOf, SweptRows
from study.runner.run import simulation_of

NOTHING: Final = Script()
LEAD_S: Final = 10.0  # a sweep begins this long before the first train of interest
Progress = Callable[[int, int], None]  # runs done, runs to do


@dataclass(frozen=True, slots=True)
class Variation:
    """What is moved, as a whole: faults and acts, each at so many steps after the instant (before it where negative).

    The first fault, or the first act where there is no fault, is at the instant. `stocks` are those whose trains the
    sweep follows. `instants`: the steps at which alone it can have an effect, in order; None: every one may matter.
    """

    name: str
    faults: tuple[tuple[int, ScriptedFault], ...] = ()
    acts: tuple[tuple[int, Act], ...] = ()
    stocks: frozenset[str] = frozenset()
    instants: tuple[int, ...] | None = None

    @property
    def first(self) -> int:
        """The step, after the instant, of the first thing that happens."""
        return min(offset for offset, _ in (*self.faults, *self.acts))

    def at(self, step: int) -> Script:
        """The script with its instant at `step`."""
        return Script(
            tuple(replace(failure, trigger=_at(step + offset)) for offset, failure in self.faults),
            tuple(replace(act, trigger=_at(step + offset)) for offset, act in self.acts),
            DEFAULTS,
        )


def _at(step: int) -> Trigger:
    return Trigger(at_s=step / STEPS_PER_S)


@dataclass(frozen=True, slots=True)
class InstantWindow:
    """Which instants, s. From LEAD_S before the first train of interest to where the last of them has ended its day.

    `staggered`: several variations one after the other within each `every_s`, so that together they are closer.
    """

    every_s: float = 1.0
    from_s: float | None = None
    to_s: float | None = None
    staggered: bool = False


@dataclass(frozen=True, slots=True)
class SweepOutcomes:
    """All outcomes of a sweep, by the variation's name and the step of the instant."""

    every_step: int
    outcomes: dict[str, dict[int, SweptRun]]

    @property
    def bad(self) -> bool:
        """Whether any run was."""
        return any(outcome.bad for runs in self.outcomes.values() for outcome in runs.values())

    def beside(self, *own: SweptRun) -> SweepOutcomes:
        """The same; no run is bad for what a drill itself ends as."""
        outcomes = {
            name: {step: run.beside(*own) for step, run in runs.items()}
            for name, runs in self.outcomes.items()
        }
        return replace(self, outcomes=outcomes)


class _VariationProgress:
    """Where the sweep of one variation is."""

    def __init__(self, variation: Variation, instants: Iterable[int]) -> None:
        self.variation = variation
        self.last_step: float = math.inf
        self._instants = iter(instants)
        self._next = next(self._instants, None)

    @property
    def open(self) -> bool:
        """Whether instants are left."""
        return self._next is not None

    def due(self, simulation: Simulation) -> Iterable[int]:
        """The instants whose runs part from the fault-free one in the stretch that begins now."""
        first = self.variation.first
        while self._next is not None and self._next + first <= simulation.horizon_step:
            if self._next + first >= simulation.step:
                yield self._next
            self._next = next(self._instants, None)

    def close(self, step: int) -> None:
        """No instants after `step`: those that were taken up ahead do not count."""
        if self.open:
            self._next, self.last_step = None, step


def sweep(
    setup: Setup,
    variations: Sequence[Variation],
    window: InstantWindow,
    jobs: int,
    progress: Progress | None = None,
    beside: Script = NOTHING,
    rows: SweptRows | None = None,
) -> SweepOutcomes:
    """Run every variation at every instant of its window. InputError on a day on which something fails by itself.

    What is varied happens where nothing else does, or beside a script of its own. What `rows` have is not run again.
    """
    if late_day(setup).failures:
        expected = "no failures and dead zones: a sweep puts faults where there are none"
        raise InputError(setup.name, "late", None, expected)
    every_step = max(1, round(window.every_s * STEPS_PER_S))
    planned = [_planned(setup, variation, window) for variation in variations]
    if window.staggered:
        later = [n * p.step // len(planned) for n, p in enumerate(planned)]
        planned = [range(p.start + n, p.stop, p.step) for n, p in zip(later, planned, strict=True)]
    # Trains may be late: without an end of its own a sweep goes on to where they have ended their day.
    courses = [
        _VariationProgress(
            v,
            (p if window.to_s is not None else count(p.start, p.step)) if v.instants is None else v.instants,
        )
        for v, p in zip(variations, planned, strict=True)
    ]
    total = sum(
        len(steps if variation.instants is None else variation.instants)
        for variation, steps in zip(variations, planned, strict=True)
    )
    rows = SweptRows(None, MadeOf(), {}) if rows is None else rows
    asked: list[Key] = []
    with (
        simulation_of(replace(setup, script=beside)) as simulation,
        Forks(SweptRun, jobs, rows.take) as copies,
    ):
        simulation.begin()
        while any(course.open for course in courses) and not simulation.settle():
            for course in courses:
                variation = course.variation
                for step in course.due(simulation):
                    asked.append((variation.name, step))
                    if asked[-1] not in rows.taken_up:
                        copies.start(asked[-1], partial(_end_of, simulation, variation.at(step)))
                    if progress is not None:
                        progress(len(asked) - copies.under_way, total)
                if window.to_s is None and all(map(simulation.has_finished, variation.stocks)):
                    course.close(simulation.step)
            simulation.advance()
        if window.to_s is None:
            for course in courses:
                course.close(simulation.step)
        copies.wait()
    outcomes: dict[str, dict[int, SweptRun]] = {variation.name: {} for variation in variations}
    last_of = {course.variation.name: course.last_step for course in courses}
    for name, step in sorted(asked):
        if step <= last_of[name]:
            outcomes[name][step] = rows.rows[name, step].run
    return SweepOutcomes(every_step, outcomes)


def _end_of(simulation: Simulation, script: Script) -> SweptRun:
    """In a copy: what becomes of it all with this script."""
    simulation.carry_out(script)
    return swept_run_of(simulation.finish(), script)


def _planned(setup: Setup, variation: Variation, window: InstantWindow) -> range:
    """The instants of a variation if its trains run to plan."""
    drawn = drawn_up(setup, setup.line)
    duties = [duty for stock in variation.stocks for duty in drawn[stock]]
    first_s = min(duty.enter_s for duty in duties) - LEAD_S if window.from_s is None else window.from_s
    ends_s = [duty.train.calls[-1].last_s for duty in duties]
    last_s = max(ends_s) if window.to_s is None else window.to_s
    every = max(1, round(window.every_s * STEPS_PER_S))
    return range(step_not_before(first_s), step_not_before(last_s) + 1, every)
