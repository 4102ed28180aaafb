"""Automatic driving and the stop at the mark with the train's own dynamics; judged by properties, not by a course."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.board import BoardRow
from onboard.driving.laws.power import power_notch
from onboard.driving.pattern import pattern_of
from onboard.records import EMERGENCY_INTERVENTION, MODE_HOLD, BehaviourRow
from tests.nightly import A_FIFTH
from tests.onboard.drive_along import START_M, TRACK_M, drive_along
from tests.rows import Rows
from vehicle.records import TrainRow
from vehicle.traction import full_force_n

Boards = Callable[[], BoardRow]


@given(
    permille=st.floats(-20.0, 20.0),
    load_share=st.floats(0.0, 1.0),
    initial_mps=st.floats(5.0, 16.8),
    spare_m=st.floats(30.0, 400.0),
)
def test_it_stops_within_a_metre_of_the_mark(
    boards: Boards,
    track: Callable[..., Rows],
    permille: float,
    load_share: float,
    initial_mps: float,
    spare_m: float,
) -> None:
    board, path = boards(), track(np.arange(float(TRACK_M)) * permille / 1000.0)
    deceleration_mps2 = board.behaviour.settings.stop_deceleration_mps2
    stop_m = START_M + initial_mps**2 / (2.0 * deceleration_mps2) + 2.0 * initial_mps + spare_m
    board.unit.target_stop_m, board.unit.stop_limit_m = stop_m, stop_m + 20.0
    board.unit.cruise_mps = initial_mps
    course = drive_along(board, path, permille, load_share, initial_mps, 4000)
    assert course.speed_mps[-1] == 0.0
    assert abs(course.position_m[-1] - stop_m) < 1.0
    assert course.interventions == 0


@A_FIFTH
@given(permille=st.floats(-20.0, 20.0), load_share=st.floats(0.0, 1.0), cruise_mps=st.floats(6.0, 16.0))
def test_it_holds_its_speed_without_hunting(
    boards: Boards, track: Callable[..., Rows], permille: float, load_share: float, cruise_mps: float
) -> None:
    """From rest to the cruising speed and four minutes of it, as far as the train climbs at all."""
    board, path = boards(), track(np.arange(float(TRACK_M)) * permille / 1000.0)
    board.unit.cruise_mps = cruise_mps
    board.unit.notch = 0.0
    course = drive_along(board, path, permille, load_share, 0.0, 2400)
    speeds, notches = np.array(course.speed_mps), np.array(course.notch)
    inside = np.array(course.position_m) < TRACK_M - 100.0
    assert speeds[inside].max() <= cruise_mps + 0.5
    held = inside & (np.arange(speeds.size) > 1200)
    if held.any():
        assert speeds[held].min() >= cruise_mps - 1.0
    power = np.maximum(notches, 0.0)[inside]
    changes_at = np.flatnonzero(np.diff(power) != 0.0)
    minutes = inside.sum() / 600.0
    assert changes_at.size <= 16.0 * max(minutes, 1.0)
    used = np.sign(notches[inside])
    used = used[used != 0.0]
    assert np.count_nonzero(np.diff(used)) <= 2  # never to and fro between power and brake


def with_lower_limit(
    from_m: int, to_m: int, permille: float, train: TrainRow, behaviour: BehaviourRow
) -> Rows:
    """The path's rows: 18 m/s, and 8 m/s between two places."""
    elevation_m = np.arange(float(TRACK_M)) * permille / 1000.0
    limits_mps = np.full(TRACK_M, 18.0)
    limits_mps[from_m:to_m] = 8.0
    return pattern_of(elevation_m, np.zeros(elevation_m.size), limits_mps, train, behaviour).view(np.recarray)


@A_FIFTH
@given(permille=st.floats(-20.0, 20.0), load_share=st.floats(0.0, 1.0), bound_m=st.floats(0.5, 40.0))
def test_it_is_down_to_a_lower_limit_in_time(
    boards: Boards,
    train: TrainRow,
    behaviour: BehaviourRow,
    permille: float,
    load_share: float,
    bound_m: float,
) -> None:
    """However wide the bound: the driver keeps clear of the intervention."""
    board, path = boards(), with_lower_limit(1500, 1700, permille, train, behaviour)
    board.unit.bound_ahead_m, board.unit.bound_growth = bound_m, 0.0
    course = drive_along(board, path, permille, load_share, 15.0, 1800)
    for position_m, speed_mps in zip(course.position_m, course.speed_mps, strict=True):
        if 1500.0 <= position_m <= 1700.0 + train.length_m:
            assert speed_mps <= 8.0
    assert course.interventions == 0
    assert course.position_m[-1] > 1600.0


