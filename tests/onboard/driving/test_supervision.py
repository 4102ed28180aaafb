from collections.abc import Callable
from copy import copy

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from onboard.driving.ahead import kept_along_mps, limit_mps
from onboard.driving.pattern import lowered_by, lowered_mps, pattern_of
from onboard.driving.supervision import RESERVE_M, stop_curve_mps, supervise
from onboard.localisation.tachometer import locate
from onboard.records import (
    EMERGENCY_INTERVENTION,
    EVENT_INTERVENTION,
    NO_INTERVENTION,
    SERVICE_INTERVENTION,
    UNIT,
    BehaviourRow,
    UnitRow,
)
from tests.nightly import A_FIFTH
from tests.rows import Rows
from vehicle.records import TrainRow

GRAVITY_SHARE_MPS2 = 9.81 / 1.08
STEP_S = 0.1
TRACK_M = 2500


@given(
    distance_m=st.floats(0.01, 3000.0),
    climb_m=st.floats(-30.0, 30.0),
    deceleration_mps2=st.floats(0.3, 1.3),
    reaction_s=st.floats(0.0, 5.0),
)
def test_the_stop_curve_solves_its_equation(
    distance_m: float, climb_m: float, deceleration_mps2: float, reaction_s: float
) -> None:
    speed = stop_curve_mps(distance_m, climb_m, deceleration_mps2, reaction_s, GRAVITY_SHARE_MPS2)
    room_m = distance_m + GRAVITY_SHARE_MPS2 * climb_m / deceleration_mps2
    used_m = speed * reaction_s + speed * speed / (2.0 * deceleration_mps2)
    assert used_m == pytest.approx(max(room_m, 0.0), abs=1e-6)


def test_the_stop_curve_by_hand() -> None:
    """100 m, 0.8 m/s2, 1.4 s, level: v^2/1.6 + 1.4 v = 100."""
    assert stop_curve_mps(100.0, 0.0, 0.8, 1.4, GRAVITY_SHARE_MPS2) == pytest.approx(11.5786, abs=1e-4)
    assert stop_curve_mps(100.0, 0.0, 0.8, 0.0, GRAVITY_SHARE_MPS2) == pytest.approx(160.0**0.5)
    assert stop_curve_mps(0.0, 5.0, 0.8, 1.4, GRAVITY_SHARE_MPS2) == 0.0


def prepared(limit_m: float) -> UnitRow:
    row: UnitRow = np.zeros(1, dtype=UNIT).view(np.recarray)[0]
    row.position_known, row.odometer_scale = 1, 1.0
    row.expected_tag_m = row.rear_trigger_m = row.restricted_mps = np.inf
    row.position_m, row.stop_limit_m, row.path_rows = 50.0, limit_m, TRACK_M
    return row


