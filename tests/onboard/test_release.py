"""Sections are given back at the arrival tag, once: however much a tachometer shows, none is freed under the train.

Sugiyama et al. 2017, section 2.2 and figure 3, (1); a tag that is read is where it lies, a tachometer may be wrong.
Here the tag 701 between the points is missing, so that nothing tells the unit earlier that it is wrong.
"""

from collections.abc import Callable
from dataclasses import replace

import pytest

from onboard.authority.records import Cleared
from onboard.duty import machine
from onboard.duty.duty_step import DutyStep
from onboard.duty.records import AtMark, DutyPhase, Finished, NotAtMark
from onboard.duty.stop_limit import cleared_sections
from onboard.mission import Mission
from onboard.plan import plan_of
from onboard.records import EMERGENCY_INTERVENTION, EVENT_SAFE_REAR
from onboard.unit_records import UnitParameters
from radio.messages import HoldingConfirmed, HoldingReport
from tests.onboard.unit_bench import MANAGER, MARK_B_M, REAR_M, SECTIONS, TOKEN, UNIT, Bench

TAG_603_M, END_OF_6_M, END_OF_7_M = 360.0, 520.0, 580.0
ALL = ("3", *SECTIONS)


@pytest.fixture
def mission(mission: Mission) -> Mission:
    return replace(mission, tags=tuple(tag for tag in mission.tags if tag.tag_id != 701))


@pytest.fixture
def over_reading(cleared_to_b: Bench) -> Callable[[float], Bench]:
    """Since tag 603 the tachometer has shown 1.3 times the way: the train is truly where the test says."""
    cleared_to_b.read(603)

    def truly_at(front_m: float) -> Bench:
        row = cleared_to_b.row
        row.position_m = TAG_603_M + 1.3 * (front_m - TAG_603_M)
        row.bound_behind_m = 0.5 + UnitParameters().wheel_error_share * (row.position_m - TAG_603_M)
        return cleared_to_b

    return truly_at


def clears_by_the_odometer(turn: DutyStep) -> None:
    """Release as it was: whatever the safe rear has left."""
    state = turn.state
    cleared = cleared_sections(turn.plan, state.authority, state.place.clear)
    if cleared:
        turn.authority(Cleared(cleared))


def check_holds_what_it_stands_in(over_reading: Callable[[float], Bench]) -> None:
    """Metre by metre up to the arrival tag: what is not behind the true rear is held."""
    for front_m in range(400, 632):
        bench = over_reading(float(front_m))
        bench.ticked(EVENT_SAFE_REAR)
        assert front_m - REAR_M >= END_OF_6_M or "6" in bench.held
        assert front_m - REAR_M >= END_OF_7_M or "7" in bench.held


def test_a_tachometer_that_shows_too_much_frees_nothing_under_the_train(
    over_reading: Callable[[float], Bench],
) -> None:
    check_holds_what_it_stands_in(over_reading)


def test_without_the_tag_it_would(
    over_reading: Callable[[float], Bench], monkeypatch: pytest.MonkeyPatch
) -> None:
    """1.3 is more than the odometer's own margin (1.25) covers."""
    monkeypatch.setattr(machine, "clear_behind", clears_by_the_odometer)
    with pytest.raises(AssertionError, match="'6' in"):
        check_holds_what_it_stands_in(over_reading)


def test_before_the_arrival_tag_nothing_is_given_back_however_far_it_is(cleared_to_b: Bench) -> None:
    row = cleared_to_b.row
    row.odometer_m += 631.0 - row.position_m
    row.position_m = 631.0
    cleared_to_b.ticked(EVENT_SAFE_REAR)
    assert cleared_to_b.said == []
    assert cleared_to_b.held == ALL
    cleared_to_b.read(801)
    assert cleared_to_b.said == [HoldingReport(("8",), TOKEN)]
    cleared_to_b.hear(MANAGER, HoldingConfirmed(("8",), TOKEN))
    for tag_id in (802, 803):  # once
        cleared_to_b.read(tag_id)
        assert cleared_to_b.said == []


def test_the_arrival_tag_missed_the_tags_read_so_far_count_at_the_mark(cleared_to_b: Bench) -> None:
    cleared_to_b.read(803)
    assert cleared_to_b.held == ALL
    cleared_to_b.stop(MARK_B_M)
    assert cleared_to_b.held == ("8",)


@pytest.fixture
def stands(over_reading: Callable[[float], Bench]) -> Bench:
    """By its tachometer at the mark at 660 m; truly its front is at 590.8 m and its rear in section 7."""
    bench = over_reading(TAG_603_M + (MARK_B_M - TAG_603_M) / 1.3)
    bench.stop(MARK_B_M)
    assert "arrived" in bench.notes
    return bench


def test_at_a_mark_by_the_tachometer_alone_the_driver_must_look(stands: Bench) -> None:
    assert stands.held == ("6", "7", "8")  # tag 603 proves 3 and 5 to be behind
    stands.hear(MANAGER, HoldingConfirmed(("6", "7", "8"), TOKEN))
    assert stands.told == ()
    assert stands.motion.command.confirm
    assert stands.waits_for == "the driver's confirmation that the whole train has arrived"


def test_the_driver_sees_that_it_has_arrived(stands: Bench) -> None:
    stands.hear(MANAGER, HoldingConfirmed(("6", "7", "8"), TOKEN))
    stands.tell([AtMark(1)])
    assert stands.held == ("8",)
    stands.hear(MANAGER, HoldingConfirmed(("8",), TOKEN))
    assert stands.told == (Finished("T1"),)


def test_the_driver_sees_that_it_has_not_and_it_goes_on_on_sight(stands: Bench) -> None:
    confirmed = HoldingConfirmed(("6", "7", "8"), TOKEN)
    stands.now_s += 0.2
    data = stands.devices[MANAGER].seal(UNIT, confirmed, stands.now_s, stands.correlation[MANAGER])
    stands.tell([NotAtMark()], [data])  # a telegram at the same moment finds no position any more
    assert stands.phase is DutyPhase.ON_SIGHT
    assert (stands.row.position_known, stands.row.intervention) == (0, EMERGENCY_INTERVENTION)
    assert stands.held == ("6", "7", "8")
    stands.at(stands.now_s + UnitParameters().emergency_release_s)
    stands.row.speed_mps = 3.0
    for tag_id in (801, 802, 803):  # the first is ambiguous, and fixes nothing
        stands.read(tag_id)
    assert stands.held == ("6", "7", "8")
    stands.stop(MARK_B_M)
    assert stands.phase is DutyPhase.STANDING
    assert stands.held == ("8",)


def test_where_the_line_has_no_such_tag_the_driver_frees_at_the_mark(
    cleared_to_b: Bench, mission: Mission
) -> None:
    """The weaker protection, of which `branchline check` says so; never the odometer alone."""
    bare = replace(mission, tags=tuple(tag for tag in mission.tags if tag.tag_id < 700))
    cleared_to_b.unit.plan = plan_of(bare, REAR_M)
    assert cleared_to_b.unit.plan.stops[1].by_eye
    cleared_to_b.stop(MARK_B_M)
    assert len(cleared_to_b.held) > 1
    cleared_to_b.hear(MANAGER, HoldingConfirmed(cleared_to_b.held, TOKEN))
    assert cleared_to_b.motion.command.confirm
    cleared_to_b.tell([AtMark(1)])
    assert cleared_to_b.held == ("8",)
