from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from onboard.driving.pattern import braking_curve, limit_for_length, mean_over_length, pattern_of
from onboard.records import BehaviourRow
from tests.rows import Rows
from vehicle.records import TrainRow

GRAVITY_SHARE_MPS2 = 9.81 / 1.08


@pytest.mark.parametrize("permille", [0.0, 25.0, -25.0])
def test_half_the_square_of_the_speed_falls_by_the_deceleration_per_metre(permille: float) -> None:
    """By hand: 200 m before a limit of 10 m/s with 0.8 m/s2 on the level it is sqrt(100 + 320) m/s."""
    limits = np.full(400, 30.0)
    limits[300:] = 10.0
    elevation_m = np.arange(400.0) * permille / 1000.0
    curve = braking_curve(limits, elevation_m, 0.8, GRAVITY_SHARE_MPS2)
    deceleration = 0.8 + GRAVITY_SHARE_MPS2 * permille / 1000.0
    assert curve[100] == pytest.approx(np.sqrt(100.0 + 2.0 * deceleration * 200.0))
    if permille == 0.0:
        assert curve[100] == pytest.approx(420.0**0.5)
    assert np.diff(curve[100:301] ** 2 / 2.0) == pytest.approx(-deceleration)


def test_a_descent_that_outweighs_the_brake_is_taken_at_the_lower_limit() -> None:
    limits = np.full(100, 30.0)
    limits[60:] = 10.0
    elevation_m = np.arange(100.0) * -0.1
    assert braking_curve(limits, elevation_m, 0.8, GRAVITY_SHARE_MPS2)[:60] == pytest.approx(10.0)


@given(hnp.arrays(np.float64, 60, elements=st.floats(1.0, 30.0)), st.floats(0.1, 1.2))
def test_the_curve_is_the_highest_one_that_meets_every_later_limit(
    limits: np.ndarray, deceleration_mps2: float
) -> None:
    curve = braking_curve(limits, np.zeros(60), deceleration_mps2, GRAVITY_SHARE_MPS2)
    metres = np.arange(60)
    for i in range(60):
        later = np.sqrt(limits[i:] ** 2 + 2.0 * deceleration_mps2 * (metres[i:] - i))
        assert curve[i] == pytest.approx(later.min())


@given(hnp.arrays(np.float64, 120, elements=st.floats(1.0, 30.0)), st.floats(1.0, 60.0))
def test_the_whole_train_obeys_a_limit(limits: np.ndarray, length_m: float) -> None:
    whole = limit_for_length(limits, length_m)
    back = int(np.ceil(length_m))
    expected = [limits[max(i - back, 0) : i + 1].min() for i in range(limits.size)]
    assert whole == pytest.approx(expected)


def test_a_train_of_40_m_leaves_a_limit_with_its_rear() -> None:
    limits = np.full(200, 20.0)
    limits[50:61] = 10.0
    whole = limit_for_length(limits, 40.0)
    assert np.flatnonzero(whole == 10.0)[[0, -1]].tolist() == [50, 100]


def test_mean_elevation_under_the_train() -> None:
    """On a steady slope the mean is that of the train's middle; at a vertex it follows the body, not the front."""
    slope = np.arange(200.0) * 0.02
    assert mean_over_length(slope, 40.0)[40:] == pytest.approx(slope[40:] - 0.4)
    vertex = np.maximum(100.0 - np.arange(300.0), 0.0) * 0.02  # down to 100 m, then level
    mean_m = mean_over_length(vertex, 40.0)
    assert mean_m[100] == pytest.approx(0.4)
    assert mean_m[120] == pytest.approx(0.1, abs=1e-3)  # half the train on the slope: a quarter of 0.4 m
    assert mean_m[140:] == pytest.approx(0.0)
    assert mean_over_length(np.full(50, 7.0), 40.0) == pytest.approx(7.0)


def test_the_path_database(train: TrainRow, behaviour: BehaviourRow) -> None:
    limits = np.full(600, 25.0)
    limits[500:] = 0.5
    rows = pattern_of(np.zeros(600), np.zeros(600), limits, train, behaviour)
    assert rows["permitted_mps"][0] == pytest.approx(25.0)
    assert rows["permitted_mps"][400] == pytest.approx(np.sqrt(0.25 + 2 * 0.8 * 100.0))
    assert rows["driving_mps"][400] == pytest.approx(np.sqrt(0.25**2 + 2 * 0.6 * 100.0))
    assert rows["driving_mps"].min() == 0.25  # never so low that the train stands before its stop
    assert np.all(rows["driving_mps"] < rows["permitted_mps"])


def test_never_faster_than_the_train_may_run(track: Callable[..., Rows], train: TrainRow) -> None:
    assert track(np.zeros(100), 50.0)["permitted_mps"].max() == pytest.approx(train.speed_max_mps)


def test_curves_are_a_climb_for_driving_and_none_for_supervision(
    train: TrainRow, behaviour: BehaviourRow
) -> None:
    """A turn of one radian costs 600 m * 1 rad / 1000 = 0.6 m; nothing is braked later for it."""
    limits, turn_rad = np.full(600, 20.0), np.linspace(0.0, 1.0, 600)
    limits[400:] = 5.0
    curved = pattern_of(np.zeros(600), turn_rad, limits, train, behaviour)
    straight = pattern_of(np.zeros(600), np.zeros(600), limits, train, behaviour)
    assert curved["climb_m"][-1] == pytest.approx(0.6)
    for name in ("permitted_mps", "driving_mps", "body_elevation_m"):
        assert np.array_equal(curved[name], straight[name])
