"""Intervals hold the truth as often as they say; known figures by hand."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from study.sweep.statistics import (
    RunningMoments,
    difference_of,
    looks,
    mean_of,
    of_each_look,
    quantile_of,
    share_of,
)

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
def test_mean_of_what_is_not_skewed_is_that_of_the_library(one_side: list[float]) -> None:
    values = [*one_side, *(-value for value in one_side)]
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
def test_the_mean_lies_in_its_interval_and_the_longer_side_is_that_of_the_tail(values: list[float]) -> None:
    found = mean_of(values, 0.95)
    if found.value is not None and found.low is not None and found.high is not None:
        assert found.low - 1e-5 <= found.value <= found.high + 1e-5
        if len(values) > 2 and np.std(values) > 1e-3 and abs(skew := float(stats.skew(values))) > 0.1:
            assert (found.high - found.value > found.value - found.low) is (skew > 0.0)


def test_skewness_as_it_comes_is_that_of_the_library() -> None:
    values = np.random.Generator(np.random.PCG64(3)).exponential(size=200)
    running = RunningMoments()
    for value in values:
        running.add(float(value))
    assert running._skewness == pytest.approx(float(stats.skew(values, bias=False)))


# Skewed as figures of late days are: name, how drawn, the true mean, widths at which to stop.
Drawn = Callable[[np.random.Generator, int], NDArray[np.float64]]
SKEWED: dict[str, tuple[Drawn, float, tuple[float, ...]]] = {
    "mean lateness": (lambda chance, n: chance.gamma(1.5, 28.0, n) - 40.0, 2.0, (40.0, 20.0)),
    "knock-on, none on most days": (
        lambda chance, n: np.where(chance.random(n) < 0.58, 0.0, chance.exponential(310.0, n)),
        0.42 * 310.0,
        (200.0, 100.0),
    ),
    "exponential": (lambda chance, n: chance.exponential(1.0, n), 1.0, (0.8, 0.5)),
    "symmetrical": (lambda chance, n: chance.normal(0.0, 1.0, n), 0.0, (0.7, 0.5)),
}
SAID = 0.95
LEAST = 0.94


def error_of(times: int) -> float:
    """Two standard errors of a share near SAID that is counted so often."""
    return 2.0 * math.sqrt(SAID * (1.0 - SAID) / times)


def held(name: str, days: int, times: int) -> float:
    """How often the interval of so many days holds the true mean."""
    draw, truth, _ = SKEWED[name]
    chance = np.random.Generator(np.random.PCG64(days))
    found = [mean_of(draw(chance, days).tolist(), SAID) for _ in range(times)]
    return sum((f.low or 0.0) <= truth <= (f.high or 0.0) for f in found) / times


def held_when_stopped(name: str, width: float, times: int, looked: Sequence[int], confidence: float) -> float:
    """How often the interval holds it at which the stop rule ends."""
    draw, truth, _ = SKEWED[name]
    chance = np.random.Generator(np.random.PCG64(round(10 * width)))
    hits = 0
    for _ in range(times):
        running, found = RunningMoments(), mean_of([], SAID)
        for number, value in enumerate(draw(chance, looked[-1]).tolist(), start=1):
            running.add(value)
            if number in looked:
                found = running.estimate(confidence)
                if found.width is not None and found.width < width:
                    break
        hits += (found.low or 0.0) <= truth <= (found.high or 0.0)
    return hits / times


@pytest.mark.parametrize("days", [20, 50])
@pytest.mark.parametrize("name", SKEWED)
def test_intervals_of_skewed_figures_hold_as_often_as_they_say(name: str, days: int) -> None:
    assert held(name, days, 1000) >= LEAST - error_of(1000)


@pytest.mark.nightly
@pytest.mark.parametrize("days", [20, 30, 50])
@pytest.mark.parametrize("name", SKEWED)
def test_they_do_at_night_more_exactly(name: str, days: int) -> None:
    assert held(name, days, 10_000) >= LEAST - error_of(10_000)


def test_without_the_correction_they_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RunningMoments, "_skewness", 0.0)
    assert held("knock-on, none on most days", 20, 1000) < 0.91


@pytest.mark.parametrize("name", SKEWED)
def test_intervals_hold_where_the_stop_rule_ends(name: str) -> None:
    all_looks = looks(30, 400)
    for width in SKEWED[name][2]:
        held_so_often = held_when_stopped(name, width, 300, all_looks, of_each_look(SAID, len(all_looks)))
        assert held_so_often >= LEAST - error_of(300)


RARE: tuple[Drawn, float, tuple[float, ...]] = (
    lambda chance, n: np.where(chance.random(n) < 0.95, 0.0, chance.exponential(310.0, n)),
    0.05 * 310.0,
    (100.0,),
)


def test_days_that_are_all_alike_end_no_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    """What comes on a day in 20 is on none of the first 20 days of a third of all sweeps (0.95^20 = 36 %).

    An interval from 0 to 0 there says that it never comes, and would hold the truth at most in the other two thirds.
    """
    monkeypatch.setitem(SKEWED, "rare", RARE)
    all_looks = looks(20, 400)
    assert held_when_stopped("rare", 100.0, 300, all_looks, of_each_look(SAID, len(all_looks))) > 0.85
    alike = mean_of([0.0] * 20, SAID)
    assert (alike.value, alike.low, alike.high, alike.apart_from_0) == (0.0, None, None, False)


@pytest.mark.parametrize(
    ("days", "said", "apart"),
    [(1, SAID, False), (5, SAID, False), (6, SAID, True), (7, 0.99, False), (8, 0.99, True)],
)
def test_a_difference_that_is_the_same_every_day_is_none_of_chance_from_six_days_on(
    days: int, said: float, apart: bool
) -> None:
    """Six equal signs of fair coins: 2 / 2^6, three in a hundred; eight: eight in a thousand."""
    assert difference_of([(0.0, 3.0)] * days, said).apart_from_0 is apart
    # 10.4 - 10.1 and 30.5 - 30.2 differ in the last bits of what they are stored in, and in nothing else.
    firsts = [10.1, 20.1, 30.2, 40.1, 50.1, 60.1, 70.2, 80.2]
    pairs = [(first, round(first + 0.3, 1)) for first in firsts[:days]]
    found = difference_of(pairs, said)
    assert (found.low, found.apart_from_0) == (None, apart)


def test_looked_at_every_day_at_the_same_confidence_they_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped when the scatter happens to look small, as it was before."""
    monkeypatch.setattr(RunningMoments, "_skewness", 0.0)
    assert held_when_stopped("knock-on, none on most days", 100.0, 300, range(30, 401), SAID) < 0.91


def test_looks_are_ever_further_apart() -> None:
    assert looks(30, 200) == (30, 45, 68, 102, 153, 200)
    assert looks(30, 30) == looks(50, 30) == (30,)
    assert of_each_look(0.95, 5) == pytest.approx(0.99)


@given(figures)
def test_what_both_have_drops_out_of_a_difference(values: list[float]) -> None:
    found = difference_of([(value, value + 3.0) for value in values], 0.95)
    assert found.value == pytest.approx(3.0)
    assert found.width is None or found.width < 1e-4
