import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from onboard.driving.stop_keeper import soft_end_s
from onboard.driving.tasc import (
    BRAKE_TOO_WEAK,
    DESIGN,
    LEAST_BRAKE_MPS2,
    TARGET_NOT_SEEN,
    TASC,
    WHOLE_LAW,
    DesignRow,
    StopLawPart,
    StopVerdict,
    TascRow,
    aim_m,
    command_mps2,
    corrected_command_mps2,
    expected_mps2,
    judge,
    pattern,
    pattern_demand_mps2,
    pattern_through,
    predicted_motion,
    reset,
    tasc_step,
)


def design(**changes: float) -> DesignRow:
    row = np.zeros(1, dtype=DESIGN)
    values = {
        "parts": int(WHOLE_LAW),
        "pattern_mps2": 0.8,
        "pattern_least_mps2": 0.4,
        "brake_max_mps2": 0.93,
        "command_jerk_mps3": 4.65,
        "end_mps2": 0.3,
        "end_jerk_mps3": 0.6,
        "gain_per_s": 0.6,
        "dead_time_s": 1.0,
        "correction_least_m": 0.05,
        "step_s": 0.1,
    }
    for name, value in (values | changes).items():
        row[name] = value
    record: DesignRow = row[0]
    return record


def fresh() -> NDArray[np.void]:
    return np.zeros(1, dtype=TASC)


def braking(pattern_mps2: float) -> np.void:
    """One that brakes by a pattern of this deceleration."""
    tasc: np.void = fresh()[0]
    tasc["braking"], tasc["pattern_mps2"] = 1, pattern_mps2
    return tasc


def test_the_rows_have_the_fields_that_the_laws_see() -> None:
    assert tuple(DesignRow.__annotations__) == DESIGN.names
    assert tuple(TascRow.__annotations__) == TASC.names


def test_it_aims_at_the_mark_or_before_a_nearer_limit() -> None:
    assert aim_m(50.0, 80.0, 5.0) == 50.0
    assert aim_m(50.0, 40.0, 5.0) == 35.0


def test_the_pattern_at_a_design_without_soft_end_is_the_square_root() -> None:
    speed, slope = pattern(design(end_mps2=0.8), 0.8, 100.0)
    assert speed == pytest.approx(math.sqrt(160.0))
    assert slope == 0.8


@given(distance_m=st.floats(1e-3, 400.0), deceleration=st.floats(0.35, 0.93))
def test_the_pattern_is_what_its_deceleration_makes_of_it(distance_m: float, deceleration: float) -> None:
    row = design()
    ahead, behind = distance_m * (1.0 - 1e-5), distance_m * (1.0 + 1e-5)
    lower, _ = pattern(row, deceleration, ahead)
    higher, _ = pattern(row, deceleration, behind)
    _, slope = pattern(row, deceleration, distance_m)
    # v dv/dx = b
    assert (higher**2 - lower**2) / 2.0 / (behind - ahead) == pytest.approx(slope, rel=1e-3)


def test_the_soft_end_falls_to_the_deceleration_left_at_rest() -> None:
    row = design()
    assert pattern(row, 0.8, 1e-9)[1] == pytest.approx(0.3, abs=1e-3)
    # (0.8 - 0.3) / 0.6 = 0.833 s of soft end: 0.3 T^2/2 + 0.6 T^3/6 = 0.162 m
    assert pattern(row, 0.8, 0.1621)[1] == pytest.approx(0.8, abs=2e-3)
    assert pattern(row, 0.8, 0.17)[1] == 0.8
    assert pattern(row, 0.8, -1.0) == (0.0, 0.3)


@given(deceleration=st.floats(0.41, 0.92), distance_m=st.floats(2.0, 300.0))
def test_a_pattern_drawn_through_a_state_is_the_one_it_came_from(
    deceleration: float, distance_m: float
) -> None:
    row = design()
    speed, _ = pattern(row, deceleration, distance_m)
    assert pattern_through(row, speed, distance_m) == pytest.approx(deceleration, abs=1e-6)


def test_a_state_too_slow_asks_for_release_and_one_too_fast_for_the_full_brake() -> None:
    assert pattern_through(design(), 3.0, 100.0) == 0.0
    assert pattern_through(design(), 10.0, 20.0) == 0.93