@A_FIFTH
@given(
    slopes=st.lists(st.floats(-25.0, 25.0), min_size=10, max_size=10),
    limit_m=st.floats(120.0, 2400.0),
    push_mps2=st.floats(0.0, 0.6),
    bound_m=st.floats(0.0, 20.0),
    length_m=st.sampled_from([20.0, 40.0, 120.0]),
    service_works=st.booleans(),
    larger=st.floats(0.0, 0.02),
)
@example([0.0] * 10, 400.0, 0.6, 0.0, 40.0, False, 0.0)
# over a crest within the reaction time
@example([0.0, 0.0, 6.0, *[0.0] * 7], 1132.0, 0.5, 0.0, 20.0, False, 0.0)
@example([-25.0] * 10, 2000.0, 0.6, 0.0, 40.0, False, 0.0)
@example([-25.0] * 5 + [25.0] * 5, 1400.0, 0.6, 0.0, 120.0, False, 0.0)
@example([0.0] * 10, 1400.0, 0.6, 0.0, 40.0, False, 0.02)
def test_with_the_guaranteed_brake_no_train_passes_its_stop_limit(
    train: TrainRow,
    behaviour: BehaviourRow,
    slopes: list[float],
    limit_m: float,
    push_mps2: float,
    bound_m: float,
    length_m: float,
    service_works: bool,
    larger: float,
) -> None:
    """Full power until something intervenes, over hills, the front ahead of its estimate by all of the bound.

    Its wheels are larger by so much than the tachometer is set for, which shows less than there is: 2 % are stated.

    Simulated here on its own: mean gradient under the train; the brake does nothing while the motors still
    push, for the whole reaction time (one sampling step of it is the computer's), then it has its guaranteed value.
    Where the service brake works it cuts the power off for good; where it does not, only the emergency brake does.
    """
    elevation_m = np.interp(np.arange(TRACK_M), np.linspace(0, TRACK_M, 11), np.cumsum([0.0, *slopes]) / 4.0)
    long = copy(train)
    long.length_m = length_m
    path = pattern_of(elevation_m, np.zeros(TRACK_M), np.full(TRACK_M, 27.0), long, behaviour)
    unit = prepared(limit_m)
    unit.bound_ahead_m, unit.bound_growth = bound_m, larger
    front_m, speed, since_s, cut = unit.position_m + bound_m, 0.0, 0.0, False
    metres = np.arange(TRACK_M)
    for _ in range(3000):
        if unit.intervention == EMERGENCY_INTERVENTION:
            since_s += STEP_S
            braking = since_s > behaviour.emergency_reaction_s - STEP_S + 1e-9
            brake_mps2 = behaviour.emergency_guaranteed_mps2
        elif unit.intervention == SERVICE_INTERVENTION and service_works:
            since_s += STEP_S
            braking = since_s > behaviour.service_reaction_s - STEP_S + 1e-9
            brake_mps2 = behaviour.service_guaranteed_mps2
        else:
            since_s, braking, brake_mps2 = 0.0, False, 0.0
        cut = cut or braking
        ends_m = np.interp([front_m, front_m - length_m], metres, elevation_m)
        slope_mps2 = GRAVITY_SHARE_MPS2 * (ends_m[0] - ends_m[1]) / length_m
        acceleration = (-brake_mps2 if braking else 0.0 if cut else push_mps2) - slope_mps2
        after = max(speed + acceleration * STEP_S, 0.0)
        front_m += (speed + after) / 2.0 * STEP_S
        speed = after
        assert front_m <= limit_m
        locate(unit, long, (front_m - 50.0 - bound_m) / (1.0 + larger), speed / (1.0 + larger), STEP_S)
        supervise(unit, long, behaviour, path)
        if speed == 0.0 and (cut or acceleration <= 0.0):  # it stands for good
            break


@given(
    near_m=st.floats(0.0, 1000.0),
    further_m=st.floats(0.0, 1000.0),
    bound_m=st.floats(0.0, 50.0),
    permille=st.floats(-20.0, 20.0),
)
def test_the_permitted_speed_never_rises_towards_the_limit_nor_with_the_bound(
    train: TrainRow,
    behaviour: BehaviourRow,
    track: Callable[..., Rows],
    near_m: float,
    further_m: float,
    bound_m: float,
    permille: float,
) -> None:
    path = track(np.arange(TRACK_M) * permille / 1000.0)

    def permitted(distance_m: float, ahead_m: float) -> float:
        unit = prepared(2200.0)
        unit.position_m, unit.bound_ahead_m = 2200.0 - distance_m, ahead_m
        supervise(unit, train, behaviour, path)
        return float(unit.permitted_mps)

    near = permitted(near_m, 0.0)
    assert near <= permitted(near_m + further_m, 0.0) + 1e-9
    assert permitted(near_m, bound_m) <= near + 1e-9


def test_interventions(train: TrainRow, behaviour: BehaviourRow, track: Callable[..., Rows]) -> None:
    """Limit 18 m/s; service from 18.6, released at 17, emergency from 20, and that only by the driver."""
    path = track(np.zeros(TRACK_M))
    unit = prepared(np.inf)
    course = [
        (18.5, NO_INTERVENTION, 0),
        (18.7, SERVICE_INTERVENTION, EVENT_INTERVENTION),
        (17.1, SERVICE_INTERVENTION, 0),
        (16.9, NO_INTERVENTION, EVENT_INTERVENTION),
        (20.1, EMERGENCY_INTERVENTION, EVENT_INTERVENTION),
        (0.0, EMERGENCY_INTERVENTION, 0),
    ]
    for speed_mps, intervention, events in course:
        unit.speed_mps = speed_mps
        assert supervise(unit, train, behaviour, path) == events
        assert unit.intervention == intervention


def test_the_restricted_speed_is_a_ceiling(
    train: TrainRow, behaviour: BehaviourRow, track: Callable[..., Rows]
) -> None:
    unit = prepared(np.inf)
    unit.restricted_mps = 15.0 / 3.6
    supervise(unit, train, behaviour, track(np.zeros(TRACK_M)))
    assert unit.permitted_mps == pytest.approx(15.0 / 3.6)


def test_at_the_limit_and_beyond_nothing_is_permitted(
    train: TrainRow, behaviour: BehaviourRow, track: Callable[..., Rows]
) -> None:
    path = track(np.zeros(TRACK_M))
    for limit_m in (50.0, 40.0, 0.0):
        unit = prepared(limit_m)
        unit.speed_mps = 0.01
        supervise(unit, train, behaviour, path)
        assert unit.permitted_mps == 0.0
        assert unit.intervention == EMERGENCY_INTERVENTION
        unit = prepared(limit_m)
        supervise(unit, train, behaviour, path)
        assert unit.intervention == NO_INTERVENTION  # it stands


