"""One rule for every fix: intervals are cut, never moved off the truth."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.fix import (
    Fix,
    FixSource,
    RefusedFix,
    TakenFix,
    fix_by_rule,
    missed_by_m,
    take_interval,
    virtual_tag_bits,
)
from onboard.localisation.wheel_scale import narrowest
from onboard.records import UnitRow

shares = st.floats(-1.0, 1.0)
bounds_m = st.floats(0.01, 40.0)


@given(own_share=shares, its_share=shares, own_m=bounds_m, its_m=bounds_m, source=st.sampled_from(FixSource))
def test_two_intervals_that_hold_the_truth_leave_one_that_holds_it(
    unit: UnitRow, own_share: float, its_share: float, own_m: float, its_m: float, source: FixSource
) -> None:
    true_m = 500.0
    unit.position_m, unit.bound_behind_m, unit.bound_ahead_m = true_m + own_share * own_m, own_m, own_m
    unit.fix_correction_m = 0.0
    before_m = float(unit.position_m)
    fix = Fix(true_m + its_share * its_m, its_m, its_m, source)
    taken = take_interval(unit, fix)
    assert isinstance(taken, TakenFix)
    assert unit.position_m == pytest.approx(before_m + taken.correction_m)
    assert unit.fix_correction_m == pytest.approx(taken.correction_m)
    assert unit.position_m - unit.bound_behind_m <= true_m + 1e-9
    assert true_m - 1e-9 <= unit.position_m + unit.bound_ahead_m
    assert unit.bound_behind_m + unit.bound_ahead_m <= 2.0 * its_m + 1e-9
    assert unit.bound_behind_m >= -1e-9
    assert unit.bound_ahead_m >= -1e-9


@pytest.mark.parametrize("at_m", [447.4, 452.6])
def test_a_fix_that_misses_the_bounds_is_refused_and_changes_nothing(unit: UnitRow, at_m: float) -> None:
    unit.position_m, unit.bound_behind_m, unit.bound_ahead_m = 450.0, 2.0, 2.0
    before = unit.copy()  # type: ignore[attr-defined]
    fix = Fix(at_m, 0.5, 0.5, FixSource.TAG)
    assert missed_by_m(unit, fix) == pytest.approx(0.1)
    refused = take_interval(unit, fix)
    assert refused == RefusedFix("tag misses the bounds by 0.100 m")
    assert unit == before


def test_what_is_no_number_is_refused(unit: UnitRow) -> None:
    assert isinstance(take_interval(unit, Fix(float("nan"), 0.5, 0.5, FixSource.TAG)), RefusedFix)


def test_a_unit_without_a_position_takes_the_fix_as_it_is(unit: UnitRow) -> None:
    unit.position_known, unit.position_m = 0, 7.0
    assert take_interval(unit, Fix(5000.0, 0.5, 1.5, FixSource.TAG)) == TakenFix(0.0)
    assert (unit.position_known, unit.position_m) == (1, 5000.0)
    assert (unit.bound_behind_m, unit.bound_ahead_m) == (0.5, 1.5)
    assert unit.fix_correction_m == 0.0  # nothing to correct


def test_the_surer_of_two_counts_more(unit: UnitRow) -> None:
    """By the squares: 4 m against 1 m moves the estimate by 16 parts of 17."""
    unit.position_m, unit.bound_behind_m, unit.bound_ahead_m = 100.0, 4.0, 4.0
    assert take_interval(unit, Fix(101.0, 1.0, 1.0, FixSource.TAG)) == TakenFix(pytest.approx(16.0 / 17.0))


def fix_taken(unit: UnitRow, within_m: float) -> None:
    """A fix that has the front where the estimate is, within that either way."""
    unit.bound_behind_m = unit.bound_ahead_m = 50.0
    fix_by_rule(unit, unit.position_m, within_m, within_m)
    virtual_tag_bits(unit, 0)


@pytest.mark.parametrize(("run_m", "kept"), [(400.0, True), (600.0, False)])
def test_a_narrow_fix_measures_the_wheels_until_they_have_added_as_much(
    unit: UnitRow, run_m: float, kept: bool
) -> None:
    """A metre, and 2 % either way of what wheels count since, beside 22 m by satellites: it tells more for 525 m."""
    fix_taken(unit, 0.5)
    unit.odometer_m += run_m
    fix_taken(unit, 11.0)
    one = narrowest(unit)
    assert (one.high_m - one.low_m == pytest.approx(1.0)) is kept
    assert (one.odometer_m == 0.0) is kept


def test_a_slide_makes_a_narrow_fix_tell_less(unit: UnitRow) -> None:
    fix_taken(unit, 0.5)
    unit.slid_ahead_m += 30.0
    fix_taken(unit, 11.0)
    one = narrowest(unit)
    assert one.high_m - one.low_m == pytest.approx(22.0)


def test_a_fix_measures_the_wheels_once(unit: UnitRow) -> None:
    fix_taken(unit, 0.5)
    fix_taken(unit, 11.0)
    first, second = narrowest(unit), narrowest(unit)
    assert first.high_m - first.low_m == pytest.approx(1.0)
    assert second.high_m - second.low_m == pytest.approx(22.0)
