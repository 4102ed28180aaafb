"""Time that passes for timers, by a clock that is set."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from radio.elapsed import Elapsed


@given(st.lists(st.floats(0.0, 1e5), min_size=2))
def test_it_never_goes_back_and_passes_as_the_clock_does(shown_s: list[float]) -> None:
    elapsed = Elapsed()
    passed_s = [elapsed.at(now_s) for now_s in shown_s]
    assert passed_s == sorted(passed_s)
    for (before_s, after_s), (before, after) in zip(pairwise(shown_s), pairwise(passed_s), strict=True):
        assert abs((after - before) - max(after_s - before_s, 0.0)) < 1e-6


def test_a_clock_never_set_back_is_its_own_measure() -> None:
    elapsed = Elapsed()
    assert [elapsed.at(now_s) for now_s in (0.1, 7.3, 7.3, 1e5)] == [0.1, 7.3, 7.3, 1e5]
    assert elapsed.shown_at(123.4) == 123.4


def test_a_timer_set_by_a_clock_that_was_ahead_runs_out_when_its_time_has_passed() -> None:
    elapsed = Elapsed()
    runs_out_s = elapsed.at(3610.0) + 2.0  # an hour ahead
    elapsed.at(10.5)  # set right half a second later
    assert elapsed.shown_at(runs_out_s) == 12.5
    assert elapsed.at(12.5) == runs_out_s
