"""Geometry against what circles, clothoids and straight lines are known to do."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.alignment import bearing_rad, curvature_per_m, positions
from network.model import Alignment, Curve, Gradient


def make(
    curves: Sequence[Curve] = (),
    *,
    length_m: float = 1000.0,
    bearing_deg: float = 0.0,
    gradients: Sequence[Gradient] = (),
) -> Alignment:
    return Alignment(
        id="a",
        from_m=0.0,
        to_m=length_m,
        x_m=10.0,
        y_m=20.0,
        bearing_deg=bearing_deg,
        elevation_m=100.0,
        gradients=tuple(gradients),
        curves=tuple(curves),
        limits=(),
        coverage=(),
    )


@pytest.mark.parametrize(
    ("bearing_deg", "east_m", "north_m"), [(0, 0, 500), (90, 500, 0), (180, 0, -500), (270, -500, 0)]
)
def test_straight_follows_the_compass(bearing_deg: float, east_m: float, north_m: float) -> None:
    point = positions(make(bearing_deg=bearing_deg), np.array([500.0]))[0]
    assert point == pytest.approx((10.0 + east_m, 20.0 + north_m, 100.0), abs=1e-9)


def test_half_circle_to_the_right_ends_a_diameter_to_the_east() -> None:
    radius_m = 300.0
    line = make([Curve(0.0, math.pi * radius_m, radius_m, 0.0, 0.0)], length_m=math.pi * radius_m)
    point = positions(line, np.array([math.pi * radius_m]))[0]
    assert point[:2] == pytest.approx((10.0 + 2 * radius_m, 20.0), abs=1e-6)


def test_curve_to_the_left_is_the_mirror_image() -> None:
    at_m = np.linspace(0.0, 1000.0, 57)
    right = positions(make([Curve(200.0, 800.0, 250.0, 60.0, 0.0)]), at_m)
    left = positions(make([Curve(200.0, 800.0, -250.0, 60.0, 0.0)]), at_m)
    assert left[:, 0] - 10.0 == pytest.approx(10.0 - right[:, 0], abs=1e-9)
    assert left[:, 1] == pytest.approx(right[:, 1], abs=1e-9)


def test_clothoid_against_its_power_series() -> None:
    # Fresnel integrals of a clothoid with parameter A^2 = R L: offset s^3 / (6 R L) with its next terms
    radius_m, length_m = 400.0, 60.0
    line = make([Curve(0.0, 500.0, radius_m, length_m, 0.0)])
    point = positions(line, np.array([length_m]))[0]
    turn = length_m / (2 * radius_m)
    ahead_m = length_m * (1 - turn**2 / 10 + turn**4 / 216)
    aside_m = length_m * (turn / 3 - turn**3 / 42 + turn**5 / 1320)
    assert point[0] - 10.0 == pytest.approx(aside_m, abs=1e-7)
    assert point[1] - 20.0 == pytest.approx(ahead_m, abs=1e-7)


def test_curvature_rises_linearly_and_is_zero_elsewhere() -> None:
    line = make([Curve(200.0, 500.0, -250.0, 50.0, 0.0)])
    expected = {0.0: 0.0, 200.0: 0.0, 225.0: -0.002, 250.0: -0.004, 450.0: -0.004, 490.0: -0.0008, 700.0: 0.0}
    for at_m, curvature in expected.items():
        assert curvature_per_m(line, at_m) == pytest.approx(curvature, abs=1e-12)


def test_transition_is_cut_to_half_of_its_curve() -> None:
    line = make([Curve(100.0, 180.0, 250.0, 500.0, 0.0)])
    assert curvature_per_m(line, 140.0) == pytest.approx(1 / 250.0)
    assert float(bearing_rad(line, np.array([900.0]))[0]) == pytest.approx(40.0 / 250.0)


def test_elevation_follows_the_gradients() -> None:
    line = make(gradients=[Gradient(0.0, 400.0, 25.0), Gradient(400.0, 1000.0, -10.0)])
    elevation = positions(line, np.array([0.0, 200.0, 400.0, 1000.0]))[:, 2]
    assert elevation == pytest.approx([100.0, 105.0, 110.0, 104.0])


def test_order_of_kilometrages_does_not_matter_and_none_is_empty() -> None:
    line = make([Curve(100.0, 700.0, 300.0, 50.0, 0.0)])
    at_m = np.array([999.0, 0.3, 512.7, 512.7])
    assert positions(line, at_m) == pytest.approx(positions(line, at_m[::-1])[::-1])
    assert positions(line, np.array([])).shape == (0, 3)


@pytest.mark.parametrize("outside_m", [-0.01, 1000.01, math.inf])
def test_outside_is_refused(outside_m: float) -> None:
    with pytest.raises(ValueError, match="kilometrage outside"):
        positions(make(), np.array([outside_m]))


curve_lists = st.lists(
    st.tuples(st.floats(20.0, 400.0), st.floats(160.0, 3000.0), st.booleans(), st.floats(0.0, 60.0)),
    max_size=5,
)


def _placed(rows: Sequence[tuple[float, float, bool, float]]) -> Alignment:
    curves, at_m = [], 50.0
    for length_m, radius_m, right, transition_m in rows:
        curves.append(
            Curve(
                at_m, at_m + length_m, radius_m if right else -radius_m, min(transition_m, length_m / 2), 0.0
            )
        )
        at_m += length_m + 30.0
    return make(curves, length_m=at_m + 50.0, bearing_deg=77.0)


def test_an_offset_lies_to_the_right_of_the_way_down() -> None:
    """Going north, to the east; going east, to the south."""
    for bearing_deg, moved in ((0.0, (2.0, 0.0)), (90.0, (0.0, -2.0))):
        line, at_m = make(bearing_deg=bearing_deg), np.array([500.0])
        beside = positions(line, at_m, 2.0) - positions(line, at_m)
        assert beside[0, :2] == pytest.approx(moved, abs=1e-9)


@given(curve_lists, st.floats(-6.0, 6.0))
def test_offset_is_kept_and_steps_have_their_length(
    rows: list[tuple[float, float, bool, float]], offset_m: float
) -> None:
    line = _placed(rows)
    at_m = np.arange(0.0, line.to_m, 0.7)
    axis, beside = positions(line, at_m), positions(line, at_m, offset_m)
    assert np.hypot(*(beside - axis)[:, :2].T) == pytest.approx(abs(offset_m), abs=1e-9)
    # a chord is shorter than its arc by s^3 / (24 R^2) only
    assert np.hypot(*np.diff(axis, axis=0)[:, :2].T) == pytest.approx(0.7, abs=1e-6)


@given(curve_lists)
def test_the_whole_turn_is_the_sum_of_the_deflections(rows: list[tuple[float, float, bool, float]]) -> None:
    line = _placed(rows)
    turned = float(np.diff(bearing_rad(line, np.array([0.0, line.to_m])))[0])
    assert turned == pytest.approx(
        sum((c.to_m - c.from_m - c.transition_m) / c.radius_m for c in line.curves), abs=1e-9
    )
