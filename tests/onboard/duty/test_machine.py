"""Rows of the table of the duty, on the run of the RTRI test line: next state and actions."""

from typing import Any, Final, get_args

import pytest
from msgspec.structs import replace

from onboard.authority import records
from onboard.duty import on_sight
from onboard.duty.machine import TABLE, step
from onboard.duty.records import (
    LEAVE,
    RELEASE,
    AtMark,
    ChangeEnds,
    DrivingOrder,
    DutyPhase,
    DutyState,
    EndOfHeld,
    Event,
    Looked,
    PlaceInJoints,
    PositionLost,
    StopLimit,
    SwitchedOn,
    TagBelieved,
    TelegramHeard,
    TimerDue,
)
from onboard.duty.shown import command_of, waits_for
from onboard.duty.stop_limit import HALTED
from onboard.duty_parameters import ReleaseRule
from tests.onboard.duty.rows_fixes import FIXES
from tests.onboard.duty.rows_orders import ORDERS
from tests.onboard.duty.rows_people import PEOPLE
from tests.onboard.duty.rows_sensed import SENSED
from tests.onboard.duty.rows_told import TOLD
from tests.onboard.duty.rows_vehicle import UNABLE, VEHICLE
from tests.onboard.duty.stage import (
    AT_A,
    AT_B,
    BEFORE_5,
    BEFORE_7,
    FINISHED,
    HOLDS_3,
    HOLDS_8,
    HOLDS_ALL,
    HOLDS_REST,
    LOST,
    NOW_S,
    ON_6,
    ON_SIGHT,
    P5,
    P7,
    PLAN,
    REPORT_OPEN,
    ROUTE_OPEN,
    RUNNING,
    SECTIONS,
    SIGN_OFF_OPEN,
    SIGNING_OFF,
    SIGNING_ON,
    STANDING,
    STATES,
    TIMES,
    TO_THE_END,
    moved,
    reported,
    sent,
)
from verify.restored import restored

CASES: Final = PEOPLE | SENSED | FIXES | TOLD | VEHICLE | ORDERS


@pytest.mark.parametrize("name", CASES)
def test_row(name: str) -> None:
    state, event, place, after, actions = CASES[name]
    assert step(PLAN, TIMES, state, event, place, NOW_S) == (after, actions)


def test_every_row_has_a_case() -> None:
    cases = {(state.phase, type(event)) for state, event, _, _, _ in CASES.values()}
    assert cases == set(TABLE)


def test_by_section_any_tag_gives_back_what_it_proves_but_the_one_that_tells_a_lost_position() -> None:
    by_section = replace(TIMES, release=ReleaseRule.SECTION)
    state, event, place, _, _ = CASES["at the approach tag the arrival points are thrown"]
    holds_5 = replace(state, authority=replace(state.authority, held=("5", "6", "7", "8")))
    passed, actions = step(PLAN, by_section, holds_5, event, place, NOW_S)
    assert (passed.freed, passed.authority.held) == (2, ("6", "7", "8"))
    assert set(reported("6", "7", "8")) <= set(actions)
    early, _ = step(PLAN, by_section, holds_5, event, replace(place, clear=1), NOW_S)
    assert early.authority.held == ("5", "6", "7", "8")  # the safe rear is still in it
    whole, _ = step(PLAN, TIMES, holds_5, event, place, NOW_S)
    assert (whole.freed, whole.authority.held) == (0, ("5", "6", "7", "8"))
    lost = replace(holds_5, phase=DutyPhase.ON_SIGHT)
    found, _ = step(PLAN, by_section, lost, TagBelieved(4, found=True), place, NOW_S)
    assert (found.proved, found.freed, found.authority.held) == (2, 0, ("5", "6", "7", "8"))


def test_by_section_only_what_lies_ahead_is_asked_for_again() -> None:
    held_up = replace(RUNNING, authority=replace(HOLDS_REST, held=("6",), commandable=()))
    place = moved(ON_6, stands=True)
    for rule, wants in ((ReleaseRule.SECTION, ("6", "7", "8")), (ReleaseRule.ROUTE, SECTIONS)):
        asks, _ = step(PLAN, replace(TIMES, release=rule), held_up, Looked(), place, NOW_S)
        request = asks.authority.open(records.RequestKind.ROUTE)
        assert request is not None
        assert request.section_ids == wants


