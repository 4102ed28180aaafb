"""A limit to waiting counts only time in which one runs: the clock here is a list of times."""

from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.patience import Patience


def patience(limit_s: float, *times_s: float) -> Patience:
    told: Iterator[float] = iter(times_s)
    return Patience(limit_s, gap_s_max=1.0, clock=lambda: next(told))


def test_what_is_waited_counts() -> None:
    waiting = patience(2.0, 0.0, 0.5, 1.0, 1.9, 2.0)
    assert [waiting.is_over() for _ in range(4)] == [False, False, False, True]


@pytest.mark.parametrize("slept_s", [1.1, 60.0, 1e6])
def test_sleep_does_not(slept_s: float) -> None:
    waiting = patience(2.0, 0.0, 0.9, 0.9 + slept_s, 1.8 + slept_s, 2.1 + slept_s)
    assert [waiting.is_over() for _ in range(4)] == [False, False, False, True]


@given(st.lists(st.floats(0.0, 100.0), min_size=1, max_size=50), st.floats(0.0, 20.0))
def test_it_is_over_after_the_limit_of_time_awake(gaps_s: list[float], limit_s: float) -> None:
    times_s = [0.0]
    for gap_s in gaps_s:
        times_s.append(times_s[-1] + gap_s)
    waiting = patience(limit_s, *times_s)
    over = [waiting.is_over() for _ in gaps_s]
    awake_s = 0.0
    for was_over, before_s, now_s in zip(over, times_s, times_s[1:], strict=False):
        awake_s += now_s - before_s if now_s - before_s <= 1.0 else 0.0
        assert was_over == (awake_s >= limit_s)
