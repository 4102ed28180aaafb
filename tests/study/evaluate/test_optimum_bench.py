import pytest

from scenario.scenario import load_scenario
from study.evaluate import optimum_bench
from study.evaluate.optimum_bench import POINTS, longest_hop, optimum_cost
from vehicle.optimum import Course, least_energy, least_time


@pytest.fixture(scope="module")
def hop() -> Course:
    return longest_hop(load_scenario("karasuyama_weekday").setup)


def test_the_longest_hop_is_timed_and_nothing_is_asked_of_the_clock(hop: Course) -> None:
    assert hop.stop_m - hop.start_m > 3000.0
    cost = optimum_cost(hop, "a hop")
    time_s = 1.1 * float(least_time(hop).time_s[-1])
    assert cost.steps == least_energy(hop, time_s, POINTS).rounds
    assert cost.bound_ms > 0.0


@pytest.mark.parametrize(("took_ms", "kept"), [(19.9, True), (20.0, True), (20.1, False)])
def test_a_solution_of_more_than_20_ms_is_over_the_budget(
    hop: Course, monkeypatch: pytest.MonkeyPatch, took_ms: float, kept: bool
) -> None:
    monkeypatch.setattr(optimum_bench, "_median_ms", lambda _work: took_ms)
    cost = optimum_cost(hop, "a hop")
    assert cost.kept is kept
    assert cost.limit_ms == 20.0
