"""Unit and driving part together, phase by phase, with hand-made telegrams of a block manager and point terminals."""

import math
from collections.abc import Callable
from dataclasses import replace

import msgspec
import pytest

from network.model import Coverage, Line, Position
from onboard import motion as driving
from onboard.duty.records import (
    Begin,
    DutyPhase,
    Event,
    Finished,
    Leave,
    LeftLine,
    OffTheLine,
    SwitchedOn,
    TakeUpWay,
    WayOrdered,
)
from onboard.motion import UnitMotion
from onboard.records import (
    EMERGENCY_INTERVENTION,
    EVENT_POSITION,
    EVENT_SAFE_REAR,
    EVENT_STOPPED,
    EVENT_TACHOMETER,
    EVENT_TAG_OVERDUE,
    MODE_DRIVE,
    MODE_HOLD,
    NO_INTERVENTION,
)
from onboard.unit import OnboardUnit
from onboard.unit_records import UnitParameters
from onboard.vehicle import VehicleInputs
from radio import messages
from tests.onboard.unit_bench import (
    DEPARTURE_S,
    LEAD_S,
    MANAGER,
    MARK_B_M,
    REAR_M,
    SECTIONS,
    TOKEN,
    UNIT,
    Bench,
    capabilities,
    proof,
)

# the run as it should be ----------------------------------------------------------------------------------------


def test_the_stop_limit_moves_on_with_the_grant_and_the_proofs(cleared_to_b: Bench) -> None:
    assert cleared_to_b.row.stop_limit_m == pytest.approx(690.0)  # the arrival track
    assert cleared_to_b.row.target_stop_m == pytest.approx(MARK_B_M)


def test_before_the_proof_it_aims_short_of_the_points(running: Bench) -> None:
    assert running.row.target_stop_m == pytest.approx(520.0 - UnitParameters().standoff_m)


def test_it_does_not_leave_towards_points_that_are_not_proven(granted: Bench) -> None:
    assert granted.row.stop_limit_m == pytest.approx(110.0)
    granted.at(DEPARTURE_S + 1.0)
    assert granted.phase is DutyPhase.STANDING
    assert granted.row.mode == MODE_HOLD
    assert granted.waits_for == "points P5: not proven"
    granted.hear("A-E", proof("P5"))
    assert granted.phase is DutyPhase.RUNNING
    assert granted.row.mode == MODE_DRIVE


def test_it_does_not_leave_before_its_time(granted: Bench) -> None:
    granted.hear("A-E", proof("P5"))
    granted.at(DEPARTURE_S - 1.0)
    assert granted.phase is DutyPhase.STANDING
    assert granted.waits_for == "departure time"


def test_a_late_clock_departs_late(granted: Bench) -> None:
    granted.hear("A-E", proof("P5"))
    granted.at(DEPARTURE_S - 600.0)  # set back by ten minutes
    assert granted.wake_at_s == DEPARTURE_S
    granted.at(DEPARTURE_S - 1.0)
    assert granted.phase is DutyPhase.STANDING
    granted.at(DEPARTURE_S)
    assert granted.phase is DutyPhase.RUNNING


def test_a_clock_that_is_set_back_leaves_no_request_waiting(granted: Bench) -> None:
    repeat_s = (granted.wake_at_s or 0.0) - granted.now_s  # the throw is not answered
    granted.at(granted.now_s + 0.5)
    granted.at(granted.now_s - 3600.0)
    assert granted.said == []
    assert granted.wake_at_s == pytest.approx(granted.now_s + repeat_s - 0.5)
    granted.at(granted.wake_at_s or 0.0)
    assert [type(message) for message in granted.said] == [messages.PointsCommand]


def test_a_refused_train_says_what_it_waits_for(bench: Bench) -> None:
    bench.at(DEPARTURE_S - LEAD_S)
    bench.hear(MANAGER, messages.RouteRefused("3>8", messages.RefusalReason.HELD, "6", "K2"))
    assert bench.waits_for == "route 3>8: held: section 6 of K2"
    bench.at(DEPARTURE_S + 100.0)
    assert bench.phase is DutyPhase.STANDING


