"""A frame of the camera as a fix: intervals are cut, never moved off the truth."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from onboard.localisation.fix import FixSource, Refused, Taken, take
from onboard.localisation.sighting import SIGN_BEYOND_MARK_M, accuracy_m, sign_fix
from onboard.records import UnitRow

MARK_M = 500.0


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    true_m=st.floats(425.0, 500.0),
    estimate_share=st.floats(-1.0, 1.0),
    bound_m=st.floats(0.01, 40.0),
    seen_share=st.floats(-1.0, 1.0),
    speed_mps=st.floats(0.0, 20.0),
)
def test_the_true_front_stays_within_the_bounds(
    unit: UnitRow,
    true_m: float,
    estimate_share: float,
    bound_m: float,
    seen_share: float,
    speed_mps: float,
) -> None:
    unit.position_m = true_m + estimate_share * bound_m
    unit.bound_ahead_m = unit.bound_behind_m = bound_m
    unit.train_mps, unit.fix_correction_m = speed_mps, 0.0
    before_m = float(unit.position_m)
    real_m = MARK_M + SIGN_BEYOND_MARK_M - true_m
    slack_m = accuracy_m(real_m, speed_mps)
    shown_m = real_m + 0.5 * seen_share * slack_m  # the slack is that at the distance shown, so half of it
    taken = take(unit, sign_fix(unit, MARK_M, shown_m))
    assert isinstance(taken, Taken)
    assert unit.position_m == pytest.approx(before_m + taken.correction_m)
    assert unit.fix_correction_m == pytest.approx(taken.correction_m)
    assert unit.position_m - unit.bound_behind_m <= true_m + 1e-9
    assert true_m - 1e-9 <= unit.position_m + unit.bound_ahead_m
    assert unit.bound_ahead_m + unit.bound_behind_m <= 2.0 * bound_m + 1e-9


def test_what_cannot_be_is_not_believed(unit: UnitRow) -> None:
    unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = 450.0, 1.0, 1.0
    fix = sign_fix(unit, MARK_M, 30.0)  # it would be at 480 m
    assert fix.source is FixSource.SIGN
    assert isinstance(take(unit, fix), Refused)
    assert unit.position_m == 450.0


def test_near_the_mark_a_sign_is_as_good_as_a_tag() -> None:
    """Oda, table 1: about 0.1 m; a tag here counts as 0.5 m."""
    assert accuracy_m(SIGN_BEYOND_MARK_M, 0.0) < 0.25
    assert accuracy_m(70.0, 12.0) > 1.0