A_PART: Final = records.Authority(held=("3", "5", "6"), commandable=("5",), on_line=True)
THE_REST: Final = replace(ROUTE_OPEN, section_ids=("7", "8"), refusal="the rest is not free")


@pytest.mark.parametrize(
    ("waits_for", "keeps"),
    [((THE_REST,), ("3", "5", "6")), ((), ("3",)), ((ROUTE_OPEN,), ("3",))],
    ids=["the rest", "nothing", "the whole"],
)
def test_a_part_of_the_way_is_kept_only_while_the_rest_is_asked_for(
    waits_for: tuple[records.OpenRequest, ...], keeps: tuple[str, ...]
) -> None:
    state = replace(STANDING, authority=replace(A_PART, requests=waits_for))
    after, _ = step(PLAN, replace(TIMES, release=ReleaseRule.SECTION), state, Looked(), AT_A, NOW_S)
    assert after.authority.held == keeps


def test_with_a_part_of_the_way_its_points_are_thrown() -> None:
    asks = replace(STANDING, authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)))
    grant = records.GrantHeard("3>8", ("5", "6"), ("5",), answers=True, fresh=True, newer=True)
    granted, actions = step(PLAN, TIMES, asks, TelegramHeard(grant), AT_A, NOW_S)
    assert granted.authority.held == ("3", "5", "6")
    assert [command.needed for command in granted.authority.commands] == [P5]
    assert actions
    refused, _ = step(PLAN, TIMES, asks, TelegramHeard(replace(grant, answers=False)), AT_A, NOW_S)
    assert refused.authority == asks.authority


@pytest.mark.parametrize("rule", ReleaseRule)
def test_without_a_position_the_way_is_asked_for_from_where_the_driver_sees_the_train(
    rule: ReleaseRule,
) -> None:
    """It stands on section 6, and has given back what lies behind: that may be another's."""
    state = replace(ON_SIGHT, authority=replace(HOLDS_3, held=("6",)))
    after, _ = step(PLAN, replace(TIMES, release=rule), state, EndOfHeld(2), LOST, NOW_S)
    request = after.authority.open(records.RequestKind.ROUTE)
    assert request is not None
    assert request.section_ids == (("6", "7", "8") if rule is ReleaseRule.SECTION else SECTIONS)


def test_on_sight_it_keeps_nothing_that_lies_beyond_what_it_lacks() -> None:
    """As the register may have it after a false claim: its driver sees that it stands on section 3."""
    state = replace(ON_SIGHT, authority=replace(HOLDS_3, held=("3", "7")))
    after, _ = step(PLAN, TIMES, state, EndOfHeld(0), LOST, NOW_S)
    assert after.authority.held == ("3",)
    whole, _ = step(PLAN, TIMES, replace(state, authority=HOLDS_ALL), EndOfHeld(0), LOST, NOW_S)
    assert whole.authority.held == HOLDS_ALL.held


@pytest.mark.parametrize(
    "state", [RUNNING, replace(STANDING, place=ON_6, entered=RUNNING.entered, may_leave=True)]
)
def test_halted_where_no_radio_reaches_it_runs_on_sight_to_where_it_hears(state: DutyState) -> None:
    """No further than the end of section 6, though it holds the points beyond as proven."""
    holds_rest = replace(HOLDS_REST, proven=(P7,), requests=(REPORT_OPEN,), mismatch="contested: 8")
    state = replace(state, authority=holds_rest, halted=True, released=False)
    covered = moved(ON_6, stands=True, emergency=True)
    waits, _ = step(PLAN, TIMES, state, TimerDue(RELEASE), covered, NOW_S)
    assert not command_of(PLAN, waits).drive
    shadow = replace(covered, covered=False)
    seeks, actions = step(PLAN, TIMES, waits, Looked(), shadow, NOW_S)
    seeks, actions = step(PLAN, TIMES, seeks, TimerDue(RELEASE), shadow, NOW_S)
    assert DrivingOrder.RELEASE in actions
    runs, _ = step(PLAN, TIMES, seeks, Looked(), moved(shadow, stands=False, emergency=False), NOW_S)
    shown = command_of(PLAN, runs)
    assert (shown.drive, shown.sweeps, shown.limit) == (True, True, StopLimit(3, "7", HALTED))
    reached = moved(runs.place, covered=True)
    on, _ = step(PLAN, TIMES, runs, Looked(), reached, NOW_S)
    assert command_of(PLAN, on).drive  # by its own reckoning: it has yet to hear something
    told, _ = step(PLAN, TIMES, on, TelegramHeard(records.ContestHeard(("8",))), reached, NOW_S)
    assert not command_of(PLAN, told).drive


