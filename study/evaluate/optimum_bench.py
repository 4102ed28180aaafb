"""What a run of least energy costs to compute, with and without its bound; compiled before anything is timed."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Final

from simulation.setup import Setup
from study.measures.least_energy import Allowed, course_of
from study.measures.running_times import planned_hops
from vehicle.optimum import Course, least_energy, least_time
from vehicle.optimum.bound import lower_bound_j

POINTS: Final = 300
TIMES: Final = 1.1
SOLUTIONS: Final = 50
BUDGET_MS: Final = 20.0


@dataclass(frozen=True, slots=True)
class OptimumCost:
    """Medians over the solutions, ms; the budget is for the solution, as a unit needs it at a departure."""

    what: str
    length_m: float
    points: int
    steps: int
    solution_ms: float
    bound_ms: float
    limit_ms: float
    kept: bool


def longest_hop(setup: Setup) -> Course:
    """The course of the timetable's longest hop at the mean load."""
    hop = max(
        planned_hops(setup), key=lambda each: (each.there.mark_m - each.here.mark_m, each.mission.number)
    )
    return course_of(setup, hop, setup.load.load_share_mean, Allowed.as_units_drive(setup))


def optimum_cost(course: Course, what: str) -> OptimumCost:
    """Time solutions of one course at 1.1 times its least time."""
    time_s = TIMES * float(least_time(course).time_s[-1])
    found = least_energy(course, time_s, POINTS)
    lower_bound_j(course, found, time_s)
    solution_ms = _median_ms(lambda: least_energy(course, time_s, POINTS))
    bound_ms = _median_ms(lambda: lower_bound_j(course, found, time_s))
    return OptimumCost(
        what,
        course.stop_m - course.start_m,
        POINTS,
        found.rounds,
        round(solution_ms, 2),
        round(bound_ms, 2),
        BUDGET_MS,
        solution_ms <= BUDGET_MS,
    )


def bench_optimum(scenario: str) -> dict[str, Any]:
    """The part of `branchline bench`: the longest hop of a scenario's timetable."""
    from scenario.scenario import load_scenario

    return asdict(optimum_cost(longest_hop(load_scenario(scenario).setup), "least energy of the longest hop"))


def _median_ms(work: Callable[[], object]) -> float:
    spent: list[float] = []
    for _ in range(SOLUTIONS):
        started = time.perf_counter()
        work()
        spent.append(1e3 * (time.perf_counter() - started))
    return statistics.median(spent)
