"""What the check says, held against what runs make of it: a small sample, and a larger one by night.

The two know nothing of each other: the check reads plans, the run has units, radio and SUMO.
"""

from dataclasses import replace

import pytest

from simulation.result import RunResult
from simulation.setup import Setup
from study.feasibility.check import feasibility
from study.feasibility.finding import FindingKind
from study.runner.outcome import broken_rules, unfinished
from study.runner.run import CarrierKind, simulation_of
from tests.nightly import others_nightly
from tests.study.feasibility.broken_plans import BREAKS, good
from tests.study.feasibility.good_plans import good_plan
from tests.study.feasibility.moved_plans import moved_plan

GOES_WRONG_S = 15.0  # later than this, a train of these plans did not run as planned
ABOUT_S = 100.0  # by which a day in blocks and minutes may be wrong about the latest train
BROKEN = [name for name in BREAKS if name != "no_way"]  # which has no run
IN_PASSING = ("leg_in_two_minutes",)


def run(setup: Setup) -> RunResult:
    with simulation_of(setup, carrier=CarrierKind.PLAIN) as simulation:
        return simulation.run()


def latest_s(result: RunResult) -> float:
    """The worst lateness of any arrival or departure, s."""
    times = [(stop.arrival_s, stop.planned_arrival_s) for stop in result.stops]
    times += [(stop.departure_s, stop.planned_departure_s) for stop in result.stops]
    return max((is_s - due_s for is_s, due_s in times if is_s is not None and due_s is not None), default=0.0)


def test_the_plan_before_it_is_broken_runs_to_plan() -> None:
    result = run(good().setup())
    assert unfinished(result) == ()
    assert broken_rules(result) == []
    assert latest_s(result) < GOES_WRONG_S


@pytest.mark.parametrize("name", others_nightly(BROKEN, IN_PASSING))
def test_a_broken_plan_really_goes_wrong(name: str) -> None:
    result = run(BREAKS[name]().plan.setup())
    assert unfinished(result) or latest_s(result) > GOES_WRONG_S


@pytest.mark.parametrize("seed", others_nightly(range(200), [1]))
def test_a_good_plan_really_runs_to_plan(seed: int) -> None:
    result = run(good_plan(seed).setup())
    assert unfinished(result) == ()
    assert broken_rules(result) == []
    assert latest_s(result) < GOES_WRONG_S


def ends_if_it_may(seed: int) -> bool:
    """Run a plan that was moved about by chance, if the check lets it: every train arrives, about as late as it
    says. Whether it did run.
    """
    plan = moved_plan(seed)
    found = None if plan is None else feasibility(plan.setup())
    if plan is None or found is None or not found.good:
        return False
    result = run(plan.setup())
    assert unfinished(result) == ()
    late_s = (f.short_s or 0.0 for f in found.not_as_printed if f.kind is FindingKind.LATE)
    assert latest_s(result) == pytest.approx(max(late_s, default=0.0), abs=ABOUT_S)
    return True


def test_whatever_the_check_lets_run_ends_with_every_train_arrived() -> None:
    assert sum(ends_if_it_may(seed) for seed in range(1000, 1002)) >= 1


@pytest.mark.nightly
@pytest.mark.parametrize("first", range(0, 300, 20))
def test_whatever_the_check_lets_run_ends_by_night_too(first: int) -> None:
    assert sum(ends_if_it_may(seed) for seed in range(first, first + 20)) >= 5


def test_a_set_that_is_stabled_between_two_trains_runs_both() -> None:
    plan = good()
    stays, goes = (
        replace(plan.train("D"), ends="stabled"),
        replace(plan.train("U"), begins="stabled"),
    )
    result = run(replace(plan, trains=(stays, goes)).setup())
    assert unfinished(result) == ()
    assert latest_s(result) < GOES_WRONG_S