def test_halted_on_sight_it_goes_on_to_where_it_hears_when_it_has_heard_nothing() -> None:
    """Without a position no place tells whether the radio reaches it: from one time that its driver may acknowledge the
    stop to the next it listens, and what it then hears brings it to a stand again.
    """
    stopped = replace(LOST, emergency=True)
    authority = replace(HOLDS_REST, requests=(REPORT_OPEN,), mismatch="contested: 8")
    state = replace(ON_SIGHT, authority=authority, place=stopped, halted=True, released=False)
    query = TelegramHeard(records.QueryHeard())
    listens, actions = step(PLAN, TIMES, state, TimerDue(RELEASE), stopped, NOW_S)
    assert (command_of(PLAN, listens).drive, actions) == (False, (records.SetTimer(RELEASE, 30.0),))
    heard, _ = step(PLAN, TIMES, listens, query, stopped, NOW_S)
    listens_again, _ = step(PLAN, TIMES, heard, TimerDue(RELEASE), stopped, NOW_S)
    assert not command_of(PLAN, listens_again).drive
    seeks, actions = step(PLAN, TIMES, listens_again, TimerDue(RELEASE), stopped, NOW_S)
    assert DrivingOrder.RELEASE in actions
    shown = command_of(PLAN, seeks)
    assert (shown.drive, shown.on_sight, shown.within_section) == (True, True, True)
    runs = moved(LOST, stands=False)
    told, actions = step(PLAN, TIMES, seeks, query, runs, NOW_S)
    assert records.SetTimer(RELEASE, 30.0) in actions
    assert not command_of(PLAN, told).drive
    agrees = records.ConfirmationHeard(HOLDS_REST.held, answers=True, newer=False)
    agreed, _ = step(PLAN, TIMES, seeks, TelegramHeard(agrees), runs, NOW_S)
    released, _ = step(PLAN, TIMES, agreed, TimerDue(RELEASE), LOST, NOW_S)
    shown = command_of(PLAN, released)
    assert (shown.drive, shown.within_section) == (True, False)


def test_who_was_on_the_way_to_where_it_hears_and_loses_its_position_goes_on() -> None:
    seeks = replace(RUNNING, authority=replace(HOLDS_REST, mismatch="contested: 8"), halted=True)
    lost, _ = step(PLAN, TIMES, replace(seeks, seeks_radio=True), PositionLost(), LOST, NOW_S)
    shown = command_of(PLAN, step(PLAN, TIMES, lost, TimerDue(RELEASE), LOST, NOW_S)[0])
    assert (shown.drive, shown.within_section) == (True, True)


def test_what_waits_for_the_radio_is_said_when_anything_is_heard() -> None:
    """By a position that lies it stands where no radio reaches, and would wait for ever."""
    waits = replace(SIGN_OFF_OPEN, sent=False)
    state = replace(SIGNING_OFF, authority=replace(HOLDS_8, requests=(waits,)))
    shadow = moved(AT_B, covered=False)
    silent, actions = step(PLAN, TIMES, state, Looked(), shadow, NOW_S)
    assert not any(isinstance(action, records.SendRequest) for action in actions)
    _, actions = step(PLAN, TIMES, silent, TelegramHeard(records.QueryHeard()), shadow, NOW_S)
    assert records.SendRequest(waits) in actions


EXAMPLES: Final[dict[type[Event], Event]] = {type(event): event for _, event, _, _, _ in CASES.values()}
REFUSED: Final = [(at, kind) for at in DutyPhase for kind in get_args(Event) if (at, kind) not in TABLE]


@pytest.mark.parametrize(("at", "kind"), REFUSED, ids=[f"{at.value}-{kind.__name__}" for at, kind in REFUSED])
def test_what_the_table_does_not_name_is_refused(at: DutyPhase, kind: type[Event]) -> None:
    state = STATES[at]
    assert step(PLAN, TIMES, state, EXAMPLES[kind], state.place, NOW_S) == (state, ())


