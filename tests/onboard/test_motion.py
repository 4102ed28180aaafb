"""The driving part alone: from metres to joints, and from the command to what the tick works to."""

import math
from collections.abc import Callable
from typing import Final

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from onboard import mission as mission_module
from onboard.duty.records import (
    AtMark,
    DrivingCommand,
    DrivingOrder,
    Looked,
    MarkRelation,
    PositionLost,
    Sensed,
    StopLimit,
    Stopped,
    TagBelieved,
    WheelsTurning,
)
from onboard.localisation.places import ASKS_AHEAD
from onboard.mission import Mission
from onboard.motion import ARRIVED_WITHIN_M, UnitMotion
from onboard.records import (
    EMERGENCY_INTERVENTION,
    EVENT_MOVING,
    EVENT_POSITION,
    EVENT_SAFE_REAR,
    EVENT_STOPPED,
    EVENT_TAG_OVERDUE,
    MODE_DRIVE,
    MODE_HOLD,
    NO_INTERVENTION,
    PATTERN,
    PathData,
)
from onboard.unit_records import UnitParameters

# Sections 3, 5, 6, 7 and 8 of mission T1 begin here; the path ends at 690 m.
STARTS_M: Final = (0.0, 110.0, 170.0, 520.0, 580.0)
ENDS_M: Final = (*STARTS_M[1:], 690.0)
MARK_A_M, MARK_B_M, LENGTH_M = 80.0, 660.0, 40.0
RUN: Final = DrivingCommand(drive=True, target=1, limit=StopLimit(5, None, "end of the path"), rear=0)


@pytest.fixture
def motion(at_start: Callable[[], UnitMotion]) -> UnitMotion:
    return at_start()


def test_at_the_start_it_knows_where_it_stands(motion: UnitMotion) -> None:
    place = motion.place()
    assert (place.known, place.covered, place.stands, place.emergency) == (True, True, True, False)
    assert (place.here, place.sure, place.perhaps, place.clear, place.reach) == (0, 1, 1, 0, 2)
    assert (place.near, place.passed) == (0, 0)


@given(
    position_m=st.floats(0.0, 690.0),
    ahead_m=st.floats(0.0, 60.0),
    behind_m=st.floats(0.0, 60.0),
    true_share=st.floats(0.0, 1.0),
)
def test_joints_are_counted_surely_wherever_the_front_is_within_its_bounds(
    motion: UnitMotion, position_m: float, ahead_m: float, behind_m: float, true_share: float
) -> None:
    row = motion.row
    row.position_m, row.bound_ahead_m, row.bound_behind_m = position_m, ahead_m, behind_m
    true_m = position_m - behind_m + true_share * (ahead_m + behind_m)
    place = motion.place()
    entered = sum(start_m <= true_m for start_m in STARTS_M)
    left = sum(end_m <= true_m - LENGTH_M for end_m in ENDS_M)
    assert place.sure <= entered <= place.perhaps
    assert place.clear <= place.clear_at_mark <= left
    assert place.sure <= place.here + 1 <= place.perhaps


def test_a_rear_not_known_to_be_clear_would_be_counted_without_the_bound(motion: UnitMotion) -> None:
    """The switch of the property above: with a bound of nothing, a front half a metre back is counted wrongly."""
    row = motion.row
    row.position_m, row.bound_behind_m = 150.2, 0.0
    assert motion.place().clear_at_mark == 1
    row.bound_behind_m = 0.5
    assert motion.place().clear_at_mark == 0


@pytest.mark.parametrize(
    ("position_m", "speed_mps", "near", "passed"),
    [
        (MARK_B_M - 5.1, 0.0, -1, 0),
        (MARK_B_M - 4.9, 0.0, 1, 1),  # standing, that is at the mark
        (MARK_B_M + 4.9, 0.0, 1, 1),
        (MARK_B_M - 4.9, 3.0, 1, 0),  # still moving, it is yet to be stopped at
        (MARK_B_M + 5.1, 3.0, -1, 1),
    ],
)
def test_marks_near_and_passed(
    motion: UnitMotion, position_m: float, speed_mps: float, near: int, passed: int
) -> None:
    motion.row.position_m, motion.row.speed_mps = position_m, speed_mps
    assert (motion.place().near, motion.place().passed) == (near, passed)