def test_prediction_runs_through_the_commands_under_way() -> None:
    tasc, row = fresh()[0], design(command_jerk_mps3=0.0)
    for _ in range(10):
        tasc["head"] = tasc["head"] + 1
        tasc["pending_mps2"][int(tasc["head"])] = 0.8
    speed, run_m = predicted_motion(tasc, row, 10.0, 0.0)
    # 1 s at 0.8 m/s^2: 10 - 0.8 m/s after 10 - 0.4 m
    assert speed == pytest.approx(9.2)
    assert run_m == pytest.approx(9.6)


def test_prediction_with_own_deceleration_stops_at_zero() -> None:
    speed, run_m = predicted_motion(fresh()[0], design(), 0.05, 0.1)
    assert speed == 0.0
    assert 0.0 < run_m <= 0.05


@given(demand=st.floats(0.0, 0.93), offset=st.floats(-0.25, 0.25))
def test_the_model_expects_of_a_corrected_command_what_was_demanded(demand: float, offset: float) -> None:
    row = design(offset_mps2=offset)
    command = corrected_command_mps2(row, demand)
    assert 0.0 <= command <= 0.93
    if command < 0.93:
        assert expected_mps2(row, command) == pytest.approx(demand, abs=1e-9)


def test_a_released_brake_has_no_bias() -> None:
    assert corrected_command_mps2(design(offset_mps2=-0.2), 0.0) == 0.0


def test_the_command_moves_by_the_jerk_limit() -> None:
    tasc, row = fresh()[0], design(command_jerk_mps3=1.0)
    commands = [command_mps2(tasc, row, 0.93) for _ in range(12)]
    assert np.diff([0.0, *commands]).max() == pytest.approx(0.1)
    assert commands[-1] == pytest.approx(0.93)


def test_the_model_brake_builds_up_after_the_dead_time() -> None:
    tasc, row = fresh()[0], design(command_jerk_mps3=10.0, dead_time_s=0.3)
    built = []
    for _ in range(5):
        command_mps2(tasc, row, 0.8)
        built.append(float(tasc["built_mps2"]))
    assert built == pytest.approx([0.0, 0.0, 0.0, 0.8, 0.8])


def test_no_brake_before_the_pattern_is_met() -> None:
    tasc = fresh()[0]
    assert pattern_demand_mps2(tasc, design(), 10.0, 200.0, 0.0, 0.0) == 0.0
    assert tasc["braking"] == 0
    # 10 m/s needs 62.5 m at 0.8 m/s^2, and 0.9 m to build up
    assert pattern_demand_mps2(tasc, design(), 10.0, 63.2, 0.0, 0.0) > 0.7
    assert tasc["braking"] == 1


@given(moved_m=st.floats(-6.0, 3.0))
def test_a_fix_changes_the_demand_no_more_than_the_new_distance_requires(moved_m: float) -> None:
    tasc, row = braking(0.8), design(gain_per_s=2.0)
    speed, _ = pattern(row, 0.8, 50.0)
    left_m = 50.0 - moved_m
    demand = pattern_demand_mps2(tasc, row, speed, left_m, 0.0, moved_m)
    assert tasc["braking"] == 1
    # constant deceleration over what is left, not a push by the gain
    expected = 0.8 if abs(moved_m) < 0.05 else speed**2 / 2.0 / left_m
    assert demand == pytest.approx(expected, abs=0.15 if abs(moved_m) < 0.05 else 0.02)


def test_a_mark_much_farther_than_believed_releases_the_brake() -> None:
    tasc, row = braking(0.8), design()
    assert pattern_demand_mps2(tasc, row, 4.0, 60.0, 0.0, -50.0) == 0.0
    assert tasc["braking"] == 0


def test_the_demand_never_lets_the_train_roll_at_the_mark() -> None:
    tasc = braking(0.8)
    downhill_mps2 = -0.1
    assert pattern_demand_mps2(tasc, design(), 0.0, 0.5, downhill_mps2, 0.0) >= 0.1 + LEAST_BRAKE_MPS2 - 1e-12


def test_integral_and_derivative_add_to_the_demand() -> None:
    demands = []
    for changes in ({}, {"integral_gain_per_s2": 0.5}, {"derivative_gain": 0.1}):
        tasc, row = braking(0.6), design(**changes)
        tasc["integral_m"] = 0.1
        speed = pattern(row, 0.6, 50.0)[0] + 0.05
        demands.append(pattern_demand_mps2(tasc, row, speed, 50.0, 0.0, 0.0))
    assert demands[0] == pytest.approx(0.6 + 0.6 * 0.05)
    assert demands[1] == pytest.approx(demands[0] + 0.05)
    assert demands[2] == pytest.approx(demands[0] + 0.1 * 0.05 / 0.1)


