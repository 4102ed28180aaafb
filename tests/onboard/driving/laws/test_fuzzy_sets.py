"""Fuzzy sets of Yasunobu and others, 5.1: at the points by which the paper tells their shapes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.driving.laws.fuzzy_sets import (
    comfortable,
    dangerous,
    falling,
    in_free_zone,
    in_stop_zone,
    peaked,
    rising,
    runs_exactly,
    runs_slowly,
    runs_well,
    safe,
    saves,
    stops_exactly,
    stops_well,
)

A = 3.0
figure = st.floats(-1e3, 1e3)
width = st.floats(-100.0, 100.0)


@pytest.mark.parametrize(
    ("x", "b", "grade"),
    [
        (A, 2.0, 1.0),
        (A + 50.0, 2.0, 1.0),
        (A - 2.0, 2.0, 0.5),
        (A - 6.0, 2.0, 0.25),
        (A, -2.0, 1.0),
        (A + 50.0, -2.0, 1.0),
        (A - 2.0, -2.0, 0.5),
        (A - 3.0, -2.0, 0.25),
        (A - 4.0, -2.0, 0.0),
        (A - 4.1, -2.0, 0.0),
        (A - 1e-9, 0.0, 0.0),
        (A, 0.0, 1.0),
    ],
)
def test_a_is_told_by_its_points_for_both_signs_of_b(x: float, b: float, grade: float) -> None:
    assert rising(x, A, b) == pytest.approx(grade, abs=1e-9)
    assert falling(2.0 * A - x, A, b) == pytest.approx(grade, abs=1e-9)


@given(figure, figure, figure, width)
def test_a_rises_b_falls_and_grades_lie_between_0_and_1(x: float, y: float, a: float, b: float) -> None:
    low, high = sorted((x, y))
    assert 0.0 <= rising(low, a, b) <= rising(high, a, b) <= 1.0
    assert 1.0 >= falling(low, a, b) >= falling(high, a, b) >= 0.0


@given(figure, figure, st.floats(0.1, 50.0), st.floats(0.1, 50.0))
def test_c_is_the_lesser_of_both(x: float, a: float, apart: float, b: float) -> None:
    assert peaked(x, a, b, a + apart, b) == min(rising(x, a, b), falling(x, a + apart, b))
    assert peaked(a + apart / 2.0, a, b, a + apart, b) == 1.0


@pytest.mark.parametrize("x", [-3.0, -1.0, 0.0, 0.4, 2.0, 5.0])
def test_zones_before_and_behind_the_brake_point_share_every_place(x: float) -> None:
    assert in_stop_zone(x, 1.0) + in_free_zone(x, 1.0) == pytest.approx(1.0)


def test_indices_at_the_points_that_the_paper_names() -> None:
    assert [dangerous(t, 2.0) for t in (-2.0, 0.0, 2.0)] == [1.0, 0.5, 0.0]
    assert [safe(t, 2.0) for t in (0.0, -2.0, -4.0)] == [1.0, 0.5, 0.0]
    assert [saves(x, 100.0, 50.0) for x in (100.0, 150.0, 200.0)] == [1.0, 0.5, 0.0]
    assert [runs_well(20.0 + v, 20.0, 0.5) for v in (-0.5, 0.5, 1.0, -1.0)] == [1.0, 1.0, 0.5, 0.5]
    assert [runs_exactly(20.0 + v, 20.0, 0.5) for v in (0.0, 0.5, -0.5, -1.5)] == [1.0, 0.5, 0.5, 0.25]
    assert [runs_slowly(v, 20.0) for v in (0.0, 10.0, 15.0)] == [1.0, 1.0, 0.5]
    assert [stops_well(m, 0.2) for m in (-0.2, 0.0, 0.2, 0.4)] == pytest.approx([1.0, 1.0, 1.0, 0.5])
    assert [stops_exactly(m, 0.2) for m in (0.0, -0.2, 0.6)] == pytest.approx([1.0, 0.5, 0.25])


@given(st.floats(0.0, 10.0), st.integers(1, 7))
def test_the_greater_change_is_never_the_more_comfortable_one(held_s: float, change: int) -> None:
    assert comfortable(held_s, change + 1.0, 0.5) <= comfortable(held_s, float(change), 0.5)
    assert comfortable(float(change), float(change), 0.5) == 1.0
    assert comfortable(0.5 * change, float(change), 0.5) == pytest.approx(0.5)