def test_a_start_needs_room(motion: UnitMotion) -> None:
    """To leave for less than twice the stand-off makes no sense: the joint at 110 m is 30 m off."""
    motion.row.position_m = 110.0 - 2.0 * UnitParameters().standoff_m - 0.1
    assert motion.place().reach == 1
    motion.row.position_m += 0.2
    assert motion.place().reach == 2


def test_who_does_not_know_where_it_is_says_nothing_of_joints(motion: UnitMotion) -> None:
    motion.row.position_known = 0
    motion.row.intervention = EMERGENCY_INTERVENTION
    place = motion.place()
    assert (place.known, place.emergency, place.sure, place.perhaps, place.clear) == (False, True, 0, 0, 0)
    assert place.covered  # it can only try


# what happened --------------------------------------------------------------------------------------------------


def test_a_tag_is_passed_by_its_index(motion: UnitMotion, mission: Mission) -> None:
    tag = mission.tags[2]  # 303, 2 m before the mark
    motion.row.position_m = tag.position_m + 0.3
    motion.row.odometer_m = 0.0
    assert motion.tag_read(tag.tag_id, 0.0) == [TagBelieved(2, found=False)]
    row = motion.row
    assert row.position_m < tag.position_m + 0.3  # drawn towards the tag, which lies within what may be
    assert row.position_m - row.bound_behind_m <= tag.position_m <= row.position_m + row.bound_ahead_m


def test_a_tag_tells_who_does_not_know(motion: UnitMotion, mission: Mission) -> None:
    motion.row.position_known = 0
    assert motion.tag_read(602, 0.0) == [TagBelieved(4, found=True)]
    assert motion.row.position_known == 1
    assert motion.row.position_m == pytest.approx(310.0)


@pytest.mark.parametrize("tag_id", [9999, 803])
def test_a_tag_where_none_can_be_is_a_position_fault(motion: UnitMotion, tag_id: int) -> None:
    assert motion.tag_read(tag_id, 0.0) == [PositionLost()]
    row = motion.row
    assert (row.position_known, row.intervention) == (0, EMERGENCY_INTERVENTION)
    assert row.restricted_mps == pytest.approx(15.0 / 3.6)
    assert row.expected_tag_m == row.rear_trigger_m == math.inf


@pytest.mark.parametrize("further_m", [0.0, 0.005])
def test_a_tag_passed_while_the_tachometer_shows_a_stand_is_a_fault_of_the_tachometer(
    motion: UnitMotion, further_m: float
) -> None:
    """No train that stands passes a tag ahead: it moves and does not know, though its bounds would hold the place."""
    motion.row.odometer_m, motion.row.position_m = 500.0, 309.0
    motion.row.bound_ahead_m = motion.row.bound_behind_m = 5.0
    motion.events(EVENT_STOPPED)
    assert motion.tag_read(602, 500.0 + further_m) == [PositionLost()]
    assert (motion.row.position_known, motion.row.intervention) == (0, EMERGENCY_INTERVENTION)
    assert [type(note).__name__ for note in motion.taken_notes()][-1] == "PositionFault"


@pytest.mark.parametrize("away_m", [-0.4, 0.0, 0.4])
def test_a_tag_under_a_train_that_stands_is_no_fault(motion: UnitMotion, away_m: float) -> None:
    """Where stations are as far apart as a tag from its mark, one lies under the mark of the other.

    It is read in the last or the first centimetre, where the tachometer shows a stand.
    """
    motion.row.odometer_m, motion.row.position_m = 500.0, 310.0 + away_m
    motion.events(EVENT_STOPPED)
    assert motion.tag_read(602, 500.0) == [TagBelieved(4, found=False)]
    assert (motion.row.position_known, motion.row.intervention) == (1, NO_INTERVENTION)


def test_a_tag_passed_after_a_start_is_a_tag(motion: UnitMotion) -> None:
    motion.row.odometer_m, motion.row.position_m = 500.0, 309.9
    motion.events(EVENT_STOPPED)
    motion.row.position_m, motion.row.odometer_m = 310.0, 500.1
    # the tick has yet to report the start
    assert motion.tag_read(602, 500.1) == [TagBelieved(4, found=False)]
    motion.events(EVENT_STOPPED)
    motion.events(EVENT_MOVING)
    assert motion.tag_read(602, 500.1) == [TagBelieved(4, found=False)]


