"""The curve of a hop through a few solutions: convex, between tangents and chords, with its price."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle.optimum.journey import ProvenHop, dual_j
from vehicle.optimum.pareto import HopCurve, ParetoPoint, curve_of

POINTS = st.lists(
    st.tuples(st.floats(50.0, 500.0), st.floats(1e5, 1e7), st.floats(0.0, 1e6)).map(
        lambda p: ParetoPoint(*p)
    ),
    min_size=1,
    max_size=8,
)


def tangents_j(hop: HopCurve, time_s: float) -> float:
    """The lower estimate."""
    return max(p.energy_j - p.price_w * (time_s - p.time_s) for p in hop.points)


def chords_j(hop: HopCurve, time_s: float) -> float:
    """The upper estimate: a run that has that mean of two solutions is no dearer where the truth is convex."""
    return float(np.interp(time_s, [p.time_s for p in hop.points], [p.energy_j for p in hop.points]))


@given(POINTS, st.floats(0.0, 1.0))
def test_the_curve_lies_between_tangents_and_chords_and_falls_at_its_price(
    points: list[ParetoPoint], share: float
) -> None:
    hop = curve_of(points)
    time_s = hop.least_s + share * (hop.longest_s - hop.least_s)
    middle = hop.energy_j(time_s)
    slack_j = 1e-6 * hop.points[0].energy_j + 1e-3
    assert tangents_j(hop, time_s) - slack_j <= middle <= chords_j(hop, time_s) + slack_j
    later_s = time_s + 1e-3 * (hop.longest_s - time_s)
    fall = middle - hop.energy_j(later_s)
    low, high = hop.graph.prices_w(later_s)[0], hop.graph.prices_w(time_s)[1]
    assert low * (later_s - time_s) - slack_j <= fall <= high * (later_s - time_s) + slack_j


@given(POINTS)
def test_all_solutions_that_are_no_mean_of_others_are_on_the_curve(points: list[ParetoPoint]) -> None:
    hop = curve_of(points)
    for point in hop.points:
        assert hop.energy_j(point.time_s) == pytest.approx(point.energy_j, rel=1e-6, abs=1.0)
    cheapest = min(p.energy_j for p in points)
    assert hop.energy_j(1e6) == pytest.approx(cheapest, rel=1e-6, abs=1.0)
    for point in points:
        assert hop.energy_j(point.time_s) <= point.energy_j * (1.0 + 1e-6) + 1.0


def test_a_price_that_is_not_known_is_told_by_the_neighbours() -> None:
    times = ((100.0, 9.0), (110.0, 5.0), (130.0, 1.0))
    hop = curve_of(ParetoPoint(time_s, energy_j, math.nan) for time_s, energy_j in times)
    assert [point.price_w for point in hop.points] == pytest.approx([0.4, 0.3, 0.1])


def test_outside_of_what_can_be_run() -> None:
    points = [ParetoPoint(100.0, 5.0, 1.0), ParetoPoint(110.0, 1.0, 0.1)]
    assert curve_of(points).energy_j(99.0) == math.inf
    assert curve_of(points).energy_j(200.0) == pytest.approx(1.0)
    assert curve_of(points, may_wait=False).energy_j(200.0) == math.inf
    with pytest.raises(ValueError, match="at least one solution"):
        curve_of([])


@given(POINTS, st.floats(0.0, 2e6), st.floats(0.0, 600.0))
def test_the_dual_of_lines_is_below_every_run_above_them(
    points: list[ParetoPoint], price_w: float, time_s: float
) -> None:
    lines = [ParetoPoint(p.time_s, p.energy_j, p.price_w, p.energy_j) for p in points]
    least_j = max(p.energy_j - p.price_w * (time_s - p.time_s) for p in points)
    assert (
        dual_j(ProvenHop(tuple(lines)), price_w, 600.0)
        <= least_j + price_w * time_s + 1e-6 * (abs(least_j) + price_w * time_s) + 1.0
    )


def test_without_a_bound_nothing_is_proven() -> None:
    assert dual_j(ProvenHop((ParetoPoint(100.0, 5.0, 1.0),)), 1.0, 600.0) == -math.inf
