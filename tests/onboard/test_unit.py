"""The unit's duty, phase by phase, with hand-made telegrams of a block manager and point terminals."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from network.model import Coverage, Line, Position
from onboard.driving.stop_keeper import StopKeeper
from onboard.duty.mission import Mission
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
)
from onboard.rows import BehaviourRow, UnitRow
from onboard.unit import (
    Finished,
    LeftLine,
    Phase,
    Transmit,
    Unit,
    UnitAction,
    UnitFacts,
    UnitParameters,
)
from radio.envelope import Endpoint, Received
from radio.keys import key_ring
from radio.messages import (
    AnyMessage,
    Capability,
    HoldingConfirmed,
    HoldingReport,
    PointsCommand,
    PointsProof,
    RefusalReason,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    SignOff,
    SignOffAccepted,
    SignOn,
    SignOnAccepted,
)
from radio.noted import Noted
from vehicle.rows import TrainRow

Rows = NDArray[np.void]

MASTER = b"m" * 32
UNIT, MANAGER, TERMINALS = "K1", "BM", ("A-E", "B-W")
DEPARTURE_S = 36_000.0
LEAD_S, REAR_M = 45.0, 40.0
MARK_A_M, MARK_B_M = 80.0, 660.0
TOKEN = 20
SECTIONS = ("5", "6", "7", "8")


class Bench:
    """A unit at the mark of section 3 and the other ends of its channels."""

    def __init__(
        self,
        line: Line,
        mission: Mission,
        row: UnitRow,
        train: TrainRow,
        behaviour: BehaviourRow,
        kept: StopKeeper,
    ) -> None:
        self.mission = mission
        self.now_s = DEPARTURE_S - 300.0
        self.row = row
        ring = key_ring(MASTER, UNIT, (MANAGER, *TERMINALS))
        facts = UnitFacts(UNIT, line, MANAGER, UnitParameters())
        self.unit = Unit(facts, row, train, behaviour, Endpoint(ring, epoch=1), kept)
        self.devices = {d: Endpoint(key_ring(MASTER, d, (UNIT,)), epoch=1) for d in (MANAGER, *TERMINALS)}
        self.correlation: dict[str, int] = {}
        row.position_m, row.bound_ahead_m, row.bound_behind_m = MARK_A_M, 0.5, 0.5

    def phase_is(self, phase: Phase) -> bool:
        return self.unit.phase is phase

    def heard(self, actions: list[UnitAction]) -> list[AnyMessage]:
        """What the devices hear of it, in order."""
        messages: list[AnyMessage] = []
        for action in actions:
            if isinstance(action, Transmit):
                opened = self.devices[action.destination].open(action.data, self.now_s)
                assert isinstance(opened, Received)
                self.correlation[action.destination] = opened.correlation
                messages.append(opened.message)
        return messages

    def commands(self, actions: list[UnitAction]) -> list[PointsCommand]:
        """The points commands among what the devices hear."""
        return [message for message in self.heard(actions) if isinstance(message, PointsCommand)]

    def say(self, device: str, message: AnyMessage, later_s: float = 0.2) -> list[UnitAction]:
        """A device answers the last telegram it heard."""
        self.now_s += later_s
        data = self.devices[device].seal(UNIT, message, self.now_s, self.correlation.get(device, 0))
        return self.unit.receive(data, self.now_s)

    def at(self, now_s: float) -> list[UnitAction]:
        """Its timer."""
        self.now_s = now_s
        return self.unit.timer(now_s)

    def read(self, tag_id: int) -> list[UnitAction]:
        """It reads a tag where that lies."""
        tag = next(tag for tag in self.mission.tags if tag.tag_id == tag_id)
        self.row.odometer_m = self.row.odometer_m + tag.position_m - self.row.position_m
        self.row.position_m = tag.position_m
        self.now_s += 10.0
        return self.unit.tag_read(tag_id, float(self.row.odometer_m), self.now_s)

    def events(self, bits: int, later_s: float = 1.0) -> list[UnitAction]:
        self.now_s += later_s
        return self.unit.events(bits, self.now_s)


def notes(actions: list[UnitAction]) -> list[str]:
    return [str(type(action).__struct_config__.tag) for action in actions if isinstance(action, Noted)]


def capabilities() -> tuple[Capability, ...]:
    return Capability("A-E", "5", b"five"), Capability("B-W", "7", b"seven")


def proof(points_id: str, position: Position | None = Position.NORMAL) -> PointsProof:
    return PointsProof(points_id, position, position is not None, position is not None, TOKEN)


@pytest.fixture
def path(track: Callable[..., Rows], mission: Mission) -> Rows:
    return track(np.zeros(math.ceil(mission.path.length_m) + 1))


@pytest.fixture
def bench(
    rtri: Line,
    mission: Mission,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    keeper: Callable[[], StopKeeper],
    path: Rows,
) -> Bench:
    """Standing at A, signed on."""
    bench = Bench(rtri, mission, unit, train, behaviour, keeper())
    actions = bench.unit.begin(mission, path, bench.now_s, ready_s=bench.now_s, signing_on=True)
    assert bench.heard(actions) == [SignOn(UNIT, ("3",))]
    assert bench.phase_is(Phase.SIGNING_ON)
    bench.say(MANAGER, SignOnAccepted(("3",), 10, None, ()))
    assert bench.phase_is(Phase.STANDING)
    return bench


@pytest.fixture
def granted(bench: Bench) -> Bench:
    """It has its route and has commanded the departure points."""
    assert bench.unit.wake_at_s == DEPARTURE_S - LEAD_S
    (request,) = bench.heard(bench.at(DEPARTURE_S - LEAD_S))
    assert request == RouteRequest(UNIT, "3>8", SECTIONS)
    (command,) = bench.heard(bench.say(MANAGER, RouteGranted("3>8", SECTIONS, TOKEN, capabilities())))
    assert command == PointsCommand("P5", Position.NORMAL, "5", TOKEN, b"five")
    return bench


@pytest.fixture
def running(granted: Bench) -> Bench:
    """It has left A on time and stands on the open line's beginning, tag ③ read."""
    granted.say("A-E", proof("P5"))
    assert granted.row.stop_limit_m == pytest.approx(520.0)  # before the arrival points
    assert granted.unit.wake_at_s == DEPARTURE_S
    assert "departs" in notes(granted.at(DEPARTURE_S))
    assert granted.phase_is(Phase.RUNNING)
    granted.row.speed_mps = 10.0
    assert notes(granted.events(EVENT_MOVING)) == ["moving"]
    (report,) = granted.heard(granted.read(601))
    assert report == HoldingReport(SECTIONS, TOKEN)
    granted.say(MANAGER, HoldingConfirmed(SECTIONS, TOKEN))
    return granted


