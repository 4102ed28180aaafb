"""Trains without a reader of tags: virtual tags, the driver's eye, a position found anew, by the driving part alone."""

import math
from collections.abc import Callable
from typing import Final

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import TagPurpose
from onboard import notes
from onboard.duty.records import (
    AtMark,
    CrossingCommand,
    DrivingCommand,
    FoundByOtherSensor,
    Looked,
    PositionLost,
    StopLimit,
    TagBelieved,
    TagReached,
)
from onboard.fixes import EYE_WITHIN_M
from onboard.localisation.fix import MISSED_MAX, REFUSED, TAKEN, fix_by_rule, virtual_tag_bits
from onboard.mission import Mission
from onboard.motion import NO_ROOM, UnitMotion
from onboard.records import EVENT_CONTRADICTED, EVENT_FOUND, EVENT_IDLE, EVENT_PLACE, EVENT_POSITION
from onboard.unit_records import UnitParameters

MARK_B_M: Final = 660.0
RUN: Final = DrivingCommand(
    drive=True,
    target=1,
    limit=StopLimit(5, None, "end of the path"),
    on_line=True,
    held=("3", "5", "6", "7", "8"),
)
# Tags 301 to 803 of the mission lie here; 602 is the approach tag, 801 the arrival tag.
APPROACH, ARRIVAL = 4, 7
UNKNOWN_TAG: Final = 60_000


@pytest.fixture
def motion(at_start: Callable[..., UnitMotion]) -> UnitMotion:
    """At the mark of section 3, without a reader of tags."""
    motion = at_start(reads_tags=False)
    motion.obey(RUN, 0.0)
    return motion


def fix(motion: UnitMotion, low_m: float, high_m: float) -> int:
    """A fix of an absolute sensor, as the compiled tick takes it; event bits."""
    row, half_m = motion.row, (high_m - low_m) / 2.0
    known, row.fix_came = row.position_known, 0
    fix_by_rule(motion._record, low_m + half_m, half_m, half_m)
    row.found = int(not known and row.position_known)
    return int(virtual_tag_bits(motion._record, 0)) | (EVENT_FOUND if row.found else 0)


def run_to(motion: UnitMotion, position_m: float, bound_m: float) -> None:
    row = motion.row
    row.odometer_m += position_m - row.position_m
    row.position_m = position_m
    row.bound_ahead_m = row.bound_behind_m = bound_m


# virtual tags -----------------------------------------------------------------------------------------------------


def test_a_place_is_passed_once_the_whole_fix_lies_beyond_it(motion: UnitMotion, mission: Mission) -> None:
    tag_m = mission.tags[ARRIVAL].position_m
    run_to(motion, tag_m + 1.0, 40.0)
    motion.events(fix(motion, tag_m - 2.0, tag_m + 4.0))  # all the others lie behind it
    before = fix(motion, tag_m - 1.0, tag_m + 4.0)
    assert before & EVENT_PLACE == 0
    assert motion.events(before) == []
    assert motion.events(fix(motion, tag_m, tag_m + 4.0)) == [TagBelieved(ARRIVAL, found=False)]
    assert motion.taken_notes()[-1] == notes.PlacePassed(
        tag_id=mission.tags[ARRIVAL].tag_id, purpose=TagPurpose.ARRIVAL, reader="sign"
    )


def test_the_next_fix_counts_for_the_places_before_it(motion: UnitMotion) -> None:
    run_to(motion, 640.0, 20.0)
    passed = motion.events(fix(motion, 635.0, 645.0))
    assert passed == [TagBelieved(index, found=False) for index in range(3, ARRIVAL + 1)]


def test_bounds_by_the_tachometer_prove_nothing(motion: UnitMotion) -> None:
    run_to(motion, 680.0, 1.0)
    assert motion.events(EVENT_POSITION | EVENT_PLACE) == [
        TagReached(APPROACH),
        TagReached(5),
        TagReached(6),
        TagReached(8),
        Looked(),
    ]


@given(fixes=st.lists(st.tuples(st.floats(0.0, 650.0), st.floats(0.0, 60.0)), min_size=1, max_size=6))
def test_no_place_is_passed_before_a_fix_proves_it(
    motion: UnitMotion, mission: Mission, fixes: list[tuple[float, float]]
) -> None:
    """Whatever the tachometer shows, and however wide the fixes are."""
    motion._fixes._places.take_up(mission.tags)
    proved, lows = set[int](), [-math.inf]
    for low_m, width_m in fixes:
        run_to(motion, 690.0, 690.0)
        lows.append(low_m)
        for event in motion.events(fix(motion, low_m, low_m + width_m)):
            assert isinstance(event, TagBelieved)
            proved.add(event.tag)
    for index in proved:
        assert mission.tags[index].position_m <= max(lows)


