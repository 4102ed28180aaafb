"""TASC in the tick: the speed while wheels slide, the model fed with what was really issued, the waves."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.driving.stop_keeper import StopKeeper, fill_design
from onboard.driving.stopping import (
    LIMIT_MARGIN_M,
    WAVE_STEPS,
    ride_over_slide,
    stop_anew,
    stop_command_mps2,
    take_up_command,
)
from onboard.driving.tasc import StopVerdict, judge
from onboard.driving.tuning import OFFSET_STEP_MPS2, Learned
from onboard.records import EMERGENCY_INTERVENTION, EVENT_VERDICT, BehaviourRow, UnitRow
from vehicle.records import TrainRow

STEP_S = 0.1


@given(
    before_mps=st.floats(0.5, 25.0),
    share=st.floats(0.0, 0.3),
    slides=st.booleans(),
    built_mps2=st.floats(0.0, 1.0),
)
def test_the_estimate_moves_only_within_the_interval(
    unit: UnitRow,
    train: TrainRow,
    keeper: Callable[[], StopKeeper],
    before_mps: float,
    share: float,
    slides: bool,
    built_mps2: float,
) -> None:
    """The protection keeps the wheel within 30 % of the train (train file), so the train is within that of it."""
    tasc = keeper().tasc
    tasc.built_mps2 = built_mps2
    unit.train_mps = before_mps
    unit.speed_mps = before_mps * (1.0 - share if slides else 1.0 + share)
    unit.wheel_slide = -1 if slides else 1
    unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = 100.0, 5.0, 5.0
    run_m = unit.speed_mps * STEP_S
    ride_over_slide(unit, train, tasc, 0.0, run_m, STEP_S)
    low, high = sorted((unit.speed_mps, unit.speed_mps / 0.7 if slides else (unit.speed_mps - 1.0) / 1.3))
    assert max(low, 0.0) - 1e-9 <= unit.train_mps <= high + 1e-9
    assert unit.position_m + unit.bound_ahead_m == pytest.approx(105.0)
    assert unit.position_m - unit.bound_behind_m == pytest.approx(95.0)
    assert unit.position_m >= 100.0 if slides else unit.position_m <= 100.0


def test_wheels_that_roll_tell_the_speed(
    unit: UnitRow, train: TrainRow, keeper: Callable[[], StopKeeper]
) -> None:
    unit.odometer_scale, unit.speed_mps, unit.wheel_slide = 1.01, 10.0, 0
    ride_over_slide(unit, train, keeper().tasc, 0.0, 1.0, STEP_S)
    assert unit.train_mps == pytest.approx(10.1)


@pytest.mark.parametrize("state", [-1, 1])
def test_a_unit_that_believes_its_wheels_rides_over_nothing(
    unit: UnitRow, train: TrainRow, keeper: Callable[[], StopKeeper], state: int
) -> None:
    for believes in (0, 1):
        unit.train_mps, unit.speed_mps, unit.wheel_slide = 10.0, 10.0 + state, state
        unit.odometer_scale, unit.position_m, unit.believes_wheels = 1.0, 100.0, believes
        ride_over_slide(unit, train, keeper().tasc, 0.0, unit.speed_mps * STEP_S, STEP_S)
        assert bool(unit.position_m == 100.0) is bool(believes)
        assert bool(unit.train_mps == 10.0 + state) is bool(believes)


def test_the_model_takes_up_the_emergency_brake(
    unit: UnitRow, train: TrainRow, keeper: Callable[[], StopKeeper]
) -> None:
    kept = keeper()
    unit.notch, unit.emergency, unit.intervention = -train.brake_notches, 1, EMERGENCY_INTERVENTION
    take_up_command(unit, train, kept.tasc, kept.design, kept.wave, 0.0)
    expected = max(train.emergency_deceleration_mps2, 1.0)
    assert kept.tasc.pending_mps2[kept.tasc.head] == pytest.approx(expected)
    assert kept.wave.disturbed == 1


def test_a_verdict_is_told_once(unit: UnitRow, train: TrainRow, keeper: Callable[[], StopKeeper]) -> None:
    kept = keeper()
    judge(kept.tasc, int(StopVerdict.BRAKE_TOO_WEAK))
    events = [take_up_command(unit, train, kept.tasc, kept.design, kept.wave, 0.0) for _ in range(3)]
    assert events == [EVENT_VERDICT, 0, 0]
    assert StopVerdict(int(unit.stop_verdict)) is StopVerdict.BRAKE_TOO_WEAK


def test_a_mark_behind_the_limit_is_not_aimed_at(unit: UnitRow, keeper: Callable[[], StopKeeper]) -> None:
    """At 10 m/s and 0.6 m/s^2 83 m are needed: the mark leaves them, the limit less bound and margin does not."""
    kept = keeper()
    unit.train_mps, unit.position_m, unit.bound_ahead_m = 10.0, 0.0, 3.0
    unit.target_stop_m, unit.target_mps = 200.0, 10.0
    unit.stop_limit_m = np.inf
    assert stop_command_mps2(unit, kept.tasc, kept.design, 0.0) == 0.0
    unit.stop_limit_m = 85.0 + 3.0 + LIMIT_MARGIN_M
    assert stop_command_mps2(unit, kept.tasc, kept.design, 0.0) > 0.0
    assert unit.braking_to_stop == 1
    assert unit.target_mps <= 10.0


def test_a_new_target_frees_the_brake_and_the_verdict(
    unit: UnitRow, keeper: Callable[[], StopKeeper]
) -> None:
    kept = keeper()
    kept.tasc.braking = 1
    judge(kept.tasc, int(StopVerdict.TARGET_NOT_SEEN))
    unit.braking_to_stop = 0
    unit.train_mps, unit.position_m, unit.target_stop_m, unit.stop_limit_m = 10.0, 0.0, 2000.0, np.inf
    assert stop_command_mps2(unit, kept.tasc, kept.design, 0.0) == 0.0
    assert (kept.tasc.braking, kept.verdict()) == (0, StopVerdict.POSSIBLE)


def test_standing_forgets_the_stop(keeper: Callable[[], StopKeeper]) -> None:
    kept = keeper()
    kept.tasc.head, kept.tasc.braking, kept.wave.built_mps2 = 7, 1, 0.5
    stop_anew(kept.tasc, kept.wave)
    assert (kept.tasc.head, kept.tasc.braking, kept.wave.built_mps2) == (0, 0, 0.0)


def made_stop(
    unit: UnitRow, train: TrainRow, kept: StopKeeper, dead_steps: int, offset_mps2: float, own_mps2: float
) -> None:
    """Feed a stop from 15 m/s whose brake answers `dead_steps` late and gives `offset_mps2` more than asked for."""
    unit.train_mps, unit.notch = 15.0, 0.0
    commands = [0.0] * 40 + [-4.2] * 400
    built = 0.0
    share = 1.0 - np.exp(-STEP_S / train.brake_lag_s)
    for k, notch in enumerate(commands):
        kept.tasc.braking = 1 if notch < 0.0 else 0
        unit.notch = notch
        take_up_command(unit, train, kept.tasc, kept.design, kept.wave, own_mps2)
        asked = 0.6 + offset_mps2 if k >= dead_steps and commands[k - dead_steps] < 0.0 else 0.0
        built += share * (asked - built)
        unit.train_mps = max(unit.train_mps - (built + own_mps2) * STEP_S, 0.0)
        if unit.train_mps == 0.0:
            take_up_command(unit, train, kept.tasc, kept.design, kept.wave, own_mps2)
            return


@pytest.mark.parametrize(
    ("dead_steps", "offset_steps", "own_mps2"), [(5, 0, 0.0), (9, -3, 0.02), (2, 4, -0.05)]
)
def test_a_train_learns_its_own_brake(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    keeper: Callable[[], StopKeeper],
    dead_steps: int,
    offset_steps: int,
    own_mps2: float,
) -> None:
    """Notch 4.2 of seven even ones up to 1 m/s^2 is 0.6 m/s^2 (train file), the pattern's deceleration."""
    kept = keeper()
    kept.learns = True
    offset_mps2 = offset_steps * OFFSET_STEP_MPS2
    for _ in range(3):
        made_stop(unit, train, kept, dead_steps, offset_mps2, own_mps2)
        told = kept.learn_from_stop(train, behaviour, 0.2)
        assert told is not None
        assert told.left_out is None
        kept.wave.steps = 0
    assert kept.learned.stops == 3
    assert kept.design.dead_time_s == pytest.approx(dead_steps * STEP_S, abs=STEP_S + 1e-9)
    assert kept.design.offset_mps2 == pytest.approx(offset_mps2, abs=OFFSET_STEP_MPS2 + 1e-9)


