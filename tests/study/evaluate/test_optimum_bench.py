from __future__ import annotations

from study.evaluate.optimum_bench import POINTS, longest_hop, optimum_cost
from study.scenario.scenario import load_scenario
from vehicle.optimum import least_energy, least_time


def test_the_longest_hop_is_timed_and_nothing_is_asked_of_the_clock() -> None:
    course = longest_hop(load_scenario("karasuyama_weekday").setup)
    assert course.stop_m - course.start_m > 3000.0
    cost = optimum_cost(course, "a hop")
    time_s = 1.1 * float(least_time(course).time_s[-1])
    assert cost.steps == least_energy(course, time_s, POINTS).rounds
    assert cost.kept == (cost.solution_ms <= cost.limit_ms)
    assert cost.bound_ms > 0.0
