"""`branchline best robust`: the same trains with reserves where late days need them, and what they are worth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from exchange.timetable_writer import file_of_timetable, timetable_toml
from network.errors import InputError
from network.files.json_input import write_aside
from network.files.toml_text import toml_of
from network.timetable import Timetable
from plan.reserves.delays import PlannedTimes, SampledDelays, planned_times
from plan.reserves.evenly import spread_evenly
from plan.reserves.model import MOVE_S, least_late
from plan.reserves.problem import ReserveProblem, reserve_problem
from plan.reserves.sampled import sampled_days
from plan.reserves.written import with_times
from simulation.setup import Setup
from study.feasibility.check import feasibility

TRAINING_SEED: Final = (
    100_001  # assumed: of the first day that is trained on, far from the seeds that people take
)


@dataclass(frozen=True, slots=True)
class ReservePlan:
    """Times of all trains, the mean delay of an arrival by the model, s: on the days trained on, and on others."""

    times: PlannedTimes
    trained_s: float
    fresh_s: float


@dataclass(frozen=True, slots=True)
class Robust:
    """A timetable as it is, with its reserves spread evenly, and placed; `bound_s` is of the days trained on."""

    problem: ReserveProblem
    as_it_is: ReservePlan
    evenly: ReservePlan
    placed: ReservePlan
    bound_s: float
    training_seeds: range
    fresh_seeds: range


def most_robust(setup: Setup, days: int, fresh: range, move_s: int = MOVE_S) -> Robust:
    """Place the reserves of a timetable. Raises InputError where nothing makes days late, or seeds are met again."""
    if not setup.late.model_fields_set:
        raise InputError(setup.name, "late", None, "what makes its days late: a scenario with [late]")
    training = range(TRAINING_SEED, TRAINING_SEED + days)
    if set(fresh) & set(training):
        raise InputError(
            setup.name, "seeds", fresh.start, f"days that are not trained on, before {TRAINING_SEED}"
        )
    problem = reserve_problem(setup)
    trained = sampled_days(setup, training)
    judges = [SampledDelays(problem, one) for one in (trained, sampled_days(setup, fresh))]

    def judged(times: PlannedTimes) -> ReservePlan:
        return ReservePlan(times, *(judge.mean_s(times) for judge in judges))

    found = least_late(problem, trained, move_s)
    as_it_is, evenly = judged(planned_times(problem)), judged(spread_evenly(problem, move_s))
    return Robust(problem, as_it_is, evenly, judged(found.times), found.bound_s, training, fresh)


def timetables_of(setup: Setup, found: Robust, stem: str) -> tuple[Timetable, Timetable]:
    """The timetable with its reserves placed, and spread evenly. Raises InputError where one fails `check`."""
    how = f"placed against {len(found.training_seeds)} sampled late days", "spread evenly over all runs"
    plans = (found.placed, f"{stem}_times", how[0]), (found.evenly, f"{stem}_evenly_times", how[1])
    made: list[Timetable] = []
    for plan, name, words in plans:
        day = with_times(setup.timetable, found.problem, plan.times, name, f"reserves: {words}")
        if not feasibility(replace(setup, timetable=day)).good:
            raise InputError(setup.name, "timetable", name, "times that `branchline check` lets run")
        made.append(day)
    return made[0], made[1]


def write_sweep(out: Path, extends: str, timetables: tuple[Timetable, Timetable], fresh: range) -> Path:
    """A sweep beside the answer that runs all three timetables on the fresh days."""
    placed, evenly = timetables
    write_aside(out.with_name(f"{evenly.head.id}.toml"), timetable_toml(file_of_timetable(evenly)))
    points = [
        {"label": "as it is"},
        {"label": "evenly", "set": {"timetable": f"{evenly.head.id}.toml"}},
        {"label": "placed", "set": {"timetable": f"{placed.head.id}.toml"}},
    ]
    tables = {
        "id": f"{out.stem}_days",
        "name": "Reserves as they are, spread evenly, and placed",
        "scenario": extends,
        "watch": ["mean_delay_s", "lost_train_minutes", "within_60_s", "secondary_s"],
        "axis": [{"name": "reserves", "point": points}],
        "seeds": {"first": fresh.start, "days": len(fresh)},
    }
    path = out.with_name(f"{out.stem}_days.toml")
    write_aside(path, toml_of(tables))
    return path