def test_a_limit_ahead_counts_from_the_furthest_place_where_the_front_may_be(
    train: TrainRow, behaviour: BehaviourRow
) -> None:
    limits = np.full(TRACK_M, 20.0)
    limits[200:] = 5.0
    path = pattern_of(np.zeros(TRACK_M), np.zeros(TRACK_M), limits, train, behaviour)
    unit = prepared(np.inf)
    unit.position_m, unit.bound_ahead_m = 190.0 - RESERVE_M, 10.0
    supervise(unit, train, behaviour, path)
    assert unit.permitted_mps == pytest.approx(5.0)


def limited(
    train: TrainRow, behaviour: BehaviourRow, *slow: tuple[int, int, float], else_mps: float = 20.0
) -> Rows:
    """The path database of level track with limits (m/s) on metres from and to, and one between them."""
    limits, level = np.full(TRACK_M, else_mps), np.zeros(TRACK_M)
    for from_m, to_m, mps in slow:
        limits[from_m : to_m + 1] = np.minimum(limits[from_m : to_m + 1], mps)
    return pattern_of(level, level, limits, train, behaviour).view(np.recarray)


def held(unit: UnitRow, train: TrainRow, behaviour: BehaviourRow, path: Rows) -> tuple[float, float]:
    """The speed that supervision permits, and the one under which driving stays, m/s."""
    supervise(unit, train, behaviour, path)
    return float(unit.permitted_mps), limit_mps(unit, behaviour, path)


@pytest.mark.parametrize("bounds_m", [(0.0, 0.0), (15.0, 10.0), (0.0, 80.0), (80.0, 0.0)])
def test_a_limit_holds_until_the_rear_has_left_it_wherever_the_train_may_be(
    train: TrainRow, behaviour: BehaviourRow, bounds_m: tuple[float, float]
) -> None:
    """8 m/s from 1500 to 1600 m, 40 m of train: the rearmost place of its rear is beyond at 1640 m and the bound."""
    path, unit = limited(train, behaviour, (1500, 1600, 8.0)), prepared(np.inf)
    unit.bound_ahead_m, unit.bound_behind_m = bounds_m
    assert train.length_m == 40.0
    beyond_m = 1600.0 + 40.0 + unit.bound_behind_m
    for position_m in (1560.0, beyond_m - 0.1, beyond_m):
        unit.position_m = position_m
        assert held(unit, train, behaviour, path) == pytest.approx((8.0, 6.8))
    unit.position_m = beyond_m + 1.0  # rows are a metre apart
    assert held(unit, train, behaviour, path) == pytest.approx((20.0, 18.8))


def test_a_limit_shorter_than_the_bounds_holds_all_the_while_that_the_train_may_be_in_it(
    train: TrainRow, behaviour: BehaviourRow
) -> None:
    """Five metres, and a train of ten: neither the furthest nor the nearest place nor the estimate is within it."""
    short, unit = copy(train), prepared(np.inf)
    short.length_m = 10.0
    path = limited(short, behaviour, (1500, 1505, 8.0))
    unit.bound_ahead_m = unit.bound_behind_m = 50.0
    for position_m in (1452.0, 1480.0, 1516.0, 1540.0, 1565.0):
        unit.position_m = position_m
        assert held(unit, short, behaviour, path) == pytest.approx((8.0, 6.8))
    unit.position_m = 1567.0
    assert held(unit, short, behaviour, path) == pytest.approx((20.0, 18.8))


PLACES = st.tuples(st.integers(100, 2300), st.integers(1, 200), st.floats(1.0, 18.0))


