"""Intervals hold the truth as often as they say; known figures by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from study.sweep.statistics import difference_of, mean_of, quantile_of, share_of

figures = st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=60)


def test_mean_by_hand() -> None:
    found = mean_of([1.0, 2.0, 3.0, 4.0, 5.0], 0.95)
    reach = 2.776445 * math.sqrt(2.5 / 5)  # t of 4 degrees of freedom
    assert found.value == 3.0
    assert found.low == pytest.approx(3.0 - reach, abs=1e-5)
    assert found.high == pytest.approx(3.0 + reach, abs=1e-5)
    assert mean_of([7.0], 0.95).width is None
    assert mean_of([], 0.95).value is None


@given(figures)
def test_mean_is_that_of_the_library(values: list[float]) -> None:
    found = mean_of(values, 0.9)
    assert found.value == pytest.approx(float(np.mean(values)), abs=1e-5)
    if len(values) > 1 and np.std(values) > 1e-3:
        low, high = stats.t.interval(0.9, len(values) - 1, np.mean(values), stats.sem(values))
        assert (found.low, found.high) == pytest.approx((float(low), float(high)), rel=1e-6, abs=1e-4)


def test_share_of_wilson_by_hand() -> None:
    # Wilson 1927: (p + z^2/2n ± z sqrt(p(1-p)/n + z^2/4n^2)) / (1 + z^2/n)
    z, p, n = 1.959964, 0.1, 50
    centre = (p + z * z / (2 * n)) / (1 + z * z / n)
    reach = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    found = share_of(5, 50, 0.95)
    assert (found.low, found.high) == pytest.approx((centre - reach, centre + reach), abs=1e-5)
    assert share_of(0, 30, 0.95).low == 0.0
    assert share_of(0, 0, 0.95).value is None


@given(figures, st.sampled_from([0.05, 0.5, 0.95]))
def test_quantile_interval_holds_its_figure(values: list[float], share: float) -> None:
    found = quantile_of(values, share, 0.95)
    assert found.days == len(values)
    if found.low is not None and found.high is not None:
        assert found.low - 1e-5 <= found.value <= found.high + 1e-5
        assert {found.low, found.high} <= {round(value, 6) for value in values}


@pytest.mark.parametrize("share", [0.25, 0.5, 0.95])
def test_intervals_cover_as_often_as_they_say(share: float) -> None:
    chance = np.random.Generator(np.random.PCG64(7))
    truth, hits, wide = float(stats.expon.ppf(share)), 0, 0
    for _ in range(400):
        found = quantile_of(chance.exponential(size=80), share, 0.9)
        assert found.low is not None
        assert found.high is not None
        hits += found.low <= truth <= found.high
        wide += found.low == 0.0
    assert 0.87 <= hits / 400 <= 0.98  # never less than said, but for chance; order statistics come in steps
    assert wide == 0


@given(figures)
def test_what_both_have_drops_out_of_a_difference(values: list[float]) -> None:
    found = difference_of([(value, value + 3.0) for value in values], 0.95)
    assert found.value == pytest.approx(3.0)
    assert found.width is None or found.width < 1e-4