@pytest.mark.parametrize("at", [DutyPhase.SIGNING_ON, DutyPhase.SIGNING_OFF])
def test_a_timer_of_the_authority_repeats_its_request(at: DutyPhase) -> None:
    state = STATES[at]
    (request,) = state.authority.requests
    assert step(PLAN, TIMES, state, TimerDue(request.timer), state.place, NOW_S) == (state, sent(request))
    assert step(PLAN, TIMES, state, TelegramHeard(records.PeerRestarted()), state.place, NOW_S) == (
        state,
        sent(request),
    )


@pytest.mark.parametrize("sure", [3, 4])
def test_points_count_as_entered_only_where_the_front_surely_is(sure: int) -> None:
    """Its bounds reach onto points 7: withdrawn now, their proof still stops a train that may be short of them."""
    place = moved(ON_6, sure=sure, perhaps=4)
    proven = replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), limit=TO_THE_END)
    entered, _ = step(PLAN, TIMES, proven, Looked(), place, NOW_S)
    assert entered.entered == ({"5", "7"} if sure == 4 else {"5"})
    lost = TelegramHeard(records.ProofHeard("P7", "B-W", None, mine=True))
    withdrawn, _ = step(PLAN, TIMES, entered, lost, place, NOW_S)
    assert withdrawn.limit == (TO_THE_END if sure == 4 else BEFORE_7)


def test_resuming_it_counts_only_points_as_entered_where_the_front_surely_is() -> None:
    place = moved(ON_6, perhaps=4)
    resumed, _ = step(PLAN, TIMES, ON_SIGHT, TagBelieved(3, found=True), place, NOW_S)
    assert resumed.phase is DutyPhase.RUNNING
    assert resumed.entered == {"3", "5", "6"}
    assert resumed.limit == BEFORE_7


# the command for the driving part ------------------------------------------------------------------------------


@pytest.mark.parametrize("at", DutyPhase)
def test_it_drives_only_running_or_on_sight(at: DutyPhase) -> None:
    command = command_of(PLAN, STATES[at])
    assert command.drive is (at in (DutyPhase.RUNNING, DutyPhase.ON_SIGHT))
    assert command.on_sight is (at is DutyPhase.ON_SIGHT)
    assert command.target == (1 if at is DutyPhase.RUNNING else None)
    assert command.limit == STATES[at].limit


@pytest.mark.parametrize(
    ("changes", "drives"),
    [
        ({}, True),
        ({"released": False}, False),
        ({"stands_at": 0, "may_leave": False}, False),
        ({"stands_at": 0}, True),
    ],
)
def test_on_sight_it_waits_for_the_driver_and_for_its_time(changes: dict[str, Any], drives: bool) -> None:
    assert command_of(PLAN, replace(ON_SIGHT, **changes)).drive is drives


def test_the_rear_that_is_watched_is_that_of_the_first_section_held() -> None:
    assert command_of(PLAN, replace(RUNNING, freed=4)).rear == 2
    assert command_of(PLAN, replace(FINISHED, freed=4)).rear is None
    assert command_of(PLAN, replace(ON_SIGHT, freed=4)).rear is None


def test_no_rear_is_watched_before_the_arrival_tag() -> None:
    assert command_of(PLAN, replace(RUNNING, proved=4)).rear is None


def test_seen_at_its_mark_a_train_gives_back_what_lies_off_its_way() -> None:
    """The register gave it back after a false claim; who holds two sections cannot sign off."""
    held = replace(HOLDS_REST, held=(*HOLDS_REST.held, "99"))
    after, _ = step(PLAN, TIMES, replace(ON_SIGHT, authority=held), AtMark(1), PlaceInJoints(), NOW_S)
    assert after.authority.held == HOLDS_8.held


@pytest.mark.parametrize("at", DutyPhase)
def test_a_train_that_is_halted_drives_in_no_phase(at: DutyPhase) -> None:
    assert not command_of(PLAN, replace(STATES[at], halted=True)).drive


