"""`too-fast` in every step between two looks, by hand: a limit of 15 m/s from 270 to 280 m of E-, a train of 40 m."""

import pytest

from simulation.judge.body import Body, NetTrack
from simulation.judge.log import Checker, Log
from simulation.judge.rail import RailWatch
from simulation.judge.speed import LimitBetween, RunSince, SpeedWatch, TrueLimits
from tests.simulation.judge.stage import Stage, net

STEP_S = 0.1
# the emergency brake comes 2 m/s above a limit, and a train gains 1 m/s until it acts
ALLOWED_MPS = 15.0 + 2.0 + 1.0


def ran(stage: Stage, at_s: float, front_m: float, *stretch: tuple[int, float]) -> list[tuple[float, str]]:
    """B, seen at 260 m of E-, is seen again after steps at these speeds; breaches of its speed, and when."""
    speeds_mps = [mps for steps, mps in stretch for _ in range(steps)]
    edge, along_m = ("E-", front_m) if front_m < 300.0 else ("B-", front_m - 300.0)
    stage.checkers.observe(at_s, "B", edge, along_m, speeds_mps[-1], RunSince(STEP_S, speeds_mps))
    return [(v.t_s, v.text) for v in stage.checkers.violations if v.checker == Checker.TOO_FAST]


@pytest.fixture
def before_the_limit() -> Stage:
    stage = Stage().accept("B", "E", "B").holds("B", "E", "B").put("B", "E-", 100.0)
    return stage.see("B", ("E-", 260.0), speed_mps=10.0)


def test_what_was_over_before_the_train_is_seen_again_counts(before_the_limit: Stage) -> None:
    """100 m at 20 m/s: the rear has left the limit by 40 m when the train is seen, and 20 m/s is allowed there."""
    broken = ran(before_the_limit, 100.0, 360.0, (50, 20.0))
    assert [text for _, text in broken] == ["B runs at 20.0 m/s where no more than 15.0 m/s is allowed"]
    assert 95.5 <= broken[0][0] <= 98.0  # the front comes onto it after 10 m, the rear leaves it after 60 m


def test_the_step_in_which_a_train_is_too_fast_by_most_is_told(before_the_limit: Stage) -> None:
    """The last of those between the first and the second of five seconds, while the rear is 18 m within."""
    broken = ran(before_the_limit, 100.0, 360.0, (10, 19.0), (10, 23.0), (10, 19.0), (20, 19.5))
    assert broken == [(pytest.approx(97.0), "B runs at 23.0 m/s where no more than 15.0 m/s is allowed")]


@pytest.mark.parametrize(("steps", "breaks"), [(30, True), (32, True), (33, False)])
def test_it_may_run_faster_as_soon_as_its_rear_has_left_the_limit(
    before_the_limit: Stage, steps: int, breaks: bool
) -> None:
    """After 60 m, which are 33.5 steps: so the 34th is the first that may end at more than is let pass."""
    speeds = (steps, ALLOWED_MPS - 0.1), (50 - steps, ALLOWED_MPS + 0.1)
    after_m = STEP_S * (steps * speeds[0][1] + (50 - steps) * speeds[1][1] - 0.1)  # evenly within each step
    assert bool(ran(before_the_limit, 100.0, 260.0 + after_m, *speeds)) is breaks


def test_an_edge_that_the_train_ran_over_between_two_looks_counts() -> None:
    """20 m of train over 10 m of track at 10 m/s: it lies on neither look's edges, both beyond."""
    log, track = Log(), NetTrack(net(), {})
    watch = SpeedWatch(net(), TrueLimits({"stem2-": [LimitBetween(0.0, 10.0, 10.0)]}, {}, 2.0), log)
    body = Body("A", 20.0, ["B-"])
    track.follow(body, "B-", 490.0)
    track.follow(body, "normal2-", 29.0)
    body.speed_mps = 19.6
    watch.observe(100.0, body, RailWatch(0.8, {}), RunSince(STEP_S, [19.6] * 25))
    assert [v.text for v in log.violations] == ["A runs at 19.6 m/s where no more than 10.0 m/s is allowed"]


def test_a_train_that_is_seen_again_before_it_has_run_is_as_fast_as_it_is(before_the_limit: Stage) -> None:
    stage = before_the_limit.see("B", ("E-", 271.0), speed_mps=17.9)
    assert stage.checkers.counts.get(Checker.TOO_FAST, 0) == 0
    stage.checkers.observe(stage.t_s, "B", "E-", 271.0, 18.1, RunSince(STEP_S, ()))
    assert stage.checkers.counts[Checker.TOO_FAST] == 1