def test_who_reads_tags_has_no_virtual_ones(motion: UnitMotion, mission: Mission) -> None:
    motion._fixes.take_up(mission, virtual=False)
    run_to(motion, 640.0, 20.0)
    assert motion.events(fix(motion, 635.0, 645.0)) == []
    assert motion.taken_notes() == []
    assert motion._fixes.ask_m == math.inf


def test_what_asks_for_something_ahead_goes_by_the_estimate(motion: UnitMotion, mission: Mission) -> None:
    assert motion.row.position_trigger_m == mission.tags[APPROACH].position_m
    run_to(motion, mission.tags[APPROACH].position_m, 30.0)
    assert TagReached(APPROACH) in motion.events(EVENT_POSITION)
    motion.obey(RUN, 1.0)
    assert motion.row.position_trigger_m == mission.tags[APPROACH + 1].position_m


def test_an_estimate_that_nobody_believes_reaches_nothing(motion: UnitMotion, mission: Mission) -> None:
    """Each step of a train that had lost its position was a stretch of its own: the day stood still."""
    run_to(motion, mission.tags[APPROACH].position_m, 30.0)
    lose(motion)
    motion.obey(RUN, 1.0)
    assert motion.row.position_trigger_m == math.inf
    motion.row.position_known = 1
    motion.obey(RUN, 2.0)
    assert motion.row.position_trigger_m == mission.tags[APPROACH].position_m


# bounds that are wrong ----------------------------------------------------------------------------------------------


def test_fixes_that_miss_the_bounds_one_after_the_other_give_the_position_up(motion: UnitMotion) -> None:
    run_to(motion, 300.0, 5.0)
    bits = [fix(motion, 400.0, 410.0) for _ in range(MISSED_MAX + 1)]
    assert bits == [0, 0, EVENT_CONTRADICTED, 0]
    assert motion.events(EVENT_CONTRADICTED) == [PositionLost()]
    assert motion.row.position_known == 0


def test_one_that_fits_between_them_forgives(motion: UnitMotion) -> None:
    run_to(motion, 300.0, 5.0)
    for _ in range(3):
        assert fix(motion, 400.0, 410.0) == fix(motion, 400.0, 410.0) == 0
        fix(motion, 290.0, 310.0)


# found anew ---------------------------------------------------


def lose(motion: UnitMotion) -> None:
    motion._lose("a test")
    motion.taken_notes()


def test_a_fix_finds_a_position_where_the_unit_holds_all_it_may_stand_in(motion: UnitMotion) -> None:
    lose(motion)
    assert motion.events(fix(motion, 300.0, 310.0)) == [FoundByOtherSensor(), TagBelieved(3, found=False)]
    assert motion.row.position_known == 1
    assert motion.place().untold


@pytest.mark.parametrize("held", [(), ("3", "5"), ("6", "7")])
def test_and_nowhere_else(motion: UnitMotion, held: tuple[str, ...]) -> None:
    """Its rear may be on 5, its front on 6: holding one of them, it may be on another track."""
    lose(motion)
    motion.command = msgspec.structs.replace(RUN, held=held)
    assert motion.events(fix(motion, 180.0, 200.0)) == []
    assert motion.row.position_known == 0
    assert motion.taken_notes() == [notes.FoundElsewhere(reader="sign")]
    assert motion.events(fix(motion, 180.0, 200.0)) == []
    assert motion.taken_notes() == []  # said once


def test_nor_off_its_path(motion: UnitMotion) -> None:
    lose(motion)
    assert motion.events(fix(motion, -500.0, -490.0)) == []
    assert motion.row.position_known == 0


@pytest.mark.parametrize(
    ("low_m", "believed"), [(400.0, True), (210.1, True), (200.0, False), (515.0, False)]
)
def test_before_the_manager_answers_only_on_open_line(
    motion: UnitMotion, low_m: float, believed: bool
) -> None:
    """Section 6, from 170 to 520 m, has no other track beside it; the train is 40 m long."""
    lose(motion)
    motion.command = DrivingCommand()
    assert bool(motion.events(fix(motion, low_m, low_m + 10.0))) is believed
    assert bool(motion.row.position_known) is believed