@pytest.fixture
def cleared_to_b(running: Bench) -> Bench:
    """It has passed the approach tag ④ and its points are proven."""
    (command,) = running.commands(running.read(602))
    assert command == PointsCommand("P7", Position.NORMAL, "7", TOKEN, b"seven")
    running.say("B-W", proof("P7"))
    return running


def test_the_stop_limit_moves_on_with_the_grant_and_the_proofs(cleared_to_b: Bench) -> None:
    assert cleared_to_b.row.stop_limit_m == pytest.approx(690.0)  # the arrival track
    assert cleared_to_b.row.target_stop_m == pytest.approx(MARK_B_M)


def test_before_the_proof_it_aims_short_of_the_points(running: Bench) -> None:
    assert running.row.target_stop_m == pytest.approx(520.0 - UnitParameters().standoff_m)


def test_it_does_not_leave_towards_points_that_are_not_proven(granted: Bench) -> None:
    assert granted.row.stop_limit_m == pytest.approx(110.0)
    granted.at(DEPARTURE_S + 1.0)
    assert granted.phase_is(Phase.STANDING)
    assert granted.row.mode == MODE_HOLD
    assert granted.unit.waits_for() == "points P5: not proven"
    granted.say("A-E", proof("P5"))
    assert granted.phase_is(Phase.RUNNING)
    assert granted.row.mode == MODE_DRIVE


def test_it_does_not_leave_before_its_time(granted: Bench) -> None:
    granted.say("A-E", proof("P5"))
    granted.at(DEPARTURE_S - 1.0)
    assert granted.phase_is(Phase.STANDING)
    assert granted.unit.waits_for() == "departure time"


def test_a_refused_train_says_what_it_waits_for(bench: Bench) -> None:
    bench.heard(bench.at(DEPARTURE_S - LEAD_S))
    bench.say(MANAGER, RouteRefused("3>8", RefusalReason.HELD, "6", "K2"))
    assert bench.unit.waits_for() == "route 3>8: held: section 6 of K2"
    bench.at(DEPARTURE_S + 100.0)
    assert bench.phase_is(Phase.STANDING)


