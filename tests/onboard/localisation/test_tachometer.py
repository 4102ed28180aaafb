import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.fix import TakenFix, take_interval
from onboard.localisation.tachometer import SURE_BRAKE_MPS2, calibrated_scale, locate
from onboard.localisation.tags import tag_fix
from onboard.records import EVENT_SAFE_REAR, EVENT_TAG_OVERDUE, UNIT, UnitRow
from tests.nightly import others_nightly
from vehicle.records import TrainRow

ACCURACY_M = 0.5
STEP_S = 0.1


def new_unit(growth: float = 0.02) -> UnitRow:
    row: UnitRow = np.zeros(1, dtype=UNIT).view(np.recarray)[0]
    row.position_known, row.odometer_scale, row.bound_growth = 1, 1.0, growth
    row.speed_mps = 20.0
    row.bound_ahead_m = row.bound_behind_m = ACCURACY_M
    row.expected_tag_m = row.rear_trigger_m = np.inf
    return row


@given(
    growth=st.floats(0.0, 0.05),
    shares=st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=40),
    run_m=st.floats(0.0, 200.0),
    start_error_m=st.floats(-ACCURACY_M, ACCURACY_M),
    tag_error_m=st.floats(-ACCURACY_M, ACCURACY_M),
)
def test_the_truth_lies_within_the_bounds_for_any_wheel_error_within_the_growth(
    train: TrainRow,
    growth: float,
    shares: list[float],
    run_m: float,
    start_error_m: float,
    tag_error_m: float,
) -> None:
    """The wheel errs by another share of the growth on every stretch; half way a tag is read, with an error."""
    unit = new_unit(growth)
    true_m, odometer_m = start_error_m, 0.0
    for index, share in enumerate(shares):
        odometer_m += run_m
        true_m += run_m * (1.0 + share * growth)
        locate(unit, train, odometer_m, 10.0, STEP_S)
        assert true_m <= unit.position_m + unit.bound_ahead_m + 1e-6
        assert true_m >= unit.position_m - unit.bound_behind_m - 1e-6
        if index == len(shares) // 2:
            take_interval(unit, tag_fix(unit, true_m, odometer_m + tag_error_m, ACCURACY_M))
            assert true_m <= unit.position_m + unit.bound_ahead_m + 1e-6
            assert true_m >= unit.position_m - unit.bound_behind_m - 1e-6


@given(runs_m=st.lists(st.floats(0.0, 50.0), min_size=2, max_size=20))
def test_bounds_only_grow_between_tags(train: TrainRow, runs_m: list[float]) -> None:
    unit = new_unit()
    odometer_m, before_m = 0.0, unit.bound_ahead_m
    for run_m in runs_m:
        odometer_m += run_m
        locate(unit, train, odometer_m, 10.0, STEP_S)
        assert unit.bound_ahead_m >= before_m
        before_m = unit.bound_ahead_m
    assert unit.bound_ahead_m == pytest.approx(ACCURACY_M + 0.02 * odometer_m)


def test_a_tag_read_a_while_ago_counts_with_what_was_run_since(train: TrainRow) -> None:
    unit = new_unit()
    locate(unit, train, 1000.0, 20.0, STEP_S)
    fix = tag_fix(unit, 983.0, 980.0, ACCURACY_M)
    assert fix.position_m == pytest.approx(983.0 + 20.0)
    assert fix.behind_m == fix.ahead_m == pytest.approx(ACCURACY_M + 0.02 * 20.0)


def test_a_way_between_two_readings_may_be_a_pulse_off(train: TrainRow) -> None:
    """Both readings are of whole pulses: 45 mm for a wheel of 860 mm and 60 pulses a turn."""
    unit = new_unit()
    unit.pulse_m = np.pi * 0.860 / 60
    locate(unit, train, 1000.0, 20.0, STEP_S)
    fix = tag_fix(unit, 983.0, 980.0, ACCURACY_M)
    assert fix.behind_m == fix.ahead_m == pytest.approx(ACCURACY_M + 0.0450 + 0.02 * 20.0, abs=1e-4)


