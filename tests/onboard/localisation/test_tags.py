"""Which tag is believed after a position fault, and when the bounds become narrow again."""

import numpy as np
import pytest

from network.model import TagPurpose
from onboard.localisation.tags import TagDoubt
from onboard.mission import PathTag
from onboard.unit_records import UnitParameters

PARAMETERS = UnitParameters()
# as between A and B on the test line: tags 601 to 603 and 701
FIRST, SECOND, THIRD, FOURTH = (
    PathTag(tag_id, position_m, TagPurpose.POSITION)
    for tag_id, position_m in ((601, 165.0), (602, 300.0), (603, 350.0), (701, 550.0))
)


@pytest.fixture
def doubt(unit: np.recarray) -> TagDoubt:
    """A unit that has read FIRST where it is; the tachometer counts path coordinates."""
    unit.bound_growth = PARAMETERS.wheel_error_share
    unit.position_m = unit.odometer_m = FIRST.position_m
    unit.bound_ahead_m = unit.bound_behind_m = PARAMETERS.tag_accuracy_m
    tags = TagDoubt(unit, PARAMETERS)
    tags.new_path((FIRST, SECOND, THIRD, FOURTH))
    tags.believe_tag(FIRST, FIRST.position_m)
    return tags


def fault_at(doubt: TagDoubt, unit: np.recarray, position_m: float) -> None:
    unit.position_m = unit.odometer_m = position_m
    doubt.begin_doubt()
    unit.position_known = 0


def test_without_a_fault_every_tag_that_may_be_read_is_believed(doubt: TagDoubt) -> None:
    assert doubt.believes(SECOND, SECOND.position_m)


def test_a_fault_widens_the_bounds_by_what_may_be_false_since_the_last_tag(
    doubt: TagDoubt, unit: np.recarray
) -> None:
    fault_at(doubt, unit, 265.0)
    wide_m = PARAMETERS.tag_accuracy_m + PARAMETERS.doubt_error_share * 100.0
    assert unit.bound_ahead_m == unit.bound_behind_m == pytest.approx(wide_m)
    assert unit.bound_growth == PARAMETERS.doubt_error_share


def test_the_only_tag_that_can_be_meant_is_believed(doubt: TagDoubt, unit: np.recarray) -> None:
    fault_at(doubt, unit, 310.0)
    unit.position_m = unit.odometer_m = THIRD.position_m
    assert doubt.believes(THIRD, THIRD.position_m)


def test_swapped_tags_are_not_believed_and_a_true_one_after_them_is(
    doubt: TagDoubt, unit: np.recarray
) -> None:
    """SECOND and THIRD lie in each other's place: the first reading is the fault, the other must not fix it."""
    fault_at(doubt, unit, SECOND.position_m)
    unit.position_m = unit.odometer_m = THIRD.position_m
    assert not doubt.believes(SECOND, THIRD.position_m)
    unit.position_m = unit.odometer_m = FOURTH.position_m
    assert doubt.believes(FOURTH, FOURTH.position_m)


def test_where_more_than_one_can_be_meant_two_must_agree(doubt: TagDoubt, unit: np.recarray) -> None:
    fault_at(doubt, unit, SECOND.position_m)
    unit.bound_ahead_m = unit.bound_behind_m = 500.0
    assert not doubt.believes(SECOND, 1000.0)
    assert not doubt.believes(THIRD, 1000.0 + 2.0 * (THIRD.position_m - SECOND.position_m))
    unit.odometer_m = 1000.0 + 2.0 * 50.0 + 200.0
    assert doubt.believes(FOURTH, 1000.0 + 2.0 * 50.0 + FOURTH.position_m - THIRD.position_m)


def test_an_ambiguous_tag_fixes_nothing(doubt: TagDoubt, unit: np.recarray) -> None:
    """At 325 m within 40 m either way it may be the one at 300 m or that at 350 m, whichever says its name."""
    fault_at(doubt, unit, 325.0)
    unit.bound_ahead_m = unit.bound_behind_m = 40.0
    assert not doubt.believes(THIRD, 325.0)
    unit.bound_ahead_m = unit.bound_behind_m = 20.0
    assert not doubt.believes(THIRD, 325.0)  # nor may one that cannot be there
    unit.bound_ahead_m = 30.0
    assert doubt.believes(THIRD, 325.0)


def test_the_bounds_stay_wide_until_tags_and_tachometer_agree(doubt: TagDoubt, unit: np.recarray) -> None:
    fault_at(doubt, unit, SECOND.position_m)
    unit.position_known = 1
    doubt.believe_tag(SECOND, 300.0)
    assert unit.bound_growth == PARAMETERS.doubt_error_share
    doubt.believe_tag(THIRD, 300.0 + 0.9 * 50.0)  # a tenth too little
    assert unit.bound_growth == PARAMETERS.doubt_error_share
    doubt.believe_tag(FOURTH, 345.0 + 200.0)
    assert unit.bound_growth == pytest.approx(PARAMETERS.wheel_error_share)


def test_nothing_is_freed_on_what_a_tachometer_may_show_too_much(doubt: TagDoubt, unit: np.recarray) -> None:
    assert doubt.release_margin_m(standing=False) == 0.0
    unit.position_m = FIRST.position_m + 100.0
    margin_m = doubt.release_margin_m(standing=False)
    assert margin_m == pytest.approx(PARAMETERS.doubt_error_share * 100.0)
    assert doubt.release_margin_m(standing=True) == 0.0  # its driver sees the mark


@pytest.mark.parametrize("end_m", [170.0, 220.0, 400.0])
def test_the_trigger_is_where_the_margin_lets_go(doubt: TagDoubt, unit: np.recarray, end_m: float) -> None:
    length_m = 40.0
    rear_m = doubt.release_trigger_m(end_m, length_m)
    unit.position_m = rear_m + length_m + unit.bound_behind_m
    assert rear_m - doubt.release_margin_m(standing=False) == pytest.approx(end_m)