def test_what_is_disturbed_teaches_nothing(
    unit: UnitRow, train: TrainRow, behaviour: BehaviourRow, keeper: Callable[[], StopKeeper]
) -> None:
    kept = keeper()
    kept.learns = True
    made_stop(unit, train, kept, 5, 0.0, 0.0)
    kept.wave.disturbed = 1
    told = kept.learn_from_stop(train, behaviour, 0.2)
    assert told is not None
    assert told.left_out == "slide"
    assert (kept.learned.stops, kept.learned.left_out, kept.last) == (0, 1, None)


def test_without_braking_there_is_no_record(keeper: Callable[[], StopKeeper]) -> None:
    assert keeper().record(0.0) is None


def test_a_record_is_as_long_as_the_ring_at_most(keeper: Callable[[], StopKeeper]) -> None:
    kept = keeper()
    kept.wave.steps, kept.wave.head = WAVE_STEPS, 3
    kept.wave.designed_mps2[3] = 0.6
    record = kept.record(0.0)
    assert record is not None
    assert record.designed_mps2.size == WAVE_STEPS
    assert record.designed_mps2[-1] == 0.6


def test_the_design_row_is_overlaid_with_what_was_learned(
    train: TrainRow, behaviour: BehaviourRow, keeper: Callable[[], StopKeeper]
) -> None:
    """EV-E301's file: dead time 0.5 s, lag 0.4 s, 3.6 km/h/s at the last notch."""
    kept = keeper()
    assert kept.design.dead_time_s == pytest.approx(0.5)
    assert kept.design.lag_s == pytest.approx(0.4)
    assert kept.design.brake_max_mps2 == pytest.approx(1.0)
    counts = [0] * 21
    counts[8] = 5
    learned = Learned("K1", 0.5, tuple(counts), tuple(counts))
    fill_design(kept.design, train, behaviour, learned)
    assert kept.design.dead_time_s == pytest.approx(0.8)
    assert kept.design.offset_mps2 == pytest.approx(-2 * OFFSET_STEP_MPS2)