def test_what_the_tick_reports(motion: UnitMotion) -> None:
    assert motion.events(EVENT_MOVING) == [WheelsTurning()]
    assert motion.events(EVENT_POSITION) == motion.events(EVENT_SAFE_REAR) == [Looked()]
    assert motion.events(EVENT_POSITION | EVENT_SAFE_REAR) == [Looked()]
    assert motion.events(EVENT_TAG_OVERDUE) == [PositionLost()]


@pytest.mark.parametrize(
    ("away_m", "how"),
    [
        (-200.0, MarkRelation.SHORT),
        (-5.1, MarkRelation.SHORT),
        (-4.9, MarkRelation.AT),
        (0.0, MarkRelation.AT),
        (4.9, MarkRelation.AT),
        (5.1, MarkRelation.BEYOND),
    ],
)
def test_a_stop_is_judged_by_the_next_mark(motion: UnitMotion, away_m: float, how: MarkRelation) -> None:
    assert ARRIVED_WITHIN_M == 5.0
    motion.obey(RUN, 0.0)
    motion.row.position_m, motion.row.speed_mps = MARK_B_M + away_m, 0.0
    (stopped,) = motion.events(EVENT_STOPPED)
    assert isinstance(stopped, Stopped)
    assert stopped.how is how
    assert stopped.away_m == pytest.approx(away_m)


def stopped_at(motion: UnitMotion, position_m: float, **row: float) -> list[Sensed]:
    """What is told of a train under way that has come to a stand there."""
    motion.obey(RUN, 0.0)
    for name, value in {"position_m": position_m, "speed_mps": 0.0, **row}.items():
        setattr(motion.row, name, value)
    return motion.events(EVENT_STOPPED)


def test_a_mark_beyond_the_limit_of_its_own_track_cannot_be_reached(motion: UnitMotion) -> None:
    """It went as far as it may on the track where it calls: it has arrived there, 10 m short."""
    assert stopped_at(motion, MARK_B_M - 10.0, stop_limit_m=MARK_B_M) == [
        Stopped(MarkRelation.AT, pytest.approx(-10.0))
    ]
    assert [type(note).__name__ for note in motion.taken_notes()] == ["StopImpossible"]
    assert not motion.place().unsure


def test_a_limit_before_its_track_that_came_too_late_is_no_stop(motion: UnitMotion, mission: Mission) -> None:
    """The train stands beyond the joint before which it was to stop, 10 m short of its mark: it goes on to that."""
    limit_m = mission.span_at(MARK_B_M).start_m
    assert stopped_at(motion, MARK_B_M - 10.0, stop_limit_m=limit_m) == [
        Stopped(MarkRelation.SHORT, pytest.approx(-10.0))
    ]


def test_a_crossing_before_its_mark_is_no_stop(motion: UnitMotion) -> None:
    """The road lies between the front and the mark, on the same track: what ends its way there is not its stop."""
    assert stopped_at(motion, MARK_B_M - 10.0, stop_limit_m=MARK_B_M - 5.0) == [
        Stopped(MarkRelation.SHORT, pytest.approx(-10.0))
    ]


def test_held_short_of_it_by_its_own_bounds_it_is_unsure_until_the_driver_has_looked(
    motion: UnitMotion,
) -> None:
    """The mark lies well within what it may go to: where the train stands, only a look from its cab can tell."""
    assert stopped_at(motion, MARK_B_M - 10.0, bound_ahead_m=40.0, stop_limit_m=MARK_B_M + 30.0) == [
        Stopped(MarkRelation.AT, pytest.approx(-10.0))
    ]
    assert motion.place().unsure
    motion.at_mark(AtMark(1))
    assert not motion.place().unsure


@pytest.mark.parametrize(("bound_m", "asked"), [(6.9, False), (7.1, True)])
def test_with_bounds_wider_than_the_eye_it_is_unsure_until_the_driver_has_looked(
    motion: UnitMotion, bound_m: float, asked: bool
) -> None:
    """The eye tells to 6 m; a metre wider on either side and it is worth a look, whatever the estimate says."""
    assert stopped_at(motion, MARK_B_M, bound_ahead_m=bound_m, bound_behind_m=bound_m) == [
        Stopped(MarkRelation.AT, pytest.approx(0.0))
    ]
    assert motion.place().unsure is asked
    motion.at_mark(AtMark(1))
    assert not motion.place().unsure


