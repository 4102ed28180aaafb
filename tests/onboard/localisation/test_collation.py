"""Equations (2) and (3): the sums, the least of them, and the interval that noise can explain."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.collation import all_squares, difference_sum, explained_shifts, least_shift

COUNT, SPAN = 300, 60


def alignment(rng: np.random.Generator, metres: int) -> np.ndarray:
    """Curvature of curves with clothoids between straights, as laid by chance, 1/m."""
    breaks, values = [0.0], [0.0]
    while breaks[-1] < metres:
        straight, ramp, arc = rng.uniform(20, 150), rng.uniform(25, 60), rng.uniform(20, 150)
        bend = rng.choice([-1.0, 1.0]) / rng.uniform(200.0, 800.0)
        for length, value in ((straight, 0.0), (ramp, bend), (arc, bend), (ramp, 0.0)):
            breaks.append(breaks[-1] + length)
            values.append(value)
    return np.interp(np.arange(float(metres)), breaks, values)


def summed(known: np.ndarray, seen: np.ndarray) -> tuple[int, np.ndarray]:
    energy, free = np.zeros(SPAN + 1), np.zeros(SPAN + 1)
    return all_squares(known, seen, 0, COUNT, SPAN, energy, free), free


def test_the_sums_are_those_of_the_paper() -> None:
    rng = np.random.default_rng(1)
    known, seen = rng.normal(size=COUNT + SPAN), rng.normal(size=COUNT + 7)
    for shift, begin, count in ((0, 0, COUNT), (13, 7, 99), (SPAN, 3, 1)):
        away = known[shift : shift + count] - seen[begin : begin + count]
        assert difference_sum(known, shift, seen, begin, count, 0.0) == pytest.approx(np.abs(away).sum())
        assert difference_sum(known, shift, seen, begin, count, 0.2) == pytest.approx(
            np.abs(away - 0.2).sum()
        )
        energy, free = np.zeros(SPAN + 1), np.zeros(SPAN + 1)
        least = all_squares(known, seen, begin, count, SPAN, energy, free)
        assert energy[shift] == pytest.approx((away**2).sum())
        assert free[shift] == pytest.approx(((away - away.mean()) ** 2).sum(), abs=1e-9)
        assert least == int(np.argmin(free))


@given(st.integers(0, 2**32 - 1), st.floats(5.0, SPAN - 5.0))
def test_the_least_is_where_the_run_was_also_between_metres(seed: int, shift: float) -> None:
    known = alignment(np.random.default_rng(seed), COUNT + SPAN)
    seen = np.interp(np.arange(float(COUNT)) + shift, np.arange(float(known.size)), known)
    least, _ = summed(known, seen)
    found = least_shift(known, seen, 0, COUNT, 0, SPAN, 0.0, np.zeros(SPAN + 1))
    assert abs(least - shift) <= 1.0 and abs(found - shift) <= 0.5


@given(st.integers(0, 2**32 - 1))
def test_a_constant_difference_moves_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    known = alignment(rng, COUNT + SPAN)
    seen = known[30 : 30 + COUNT] + rng.normal(0.0, 1e-5, COUNT)
    plain, with_bias = summed(known, seen), summed(known, seen + 3e-4)
    assert plain[0] == with_bias[0] and np.allclose(plain[1], with_bias[1], atol=1e-12)


@given(st.integers(0, 2**32 - 1), st.floats(1e-5, 3e-4))
def test_the_hull_holds_the_truth_whatever_line_and_noise(seed: int, sigma: float) -> None:
    rng = np.random.default_rng(seed)
    known = alignment(rng, COUNT + SPAN)
    truth = int(rng.integers(3, SPAN - 3))
    seen = known[truth : truth + COUNT] + rng.normal(0.0, sigma, COUNT)
    least, free = summed(known, seen)
    limit = free[least] + (5.0 * sigma) ** 2
    low, high = explained_shifts(free, SPAN, least, 8, limit, limit)
    assert low <= truth <= high


def test_without_room_for_noise_the_hull_misses() -> None:
    missed = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        known = alignment(rng, COUNT + SPAN)
        seen = known[30 : 30 + COUNT] + rng.normal(0.0, 3e-4, COUNT)
        least, free = summed(known, seen)
        low, high = explained_shifts(free, SPAN, least, 8, free[least], free[least])
        missed += not low <= 30 <= high
    assert missed > 10


def test_curves_that_look_alike_give_a_wide_hull() -> None:
    one = 3e-3 * np.clip(10.0 - np.abs(np.arange(40.0) - 20.0), 0.0, 5.0) / 5.0
    known = np.tile(one, 10)
    seen = known[20 : 20 + COUNT]
    least, free = summed(known, seen)
    low, high = explained_shifts(free, SPAN, least, 8, free[least] + 1e-9, free[least] + 1e-9)
    assert low <= 20 and high >= 60 - 1e-9