def test_arrival_report_and_end_of_the_mission(cleared_to_b: Bench) -> None:
    cleared_to_b.read(701)
    assert cleared_to_b.held == ("3", *SECTIONS)
    cleared_to_b.read(801)  # (1) of figure 3: what is behind is given back, once
    assert cleared_to_b.held == ("8",)
    assert cleared_to_b.said == [messages.HoldingReport(("8",), TOKEN)]
    for tag_id in (802, 803):
        cleared_to_b.read(tag_id)
    cleared_to_b.stop(MARK_B_M + 0.1)
    assert "arrived" in cleared_to_b.notes
    assert cleared_to_b.phase is DutyPhase.STANDING  # until the release is confirmed
    cleared_to_b.hear(MANAGER, messages.HoldingConfirmed(("8",), TOKEN))
    assert cleared_to_b.told == (Finished("T1"),)
    assert cleared_to_b.phase is DutyPhase.FINISHED
    assert cleared_to_b.row.mode == MODE_HOLD


@pytest.mark.parametrize(
    ("beyond_m", "what", "arrived"),
    [(-5.1, "stopped_short", False), (-4.9, "arrived", True), (4.9, "arrived", True), (5.1, "overran", True)],
)
def test_stopping_off_the_mark(cleared_to_b: Bench, beyond_m: float, what: str, arrived: bool) -> None:
    cleared_to_b.stop(MARK_B_M + beyond_m)
    assert what in cleared_to_b.notes
    assert (cleared_to_b.phase is DutyPhase.STANDING) is arrived
    assert ("arrived" in cleared_to_b.notes) is arrived


def test_signing_off(at_b: Bench) -> None:
    assert at_b.told == (Finished("T1"),)
    at_b.tell([Leave()])
    assert at_b.said == [messages.SignOff(UNIT, TOKEN)]
    assert at_b.phase is DutyPhase.SIGNING_OFF
    at_b.hear(MANAGER, messages.SignOffAccepted())
    assert at_b.told == (LeftLine("T1"),)
    assert at_b.phase is DutyPhase.LEAVING
    assert at_b.held == ("8",), "its train stands there"
    at_b.tell([OffTheLine()])
    assert at_b.phase is DutyPhase.GONE
    assert at_b.held == ()


def test_booted_off_the_line_it_answers_a_manager_that_speaks_to_its_earlier_boot(at_b: Bench) -> None:
    at_b.unit = at_b.boot(2)
    at_b.hear(MANAGER, messages.ClaimQuery())
    assert (at_b.notes, at_b.said) == (["telegram_dropped"], []), "it may be on the line"
    at_b.tell([OffTheLine()])
    at_b.hear(MANAGER, messages.ClaimQuery())
    assert (at_b.notes, at_b.said) == (["telegram_dropped", "claimed"], [messages.Claim((), 0)])
    at_b.hear("A-E", proof("P5"))
    assert (at_b.notes, at_b.said) == (["telegram_dropped"], [])


def test_a_broken_telegram_takes_no_effect(granted: Bench) -> None:
    data = granted.devices["A-E"].seal(UNIT, proof("P5"), granted.now_s, granted.correlation["A-E"])
    granted.tell(telegrams=[data[:-1] + b"?"])
    assert granted.notes == ["telegram_dropped"]
    assert granted.motion.command.proven == ()
    granted.tell(telegrams=[data])
    assert "proven" in granted.notes
    granted.tell(telegrams=[data])
    assert granted.notes == ["telegram_dropped"]  # repeated


# giving back ----------------------------------------------------------------------------------------------------


@pytest.fixture
def tag_passed(cleared_to_b: Bench) -> Bench:
    """What is behind may be given back by the arrival tag, with the rear by the odometer still in section 6."""
    bench = cleared_to_b
    bench.unit.state = msgspec.structs.replace(bench.unit.state, proved=4, freed=4)
    bench.ticked(EVENT_POSITION)
    assert bench.said == [messages.HoldingReport(("6", "7", "8"), TOKEN)]
    bench.hear(MANAGER, messages.HoldingConfirmed(("6", "7", "8"), TOKEN))
    return bench