@pytest.mark.parametrize(("away_m", "bound"), [(-200.0, "bound_ahead_m"), (655.0, "bound_behind_m")])
def test_bounds_too_wide_towards_the_mark_are_a_position_fault(
    motion: UnitMotion, away_m: float, bound: str
) -> None:
    """Short of it they leave no room to go on; beyond it, by wheels that lied, the train may as well stand at it."""
    too_wide_m = UnitParameters().doubt_bound_max_m + 0.1
    assert stopped_at(motion, MARK_B_M + away_m, **{bound: too_wide_m}) == [PositionLost()]


def test_a_tag_that_may_lie_behind_already_is_not_expected(motion: UnitMotion, mission: Mission) -> None:
    """Tag 303 lies at 78 m of the path: with half a metre of bound it is due from 77.3 m, not from 77.6 m."""
    path = PathData(np.zeros(1, PATTERN), 0)
    for position_m, expected_m in ((77.3, 78.0), (77.6, 175.0)):
        motion.row.position_m = position_m
        motion.go_on(mission, path)
        assert motion.row.position_m == pytest.approx(position_m)
        assert motion.row.expected_tag_m == pytest.approx(expected_m)


def test_ends_changed_what_was_the_rear_is_the_front(
    motion: UnitMotion, mission: Mission, back: Mission
) -> None:
    """At the mark of section 8 (km 1.02), 40 m long: going up, the front is at km 0.98."""
    path = PathData(np.zeros(1, PATTERN), 0)
    row = motion.row
    row.position_m, row.bound_ahead_m, row.bound_behind_m = MARK_B_M, 1.0, 3.0
    motion.turn(back, path)
    assert back.path.kilometrage_m(float(row.position_m)) == pytest.approx(980.0)
    assert (row.bound_ahead_m, row.bound_behind_m) == (3.0, 1.0)


def test_ends_changed_without_a_position_by_an_estimate_off_the_way_back(
    motion: UnitMotion, mission: Mission, back: Mission
) -> None:
    """A tachometer has stood still since section 3, which the way back to section 4 does not touch: rear at km 0.42."""
    path = PathData(np.zeros(1, PATTERN), 0)
    motion.row.position_m, motion.row.position_known = 100.0, 0
    motion.turn(back, path)
    assert back.path.kilometrage_m(float(motion.row.position_m)) == pytest.approx(420.0)
    assert motion.row.position_known == 0
    motion.go_on(mission, path)
    assert mission.path.kilometrage_m(float(motion.row.position_m)) == pytest.approx(460.0)


def test_switched_on_for_the_way_back_no_place_on_it_is_passed(
    at_start: Callable[..., UnitMotion], back: Mission
) -> None:
    """Its power failed at the mark at km 1.02, its rear at km 0.98, short of all places but those in the track."""
    path = PathData(np.zeros(1, PATTERN), 0)
    before = at_start(reads_tags=False)
    before.row.position_m = MARK_B_M
    motion = UnitMotion(
        before._line, UnitParameters(), before._record, before._train, before._behaviour, before.keeper,
        reads_tags=False, before=before,
    )  # fmt: skip
    motion.switch_on(back, path, 0.0, 0.0)
    assert back.path.kilometrage_m(float(motion.row.position_m)) == pytest.approx(980.0)
    ahead_m = [tag.position_m for tag in back.tags if tag.purpose in ASKS_AHEAD and tag.position_m > 70.0]
    assert motion._fixes.ask_m == pytest.approx(ahead_m[0])


# what the tick works to -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("joint", range(6))
def test_the_stop_limit_in_metres(motion: UnitMotion, joint: int) -> None:
    limit_m = (*STARTS_M, 690.0)[joint]
    motion.obey(msgspec.structs.replace(RUN, limit=StopLimit(joint, None, "")), 0.0)
    assert motion.row.stop_limit_m == pytest.approx(limit_m)
    aim_m = MARK_B_M if limit_m > MARK_B_M else limit_m - UnitParameters().standoff_m
    assert motion.row.target_stop_m == pytest.approx(aim_m)


def test_it_drives_only_when_told(motion: UnitMotion) -> None:
    motion.obey(RUN, 0.0)
    assert motion.row.mode == MODE_DRIVE
    motion.obey(msgspec.structs.replace(RUN, drive=False), 0.0)
    assert motion.row.mode == MODE_HOLD