def test_after_a_tag_of_another_track_only_a_tag_tells_that_it_is_on_its_path(
    motion: UnitMotion, mission: Mission
) -> None:
    """What does not tell tracks apart cannot stand against a tag that does, whatever the register has."""
    motion.reads_tags = True
    motion._fixes.take_up(mission, virtual=False)
    run_to(motion, 300.0, 5.0)
    assert motion.tag_read(9999, motion.row.odometer_m) == [PositionLost()]
    assert motion.events(fix(motion, 295.0, 305.0)) == []
    assert motion.row.position_known == 0
    motion._fixes.tag_believed(mission.tags[APPROACH], 0.0)
    assert motion.events(fix(motion, 295.0, 305.0)) == [FoundByOtherSensor()]


# the driver's eye ---------------------------------------------------


def test_the_drivers_eye_is_a_fix(motion: UnitMotion, mission: Mission) -> None:
    run_to(motion, MARK_B_M - 3.0, 30.0)
    assert motion.place().unsure
    passed = motion.at_mark(AtMark(1))
    assert passed == [TagBelieved(i, found=False) for i in range(3, ARRIVAL + 2)]
    row = motion.row
    assert row.position_m - row.bound_behind_m == pytest.approx(MARK_B_M - EYE_WITHIN_M)
    assert row.position_m + row.bound_ahead_m == pytest.approx(MARK_B_M + EYE_WITHIN_M)
    assert not motion.place().unsure


def test_after_it_the_unit_is_sure_wherever_in_its_bounds_the_estimate_stays(motion: UnitMotion) -> None:
    """The estimate goes but part of the way to it, so that one of the bounds is wider than half of what is left."""
    run_to(motion, MARK_B_M - 6.0, 12.0)
    motion.at_mark(AtMark(1))
    row = motion.row
    assert row.bound_ahead_m > EYE_WITHIN_M + 1.0
    assert row.bound_ahead_m + row.bound_behind_m == pytest.approx(2.0 * EYE_WITHIN_M)
    assert not motion.place().unsure


def test_it_outranks_bounds_that_it_contradicts(motion: UnitMotion) -> None:
    run_to(motion, MARK_B_M, 1.0)
    motion.at_mark(AtMark(1, beyond_m=20.0))
    row = motion.row
    assert row.position_m == pytest.approx(MARK_B_M + 20.0)
    assert row.bound_ahead_m == pytest.approx(EYE_WITHIN_M)


def test_it_finds_a_position(motion: UnitMotion) -> None:
    lose(motion)
    assert motion.at_mark(AtMark(1))[0] == FoundByOtherSensor()
    assert motion.row.position_known == 1


def test_but_not_on_a_track_that_the_register_does_not_have(motion: UnitMotion) -> None:
    lose(motion)
    motion.command = msgspec.structs.replace(RUN, held=("3",))
    assert motion.at_mark(AtMark(1)) == []
    assert motion.row.position_known == 0


def test_who_reads_tags_does_not_go_by_it(motion: UnitMotion, mission: Mission) -> None:
    motion._fixes.take_up(mission, virtual=False)
    run_to(motion, MARK_B_M - 3.0, 30.0)
    assert motion.at_mark(AtMark(1)) == []
    assert motion.row.bound_ahead_m == 30.0
    assert not motion.place().unsure


# a tag read in the step in which another sensor finds the position ------------------------------------------------


def with_a_reader(motion: UnitMotion, mission: Mission) -> None:
    motion.reads_tags = True
    motion._fixes.take_up(mission, virtual=False)


def test_a_tag_goes_before_what_is_found_in_the_same_step(motion: UnitMotion, mission: Mission) -> None:
    """What a receiver says 50 m further on is no reason to doubt the tag, and is not found any more."""
    with_a_reader(motion, mission)
    lose(motion)
    motion._doubt.position_told()
    motion._doubt._doubting = False
    bits, tag = fix(motion, 500.0, 520.0), mission.tags[APPROACH]
    assert motion.tag_read(tag.tag_id, float(motion.row.odometer_m)) == [TagBelieved(APPROACH, found=True)]
    assert motion.events(bits) == []
    assert motion.row.position_known == 1
    assert motion.row.position_m == pytest.approx(tag.position_m)


