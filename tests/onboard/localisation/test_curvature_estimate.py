"""What a fix by curvature does to the estimate, and what is learned of the gyro's bias to the metres in the ring."""

from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard.localisation.collation import all_squares, explained_shifts
from onboard.localisation.curvature import take_fix
from onboard.localisation.curvature_bounds import explained_by_jump, turn_to_bias, without_jump
from onboard.localisation.curvature_ring import keep_metre, keep_within
from onboard.localisation.curvature_row import BY_SPACE, WINDOW_MAX, CurvatureRow
from onboard.localisation.fix import REFUSED, TAKEN, fix_by_rule
from onboard.localisation.spatial_filter import CORNER_M, filtered_sample, sections, step_response
from onboard.localisation.table import READERS_ROW
from onboard.records import UnitRow

halves_m = st.floats(0.5, 40.0)
shares = st.floats(-1.0, 1.0)


@pytest.fixture
def own() -> CurvatureRow:
    """A reader that knows nothing yet, with the filter by distance."""
    rows: Any = np.zeros(1, dtype=READERS_ROW).view(np.recarray)
    row = rows[0].curvature
    row.settings.sure_sigmas, row.worn_share, row.doubtful_share = 5.0, 0.018, 0.02
    row.scale_low, row.scale_high = 0.982, 1.018
    row.filtered, row.settling_m = BY_SPACE, -1.0
    row.numbers[:] = sections(CORNER_M)
    return cast("CurvatureRow", row)


def believe(unit: UnitRow, at_m: float, half_m: float) -> None:
    unit.position_m, unit.bound_behind_m, unit.bound_ahead_m = at_m, half_m, half_m


@given(within_m=halves_m, bounds_m=halves_m, its_m=halves_m, share=shares)
def test_the_estimate_moves_only_as_far_as_the_fix_is_better(
    own: CurvatureRow, unit: UnitRow, within_m: float, bounds_m: float, its_m: float, share: float
) -> None:
    believe(unit, 500.0, bounds_m)
    own.within_m, own.anchored = within_m, 0
    fix_m = 500.0 + share * (bounds_m + its_m)
    outcome = take_fix(own, unit, fix_m, its_m, its_m, its_m)
    low_m, high_m = unit.position_m - unit.bound_behind_m, unit.position_m + unit.bound_ahead_m
    if outcome == REFUSED:
        assert abs(fix_m - 500.0) > bounds_m + its_m - 1e-9
        return
    assert low_m == pytest.approx(max(500.0 - bounds_m, fix_m - its_m))
    assert high_m == pytest.approx(min(500.0 + bounds_m, fix_m + its_m))
    if its_m >= within_m:  # it only has to lie inside what is left
        assert unit.position_m == pytest.approx(min(max(500.0, low_m), high_m))
        assert own.within_m == within_m
    else:
        assert its_m <= own.within_m <= within_m


def test_by_the_rule_for_all_other_readers_a_weak_fix_moves_it(own: CurvatureRow, unit: UnitRow) -> None:
    """On a long straight there is one each 25 m, from the same metres of rails: the estimate would lean onto them."""
    for _ in range(10):
        believe(unit, 500.0, 6.0)
        own.within_m = 6.0
        assert take_fix(own, unit, 506.0, 8.0, 8.0, 8.0) == TAKEN
        assert unit.position_m == 500.0
    assert fix_by_rule(unit, 506.0, 8.0, 8.0) == TAKEN
    assert unit.position_m > 501.0


def test_what_the_estimate_may_be_wrong_by_grows_with_the_run_and_falls_with_anothers_fix(
    own: CurvatureRow, unit: UnitRow
) -> None:
    believe(unit, 500.0, 6.0)
    own.within_m = 3.0
    keep_within(own, unit, 0.5)
    assert own.within_m == 3.5
    believe(unit, 500.0, 1.0)  # a tag
    keep_within(own, unit, 0.5)
    assert own.within_m == 1.0


def test_another_bias_leaves_no_step_in_the_ring(own: CurvatureRow) -> None:
    """A bias that was believed wrongly, over changing speed: nothing of it is left, before and behind the front."""
    bias_radps = 1.5e-3
    slow_s_per_m = 1.0 / (15.0 + 5.0 * np.sin(np.arange(1200.0) / 300.0))
    for slow in slow_s_per_m[:1000]:
        keep_metre(own, bias_radps * slow, slow)
    before = np.array(own.bent_per_m[own.at + WINDOW_MAX - 300 : own.at + WINDOW_MAX])
    assert np.abs(before).min() > 5e-5
    turn_to_bias(own, own.bias_radps + bias_radps)
    assert own.bias_radps == bias_radps
    for slow in slow_s_per_m[1000:]:
        keep_metre(own, 0.0, slow)
    after = np.array(own.bent_per_m[own.at + WINDOW_MAX - 600 : own.at + WINDOW_MAX])
    # the filter's own delay over the changing speed is all that is left
    assert np.abs(after).max() < 0.05 * np.abs(before).max()


SEEN_M, SPAN_M, TRUE = 300, 40, 20


def seen_with_a_jump(own: CurvatureRow, first: int, jump_radps: float) -> np.ndarray:
    """A run on a straight before a curve, in which the gyro's bias jumps from metre `first` on; returns the map."""
    own.rises[:] = step_response(np.array(own.numbers))
    own.span = SPAN_M
    own.slow_s_per_m[:] = 0.1
    # the curve begins before the map ends
    known = np.interp(np.arange(float(SEEN_M + SPAN_M)), [0.0, 318.0, 340.0], [0.0, 0.0, 5e-4])
    step = np.zeros(SEEN_M)
    step[first:] = 0.1 * jump_radps
    kept = np.zeros(4)
    filtered = np.array([filtered_sample(np.array(own.numbers), kept, value) for value in step])
    begin = own.at + WINDOW_MAX - SEEN_M
    own.bent_per_m[begin : begin + SEEN_M] = known[TRUE : TRUE + SEEN_M] + filtered
    return known


@pytest.mark.parametrize("back_m", [3, 33, 63, 99, 150, 270])
@pytest.mark.parametrize("jump_radps", [-8e-3, 3e-3])
def test_a_jump_leaves_nothing_over_at_the_true_shift(
    own: CurvatureRow, back_m: int, jump_radps: float
) -> None:
    known = seen_with_a_jump(own, SEEN_M - back_m, jump_radps)
    plain = np.array(own.bent_per_m[own.at + WINDOW_MAX - SEEN_M : own.at + WINDOW_MAX])
    assert without_jump(own, known, SEEN_M, TRUE) < 1e-3 * float(
        np.sum((known[TRUE : TRUE + SEEN_M] - plain) ** 2)
    )


def test_a_jump_that_looks_like_a_curve_hides_no_shift(own: CurvatureRow) -> None:
    """Without it the curve that comes would have been entered already, by all that is left over."""
    known = seen_with_a_jump(own, SEEN_M - 24, 4e-3)
    energy, free = np.zeros(SPAN_M + 1), np.zeros(SPAN_M + 1)
    begin = own.at + WINDOW_MAX - SEEN_M
    least = all_squares(known, own.bent_per_m, begin, SEEN_M, SPAN_M, energy, free)
    limit = 2e-8
    hull = explained_shifts(free, SPAN_M, least, 8, free[least] + limit, free[least] + limit)
    assert not hull[0] <= TRUE <= hull[1]
    most = without_jump(own, known, SEEN_M, least) + limit
    from_m, to_m = explained_by_jump(own, known, SEEN_M, hull, most)
    assert from_m <= TRUE <= to_m
