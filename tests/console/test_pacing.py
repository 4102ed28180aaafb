"""Where a paced run is to be, by a clock that is given."""

from threading import TIMEOUT_MAX

from console.pacing import BEHIND_MAX_S, Pacer


def test_real_time_is_ten_steps_a_second_and_sixty_times_that_six_hundred() -> None:
    assert [Pacer(1.0, 100, 5.0).due(now_s) for now_s in (5.0, 5.05, 5.1, 6.0)] == [100, 100, 101, 110]
    assert Pacer(60.0, 100, 5.0).due(6.0) == 700
    assert Pacer(0.0, 100, 5.0).due(1000.0) == 100


def test_it_waits_for_the_next_step_and_not_at_all_when_it_stands() -> None:
    wait_s = Pacer(2.0, 100, 5.0).wait_s(100, 5.01)
    assert wait_s is not None
    assert abs(wait_s - 0.04) < 1e-9
    assert Pacer(0.0, 100, 5.0).wait_s(100, 5.0) is None
    assert Pacer(0.0, 100, 5.0, 200).wait_s(100, 5.0) == 0.0


def test_who_cannot_keep_up_falls_back_and_does_not_hurry() -> None:
    """At pace 60 the run has come to step 130 when it should be at 700."""
    pacer = Pacer(60.0, 100, 5.0).at(130, 6.0)
    assert (pacer.due(6.0), pacer.due(6.1)) == (130, 190)
    near = Pacer(1.0, 100, 5.0)
    assert near.at(106, 5.6 + BEHIND_MAX_S - 0.01) is near


def test_at_its_goal_it_stands() -> None:
    pacer = Pacer(0.0, 100, 5.0, 300)
    assert pacer.due(5.0) == 300
    assert pacer.at(250, 6.0) is pacer
    assert pacer.at(300, 7.0) == Pacer(0.0, 300, 7.0)


def test_a_pace_that_is_next_to_nothing_asks_no_clock_to_wait_longer_than_it_can() -> None:
    """Its next step is due in 300,000 years."""
    waits_s = Pacer(1e-14, 0, 0.0).wait_s(0, 0.0)
    assert waits_s is not None and waits_s < TIMEOUT_MAX