def check_given_back_by_the_safe_rear(bench: Bench) -> None:
    """Safe against the bound behind, and against a tachometer that has shown too much since tag 602 (at 310 m)."""
    row, tag_m, share = bench.row, 310.0, UnitParameters().doubt_error_share
    rear_m = 520.0 + share * (520.0 + REAR_M + row.bound_behind_m - tag_m) / (1.0 - share)
    assert row.rear_trigger_m == pytest.approx(rear_m)
    row.bound_behind_m = 2.1
    row.position_m = (520.0 + REAR_M + 2.0 - share * tag_m) / (1.0 - share)
    bench.ticked(EVENT_SAFE_REAR)
    assert bench.said == []
    row.bound_behind_m = 1.9
    bench.ticked(EVENT_SAFE_REAR)
    assert bench.said == [messages.HoldingReport(("7", "8"), TOKEN)]
    assert row.rear_trigger_m > 580.0


def test_after_the_tag_sections_are_given_back_by_the_safe_rear(tag_passed: Bench) -> None:
    check_given_back_by_the_safe_rear(tag_passed)


@pytest.mark.parametrize("off", ["the bound behind", "the margin for the tachometer"])
def test_without_either_it_would_give_back_too_early(
    tag_passed: Bench, off: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if off == "the bound behind":
        place = UnitMotion.place

        def bold(motion: UnitMotion) -> driving.PlaceInJoints:
            bound_m, motion.row.bound_behind_m = motion.row.bound_behind_m, 0.0
            found = place(motion)
            motion.row.bound_behind_m = bound_m
            return found

        monkeypatch.setattr(UnitMotion, "place", bold)
    else:
        monkeypatch.setattr("onboard.localisation.tags.TagDoubt.release_margin_m", lambda *_, **__: 0.0)
    with pytest.raises(AssertionError):
        check_given_back_by_the_safe_rear(tag_passed)


def test_at_its_mark_a_train_gives_back_without_the_margin(tag_passed: Bench) -> None:
    """The rear at 620 m has left section 7 (to 580 m), for a tachometer out of order it might not."""
    row = tag_passed.row
    row.bound_behind_m = 10.0
    margin_m = UnitParameters().doubt_error_share * (MARK_B_M - 310.0)
    assert MARK_B_M - REAR_M - row.bound_behind_m - margin_m < 580.0
    tag_passed.stop(MARK_B_M)
    assert tag_passed.held == ("8",)


# points ---------------------------------------------------------------------------------------------------------


def test_a_withdrawn_proof_draws_the_limit_back_and_is_asked_for_again(cleared_to_b: Bench) -> None:
    cleared_to_b.hear("B-W", proof("P7", None))
    assert cleared_to_b.said == [messages.PointsCommand("P7", Position.NORMAL, "7", TOKEN, b"seven")]
    assert cleared_to_b.row.stop_limit_m == pytest.approx(520.0)
    assert cleared_to_b.row.target_stop_m < 520.0
    cleared_to_b.hear("B-W", proof("P7"))
    assert cleared_to_b.row.stop_limit_m == pytest.approx(690.0)


def test_points_perhaps_under_the_train_are_never_commanded_again(cleared_to_b: Bench) -> None:
    """The front may be 1 m beyond the joint (at 520 m), or half a metre short of it."""
    cleared_to_b.row.position_m = 519.5
    cleared_to_b.row.bound_ahead_m = 1.5
    cleared_to_b.hear("B-W", proof("P7", None))
    assert cleared_to_b.said == []


def test_the_next_tag_throws_the_arrival_points_if_the_approach_tag_was_missed(running: Bench) -> None:
    running.read(603)
    assert [command.points_id for command in running.commanded] == ["P7"]


# position faults ------------------------------------------------------------------------------------------------


@pytest.fixture
def lost(running: Bench) -> Bench:
    running.ticked(EVENT_TAG_OVERDUE)
    assert "position_fault" in running.notes
    return running


def test_a_missed_tag_stops_the_train_and_it_goes_on_on_sight(lost: Bench) -> None:
    row = lost.row
    assert lost.phase is DutyPhase.ON_SIGHT
    assert (row.position_known, row.intervention) == (0, EMERGENCY_INTERVENTION)
    assert row.restricted_mps == pytest.approx(15.0 / 3.6)
    assert row.mode == MODE_HOLD  # the emergency brake is applied
    row.speed_mps = 0.0
    lost.ticked(EVENT_STOPPED)
    assert lost.waits_for == "release of the emergency brake"
    release_s = lost.now_s + UnitParameters().emergency_release_s
    assert lost.wake_at_s == release_s
    lost.at(release_s)
    assert "emergency_released" in lost.notes
    assert row.intervention == NO_INTERVENTION
    assert row.mode == MODE_DRIVE
    assert row.restricted_mps == pytest.approx(15.0 / 3.6)
    assert lost.waits_for == "a tag or another fix: its position is unknown"


def test_the_next_tag_ends_it_and_the_block_picture_is_unchanged(lost: Bench) -> None:
    lost.read(602)
    assert "position_found" in lost.notes
    assert lost.row.position_known == 1
    assert lost.row.restricted_mps == math.inf
    assert lost.held == ("3", *SECTIONS)  # nothing is given back before the arrival tag
    assert lost.row.stop_limit_m == pytest.approx(520.0)
    assert lost.phase is DutyPhase.RUNNING
    assert lost.row.intervention == EMERGENCY_INTERVENTION  # until it stands and the driver releases it


def test_without_a_position_nothing_is_given_back_and_nothing_thrown(lost: Bench) -> None:
    lost.row.position_m, lost.row.bound_behind_m = 500.0, 0.5
    held = lost.held
    lost.ticked(EVENT_SAFE_REAR)
    assert lost.said == []
    assert lost.held == held
    lost.hear("A-E", proof("P5", None))
    assert lost.said == []


@pytest.mark.parametrize("tag_id", [9999, 803])
def test_a_tag_where_none_can_be_stops_the_train(running: Bench, tag_id: int) -> None:
    """A tag of no track of this path, and one that lies half a kilometre on."""
    before_m = running.row.position_m
    running.tell(running.motion.tag_read(tag_id, float(running.row.odometer_m)))
    assert "position_fault" in running.notes
    assert running.row.intervention == EMERGENCY_INTERVENTION
    assert running.row.position_m == before_m


def test_a_tachometer_that_shows_what_cannot_be_stops_the_train(running: Bench) -> None:
    running.ticked(EVENT_TACHOMETER)
    assert running.notes[:2] == ["tachometer_fault", "position_fault"]
    assert running.phase is DutyPhase.ON_SIGHT
    assert running.row.intervention == EMERGENCY_INTERVENTION


def test_an_emergency_is_released_only_at_a_stand(running: Bench) -> None:
    running.row.intervention = EMERGENCY_INTERVENTION
    running.at(running.now_s + 100.0)
    assert running.row.intervention == EMERGENCY_INTERVENTION
    running.stop(200.0)
    running.at(running.now_s + UnitParameters().emergency_release_s)
    assert running.row.intervention == NO_INTERVENTION


def test_a_brake_that_is_not_in_order_stops_the_train_until_it_is_and_the_driver_acknowledges(
    cleared_to_b: Bench,
) -> None:
    cleared_to_b.tell(cleared_to_b.motion.vehicle_shows(VehicleInputs(brake_good=False)))
    assert cleared_to_b.notes == ["vehicle_unfit"]
    assert cleared_to_b.row.intervention == EMERGENCY_INTERVENTION
    cleared_to_b.stop(200.0)
    cleared_to_b.at(cleared_to_b.now_s + UnitParameters().emergency_release_s)
    assert cleared_to_b.row.intervention == EMERGENCY_INTERVENTION
    assert cleared_to_b.waits_for == "vehicle: brake not in order"
    cleared_to_b.tell(cleared_to_b.motion.vehicle_shows(VehicleInputs()))
    assert cleared_to_b.row.intervention == EMERGENCY_INTERVENTION
    cleared_to_b.at(cleared_to_b.wake_at_s or 0.0)
    assert (cleared_to_b.row.intervention, cleared_to_b.row.mode) == (NO_INTERVENTION, MODE_DRIVE)


def test_nothing_is_reported_that_has_not_changed(running: Bench) -> None:
    assert running.motion.vehicle_shows(VehicleInputs()) == []


def test_bounds_that_leave_no_room_to_go_on_are_a_position_fault(running: Bench) -> None:
    running.row.bound_ahead_m = UnitParameters().doubt_bound_max_m + 1.0
    running.stop(400.0)
    assert "position_fault" in running.notes
    assert running.phase is DutyPhase.ON_SIGHT


def test_switched_on_again_it_knows_nothing_and_stands_braked(running: Bench) -> None:
    """Until a tag has told the position and the manager what is held."""
    running.unit = running.boot(2)
    running.motion.switch_on(running.mission, running.path, 0.0, 0.0)
    running.row.speed_mps = 0.0
    running.tell([SwitchedOn(running.plan, None)])
    assert running.said == [messages.SignOn(UNIT, None)]
    assert running.row.position_known == 0
    assert (running.row.intervention, running.row.mode) == (EMERGENCY_INTERVENTION, MODE_HOLD)
    assert running.row.restricted_mps == pytest.approx(15.0 / 3.6)
    running.hear(MANAGER, messages.SignOnAccepted(("6", "7", "8"), TOKEN, None, capabilities()[1:]))
    assert running.phase is DutyPhase.ON_SIGHT
    running.read(602)
    assert running.phase is DutyPhase.RUNNING
    assert running.row.restricted_mps == math.inf
    assert running.held == ("6", "7", "8")
    assert running.commanded == [messages.PointsCommand("P7", Position.NORMAL, "7", TOKEN, b"seven")]


@pytest.mark.parametrize("phase", DutyPhase)
def test_a_train_number_is_taken_before_the_first_train_and_when_one_is_over(
    running: Bench, phase: DutyPhase
) -> None:
    """At any other time the plan stays: what its spans and stops are numbered by is the train that it runs."""
    plan, taken = running.plan, {DutyPhase.OFF, DutyPhase.FINISHED, DutyPhase.GONE}
    running.unit.state = msgspec.structs.replace(running.unit.state, phase=phase)
    running.tell([Begin(msgspec.structs.replace(plan, number="another"), signs_on=False)])
    assert running.unit.plan.number == ("another" if phase in taken else plan.number)


# radio ----------------------------------------------------------------------------------------------------------


def test_what_is_due_out_of_reach_goes_out_where_the_radio_begins_again(
    rtri: Line, bench_on: Callable[[Line], Bench]
) -> None:
    main = replace(rtri.alignments["main"], coverage=(Coverage(0.0, 100.0), Coverage(500.0, 1410.0)))
    bench = bench_on(replace(rtri, alignments={"main": main}))
    bench.begin()
    assert bench.said == []
    assert bench.wake_at_s == DEPARTURE_S - LEAD_S  # and no repeat
    assert bench.row.position_trigger_m == pytest.approx(141.0)  # km 0.5, and a metre
    bench.row.position_m = 141.0
    bench.ticked(EVENT_POSITION)
    assert bench.said == [messages.SignOn(UNIT, ("3",))]
    assert bench.wake_at_s == pytest.approx(bench.now_s + 2.0)


def test_timers_run_out_in_the_order_of_their_times(bench: Bench) -> None:
    """Asked late, it asks for its route first and only then finds that its time has come."""
    bench.at(DEPARTURE_S + 10.0)
    assert bench.said == [messages.RouteRequest(UNIT, "3>8", SECTIONS, 10)]
    assert bench.unit.state.may_leave
    assert bench.wake_at_s == pytest.approx(bench.now_s + 2.0)


def test_what_happened_comes_before_telegrams_and_telegrams_before_timers(
    granted: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[str] = []

    def noted(self: OnboardUnit, event: Event, *rest: object) -> None:
        taken.append(type(event).__name__)

    monkeypatch.setattr(OnboardUnit, "_take", noted)
    granted.now_s = DEPARTURE_S
    data = granted.devices["A-E"].seal(UNIT, proof("P5"), granted.now_s, granted.correlation["A-E"])
    granted.tell(granted.motion.events(EVENT_POSITION), [data])
    assert taken[:2] == ["Looked", "TelegramHeard"]
    assert set(taken[2:]) == {"TimerDue"}


# what the dispatcher orders ---------------------------------------------------------------------------------------


def test_a_way_that_was_not_ordered_is_not_taken_up(running: Bench) -> None:
    running.tell([TakeUpWay(running.plan)])
    assert running.said == []
    assert running.unit.plan == running.plan


def test_ordered_to_another_track_it_has_its_driver_take_up_that_way(bench: Bench) -> None:
    bench.at(DEPARTURE_S - LEAD_S)
    (request,) = bench.said
    assert isinstance(request, messages.RouteRequest)
    bench.hear(MANAGER, messages.TrackOrdered(request.route_id, "3>9"))
    assert bench.told == (WayOrdered("3>8", "3>9"),)
    bench.tell([TakeUpWay(bench.plan)])  # that is the way it has already
    assert bench.said == [messages.OrderRefused("3>8", messages.OrderRefusalReason.UNKNOWN_TRACK)]
