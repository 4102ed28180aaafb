"""What a party's clock shows, and when it will show a time."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation.clock import Clock

DAY_S = 86_400.0
offsets_s = st.floats(-DAY_S, DAY_S)
drifts = st.floats(-0.1, 0.1)
times_s = st.floats(0.0, 2 * DAY_S)


@given(times_s)
def test_a_clock_in_order_shows_the_true_time_to_the_last_bit(true_s: float) -> None:
    assert Clock().shows(true_s) == true_s == Clock().true_s(true_s)


@given(offsets_s, drifts, times_s, times_s)
def test_when_it_shows_a_time_is_the_inverse_of_what_it_shows(
    offset_s: float, drift: float, since_s: float, true_s: float
) -> None:
    clock = Clock().wrong(offset_s, drift, since_s)
    assert clock.true_s(clock.shows(true_s)) == pytest.approx(true_s, abs=1e-6)


@given(offsets_s, drifts, times_s, st.floats(0.0, DAY_S))
def test_it_is_off_by_its_offset_at_once_and_by_its_drift_for_each_second(
    offset_s: float, drift: float, since_s: float, later_s: float
) -> None:
    clock = Clock().wrong(offset_s, drift, since_s)
    assert clock.shows(since_s) - since_s == pytest.approx(offset_s, abs=1e-6)
    true_s = since_s + later_s
    assert clock.shows(true_s) - true_s == pytest.approx(offset_s + drift * later_s, abs=1e-6)


def test_however_many_are_too_slow_it_goes_on() -> None:
    clock = Clock()
    for since_s in range(1000, 21_000, 1000):
        before, clock = clock, clock.wrong(0.0, -0.1, since_s)
        assert clock.shows(since_s) == pytest.approx(before.shows(since_s))  # nor does it jump
    assert clock.shows(100.0) > clock.shows(0.0)