def test_sections_are_given_back_by_the_safe_rear(cleared_to_b: Bench) -> None:
    """Safe against the bound behind, and against a tachometer that has shown too much since tag 602 (at 310 m)."""
    row, tag_m, share = cleared_to_b.row, 310.0, UnitParameters().doubt_error_share
    rear_m = 520.0 + share * (520.0 + REAR_M + row.bound_behind_m - tag_m) / (1.0 - share)
    assert row.rear_trigger_m == pytest.approx(rear_m)
    row.bound_behind_m = 2.1
    row.position_m = (520.0 + REAR_M + 2.0 - share * tag_m) / (1.0 - share)
    assert cleared_to_b.heard(cleared_to_b.events(EVENT_SAFE_REAR)) == []
    row.bound_behind_m = 1.9
    assert cleared_to_b.heard(cleared_to_b.events(EVENT_SAFE_REAR)) == [HoldingReport(("7", "8"), TOKEN)]
    assert row.rear_trigger_m > 580.0


def test_arrival_report_and_end_of_the_mission(cleared_to_b: Bench) -> None:
    for tag_id in (801, 802, 803):
        cleared_to_b.heard(cleared_to_b.read(tag_id))
    cleared_to_b.row.position_m, cleared_to_b.row.speed_mps = MARK_B_M + 0.1, 0.0
    actions = cleared_to_b.events(EVENT_STOPPED)
    assert "arrived" in notes(actions)
    assert cleared_to_b.unit.authority.section_ids() == ("8",)
    assert cleared_to_b.phase_is(Phase.STANDING)  # until the release is confirmed
    actions = cleared_to_b.say(MANAGER, HoldingConfirmed(("8",), TOKEN))
    assert Finished("T1") in actions
    assert cleared_to_b.phase_is(Phase.FINISHED)
    assert cleared_to_b.row.mode == MODE_HOLD


@pytest.mark.parametrize(
    ("beyond_m", "what", "arrived"),
    [(-5.1, "stopped_short", False), (-4.9, "arrived", True), (4.9, "arrived", True), (5.1, "overran", True)],
)
def test_stopping_off_the_mark(cleared_to_b: Bench, beyond_m: float, what: str, arrived: bool) -> None:
    cleared_to_b.row.position_m, cleared_to_b.row.speed_mps = MARK_B_M + beyond_m, 0.0
    assert what in notes(cleared_to_b.events(EVENT_STOPPED))
    assert cleared_to_b.phase_is(Phase.RUNNING) is not arrived


def test_signing_off(bench: Bench) -> None:
    assert bench.heard(bench.unit.leave(bench.now_s)) == [SignOff(UNIT, 10)]
    assert bench.phase_is(Phase.SIGNING_OFF)
    assert LeftLine() in bench.say(MANAGER, SignOffAccepted())
    assert bench.phase_is(Phase.GONE)
    assert bench.unit.authority.section_ids() == ()


def test_a_broken_telegram_takes_no_effect(granted: Bench) -> None:
    data = granted.devices["A-E"].seal(UNIT, proof("P5"), granted.now_s, granted.correlation["A-E"])
    assert notes(granted.unit.receive(data[:-1] + b"?", granted.now_s)) == ["telegram_dropped"]
    assert granted.unit.authority.proven == ()
    assert "proven" in notes(granted.unit.receive(data, granted.now_s))
    assert notes(granted.unit.receive(data, granted.now_s)) == ["telegram_dropped"]  # repeated


def test_a_withdrawn_proof_draws_the_limit_back_and_is_asked_for_again(cleared_to_b: Bench) -> None:
    actions = cleared_to_b.say("B-W", proof("P7", None))
    assert cleared_to_b.heard(actions) == [PointsCommand("P7", Position.NORMAL, "7", TOKEN, b"seven")]
    assert cleared_to_b.row.stop_limit_m == pytest.approx(520.0)
    assert cleared_to_b.row.target_stop_m < 520.0
    cleared_to_b.say("B-W", proof("P7"))
    assert cleared_to_b.row.stop_limit_m == pytest.approx(690.0)


def test_points_under_the_train_are_never_commanded_again(cleared_to_b: Bench) -> None:
    cleared_to_b.row.position_m = 521.0
    assert cleared_to_b.heard(cleared_to_b.say("B-W", proof("P7", None))) == []