@pytest.mark.parametrize(
    ("tag_m", "accepted"), [(1000.0, True), (1020.9, True), (1021.1, False), (979.1, True), (978.9, False)]
)
def test_a_tag_is_accepted_where_it_can_have_been_read(train: TrainRow, tag_m: float, accepted: bool) -> None:
    """After 1000 m the bound is 0.5 m + 20 m, and the tag itself is read to 0.5 m."""
    unit = new_unit()
    locate(unit, train, 1000.0, 20.0, STEP_S)
    assert isinstance(take_interval(unit, tag_fix(unit, tag_m, 1000.0, ACCURACY_M)), TakenFix) is accepted


def test_without_a_position_none_is_overdue(train: TrainRow) -> None:
    unit = new_unit()
    unit.position_known, unit.expected_tag_m, unit.rear_trigger_m = 0, 10.0, 20.0
    assert locate(unit, train, 500.0, 20.0, STEP_S) == 0


LOCKED = [(0.08, 8.0), *((adhesion, 20.0) for adhesion in (0.05, 0.08, 0.2))]


@pytest.mark.parametrize(("adhesion", "from_mps"), others_nightly(LOCKED, LOCKED[:1], columns=True))
def test_locked_wheels_let_the_bound_grow_with_time(
    train: TrainRow, adhesion: float, from_mps: float
) -> None:
    """The wheels lock at once and the train slides to a stand: v^2 / 2 a further on than they counted."""
    unit = new_unit(growth=0.0)
    unit.notch = -train.brake_notches
    locate(unit, train, 2.0, from_mps, STEP_S)
    slides_mps2 = adhesion * 9.80665 - 0.245  # down 25 permille
    true_m, speed_mps = 2.0, from_mps
    while speed_mps > 0.0:
        after_mps = max(speed_mps - slides_mps2 * STEP_S, 0.0)
        true_m += (speed_mps + after_mps) / 2.0 * STEP_S
        speed_mps, unit.wheel_slide = after_mps, -1
        locate(unit, train, 2.0, 0.0, STEP_S)
        assert true_m <= unit.position_m + unit.bound_ahead_m
    assert unit.bound_ahead_m >= from_mps**2 / (2.0 * slides_mps2)
    for _ in range(round(from_mps / SURE_BRAKE_MPS2 / STEP_S) + 100):  # until the train surely stands
        locate(unit, train, 2.0, 0.0, STEP_S)
    assert unit.bound_ahead_m == pytest.approx(ACCURACY_M + from_mps**2 / (2.0 * SURE_BRAKE_MPS2))


@pytest.mark.parametrize("gains_mps2", [0.6, 1.4, 4.0])
def test_locked_wheels_show_the_speed_only_once_they_roll(train: TrainRow, gains_mps2: float) -> None:
    """Both axles were locked, so the protection says that they roll, as the rail brings them back."""
    unit, train = new_unit(growth=0.0), train.copy()
    train.wheel_slide_share_max = 1.0
    true_m, shown_m, true_mps, shown_mps = 2.0, 2.0, 6.0, 0.0
    locate(unit, train, 2.0, true_mps, STEP_S)
    for step in range(200):
        unit.wheel_slide = -1 if step < 10 else 0
        if step >= 20:
            shown_mps = min(shown_mps + gains_mps2 * STEP_S, true_mps)
        true_m, shown_m = true_m + true_mps * STEP_S, shown_m + shown_mps * STEP_S
        locate(unit, train, shown_m, shown_mps, STEP_S)
        assert true_m <= unit.position_m + unit.bound_ahead_m + 1e-9
    ahead_m = unit.bound_ahead_m
    locate(unit, train, shown_m + true_mps * STEP_S, true_mps, STEP_S)
    assert unit.bound_ahead_m == ahead_m, "wheels that roll again tell all"