def test_nothing_is_found_in_a_step_in_which_the_position_is_lost(
    motion: UnitMotion, mission: Mission
) -> None:
    with_a_reader(motion, mission)
    lose(motion)
    bits = fix(motion, 500.0, 520.0)
    assert motion.tag_read(UNKNOWN_TAG, float(motion.row.odometer_m)) == [PositionLost()]
    assert motion.events(bits) == []
    assert motion.row.position_known == 0


# the tachometer, by fixes ---------------------------------------------------


def stretched(motion: UnitMotion, factor: float) -> None:
    """Two fixes 400 m apart, the tachometer having shown `factor` times that."""
    row = motion.row
    motion.events(fix(motion, 99.9, 100.1) | EVENT_PLACE)
    row.odometer_m += 400.0 * factor
    row.position_m, row.bound_ahead_m, row.bound_behind_m = 500.0, 80.0, 80.0
    motion.events(fix(motion, 499.9, 500.1) | EVENT_PLACE)


def test_two_fixes_measure_the_wheels(motion: UnitMotion) -> None:
    run_to(motion, 100.0, 1.0)
    stretched(motion, 1.01)
    assert motion.row.odometer_scale == pytest.approx(1.0 / 1.01, abs=0.006)


@pytest.mark.parametrize(("factor", "sound"), [(1.005, True), (1.1, False)])
def test_they_end_the_doubt_about_it_where_it_agrees(motion: UnitMotion, factor: float, sound: bool) -> None:
    run_to(motion, 100.0, 1.0)
    motion.row.bound_growth = 0.2
    stretched(motion, factor)
    assert (motion.row.bound_growth <= UnitParameters().wheel_error_share) is sound


def test_what_leans_without_cutting_proves_nothing(motion: UnitMotion) -> None:
    """A camera leans the estimate and tells TAKEN all the same."""
    run_to(motion, 640.0, 20.0)
    motion.row.fix_came = 0
    assert virtual_tag_bits(motion._record, 0) == 0
    assert motion.row.sure_m == -math.inf


def test_outcomes_of_the_rule_are_told_apart(motion: UnitMotion) -> None:
    row = motion._record
    run_to(motion, 300.0, 5.0)
    assert fix_by_rule(row, 300.0, 2.0, 2.0) == TAKEN
    assert fix_by_rule(row, 400.0, 2.0, 2.0) == REFUSED


# no room to go on -------------------------------------------------------------------------------------------------


def stand_idle(motion: UnitMotion, short_m: float, bound_m: float) -> list[object]:
    """Stand so far short of the mark, which the limit lies just behind, with such bounds, and report it."""
    run_to(motion, MARK_B_M - short_m, bound_m)
    motion.row.speed_mps = 0.0
    motion.row.stop_limit_m = MARK_B_M + 10.0
    return list(motion.events(EVENT_IDLE))


def test_a_train_that_stands_since_its_bounds_leave_no_room_gives_its_position_up(motion: UnitMotion) -> None:
    """It may drive on to its mark, and stands: nothing else would ever change that."""
    assert stand_idle(motion, 300.0, 320.0) == [PositionLost()]
    assert motion.row.position_known == 0
    assert notes.PositionFault(why=NO_ROOM) in motion.taken_notes()


def test_a_crossing_beyond_its_mark_is_nothing_to_wait_for(motion: UnitMotion) -> None:
    """Its unit asks that once it has called."""
    motion.obey(msgspec.structs.replace(RUN, crossings=CrossingCommand("C", "C")), 0.0)
    assert stand_idle(motion, 300.0, 320.0) == [PositionLost()]


def test_a_train_that_has_room_and_stands_waits_for_something_else(motion: UnitMotion) -> None:
    assert stand_idle(motion, 300.0, 20.0) == []
    assert motion.row.position_known == 1


def test_a_position_that_was_given_up_for_want_of_room_is_not_found_again_without(motion: UnitMotion) -> None:
    stand_idle(motion, 300.0, 320.0)
    bits = fix(motion, MARK_B_M - 40.0, MARK_B_M + 5.0)  # its mark lies within
    assert bits & EVENT_FOUND
    assert motion.events(bits) == []
    assert motion.row.position_known == 0
    assert FoundByOtherSensor() in motion.events(fix(motion, MARK_B_M - 110.0, MARK_B_M - 60.0))


def test_a_position_as_narrow_as_the_drivers_eye_is_found_again_anywhere(motion: UnitMotion) -> None:
    stand_idle(motion, 300.0, 320.0)
    assert FoundByOtherSensor() in motion.events(fix(motion, MARK_B_M - 4.0, MARK_B_M + 4.0))