@pytest.mark.parametrize("at", DutyPhase)
def test_the_driver_is_asked_at_a_mark_where_something_behind_is_still_held(at: DutyPhase) -> None:
    """And not while a report is open: what is held may be what that gives back."""
    holding = replace(STATES[at], at=1, authority=replace(HOLDS_REST, held=("7", "8")))
    asked = at in (DutyPhase.STANDING, DutyPhase.FINISHED, DutyPhase.SIGNING_OFF)
    assert command_of(PLAN, holding).confirm is asked
    reporting = replace(holding, authority=replace(holding.authority, requests=(REPORT_OPEN,)))
    assert not command_of(PLAN, reporting).confirm
    assert not command_of(PLAN, replace(holding, authority=HOLDS_8)).confirm


@pytest.mark.parametrize("at", DutyPhase)
def test_the_driver_is_asked_where_the_bounds_leave_open_whether_it_is_at_its_mark(at: DutyPhase) -> None:
    state = STATES[at]
    asked = at in (DutyPhase.STANDING, DutyPhase.FINISHED, DutyPhase.SIGNING_OFF)
    assert command_of(PLAN, replace(state, place=moved(state.place, unsure=True))).confirm is asked


def test_what_must_be_swept_is_shown() -> None:
    assert command_of(PLAN, replace(RUNNING, sweeps=True)).sweeps


@pytest.mark.parametrize(
    ("state", "words"),
    [
        (SIGNING_ON, "signing on: no answer from the block manager"),
        (SIGNING_OFF, "signing off: no answer from the block manager"),
        (STANDING, "departure time"),
        (RUNNING, "its run to B"),
        (replace(RUNNING, place=moved(RUNNING.place, stands=True, reach=4)), "nothing"),
        (ON_SIGHT, "a tag or another fix: its position is unknown"),
        (replace(ON_SIGHT, place=moved(LOST, emergency=True)), "release of the emergency brake"),
        (
            replace(ON_SIGHT, place=moved(LOST, emergency=True, unfit="brake not in order")),
            "vehicle: brake not in order",
        ),
        (
            replace(STANDING, place=moved(AT_A, unfit="doors not closed"), may_leave=True),
            "vehicle: doors not closed",
        ),
        (
            UNABLE,
            "what takes it to B: a pull of 32.0 kN on 40.0 permille at km 0.300, 100% laden: 20.0 kN can be had with"
            " 50% of the motors",
        ),
        (
            replace(STANDING, authority=replace(HOLDS_3, requests=(replace(ROUTE_OPEN, refusal="held: 6"),))),
            "route 3>8: held: 6",
        ),
        (
            replace(RUNNING, authority=replace(HOLDS_REST, commands=(records.OpenCommand(P7),))),
            "points P7: not proven",
        ),
        (
            replace(
                RUNNING,
                authority=replace(HOLDS_REST, mismatch="contested: 7", commands=(records.OpenCommand(P7),)),
            ),
            "agreement with the block manager: contested: 7",
        ),
        (
            replace(FINISHED, authority=replace(HOLDS_REST, held=("7", "8"))),
            "the driver's confirmation that the whole train has arrived",
        ),
        (
            replace(FINISHED, authority=replace(HOLDS_8, requests=(REPORT_OPEN,))),
            "the block manager's confirmation of what is held",
        ),
        (
            replace(FINISHED, place=moved(FINISHED.place, unsure=True)),
            "the driver's word that it stands at its mark: its bounds leave that open",
        ),
    ],
)
def test_a_train_says_what_it_waits_for(state: DutyState, words: str) -> None:
    assert waits_for(PLAN, state) == words


def test_who_is_given_its_whole_route_with_its_sign_on_throws_the_departure_points() -> None:
    """It started again before its portal, with the route in hand: it asks for nothing, so nothing is granted."""
    waits = replace(SIGNING_ON, may_ask=True)
    event = TelegramHeard(records.SignOnHeard(("3", *SECTIONS), ("5", "7"), answers=True, newer=True))
    after, actions = step(PLAN, TIMES, waits, event, AT_A, NOW_S)
    assert after.phase is DutyPhase.STANDING
    assert records.SendCommand(P5) in actions
    assert records.SendCommand(P7) not in actions  # thrown at the approach tag
    again, more = step(PLAN, TIMES, after, TimerDue(LEAVE), AT_A, NOW_S)
    assert records.SendCommand(P5) not in more  # it is under way
    assert again.authority.commands == after.authority.commands


