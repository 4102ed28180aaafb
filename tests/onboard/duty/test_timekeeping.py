from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.duty.timekeeping import CRUISE_MIN_KMH, STEP_MPS, cruise_for
from tests.rows import Rows
from vehicle.records import TrainRow
from vehicle.running_time import predicted_run

LEG_M = 2000.0


@given(available_s=st.floats(60.0, 400.0), load_share=st.floats(0.0, 1.0), permille=st.floats(-10.0, 10.0))
def test_the_lowest_speed_that_is_in_time(
    train: TrainRow, track: Callable[..., Rows], available_s: float, load_share: float, permille: float
) -> None:
    path = track(np.arange(2500) * permille / 1000.0)
    elevation_m = np.ascontiguousarray(path["climb_m"])
    driving_mps = np.ascontiguousarray(path["driving_mps"])

    def time_s(cruise_mps: float) -> float:
        return predicted_run(
            train, load_share, elevation_m, driving_mps, 50.0, 50.0 + LEG_M, cruise_mps, 0.6, 1.0
        )[0]

    cruise_mps = cruise_for(train, load_share, elevation_m, driving_mps, 50.0, 50.0 + LEG_M, available_s, 0.6)
    at_least = CRUISE_MIN_KMH / 3.6
    assert at_least - 1e-9 <= cruise_mps <= driving_mps.max() + STEP_MPS
    if cruise_mps < driving_mps.max():
        assert time_s(cruise_mps) <= available_s
    if cruise_mps > at_least + 1e-9:
        assert time_s(cruise_mps - STEP_MPS) > available_s


def test_by_hand(train: TrainRow, track: Callable[..., Rows]) -> None:
    """2000 m in 180 s: 2000/v + v/2a + v/1.2 = 180, braking with 0.6 m/s2.

    The train accelerates with 0.55 m/s2 at first and 0.33 m/s2 with 380 kW at 13 m/s: v is 12.65 to 13.5 m/s.
    """
    path = track(np.zeros(2500))
    cruise_mps = cruise_for(
        train, 0.2, np.zeros(2500), np.ascontiguousarray(path["driving_mps"]), 50.0, 2050.0, 180.0, 0.6
    )
    assert 12.6 <= cruise_mps <= 13.5


def test_too_little_time_means_the_lines_limit(train: TrainRow, track: Callable[..., Rows]) -> None:
    driving_mps = np.ascontiguousarray(track(np.zeros(2500))["driving_mps"])
    for available_s in (30.0, 0.0, -100.0):
        cruise_mps = cruise_for(train, 0.2, np.zeros(2500), driving_mps, 50.0, 2050.0, available_s, 0.6)
        assert cruise_mps == pytest.approx(driving_mps.max(), abs=STEP_MPS)


def test_a_train_under_way_needs_less(train: TrainRow, track: Callable[..., Rows]) -> None:
    driving_mps = np.ascontiguousarray(track(np.zeros(2500))["driving_mps"])
    from_rest, rolling = (
        cruise_for(train, 0.2, np.zeros(2500), driving_mps, 50.0, 2050.0, 180.0, 0.6, initial_mps)
        for initial_mps in (0.0, 12.0)
    )
    assert rolling < from_rest