def without(part: StopLawPart, **changes: float) -> DesignRow:
    return design(parts=int(WHOLE_LAW & ~part), **changes)


def test_the_whole_law_has_every_part() -> None:
    assert StopLawPart(sum(StopLawPart)) == WHOLE_LAW


def test_without_prediction_it_decides_on_the_present_state() -> None:
    assert predicted_motion(fresh()[0], without(StopLawPart.PREDICTION), 10.0, 0.1) == (10.0, 0.0)
    assert predicted_motion(fresh()[0], design(), 10.0, 0.1)[0] < 10.0


def test_without_redrawing_a_fix_leaves_the_pattern_to_the_gain() -> None:
    row = without(StopLawPart.REDRAWING)
    tasc = braking(0.8)
    speed, _ = pattern(row, 0.8, 50.0)
    nearer_mps, _ = pattern(row, 0.8, 45.0)
    assert pattern_demand_mps2(tasc, row, speed, 45.0, 0.0, 5.0) == pytest.approx(
        0.8 + 0.6 * (speed - nearer_mps)
    )
    assert tasc["pattern_mps2"] == 0.8


def test_without_feed_forward_only_what_is_off_the_pattern_is_braked() -> None:
    row, tasc = without(StopLawPart.FEED_FORWARD), braking(0.8)
    speed, _ = pattern(row, 0.8, 50.0)
    assert pattern_demand_mps2(tasc, row, speed + 0.5, 50.0, 0.0, 0.0) == pytest.approx(0.6 * 0.5)


def test_without_resistance_the_demand_is_all_of_the_pattern() -> None:
    demands = []
    for row in (design(), without(StopLawPart.RESISTANCE)):
        tasc = braking(0.8)
        demands.append(pattern_demand_mps2(tasc, row, pattern(row, 0.8, 50.0)[0], 50.0, 0.05, 0.0))
    assert demands == pytest.approx([0.75, 0.8])


def test_without_the_soft_end_the_pattern_keeps_its_deceleration() -> None:
    row = without(StopLawPart.SOFT_END)
    assert pattern(row, 0.8, 1e-9)[1] == 0.8
    assert pattern(row, 0.8, 100.0)[0] == pytest.approx(math.sqrt(160.0))


def test_the_first_impossibility_stands() -> None:
    tasc = fresh()[0]
    judge(tasc, TARGET_NOT_SEEN)
    judge(tasc, BRAKE_TOO_WEAK)
    assert StopVerdict(int(tasc["verdict"])) is StopVerdict.TARGET_NOT_SEEN


def test_a_mark_too_near_is_told_at_once() -> None:
    tasc = fresh()[0]
    # 10 m/s over 1 s and 0.93 m/s^2 after it: 10 + 53.8 m
    tasc_step(tasc, design(), 10.0, 60.0, 0.0, 0.0)
    assert StopVerdict(int(tasc["verdict"])) is StopVerdict.BRAKE_TOO_WEAK
    reset(tasc)
    tasc_step(tasc, design(), 10.0, 65.0, 0.0, 0.0)
    assert StopVerdict(int(tasc["verdict"])) is StopVerdict.POSSIBLE


def test_reset_leaves_nothing_of_the_last_stop() -> None:
    rows = fresh()
    for name in TASC.names or ():
        rows[name] = 1
    reset(rows[0])
    assert rows.tobytes() == fresh().tobytes()


@pytest.mark.parametrize("pattern_mps2", [0.3, 0.6, 0.8])
def test_a_soft_end_costs_what_following_the_pattern_takes_longer(pattern_mps2: float) -> None:
    """Both from 20 m/s: along the pattern, summed up over distances, and evenly."""
    before_m = np.linspace(0.0, 20.0, 20_001)[1:] ** 2
    speeds_mps = np.array([pattern(design(), pattern_mps2, float(at_m))[0] for at_m in before_m])
    under = speeds_mps < 20.0
    steps_m = np.diff(before_m, prepend=0.0)
    times_s = 2.0 * steps_m / (speeds_mps + np.concatenate([[0.0], speeds_mps[:-1]]))
    longer_s = float(times_s[under].sum()) - float(speeds_mps[under][-1]) / pattern_mps2
    assert soft_end_s(pattern_mps2) == pytest.approx(longer_s, abs=0.005)