@pytest.mark.parametrize(("unswept", "sweeps"), [("5", False), ("6", True), ("7", True)])
def test_it_runs_on_sight_until_its_front_has_left_what_must_be_swept(unswept: str, sweeps: bool) -> None:
    """What lies behind its front it gives back much later, at an arrival tag."""
    held = replace(HOLDS_REST, held=("5", "6", "7", "8"), unswept=(unswept,), proven=(P7,))
    sweeping = replace(RUNNING, authority=held, sweeps=True, limit=TO_THE_END)
    after, _ = step(PLAN, TIMES, sweeping, Looked(), replace(ON_6, clear=1, clear_at_mark=1), NOW_S)
    assert after.sweeps is sweeps
    assert after.limit == TO_THE_END  # what it has left does not stop it
    assert unswept in after.authority.unswept


STRAY: Final = {
    "points beyond its track": (AT_A, ("3", "5"), ("3",)),
    "what nothing leads to": (AT_A, ("3", "7", "8"), ("3",)),
    "a route but for its last section": (AT_A, ("3", "5", "6", "7"), ("3",)),
    "its whole route": (AT_A, ("3", *SECTIONS), ("3", *SECTIONS)),
    "points that its front may be on": (moved(AT_A, perhaps=2), ("3", "5"), ("3", "5")),
    "what it has not come to a stand before": (moved(AT_A, stands=False), ("3", "5"), ("3", "5")),
    "open line ahead of it": (moved(ON_6, stands=True), ("6", "7"), ("6", "7")),
    "what lies beyond a gap in that": (moved(ON_6, stands=True), ("6", "8"), ("6",)),
}


@pytest.mark.parametrize("name", STRAY)
def test_standing_it_gives_back_what_it_holds_of_a_route_that_it_does_not_hold_whole(name: str) -> None:
    """The register has given it so much after a boot, or a false claim; it would keep others from it for ever."""
    place, held, kept = STRAY[name]
    phase = DutyPhase.STANDING if place.here == 0 else DutyPhase.RUNNING
    state = DutyState(phase, place, records.Authority(held=held, on_line=True), limit=BEFORE_5)
    after, actions = step(PLAN, TIMES, state, Looked(), place, NOW_S)
    assert after.authority.held == kept
    said = [
        a.request.section_ids
        for a in actions
        if isinstance(a, records.SendRequest) and a.request.ask is records.RequestKind.REPORT
    ]
    assert said == ([] if kept == held else [kept])


def test_as_it_changes_ends_what_it_stands_in_is_not_ahead_of_its_place_on_the_way_back() -> None:
    after, _ = step(PLAN, TIMES, FINISHED, ChangeEnds(), AT_A, NOW_S)
    assert after.authority.held == HOLDS_8.held


def booted_at(stop: int, *beside: str) -> records.Authority:
    """What a unit goes on holding that is switched on at a stop and told that it holds its whole route, and these."""
    state, _ = step(PLAN, TIMES, DutyState(), SwitchedOn(PLAN, stop, epoch=2), PlaceInJoints(), NOW_S)
    told = TelegramHeard(records.SignOnHeard(("3", *SECTIONS, *beside), ("5", "7"), answers=True, newer=True))
    return step(PLAN, TIMES, state, told, PlaceInJoints(), NOW_S)[0].authority


def test_switched_on_at_its_mark_it_gives_back_what_is_behind_by_the_word_of_its_crew() -> None:
    """Found by `branchline verify`, released by section: its driver changed ends, and another that had come in since
    and this one held each what the other needed.
    """
    assert booted_at(1).held == ("8",)
    assert booted_at(0).held == ("3", *SECTIONS)


@pytest.mark.parametrize("stop", [0, 1])
def test_switched_on_at_a_mark_it_gives_back_what_lies_off_its_path(stop: int) -> None:
    """By a false claim before it lost its power; nobody signs off with it, and no tag comes to a train that stands."""
    assert booted_at(stop, "9").held == booted_at(stop).held


def test_that_it_gives_that_back_is_what_frees_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(on_sight, "elsewhere", lambda _duty: ())
    assert "9" in booted_at(1, "9").held


def test_without_the_word_of_its_crew_it_keeps_all() -> None:
    with restored("booted-at-its-mark-keeps-all"), pytest.raises(AssertionError):
        test_switched_on_at_its_mark_it_gives_back_what_is_behind_by_the_word_of_its_crew()
