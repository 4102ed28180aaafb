"""A tachometer that shows what no train can do is found out by the unit itself (Sugiyama, table 5)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.tachometer import TACHOMETER_DOUBT_S, locate
from onboard.records import EVENT_TACHOMETER, UNIT
from vehicle.train_file import load_train, shipped_train

STEP_S = 0.1
TRAIN = load_train(shipped_train("ev_e301")).row.view(np.recarray)[0]
EMERGENCY_MPS2 = 1.25  # of the train file


def shown(unit: np.recarray, *speeds_mps: float) -> list[bool]:
    """Whether each reading is reported."""
    found = []
    for speed in speeds_mps:
        events = locate(unit, TRAIN, float(unit.odometer_m) + speed * STEP_S, speed, STEP_S)
        found.append(bool(events & EVENT_TACHOMETER))
    return found


@pytest.mark.parametrize("before_mps", [1.5, 5.0, 20.0])
def test_output_that_is_gone_at_once_is_reported_at_once(unit: np.recarray, before_mps: float) -> None:
    unit.speed_mps = before_mps
    assert shown(unit, 0.0) == [True]


def test_output_that_comes_from_nowhere_is_reported(unit: np.recarray) -> None:
    assert shown(unit, 10.0) == [True]


def test_motors_that_pull_without_a_pulse_are_reported_once_after_some_seconds(unit: np.recarray) -> None:
    unit.notch = 3.0
    found = shown(unit, *[0.0] * 100)
    assert sum(found) == 1
    assert (found.index(True) + 1) * STEP_S == pytest.approx(TACHOMETER_DOUBT_S, abs=2 * STEP_S)


def test_a_speed_that_does_not_answer_the_brake_is_reported(unit: np.recarray) -> None:
    unit.speed_mps = 10.0
    unit.notch = -TRAIN.brake_notches
    assert sum(shown(unit, *[10.0] * 60)) == 1


@pytest.mark.parametrize("notch", [1.0, 5.0])
@pytest.mark.parametrize("stuck_mps", [0.3, 3.6, 18.0])
def test_a_speed_that_stays_the_same_under_power_is_reported_once(
    unit: np.recarray, stuck_mps: float, notch: float
) -> None:
    unit.speed_mps, unit.notch = stuck_mps, notch
    found = shown(unit, *[stuck_mps] * 100)
    assert sum(found) == 1
    assert (found.index(True) + 1) * STEP_S == pytest.approx(TACHOMETER_DOUBT_S, abs=2 * STEP_S)


def test_a_train_that_hardly_gains_speed_under_full_power_is_no_fault(unit: np.recarray) -> None:
    unit.speed_mps, unit.notch = 18.0, TRAIN.power_notches
    assert not any(shown(unit, *(18.0 + 1e-6 * i for i in range(1, 600))))


def test_standing_with_the_brakes_applied_is_no_fault(unit: np.recarray) -> None:
    unit.notch = -TRAIN.brake_notches
    assert not any(shown(unit, *[0.0] * 600))


@given(st.floats(3.0, 25.0), st.floats(0.3, EMERGENCY_MPS2))
def test_no_braking_to_a_stand_is_taken_for_a_fault(speed_mps: float, deceleration_mps2: float) -> None:
    unit = np.zeros(1, dtype=UNIT).view(np.recarray)[0]
    unit.odometer_scale, unit.speed_mps, unit.emergency = 1.0, speed_mps, 1
    steps = int(speed_mps / (deceleration_mps2 * STEP_S)) + 10
    falling = [max(speed_mps - deceleration_mps2 * STEP_S * i, 0.0) for i in range(steps)]
    assert not any(shown(unit, *falling))


@given(st.floats(4.0, 25.0))
def test_a_slide_within_the_protection_is_no_fault_and_widens_the_bound_ahead(speed_mps: float) -> None:
    unit = np.zeros(1, dtype=UNIT).view(np.recarray)[0]
    unit.odometer_scale, unit.speed_mps, unit.notch, unit.wheel_slide = 1.0, speed_mps, -7.0, -1
    wheel_mps = (1.0 - TRAIN.wheel_slide_share_max) * speed_mps
    found = shown(unit, *[wheel_mps] * 10)
    assert not any(found)
    run_behind_m = (speed_mps - wheel_mps) * 10 * STEP_S  # what the wheel has not counted
    assert unit.bound_ahead_m >= run_behind_m - 1e-9
    assert unit.bound_behind_m == pytest.approx(0.0)