def test_wheels_that_come_to_rest_with_the_train_cost_millimetres(train: TrainRow) -> None:
    """A stop at 0.5 m/s^2: the last speed shown is 0.05 m/s."""
    unit = new_unit(growth=0.0)
    unit.notch = -4.0
    locate(unit, train, 0.005, 0.05, STEP_S)
    for _ in range(100):
        locate(unit, train, 0.005, 0.0, STEP_S)
    assert unit.bound_ahead_m - ACCURACY_M == pytest.approx(0.05**2 / (2.0 * SURE_BRAKE_MPS2), abs=1e-3)


def test_a_tag_is_overdue_once_the_front_is_surely_beyond_it(train: TrainRow) -> None:
    unit = new_unit()
    unit.expected_tag_m, unit.tag_window_m = 100.0, 5.0
    # Surely beyond: 0.98 * run - 0.5 m > 105 m.
    assert locate(unit, train, 107.6, 20.0, STEP_S) == 0
    assert locate(unit, train, 107.7, 20.0, STEP_S) == EVENT_TAG_OVERDUE
    assert locate(unit, train, 120.0, 20.0, STEP_S) == 0  # told once


def test_the_safe_rear_is_the_estimate_less_the_bound_less_the_length(train: TrainRow) -> None:
    unit = new_unit()
    unit.rear_trigger_m = 100.0  # 0.98 * run - 0.5 m - 40 m >= 100 m
    assert locate(unit, train, 143.3, 20.0, STEP_S) == 0
    assert locate(unit, train, 143.4, 20.0, STEP_S) == EVENT_SAFE_REAR
    assert locate(unit, train, 150.0, 20.0, STEP_S) == 0


def test_the_scale_is_used(train: TrainRow) -> None:
    unit = new_unit()
    unit.odometer_scale = 1.01
    locate(unit, train, 100.0, 20.0, STEP_S)
    assert unit.position_m == pytest.approx(101.0)


@given(true_scale=st.floats(0.99, 1.01), tags_m=st.lists(st.floats(200.0, 3000.0), min_size=12, max_size=12))
def test_calibration_approaches_the_true_scale(true_scale: float, tags_m: list[float]) -> None:
    scale = 1.0
    for between_m in tags_m:
        nearer = calibrated_scale(scale, between_m, between_m / true_scale, 0.015, ACCURACY_M)
        assert abs(nearer - true_scale) <= abs(scale - true_scale) + 1e-12
        scale = nearer
    assert abs(scale - true_scale) <= 0.25 * abs(1.0 - true_scale) + 1e-9


@given(
    previous=st.floats(0.985, 1.015),
    between_m=st.floats(0.1, 10_000.0),
    odometer_run_m=st.floats(-10.0, 20_000.0),
)
def test_calibration_never_leaves_what_worn_wheels_can_be(
    previous: float, between_m: float, odometer_run_m: float
) -> None:
    assert 0.985 <= calibrated_scale(previous, between_m, odometer_run_m, 0.015, ACCURACY_M) <= 1.015


def test_a_distance_that_no_wheel_explains_is_not_used() -> None:
    assert calibrated_scale(1.002, 1000.0, 1100.0, 0.015, ACCURACY_M) == 1.002  # it slid
    assert calibrated_scale(1.002, 1000.0, 0.0, 0.015, ACCURACY_M) == 1.002


@given(between_m=st.floats(2.0, 100.0), error_m=st.floats(-ACCURACY_M, ACCURACY_M))
def test_tags_close_together_say_little(between_m: float, error_m: float) -> None:
    """Half a metre must not pass for a wheel error: d / (d + 500 m) of 0.5 m / (d - 0.5 m) at the most."""
    assert abs(calibrated_scale(1.0, between_m, between_m + error_m, 0.015, ACCURACY_M) - 1.0) <= 1.4e-3