def test_an_emergency_ends_only_by_the_drivers_word(motion: UnitMotion) -> None:
    motion.row.intervention = EMERGENCY_INTERVENTION
    motion.obey(RUN, 0.0)
    assert motion.row.intervention == EMERGENCY_INTERVENTION
    motion.obey(msgspec.structs.replace(RUN, orders=(DrivingOrder.RELEASE,)), 0.0)
    assert motion.row.intervention == NO_INTERVENTION


def test_told_to_stop_it_applies_the_emergency_brake(motion: UnitMotion) -> None:
    motion.obey(msgspec.structs.replace(RUN, orders=(DrivingOrder.STOP,)), 0.0)
    assert motion.row.intervention == EMERGENCY_INTERVENTION
    assert motion.row.position_known == 1


def test_told_that_its_position_is_of_no_use_it_loses_it_and_stops(motion: UnitMotion) -> None:
    motion.obey(msgspec.structs.replace(RUN, on_sight=True, orders=(DrivingOrder.LOSE,)), 0.0)
    row = motion.row
    assert (row.position_known, row.intervention) == (0, EMERGENCY_INTERVENTION)
    assert (row.mode, row.restricted_mps) == (MODE_HOLD, pytest.approx(15.0 / 3.6))
    assert [type(note).__name__ for note in motion.taken_notes()] == ["PositionFault"]


def test_sweeping_it_knows_where_it_is_and_is_slow(motion: UnitMotion) -> None:
    motion.obey(msgspec.structs.replace(RUN, sweeps=True), 0.0)
    assert motion.row.restricted_mps == pytest.approx(15.0 / 3.6)
    assert motion.row.stop_limit_m == pytest.approx(690.0)
    motion.obey(RUN, 0.0)
    assert motion.row.restricted_mps == math.inf


def test_on_sight_it_is_slow_and_stays_within_its_section(motion: UnitMotion) -> None:
    row = motion.row
    row.position_m = 300.0
    motion.obey(DrivingCommand(drive=True, on_sight=True), 0.0)
    assert row.stop_limit_m == pytest.approx(520.0)
    assert row.target_stop_m == pytest.approx(MARK_B_M)
    assert row.restricted_mps == pytest.approx(15.0 / 3.6)
    assert row.mode == MODE_DRIVE
    row.intervention = EMERGENCY_INTERVENTION
    motion.obey(DrivingCommand(drive=True, on_sight=True), 0.0)
    assert row.mode == MODE_HOLD


@pytest.mark.parametrize(
    ("speed_mps", "keeps", "aim_m"), [(0.5, True, MARK_B_M), (0.0, True, math.inf), (0.5, False, math.inf)]
)
def test_on_sight_a_train_that_moves_keeps_its_mark_to_the_last(
    motion: UnitMotion,
    monkeypatch: pytest.MonkeyPatch,
    speed_mps: float,
    keeps: bool,
    aim_m: float,
) -> None:
    """Whatever makes it look again half a metre before it; one that stands there has called, and may go on."""
    monkeypatch.setattr(mission_module, "KEEPS_ITS_MARK", keeps)
    row = motion.row
    row.position_m, row.speed_mps = MARK_B_M - 0.5, speed_mps
    row.target_stop_m, row.braking_to_stop = MARK_B_M, 1
    motion.obey(DrivingCommand(drive=True, on_sight=True), 0.0)
    assert row.target_stop_m == pytest.approx(aim_m)
    assert row.braking_to_stop == (aim_m == MARK_B_M)


def test_without_a_position_the_crew_alone_says_how_far(motion: UnitMotion) -> None:
    motion.row.position_known = 0
    motion.obey(DrivingCommand(drive=True, on_sight=True), 0.0)
    assert motion.row.stop_limit_m == math.inf
    assert motion.row.restricted_mps == pytest.approx(15.0 / 3.6)


def test_the_rear_is_watched_where_it_frees_a_section(motion: UnitMotion) -> None:
    motion.obey(RUN, 0.0)
    share = UnitParameters().doubt_error_share
    beyond_m = 110.0 + LENGTH_M + motion.row.bound_behind_m - MARK_A_M
    assert motion.row.rear_trigger_m == pytest.approx(110.0 + share * beyond_m / (1.0 - share))
    motion.obey(msgspec.structs.replace(RUN, rear=None), 0.0)
    assert motion.row.rear_trigger_m == math.inf