@A_FIFTH
@given(permille=st.floats(-20.0, 20.0), load_share=st.floats(0.0, 1.0), bound_m=st.floats(0.0, 60.0))
def test_it_speeds_up_again_when_its_rear_has_surely_left_the_limit(
    boards: Boards,
    train: TrainRow,
    behaviour: BehaviourRow,
    permille: float,
    load_share: float,
    bound_m: float,
) -> None:
    """It believes itself ahead by all of its bound; supervision has nothing to do, and it does not dawdle beyond."""
    board, path = boards(), with_lower_limit(1000, 1201, permille, train, behaviour)
    board.unit.position_m += bound_m
    board.unit.bound_ahead_m = board.unit.bound_behind_m = bound_m
    board.unit.bound_growth = 0.0
    course = drive_along(board, path, permille, load_share, 15.0, 3000)
    positions_m, speeds_mps = np.array(course.position_m), np.array(course.speed_mps)
    within = (positions_m > 1000.0) & (positions_m < 1200.0 + train.length_m)
    assert speeds_mps[within].max() <= 8.0
    assert course.interventions == 0
    beyond = positions_m > 1200.0 + train.length_m + 2.0
    assert min(np.array(course.target_mps)[beyond]) > 8.0


def test_a_standing_train_holds_its_brake(boards: Boards, track: Callable[..., Rows]) -> None:
    board = boards()
    board.unit.mode = MODE_HOLD
    course = drive_along(board, track(np.arange(float(TRACK_M)) * -0.02), -20.0, 1.0, 0.0, 100)
    assert set(course.notch) == {-board.behaviour.standing_brake_notch}
    assert course.position_m[-1] == START_M


def test_supervision_overrules_the_driver(boards: Boards, track: Callable[..., Rows]) -> None:
    board = boards()
    board.unit.intervention = EMERGENCY_INTERVENTION
    course = drive_along(board, track(np.zeros(TRACK_M)), 0.0, 0.0, 10.0, 1)
    assert course.emergency
    assert course.notch == [-board.kind.brake_notches]


@given(force_share=st.floats(0.01, 1.0), load_share=st.floats(0.0, 1.0), speed_mps=st.floats(0.0, 25.0))
def test_the_lowest_notch_that_is_strong_enough(
    train: TrainRow, force_share: float, load_share: float, speed_mps: float
) -> None:
    """EV-E301's five notches are even (its train file), so the notch is the share in fifths, rounded up."""
    force_n = force_share * full_force_n(train, load_share, speed_mps)
    notch = power_notch(train, load_share, speed_mps, force_n)
    assert notch == pytest.approx(
        np.ceil(5.0 * force_share - 1e-9), abs=1.0 if force_share % 0.2 < 1e-9 else 0.0
    )
    assert power_notch(train, load_share, speed_mps, 0.0) == 0.0
    assert power_notch(train, load_share, speed_mps, 2.0 * full_force_n(train, load_share, speed_mps)) == 5.0


def test_notches_follow_the_force(train: TrainRow) -> None:
    forces = np.linspace(0.0, 60e3, 50)
    notches = [power_notch(train, 0.5, 5.0, force) for force in forces]
    assert all(a <= b for a, b in pairwise(notches))


@pytest.mark.parametrize(
    ("speed_mps", "left_m", "pulls"),
    [
        (0.0, 0.4, False),  # rests where it is
        (0.0, 3.0, True),
        (0.6, 1.0, False),  # 0.6 m/s * 1.8 s, and 0.3 m to brake in
        (0.6, 20.0, True),
        (10.0, 90.0, False),  # 10 m/s * 1.8 s, and 83 m to brake in with 0.6 m/s2
        (10.0, 200.0, True),
    ],
)
def test_no_power_is_taken_up_that_the_stop_would_meet_building_up(
    boards: Boards, track: Callable[..., Rows], speed_mps: float, left_m: float, pulls: bool
) -> None:
    """A train that coasts, slower than it might: with power it would still pull when it has come to rest."""
    board = boards()
    board.unit.target_stop_m = START_M + left_m
    board.unit.cruise_mps = 15.0
    course = drive_along(board, track(np.zeros(TRACK_M)), 0.0, 0.0, speed_mps, 1)
    assert (course.notch[0] > 0.0) is pulls