@given(
    places=st.lists(PLACES, max_size=4),
    position_m=st.floats(50.0, 2400.0),
    ahead_m=st.floats(0.0, 120.0),
    behind_m=st.floats(0.0, 120.0),
    length_m=st.floats(10.0, 160.0),
    truly=st.floats(0.0, 1.0),
)
@example([(1500, 5, 8.0)], 1540.0, 50.0, 50.0, 10.0, 0.5)
# its rear is still within, if it is where it may be
@example([(1500, 100, 8.0)], 1659.9, 20.0, 20.0, 40.0, 0.0)
def test_no_more_is_permitted_than_any_limit_under_the_train_allows(
    train: TrainRow,
    behaviour: BehaviourRow,
    places: list[tuple[int, int, float]],
    position_m: float,
    ahead_m: float,
    behind_m: float,
    length_m: float,
    truly: float,
) -> None:
    """Wherever within its bounds it truly is; and driving stays a margin below what supervision permits."""
    own, unit = copy(train), prepared(np.inf)
    own.length_m = length_m
    path = limited(own, behaviour, *((at, at + run_m, mps) for at, run_m, mps in places))
    unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = position_m, ahead_m, behind_m
    permitted_mps, driven_mps = held(unit, own, behaviour, path)
    front_m = position_m - behind_m + truly * (ahead_m + behind_m)
    under = [mps for at, run_m, mps in places if at < front_m and at + run_m > front_m - length_m]
    assert permitted_mps <= min(under, default=20.0)
    margin_mps = min(behaviour.settings.driving_margin_mps, permitted_mps - min(1.0, 0.5 * permitted_mps))
    assert driven_mps <= permitted_mps - margin_mps + 1e-9


@given(
    places=st.lists(PLACES, max_size=4), position_m=st.floats(50.0, 2400.0), speed_mps=st.floats(0.0, 20.0)
)
def test_who_knows_its_position_keeps_the_speeds_of_one_place(
    train: TrainRow,
    behaviour: BehaviourRow,
    places: list[tuple[int, int, float]],
    position_m: float,
    speed_mps: float,
) -> None:
    """Without bounds driving keeps, to the digit, what the curves have where it is and where it will be in a second."""
    path, unit = (
        limited(train, behaviour, *((at, at + run_m, mps) for at, run_m, mps in places)),
        prepared(np.inf),
    )
    unit.position_m, unit.speed_mps = position_m, speed_mps
    well_under_mps = lowered_by(path["permitted_mps"], 1.2)
    permitted_mps, driven_mps = held(unit, train, behaviour, path)
    kept_mps = [
        min(path["driving_mps"][int(at_m)], well_under_mps[int(at_m + RESERVE_M)])
        for at_m in (position_m, position_m + max(speed_mps, 1.0))
    ]
    assert driven_mps == min(*kept_mps, lowered_mps(permitted_mps, permitted_mps, 0.6))


@given(
    places=st.lists(st.tuples(st.integers(100, 2300), st.integers(1, 200), st.floats(5.0, 18.0)), max_size=4),
    bound_m=st.floats(0.0, 60.0),
)
@example([(1500, 5, 8.0)], 50.0)
def test_what_is_kept_along_a_path_is_what_driving_keeps_there(
    train: TrainRow, behaviour: BehaviourRow, places: list[tuple[int, int, float]], bound_m: float
) -> None:
    """The prediction for blocking times says of each metre what the tick does there, to the metre."""
    path, unit = (
        limited(train, behaviour, *((at, at + run_m, mps) for at, run_m, mps in places)),
        prepared(np.inf),
    )
    kept_mps = kept_along_mps(path, behaviour, np.full(TRACK_M, bound_m))
    unit.bound_ahead_m = unit.bound_behind_m = bound_m
    for position_m in range(60, 2200, 7):
        unit.position_m, unit.speed_mps = float(position_m), float(path["driving_mps"][position_m])
        driven_mps = held(unit, train, behaviour, path)[1]
        assert kept_mps[position_m : position_m + 2].min() - 1e-9 <= driven_mps <= kept_mps[position_m] + 1e-9


@pytest.mark.parametrize("restricted", [False, True])
@pytest.mark.parametrize(
    ("limit_kmh", "kept_mps"),
    [(1.0, 0.1389), (3.0, 0.4167), (5.0, 0.6944), (7.2, 1.0), (8.0, 1.0222), (15.0, 2.9667)],
)
def test_under_no_limit_does_a_train_stand_for_its_margins(
    train: TrainRow, behaviour: BehaviourRow, limit_kmh: float, kept_mps: float, restricted: bool
) -> None:
    """Driving keeps 1.2 m/s below a limit, and by that alone would stand at 4.3 km/h. So with the speed on sight."""
    level = np.zeros(TRACK_M)
    limits = np.full(TRACK_M, 27.0 if restricted else limit_kmh / 3.6)
    path = pattern_of(level, level, limits, train, behaviour)
    unit = prepared(2400.0)
    unit.restricted_mps = limit_kmh / 3.6 if restricted else np.inf
    supervise(unit, train, behaviour, path)
    assert limit_mps(unit, behaviour, path) == pytest.approx(kept_mps, abs=1e-4)
    if not restricted:
        assert path["driving_mps"][100] == pytest.approx(kept_mps, abs=1e-4)
        assert kept_along_mps(path, behaviour, level)[100] == pytest.approx(kept_mps, abs=1e-4)
