"""A plan laid metre by metre: speeds, times and modes of a profile worked out by hand."""

import numpy as np
import pytest

from onboard.driving.laws.cue import PLAN_COAST, PLAN_FOLLOW, PLAN_HOLD, PLAN_NONE
from onboard.driving.planner.plan import plan_rows
from vehicle.optimum import Profile

RIM_MPS2 = np.array([1.0, 0.1, 0.0, -0.4])


@pytest.fixture
def by_hand() -> Profile:
    """50 m at 1 m/s^2, 100 m at 10 m/s, 75 m of coasting at 0.5 m/s^2, a stop at 0.5 m/s^2 from 5 m/s in 25 m."""
    return Profile(
        np.array([100.5, 150.5, 250.5, 325.5, 350.5]),
        np.array([0.0, 10.0, 10.0, 5.0, 0.0]),
        np.array([0.0, 10.0, 20.0, 30.0, 40.0]),
    )


def test_the_running_time_is_the_sum_of_its_parts(by_hand: Profile) -> None:
    laid = plan_rows(by_hand, RIM_MPS2, 400)
    assert laid.takes_s == pytest.approx(10.0 + 10.0 + 10.0 + 10.0)


def test_each_metre_has_the_speed_and_the_time_of_its_place(by_hand: Profile) -> None:
    rows = plan_rows(by_hand, RIM_MPS2, 400).rows
    assert rows["speed_mps"][125] == pytest.approx(np.sqrt(2.0 * 24.5))
    assert rows["time_left_s"][125] == pytest.approx(40.0 - np.sqrt(2.0 * 24.5))
    assert rows["speed_mps"][200] == pytest.approx(10.0)
    assert rows["time_left_s"][200] == pytest.approx(20.0 + 50.5 / 10.0)
    assert rows["speed_mps"][300] == pytest.approx(np.sqrt(100.0 - 49.5))
    assert rows["speed_mps"][350] == pytest.approx(np.sqrt(2.0 * 0.5 * 0.5))
    assert rows["time_left_s"][351] == pytest.approx(0.0)


def test_modes_tell_power_and_brake_from_holding_and_coasting(by_hand: Profile) -> None:
    rows = plan_rows(by_hand, RIM_MPS2, 400).rows
    modes = [int(rows["mode"][metre]) for metre in (101, 151, 251, 326)]
    assert modes == [PLAN_FOLLOW, PLAN_HOLD, PLAN_COAST, PLAN_FOLLOW]


def test_there_is_no_plan_outside_the_profile(by_hand: Profile) -> None:
    rows = plan_rows(by_hand, RIM_MPS2, 400).rows
    assert set(rows["mode"][:100].tolist()) == {PLAN_NONE}
    assert set(rows["mode"][352:].tolist()) == {PLAN_NONE}
    assert rows.size == 400
