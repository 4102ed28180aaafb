"""A satellite fix: what it may do to estimate and bounds, what is a lie, and what of lies is held."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation import gnss as reader
from onboard.localisation.fix import MISSED, NOTHING, REFUSED, TAKEN
from onboard.localisation.gnss import BORNE_OUT, FIRST_FIXES, LOST_S, GnssRow, gnss
from onboard.localisation.table import READERS_ROW, READINGS
from onboard.records import NO_PLACES, PATTERN, Chart, UnitRow

STEP_S = 0.1
PROTECTION_M = 20.0
CHART = Chart(np.zeros(1, dtype=PATTERN), NO_PLACES)
AGE_S = 0.2


class Train:
    """A train at a constant speed whose unit knows where it is, and a receiver that errs as it is told."""

    def __init__(self, unit: UnitRow, bound_m: float = 5.0, speed_mps: float = 20.0) -> None:
        self.unit, self.true_m, self.speed_mps = unit, 1000.0, speed_mps
        self.own: GnssRow = np.zeros(1, READERS_ROW).view(np.recarray)[0].gnss
        self.shown: Any = np.zeros(1, READINGS).view(np.recarray)[0].gnss
        unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = self.true_m, bound_m, bound_m
        unit.bound_growth, unit.odometer_scale, unit.speed_mps = 0.02, 1.0, speed_mps
        unit.train_mps = unit.may_run_mps = speed_mps
        unit.position_known, unit.odometer_m = 1, 0.0
        self.wheels = 1.0  # counted over run
        self.ran_m = 0.0

    def tick(self, error_m: float | None, open_sky: int = 1, age_s: float = AGE_S) -> int:
        """A step later, with a fix that errs so, or none."""
        unit, run_m = self.unit, self.speed_mps * STEP_S
        self.true_m += run_m
        self.ran_m += run_m
        unit.odometer_m += run_m * self.wheels
        unit.position_m += run_m * self.wheels
        unit.bound_ahead_m += run_m * 0.02
        unit.bound_behind_m += run_m * 0.02
        self.shown.taken = 0 if error_m is None else 1
        self.shown.position_m = self.true_m - self.speed_mps * AGE_S + (error_m or 0.0)
        self.shown.age_s, self.shown.protection_m, self.shown.open_sky = age_s, PROTECTION_M, open_sky
        return gnss(self.own, self.shown, unit, CHART, STEP_S)

    def second(self, error_m: float | None, open_sky: int = 1) -> int:
        """A second, with a fix at its end."""
        for _ in range(9):
            self.tick(None)
        return self.tick(error_m, open_sky)

    @property
    def out_m(self) -> float:
        """By how much the truth is out of the bounds; not positive inside."""
        beyond_m = self.true_m - self.unit.position_m
        return float(max(beyond_m - self.unit.bound_ahead_m, -beyond_m - self.unit.bound_behind_m))

    def seconds(self, count: int, error_m: float | None) -> None:
        """So many seconds of fixes that err so, or without any."""
        for _ in range(count):
            self.second(error_m)

    def most_out_m(self, error_m: float) -> float:
        """Now, and in 20 s of fixes that err so."""
        found_m = [self.out_m]
        for _ in range(20):
            self.second(error_m)
            found_m.append(self.out_m)
        return max(found_m)

    @property
    def half_m(self) -> float:
        return float(self.unit.bound_ahead_m + self.unit.bound_behind_m) / 2.0


def with_fixes(unit: UnitRow, seconds: int) -> Train:
    """A train with bounds of 60 m, after so many good fixes."""
    train = Train(unit, 60.0)
    train.seconds(seconds, 0.0)
    return train


def test_a_borne_out_fix_under_an_open_sky_cuts_to_the_protection_level(unit: UnitRow) -> None:
    train = Train(unit, bound_m=80.0)
    for _ in range(BORNE_OUT - 1):
        train.second(1.0)
        assert train.half_m > 80.0
    assert train.second(1.0) == TAKEN
    assert PROTECTION_M < train.half_m < PROTECTION_M + 2.0  # and what the wheels add since it was taken
    assert train.out_m < 0.0


def test_with_part_of_the_sky_hidden_a_fix_leans_the_estimate_and_no_more(unit: UnitRow) -> None:
    train = Train(unit, bound_m=40.0)
    unit.position_m += 15.0
    for _ in range(20):
        least_m = unit.position_m - unit.bound_behind_m
        most_m = unit.position_m + unit.bound_ahead_m
        ran_m = train.ran_m
        assert train.second(0.0, open_sky=0) == TAKEN
        grown_m = 0.02 * (train.ran_m - ran_m)
        run_m = train.ran_m - ran_m
        assert unit.position_m - unit.bound_behind_m == pytest.approx(least_m + run_m - grown_m)
        assert unit.position_m + unit.bound_ahead_m == pytest.approx(most_m + run_m + grown_m)
    assert abs(unit.position_m - train.true_m) < 5.0


def test_a_unit_without_a_position_takes_the_interval_of_a_borne_out_receiver(unit: UnitRow) -> None:
    train = Train(unit, speed_mps=0.0)
    unit.position_known, unit.position_m = 0, 0.0
    for _ in range(FIRST_FIXES - 1):
        assert train.second(3.0) == NOTHING
        assert unit.position_known == 0
    assert train.second(3.0) == TAKEN
    assert unit.position_known == 1
    assert train.out_m < 0.0
    assert train.half_m == pytest.approx(PROTECTION_M, abs=0.5)


def test_no_position_is_taken_while_part_of_the_sky_is_hidden(unit: UnitRow) -> None:
    train = Train(unit, speed_mps=0.0)
    unit.position_known = 0
    assert all(train.second(0.0, open_sky=0) == NOTHING for _ in range(3 * FIRST_FIXES))
    assert unit.position_known == 0


def test_silence_is_told_once_there_was_a_fix(unit: UnitRow) -> None:
    train = Train(unit)
    assert all(train.tick(None) == NOTHING for _ in range(200))
    train.second(0.0)
    outcomes = [train.tick(None) for _ in range(round(LOST_S / STEP_S) + 2)]
    assert outcomes[0] == NOTHING
    assert outcomes[-1] == MISSED
    assert train.half_m > 5.0  # nothing cut, nothing lost


@pytest.mark.parametrize("age_s", [-0.1, 7.0, math.nan])
def test_what_cannot_be_is_refused(unit: UnitRow, age_s: float) -> None:
    train = Train(unit)
    before_m = train.half_m
    assert train.tick(0.0, age_s=age_s) == REFUSED
    assert train.tick(math.nan) == REFUSED
    assert train.half_m >= before_m


def test_a_fix_off_the_bounds_is_refused(unit: UnitRow) -> None:
    train = Train(unit, bound_m=2.0)
    train.seconds(BORNE_OUT - 1, 60.0)
    assert train.second(60.0) == REFUSED
    assert train.out_m < 0.0


def test_a_jump_widens_what_the_receiver_says_until_it_goes_back(unit: UnitRow) -> None:
    train = Train(unit, bound_m=30.0)
    train.seconds(10, 0.0)
    assert train.second(50.0) == REFUSED
    for _ in range(60):
        assert train.second(50.0) != REFUSED
        assert train.out_m < 0.0
    assert reader.lie_m(train.own, unit) == pytest.approx((0.0, 50.0), abs=2.0)
    train.second(0.0)
    for _ in range(10):
        train.second(0.0)
        assert train.out_m < 0.0
    assert train.half_m < PROTECTION_M + 10.0


def test_narrow_bounds_of_others_confirm_a_receiver(unit: UnitRow) -> None:
    train = Train(unit, bound_m=30.0)
    train.seconds(10, 30.0)
    train.second(0.0)  # it has come to its senses, which looks as if it had lost them
    assert reader.lie_m(train.own, unit)[0] < -25.0
    unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = train.true_m, 0.5, 0.5  # a tag
    train.second(0.0)
    assert reader.lie_m(train.own, unit) == (0.0, 0.0)


def test_a_new_path_begins_anew(unit: UnitRow) -> None:
    train = Train(unit)
    train.seconds(10, 0.0)
    unit.paths_taken_up += 1
    for name in ("position_m",):
        setattr(unit, name, getattr(unit, name) + 5000.0)
    train.true_m += 5000.0
    assert train.second(0.0) != REFUSED
    assert reader.lie_m(train.own, unit) == (0.0, 0.0)


def forget(own: GnssRow) -> None:
    """Nobody keeps the lie."""
    own.moved_low_m = own.moved_high_m = own.shown_low_m = own.shown_high_m = 0.0


def slide(train: Train, error_m: float) -> None:
    """For a second the wheels hardly turn, all of which bounds and unit take for what may have slid; then a fix."""
    unit, true_mps = train.unit, train.speed_mps
    for _ in range(10):
        train.wheels = 0.2
        slid_m = true_mps * STEP_S * 0.8
        unit.slid_ahead_m += slid_m
        unit.bound_ahead_m += slid_m
        train.tick(None)
    train.wheels = 1.0
    train.tick(error_m)


@pytest.mark.parametrize("forgives", [False, True])
def test_a_lie_that_comes_up_in_a_slide_is_in_the_interval(unit: UnitRow, forgives: bool) -> None:
    """Fixes fall back as much as the train slides on: they move as the wheels do. Forgiven, it would not be held."""
    train = with_fixes(unit, 10)
    train.own.forgives = int(forgives)
    for second in range(1, 4):
        slide(train, -16.0 * second)
    out_m = train.most_out_m(-48.0)
    assert (out_m > 5.0) is forgives
    assert forgives or out_m <= 0.0


@pytest.mark.parametrize("forgives", [False, True])
def test_what_may_have_slid_is_no_room_for_a_lie_ahead(unit: UnitRow, forgives: bool) -> None:
    """Wheels slid by nothing of what they may have; then fixes jump ahead by as much, as if they had."""
    train = with_fixes(unit, 10)
    train.own.forgives = int(forgives)
    unit.slid_ahead_m += 60.0
    unit.bound_ahead_m += 60.0
    out_m = train.most_out_m(50.0)
    assert (out_m > 5.0) is forgives
    assert forgives or out_m <= 0.0


@pytest.mark.parametrize("forgives", [False, True])
@pytest.mark.parametrize("open_sky", [0, None])
def test_a_lie_that_comes_up_in_a_gap_is_in_the_interval(
    unit: UnitRow, open_sky: int | None, forgives: bool
) -> None:
    """Over a kilometre without an open sky wheels count 1 % too little, and fixes fall back by more than that."""
    train = with_fixes(unit, 20)
    train.own.forgives, train.wheels = int(forgives), 0.99
    for _ in range(50):
        train.second(None if open_sky is None else -24.0, open_sky=open_sky or 0)
    out_m = train.most_out_m(-24.0)
    assert (out_m > 2.0) is forgives
    assert forgives or out_m <= 0.0


@pytest.mark.parametrize("forgives", [False, True])
@pytest.mark.parametrize("new_path", [False, True])
def test_a_receiver_silent_till_the_path_began_may_lie_by_all_that_bounds_leave(
    unit: UnitRow, forgives: bool, new_path: bool
) -> None:
    """Nothing tells how it came to show what lies in wide bounds: on a first path, or on the next after a jam."""
    train = Train(unit, 60.0)
    train.own.forgives = int(forgives)
    train.seconds(10 if new_path else 0, 0.0)
    unit.bound_ahead_m = unit.bound_behind_m = 60.0
    train.speed_mps = 0.0
    train.seconds(round(LOST_S) + 1, None)
    unit.paths_taken_up += int(new_path)
    out_m = -math.inf
    for _ in range(20):
        train.second(-50.0)
        out_m = max(out_m, train.out_m)
    assert (out_m > 5.0) is forgives
    assert forgives or out_m <= 0.0


def test_narrow_bounds_prove_a_receiver_by_its_first_fix(unit: UnitRow) -> None:
    train = Train(unit, 5.0, speed_mps=0.0)
    train.seconds(round(LOST_S) + 1, None)
    train.second(3.0)
    assert reader.lie_m(train.own, unit) == (0.0, 0.0)


GAP_M = 1000.0  # 50 s at 20 m/s
ROOM_M = (reader.STEADY_SHARE + reader.WHEELS_SHARE) * PROTECTION_M


def after_a_gap(unit: UnitRow, wheels: float = 1.0, forgives: bool = False) -> Train:
    """A receiver that is right before and after a kilometre without signals, in which wheels count so."""
    train = with_fixes(unit, 20)
    train.own.forgives, train.wheels = int(forgives), wheels
    train.seconds(49, None)
    train.second(0.0)
    train.wheels = 1.0
    return train


def test_after_a_gap_a_receiver_alone_is_allowed_what_the_wheels_are_and_no_more(unit: UnitRow) -> None:
    """Of what the wheels may be wrong by (2 % of a kilometre) 3 P / 8 hide in the protection level already."""
    train = after_a_gap(unit)
    low_m, high_m = reader.lie_m(train.own, unit)
    assert (-low_m, high_m) == pytest.approx((0.02 * GAP_M - ROOM_M, 0.02 * GAP_M - ROOM_M), abs=0.1)


def test_how_far_fixes_went_on_over_a_gap_tells_which_way_a_lie_may_point(unit: UnitRow) -> None:
    """Wheels that counted 1 % too little: fixes seem to have jumped ahead by 10 m, if the wheels were right."""
    train = after_a_gap(unit, 0.99)
    low_m, high_m = reader.lie_m(train.own, unit)
    assert high_m == pytest.approx(10.0 + 0.02 * 0.99 * GAP_M - ROOM_M, abs=0.2)
    assert low_m == pytest.approx(10.0 - 0.02 * 0.99 * GAP_M + ROOM_M, abs=0.2)


def test_wheels_that_are_known_better_give_back_what_a_gap_took(unit: UnitRow) -> None:
    train = after_a_gap(unit)
    unit.bound_growth = 0.012
    assert reader.lie_m(train.own, unit)[1] == pytest.approx(0.012 * GAP_M - ROOM_M, abs=0.1)
    unit.bound_growth = 0.006
    assert reader.lie_m(train.own, unit) == (0.0, 0.0)


def test_wheels_that_turn_out_to_count_too_little_prove_a_receiver_right(unit: UnitRow) -> None:
    """The jump ahead of 10 m was theirs."""
    train = after_a_gap(unit, 0.99)
    unit.odometer_scale, unit.bound_growth = 1.0 / 0.99, 0.005
    assert reader.lie_m(train.own, unit) == (0.0, 0.0)


def test_of_several_gaps_the_greatest_counts_until_bounds_show_what_lie_there_is(unit: UnitRow) -> None:
    train = after_a_gap(unit)
    alone = reader.lie_m(train.own, unit)
    for seconds in (40, 30):
        train.seconds(20, 0.0)
        train.seconds(seconds, None)
    train.second(0.0)
    assert reader.lie_m(train.own, unit) == pytest.approx(alone, abs=0.1)
    unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = train.true_m, 2.0, 2.0
    train.second(0.0)
    unit.bound_growth = 0.02
    assert reader.lie_m(train.own, unit) == (0.0, 0.0)


def test_no_gap_is_what_a_few_missing_fixes_leave(unit: UnitRow) -> None:
    train = Train(unit, 60.0)
    for second in range(60):
        train.second(0.0 if second % 5 == 0 else None)
    assert reader.lie_m(train.own, unit) == (0.0, 0.0)


def slid_thrice(unit: UnitRow) -> Train:
    train = with_fixes(unit, 10)
    for _ in range(3):
        slide(train, 0.0)
    return train


def test_bounds_that_others_make_narrow_give_back_what_a_slide_took(unit: UnitRow) -> None:
    train = slid_thrice(unit)
    low_m, high_m = reader.lie_m(train.own, unit)
    assert high_m - low_m > 2.0 * PROTECTION_M
    unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = train.true_m, 2.0, 2.0
    train.second(0.0)
    assert reader.lie_m(train.own, unit) == (0.0, 0.0)


def test_fixes_that_went_on_with_a_slide_are_no_lie_behind(unit: UnitRow) -> None:
    """What may have slid did: fixes have gone ahead of the wheels by it, so they are not behind by it, too."""
    train = slid_thrice(unit)
    low_m, high_m = reader.lie_m(train.own, unit)
    assert high_m - low_m == pytest.approx(48.0, abs=0.1)  # three times 16 m slid
    assert low_m > -16.0


def test_a_lie_from_the_first_fix_on_shows_against_bounds_and_is_held_as_they_grow(unit: UnitRow) -> None:
    train = Train(unit, 2.0)
    for _ in range(120):
        train.second(35.0)
        assert train.out_m <= 0.0


Bias = Callable[[float], float]


def ramp(begin_m: float, slope: float, most_m: float) -> Bias:
    """A bias that comes up from a place of the way on by so much a metre, and stays."""
    return lambda ran_m: math.copysign(min(abs(slope) * max(ran_m - begin_m, 0.0), abs(most_m)), most_m)


@given(
    seed=st.integers(0, 2**16),
    begin_m=st.floats(200.0, 1500.0),
    slope=st.floats(0.05, 20.0),
    most_m=st.floats(-200.0, 200.0),
    wheels=st.floats(0.993, 1.007),
    bound_m=st.floats(1.0, 60.0),
    speed_mps=st.floats(5.0, 25.0),
)
def test_the_truth_stays_inside_while_the_receiver_errs_as_stated_or_lies_once(
    unit: UnitRow,
    seed: int,
    begin_m: float,
    slope: float,
    most_m: float,
    wheels: float,
    bound_m: float,
    speed_mps: float,
) -> None:
    train = Train(unit, bound_m, speed_mps)
    train.wheels = wheels
    chance = np.random.default_rng(seed)
    bias = ramp(begin_m, slope, most_m)
    honest_m = 0.0
    for _ in range(160):
        honest_m = float(np.clip(0.98 * honest_m + 0.3 * chance.normal(), -4.0, 4.0))
        train.second(honest_m + bias(train.ran_m + speed_mps * (1.0 - AGE_S)))
        assert train.out_m <= 1e-9


def test_a_lie_is_kept_where_the_driver_changes_ends_and_it_points_the_other_way(unit: UnitRow) -> None:
    """Thirty metres before, sixty afterwards: the second step does not take the first one back."""
    train = Train(unit, 80.0)
    for error_m in (*[0.0] * 20, *[30.0] * 10):
        train.second(error_m)
    unit.paths_taken_up += 1
    unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = train.true_m, 60.0, 60.0
    for error_m in (*[-30.0] * 10, *[-60.0] * 10):
        train.second(error_m)
        assert train.out_m <= 0.0


def test_what_creeps_up_slower_than_wheels_may_err_is_not_held(unit: UnitRow) -> None:
    """The hazard that the docstring names: without it the property above would say nothing."""
    train = Train(unit, 30.0)
    bias = ramp(200.0, 0.015, 60.0)
    for _ in range(250):
        train.second(bias(train.ran_m))
    assert train.out_m > 5.0


def test_the_lie_that_is_kept_is_what_holds_it(unit: UnitRow) -> None:
    train = Train(unit, 30.0)
    train.seconds(20, 0.0)
    for _ in range(30):
        train.second(35.0)
        forget(train.own)
    assert train.out_m > 0.0
    assert reader.STEADY_SHARE + 2.0 * (reader.STEADY_SHARE + reader.WHEELS_SHARE) <= 1.0


@pytest.mark.parametrize("knows", [True, False])
def test_a_fix_taken_while_the_unit_was_off_is_no_use(unit: UnitRow, knows: bool) -> None:
    """Off for 3 s in which the train runs 60 m: the receiver has not moved against the wheels (random run 20034)."""
    train = Train(unit)
    train.seconds(20, 0.0)
    off_m = 60.0
    train.true_m += off_m
    unit.odometer_m += off_m
    unit.position_known, unit.bound_ahead_m, unit.bound_behind_m = 0, 1.0, 1.0
    unit.paths_taken_up += 1
    unit.boots += int(knows)
    train.tick(0.0)
    train.seconds(FIRST_FIXES + 5, 0.0)
    assert (reader.lie_m(train.own, unit) == (0.0, 0.0)) is knows


def test_what_is_known_of_a_receivers_error_outlasts_the_units_power(unit: UnitRow) -> None:
    train = Train(unit)
    train.seconds(10, 0.0)
    train.seconds(10, 30.0)
    assert reader.lie_m(train.own, unit)[1] > 20.0
    unit.paths_taken_up += 1
    unit.boots += 1
    unit.position_known = 0
    for _ in range(FIRST_FIXES + 5):
        train.second(30.0)
        assert not unit.position_known or train.out_m <= 0.0
    assert unit.position_known