def test_the_next_tag_throws_the_arrival_points_if_the_approach_tag_was_missed(running: Bench) -> None:
    (command,) = running.commands(running.read(603))
    assert command.points_id == "P7"


# position faults ------------------------------------------------------------------------------------------------


@pytest.fixture
def lost(running: Bench) -> Bench:
    assert "position_fault" in notes(running.events(EVENT_TAG_OVERDUE))
    return running


def test_a_missed_tag_stops_the_train_and_it_goes_on_on_sight(lost: Bench) -> None:
    row = lost.row
    assert (row.position_known, row.intervention) == (0, EMERGENCY_INTERVENTION)
    assert row.restricted_mps == pytest.approx(15.0 / 3.6)
    row.speed_mps = 0.0
    lost.events(EVENT_STOPPED)
    assert lost.unit.waits_for() == "release of the emergency brake"
    release_s = lost.now_s + UnitParameters().emergency_release_s
    assert lost.unit.wake_at_s == release_s
    assert "emergency_released" in notes(lost.at(release_s))
    assert row.intervention == NO_INTERVENTION
    assert row.restricted_mps == pytest.approx(15.0 / 3.6)
    assert lost.unit.waits_for() == "a tag: its position is unknown"


def test_the_next_tag_ends_it_and_the_block_picture_is_unchanged(lost: Bench) -> None:
    assert "position_found" in notes(lost.read(602))
    assert lost.row.position_known == 1
    assert lost.row.restricted_mps == math.inf
    assert lost.unit.authority.section_ids() == ("6", "7", "8")  # and the rear has left 5 for certain
    assert lost.row.stop_limit_m == pytest.approx(520.0)
    assert lost.phase_is(Phase.RUNNING)
    assert lost.row.intervention == EMERGENCY_INTERVENTION  # until it stands and the driver releases it


def test_without_a_position_nothing_is_given_back_and_nothing_thrown(lost: Bench) -> None:
    lost.row.position_m, lost.row.bound_behind_m = 500.0, 0.5
    held = lost.unit.authority.section_ids()
    assert lost.heard(lost.events(EVENT_SAFE_REAR)) == []
    assert lost.unit.authority.section_ids() == held
    assert lost.heard(lost.say("A-E", proof("P5", None))) == []


@pytest.mark.parametrize("tag_id", [9999, 803])
def test_a_tag_where_none_can_be_stops_the_train(running: Bench, tag_id: int) -> None:
    """A tag of no track of this path, and one that lies half a kilometre on."""
    before_m = running.row.position_m
    assert "position_fault" in notes(
        running.unit.tag_read(tag_id, float(running.row.odometer_m), running.now_s)
    )
    assert running.row.intervention == EMERGENCY_INTERVENTION
    assert running.row.position_m == before_m


def test_an_emergency_is_released_only_at_a_stand(running: Bench) -> None:
    running.row.intervention = EMERGENCY_INTERVENTION
    running.at(running.now_s + 100.0)
    assert running.row.intervention == EMERGENCY_INTERVENTION


def test_a_tag_that_may_lie_behind_already_is_not_expected(bench: Bench, path: Rows) -> None:
    """Tag 303 lies at 78 m of the path: with half a metre of bound it is due from 77.3 m, not from 77.6 m."""
    for position_m, expected_m in ((77.3, 78.0), (77.6, 175.0)):
        bench.row.position_m = position_m
        bench.unit.begin(bench.mission, path, bench.now_s, ready_s=math.inf, signing_on=False)
        assert bench.row.expected_tag_m == pytest.approx(expected_m)


def test_what_is_due_out_of_reach_goes_out_where_the_radio_begins_again(
    rtri: Line,
    mission: Mission,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    keeper: Callable[[], StopKeeper],
    path: Rows,
) -> None:
    main = replace(rtri.alignments["main"], coverage=(Coverage(0.0, 100.0), Coverage(500.0, 1410.0)))
    bench = Bench(replace(rtri, alignments={"main": main}), mission, unit, train, behaviour, keeper())
    actions = bench.unit.begin(mission, path, bench.now_s, ready_s=bench.now_s, signing_on=True)
    assert bench.heard(actions) == []
    assert bench.unit.wake_at_s == math.inf
    assert bench.row.position_trigger_m == pytest.approx(141.0)  # km 0.5, and a metre
    bench.row.position_m = 141.0
    assert bench.heard(bench.events(EVENT_POSITION)) == [SignOn(UNIT, ("3",))]
    assert bench.unit.wake_at_s < math.inf
