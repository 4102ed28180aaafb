"""Rows of the table of the duty, on the run of the RTRI test line: next state and actions."""

from __future__ import annotations

from typing import Any, Final, get_args

import pytest
from msgspec.structs import replace

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Position
from network.timetable import load_timetable
from onboard import notes
from onboard.authority.machine import REPEAT_S
from onboard.authority.records import (
    Ask,
    Authority,
    Command,
    Commit,
    Granted,
    PeerRestarted,
    Proof,
    Queried,
    Renew,
    Request,
    Send,
    SendClaim,
    SendCommand,
    SetTimer,
    SignedOff,
    SignedOn,
    StopTimer,
    Take,
    Timer,
    Write,
)
from onboard.duty.machine import TABLE, command_of, step, waits_for
from onboard.duty.mission import plan_mission
from onboard.duty.plan import Plan, PointsNeeded, plan_of
from onboard.duty.records import (
    ASK,
    LEAVE,
    RELEASE,
    Accepted,
    AtMark,
    Begin,
    ChangeEnds,
    DutyState,
    Event,
    Finished,
    Heard,
    How,
    Leave,
    LeftLine,
    Limit,
    Looked,
    Order,
    Phase,
    Place,
    PointsSeen,
    PointsWrong,
    PositionLost,
    SetBack,
    SetTimerAt,
    Started,
    Stopped,
    SwitchedOn,
    TagPassed,
    TimerDue,
)
from onboard.duty.turn import DutyParameters


def papers_plan() -> Plan:
    """From section 3 over 5, 6 and 7 to section 8; points P5 and P7."""
    line = load_line(shipped_line("rtri_test_line"))
    timetable = load_timetable(shipped_timetable("rtri_test_line"), line)
    return plan_of(plan_mission(line, timetable.trains["T1"], "3", None, None), 40.0)


PLAN: Final = papers_plan()
TIMES: Final = DutyParameters(dwell_min_s=20.0, request_lead_s=45.0, emergency_release_s=30.0)
DEPARTURE_S, NOW_S = 36_000.0, 35_000.0
P5: Final = PointsNeeded("P5", Position.NORMAL, "5", "A-E")
P7: Final = PointsNeeded("P7", Position.NORMAL, "7", "B-W")
SECTIONS: Final = ("5", "6", "7", "8")
APPROACH, POSITION = 4, 5  # tags 602 and 603, before the arrival points

AT_A: Final = Place(known=True, here=0, sure=1, perhaps=1, reach=1)
ON_6: Final = Place(known=True, stands=False, here=2, sure=3, perhaps=3, clear=2, clear_at_mark=2, reach=3)
AT_B: Final = Place(
    known=True, here=4, sure=5, perhaps=5, clear=4, clear_at_mark=4, reach=5, near=1, passed=1
)
LOST: Final = Place(stands=False)

ROUTE_OPEN: Final = Request(Ask.ROUTE, "3>8", SECTIONS, sent=True)
REPORT_OPEN: Final = Request(Ask.REPORT, sent=True)
SIGN_ON_OPEN: Final = Request(Ask.SIGN_ON, section_ids=("3",), sent=True)
SIGN_OFF_OPEN: Final = Request(Ask.SIGN_OFF, sent=True)
HOLDS_3: Final = Authority(held=("3",), on_line=True)
HOLDS_ALL: Final = Authority(held=("3", *SECTIONS), commandable=("5", "7"), on_line=True)
HOLDS_REST: Final = Authority(held=("6", "7", "8"), commandable=("7",), on_line=True)
HOLDS_8: Final = Authority(held=("8",), on_line=True)
BEFORE_5: Final = Limit(1, "5", "not held")
BEFORE_7: Final = Limit(3, "7", "points not proven")
TO_THE_END: Final = Limit(5, None, "end of the path")

OFF: Final = DutyState(place=AT_A)
SIGNING_ON: Final = DutyState(
    Phase.SIGNING_ON, AT_A, Authority(held=("3",), requests=(SIGN_ON_OPEN,)), limit=BEFORE_5
)
STANDING: Final = DutyState(Phase.STANDING, AT_A, HOLDS_3, limit=BEFORE_5)
RUNNING: Final = DutyState(
    Phase.RUNNING, ON_6, HOLDS_REST, entered=frozenset({"5"}), limit=BEFORE_7, may_ask=True, may_leave=True
)
ON_SIGHT: Final = DutyState(Phase.ON_SIGHT, LOST, HOLDS_REST, limit=BEFORE_7, may_ask=True, may_leave=True)
FINISHED: Final = DutyState(Phase.FINISHED, AT_B, HOLDS_8, at=1, limit=TO_THE_END)
SIGNING_OFF: Final = DutyState(
    Phase.SIGNING_OFF, AT_B, replace(HOLDS_8, requests=(SIGN_OFF_OPEN,)), at=1, limit=TO_THE_END
)
GONE: Final = DutyState(Phase.GONE, AT_B, at=1)
STATES: Final = {
    s.phase: s for s in (OFF, SIGNING_ON, STANDING, RUNNING, ON_SIGHT, FINISHED, SIGNING_OFF, GONE)
}
ON_THE_LINE: Final = tuple(p for p in Phase if p not in (Phase.OFF, Phase.GONE))


def sent(request: Request) -> tuple[Any, ...]:
    return Send(replace(request, sent=False)), SetTimer(request.timer, REPEAT_S)


def commanded(needed: PointsNeeded) -> tuple[Any, ...]:
    return SendCommand(needed), SetTimer(Timer("points", needed.points_id), REPEAT_S)


def reported(*section_ids: str) -> tuple[Any, ...]:
    note = Write(notes.Reported(section_ids=section_ids, token=0))
    return *sent(replace(REPORT_OPEN, section_ids=section_ids)), note


def holds(*section_ids: str) -> Write:
    return Write(notes.Holds(section_ids=section_ids, token=0))


def limit(joint: int, before: str | None, why: str) -> Write:
    piece, kilometrage_m = PLAN.joint(joint)
    return Write(notes.LimitSet(kilometrage_m=kilometrage_m, piece_id=piece, before=before, why=why))


def moved(place: Place, **changes: bool | int) -> Place:
    return replace(place, **changes)


BEGUN: Final = Write(notes.MissionBegun(train="T1", direction="down"))
UNTIL_DEPARTURE: Final = (SetTimerAt(ASK, DEPARTURE_S - 45.0), SetTimerAt(LEAVE, DEPARTURE_S))
RELEASE_LATER: Final = SetTimerAt(RELEASE, NOW_S + 30.0)
DENIED: Final = Write(notes.GiveBackDenied(why="the train does not stand at a known place"))
ENTERED: Final = Write(notes.GiveBackDenied(why="the train may have entered the route"))
Case = tuple[DutyState, Event, Place, DutyState, tuple[Any, ...]]

PEOPLE: Final[dict[str, Case]] = {
    "stock that comes onto the line signs on": (
        OFF,
        Begin(PLAN, signs_on=True),
        AT_A,
        SIGNING_ON,
        (
            BEGUN,
            *UNTIL_DEPARTURE,
            Renew(Ask.SIGN_ON),
            holds("3"),
            *sent(SIGN_ON_OPEN),
            limit(1, "5", "not held"),
        ),
    ),
    "the next train number of stock that is on the line": (
        replace(FINISHED, authority=HOLDS_3),
        Begin(PLAN, signs_on=False),
        AT_A,
        STANDING,
        (BEGUN, *UNTIL_DEPARTURE, limit(1, "5", "not held")),
    ),
    "the next train number without a position: on sight": (
        replace(FINISHED, authority=HOLDS_3),
        Begin(PLAN, signs_on=False),
        Place(),
        DutyState(Phase.ON_SIGHT, Place(), replace(HOLDS_3, requests=(ROUTE_OPEN,)), stands_at=0),
        (BEGUN, *UNTIL_DEPARTURE, Renew(Ask.ROUTE), *sent(ROUTE_OPEN)),
    ),
    "stock that has left comes again, its emergency brake to be released": (
        GONE,
        Begin(PLAN, signs_on=True),
        moved(AT_A, emergency=True),
        replace(SIGNING_ON, place=moved(AT_A, emergency=True), released=False),
        (
            BEGUN,
            *UNTIL_DEPARTURE,
            RELEASE_LATER,
            Renew(Ask.SIGN_ON),
            holds("3"),
            *sent(SIGN_ON_OPEN),
            limit(1, "5", "not held"),
        ),
    ),
    "switched on at open line: it knows nothing, and may run on sight when the brake is released": (
        DutyState(),
        SwitchedOn(PLAN, None, epoch=2),
        Place(),
        DutyState(
            Phase.ON_SIGHT,
            Place(),
            Authority(requests=(replace(SIGN_ON_OPEN, section_ids=None),)),
            may_ask=True,
            may_leave=True,
            released=False,
        ),
        (
            BEGUN,
            Write(notes.UnitRestarted(epoch=2)),
            RELEASE_LATER,
            Renew(Ask.SIGN_ON),
            *sent(replace(SIGN_ON_OPEN, section_ids=None)),
        ),
    ),
    "switched on at a stop: it leaves when its time has come": (
        DutyState(),
        SwitchedOn(PLAN, 0, epoch=2),
        Place(),
        DutyState(
            Phase.ON_SIGHT,
            Place(),
            Authority(requests=(replace(SIGN_ON_OPEN, section_ids=None),)),
            stands_at=0,
            released=False,
        ),
        (
            BEGUN,
            Write(notes.UnitRestarted(epoch=2)),
            *UNTIL_DEPARTURE,
            RELEASE_LATER,
            Renew(Ask.SIGN_ON),
            *sent(replace(SIGN_ON_OPEN, section_ids=None)),
        ),
    ),
    "the driver changes ends": (
        replace(FINISHED, authority=replace(HOLDS_8, proven=(P7,))),
        ChangeEnds(),
        AT_B,
        FINISHED,
        (holds("8"), Write(notes.ChangedEnds())),
    ),
    "it signs off": (FINISHED, Leave(), AT_B, SIGNING_OFF, (Renew(Ask.SIGN_OFF), *sent(SIGN_OFF_OPEN))),
    "a route is set back, and asked for again after the hold": (
        replace(STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), wanted=(P5,), limit=BEFORE_7),
        SetBack(60.0),
        AT_A,
        replace(STANDING, authority=replace(HOLDS_3, requests=(REPORT_OPEN,))),
        (
            *UNTIL_DEPARTURE,
            Write(notes.GaveBack(section_ids=SECTIONS)),
            Renew(Ask.REPORT),
            holds("3"),
            *reported("3"),
            limit(1, "5", "not held"),
        ),
    ),
    "no route is set back that the front may have entered": (
        replace(STANDING, authority=HOLDS_ALL, limit=Limit(1, "5", "points not proven")),
        SetBack(60.0),
        moved(AT_A, perhaps=2),
        replace(
            STANDING,
            place=moved(AT_A, perhaps=2),
            authority=HOLDS_ALL,
            limit=Limit(1, "5", "points not proven"),
        ),
        (ENTERED,),
    ),
    "none while it rolls": (
        STANDING,
        SetBack(60.0),
        moved(AT_A, stands=False),
        replace(STANDING, place=moved(AT_A, stands=False)),
        (ENTERED,),
    ),
    "none without a position": (
        STANDING,
        SetBack(60.0),
        Place(),
        replace(STANDING, place=Place()),
        (DENIED,),
    ),
    **{
        f"none but at a stop: {at.value}": (
            STATES[at],
            SetBack(60.0),
            STATES[at].place,
            STATES[at],
            (DENIED,),
        )
        for at in ON_THE_LINE
        if at is not Phase.STANDING
    },
    "the crew sees points lie as needed": (
        ON_SIGHT,
        PointsSeen(P7),
        LOST,
        replace(ON_SIGHT, authority=replace(HOLDS_REST, proven=(P7,))),
        (Write(notes.Proven(points_id="P7", position=Position.NORMAL, token=0, by_crew=True)),),
    ),
    "the crew sees points lie otherwise, and has them thrown": (
        ON_SIGHT,
        PointsWrong(P7),
        LOST,
        replace(ON_SIGHT, authority=replace(HOLDS_REST, commands=(Command(P7, sent=True),))),
        (Commit(P7), *commanded(P7)),
    ),
    "points that it does not hold are not thrown": (ON_SIGHT, PointsWrong(P5), LOST, ON_SIGHT, ()),
    "brought to the last mark by its driver: what is surely behind is given back": (
        ON_SIGHT,
        AtMark(1),
        Place(),
        replace(
            ON_SIGHT,
            phase=Phase.FINISHED,
            place=Place(),
            authority=replace(HOLDS_8, requests=(REPORT_OPEN,)),
            at=1,
            stands_at=1,
            may_ask=True,
            may_leave=False,
        ),
        (
            SetTimerAt(LEAVE, NOW_S + 20.0),
            Write(notes.Arrived(station="B", error_m=None)),
            Renew(Ask.REPORT),
            holds("8"),
            *reported("8"),
            Finished("T1"),
        ),
    ),
}

SENSED: Final[dict[str, Case]] = {
    "at the approach tag the arrival points are thrown": (
        RUNNING,
        TagPassed(APPROACH, found=False),
        ON_6,
        replace(RUNNING, authority=replace(HOLDS_REST, commands=(Command(P7, sent=True),)), wanted=(P7,)),
        (Commit(P7), *commanded(P7)),
    ),
    "at the next tag, if the approach tag was missed": (
        RUNNING,
        TagPassed(POSITION, found=False),
        ON_6,
        replace(RUNNING, authority=replace(HOLDS_REST, commands=(Command(P7, sent=True),)), wanted=(P7,)),
        (Commit(P7), *commanded(P7)),
    ),
    "at a tag before the approach nothing is thrown": (RUNNING, TagPassed(3, found=False), ON_6, RUNNING, ()),
    "nor beyond the arrival tag": (FINISHED, TagPassed(8, found=False), AT_B, FINISHED, ()),
    "a tag that tells the position ends running on sight": (
        ON_SIGHT,
        TagPassed(3, found=True),
        ON_6,
        replace(
            RUNNING,
            authority=replace(HOLDS_REST, commands=(Command(P7, sent=True),)),
            entered=frozenset({"3", "5", "6"}),
            wanted=(P7,),
        ),
        (
            Write(notes.PositionFound()),
            Write(notes.Resumed(next_target=1)),
            Order.RESUME,
            Commit(P7),
            *commanded(P7),
        ),
    ),
    **{
        f"a tag of the track: {at.value}": (
            STATES[at],
            TagPassed(0, found=False),
            STATES[at].place,
            STATES[at],
            (),
        )
        for at in (Phase.SIGNING_ON, Phase.STANDING, Phase.ON_SIGHT, Phase.SIGNING_OFF)
    },
    "position lost at a stop: it stands there, by its crew": (
        STANDING,
        PositionLost(),
        Place(),
        replace(
            STANDING,
            phase=Phase.ON_SIGHT,
            place=Place(),
            authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)),
            stands_at=0,
            released=False,
        ),
        (RELEASE_LATER, Renew(Ask.ROUTE), *sent(ROUTE_OPEN)),
    ),
    "position lost under way: on sight": (
        RUNNING,
        PositionLost(),
        LOST,
        replace(ON_SIGHT, entered=frozenset({"5"})),
        (),
    ),
    **{
        f"position lost elsewhere: {at.value}": (
            STATES[at],
            PositionLost(),
            Place(),
            replace(STATES[at], place=Place(), released=False),
            (RELEASE_LATER,),
        )
        for at in (Phase.SIGNING_ON, Phase.ON_SIGHT, Phase.FINISHED, Phase.SIGNING_OFF)
    },
    "the wheels turn": (RUNNING, Started(), ON_6, RUNNING, (Write(notes.Moving()),)),
    "stopped short: it asks for what it lacks": (
        replace(RUNNING, place=moved(ON_6, stands=True)),
        Stopped(How.SHORT, -120.004),
        moved(ON_6, stands=True),
        replace(RUNNING, place=moved(ON_6, stands=True)),
        (Write(notes.StoppedShort(short_m=120.0, why="points not proven")),),
    ),
    "arrived: what the safe rear has left is given back": (
        replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), limit=TO_THE_END),
        Stopped(How.AT, 0.1234),
        AT_B,
        replace(
            RUNNING,
            phase=Phase.STANDING,
            place=AT_B,
            authority=replace(HOLDS_8, requests=(REPORT_OPEN,)),
            at=1,
            limit=TO_THE_END,
            may_leave=False,
        ),
        (
            SetTimerAt(LEAVE, NOW_S + 20.0),
            Write(notes.Arrived(station="B", error_m=0.123)),
            Renew(Ask.REPORT),
            holds("8"),
            *reported("8"),
        ),
    ),
    "overran: no train sets back here, it has arrived": (
        replace(RUNNING, authority=HOLDS_8, limit=TO_THE_END),
        Stopped(How.BEYOND, 7.126),
        AT_B,
        replace(FINISHED, entered=frozenset({"5"}), may_ask=True),
        (
            Write(notes.Overran(beyond_m=7.13)),
            SetTimerAt(LEAVE, NOW_S + 20.0),
            Write(notes.Arrived(station="B", error_m=7.126)),
            Finished("T1"),
        ),
    ),
    **{
        f"an emergency stop waits for the driver: {at.value}": (
            STATES[at],
            Stopped(How.AT, 0.0),
            moved(STATES[at].place, stands=True, emergency=True),
            replace(STATES[at], place=moved(STATES[at].place, stands=True, emergency=True), released=False),
            (RELEASE_LATER,),
        )
        for at in ON_THE_LINE
        if at is not Phase.RUNNING
    },
    **{
        f"out of reach: what is open waits for its timer: {at.value}": (
            STATES[at],
            Looked(),
            moved(STATES[at].place, covered=False),
            replace(STATES[at], place=moved(STATES[at].place, covered=False)),
            (),
        )
        for at in ON_THE_LINE
    },
    "a joint passed by the safe rear: its section is given back": (
        replace(RUNNING, authority=replace(HOLDS_REST, held=("5", "6", "7", "8"))),
        Looked(),
        ON_6,
        replace(RUNNING, authority=replace(HOLDS_REST, requests=(REPORT_OPEN,))),
        (Renew(Ask.REPORT), holds("6", "7", "8"), *reported("6", "7", "8")),
    ),
    "where the radio reaches again, what is due goes out": (
        replace(
            SIGNING_ON, authority=replace(SIGNING_ON.authority, requests=(replace(SIGN_ON_OPEN, sent=False),))
        ),
        Looked(),
        AT_A,
        SIGNING_ON,
        sent(SIGN_ON_OPEN),
    ),
    "a throw is withdrawn where the front may come onto the points": (
        replace(RUNNING, authority=replace(HOLDS_REST, commands=(Command(P7, sent=True),)), wanted=(P7,)),
        Looked(),
        moved(ON_6, perhaps=4),
        replace(RUNNING, place=moved(ON_6, perhaps=4), authority=replace(HOLDS_REST, unsaid=(P7,))),
        (StopTimer(Timer("points", "P7")),),
    ),
}

TOLD: Final[dict[str, Case]] = {
    "a route may be asked for": (
        STANDING,
        TimerDue(ASK),
        AT_A,
        replace(STANDING, may_ask=True, authority=replace(HOLDS_3, requests=(ROUTE_OPEN,))),
        (Renew(Ask.ROUTE), *sent(ROUTE_OPEN)),
    ),
    "the time has come, but not the way": (
        STANDING,
        TimerDue(LEAVE),
        AT_A,
        replace(STANDING, may_leave=True),
        (),
    ),
    "the time has come and the way is free": (
        replace(STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7),
        TimerDue(LEAVE),
        AT_A,
        DutyState(Phase.RUNNING, AT_A, replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7, may_leave=True),
        (Write(notes.Departs(station="A")), Order.DEPART),
    ),
    **{
        f"the driver acknowledges an emergency stop: {at.value}": (
            replace(STATES[at], released=False),
            TimerDue(RELEASE),
            moved(STATES[at].place, emergency=True),
            STATES[at],
            (Write(notes.EmergencyReleased()), Order.RELEASE),
        )
        for at in ON_THE_LINE
    },
    "granted, the departure points are thrown": (
        replace(STANDING, may_ask=True, authority=replace(HOLDS_3, requests=(ROUTE_OPEN,))),
        Heard(Granted("3>8", SECTIONS, ("5", "7"), answers=True, fresh=True, newer=True)),
        AT_A,
        replace(
            STANDING,
            may_ask=True,
            authority=replace(HOLDS_ALL, commands=(Command(P5, sent=True),)),
            wanted=(P5,),
            limit=Limit(1, "5", "points not proven"),
        ),
        (
            StopTimer(Timer("route")),
            Take(SECTIONS),
            Write(notes.RouteHeld(route_id="3>8", token=0)),
            holds("3", *SECTIONS),
            Commit(P5),
            *commanded(P5),
            limit(1, "5", "points not proven"),
        ),
    ),
    "signed on, who waits outside may enter": (
        SIGNING_ON,
        Heard(SignedOn(("3",), (), answers=True, newer=True)),
        AT_A,
        STANDING,
        (
            StopTimer(Timer("sign on")),
            Take(("3",)),
            Write(notes.SignedOn(section_ids=("3",))),
            holds("3"),
            Accepted("T1"),
        ),
    ),
    "signed on without a position: on sight, where it stands": (
        replace(SIGNING_ON, place=Place()),
        Heard(SignedOn(("3",), (), answers=True, newer=True)),
        Place(),
        replace(
            STANDING,
            phase=Phase.ON_SIGHT,
            place=Place(),
            authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)),
            stands_at=0,
        ),
        (
            StopTimer(Timer("sign on")),
            Take(("3",)),
            Write(notes.SignedOn(section_ids=("3",))),
            holds("3"),
            Accepted("T1"),
            Renew(Ask.ROUTE),
            *sent(ROUTE_OPEN),
        ),
    ),
    "signed off, the train may be taken off the line": (
        SIGNING_OFF,
        Heard(SignedOff(answers=True)),
        AT_B,
        replace(GONE, limit=TO_THE_END),
        (StopTimer(Timer("sign off")), Write(notes.SignedOff()), holds(), LeftLine("T1")),
    ),
    "proven, the stop limit moves on": (
        replace(RUNNING, authority=replace(HOLDS_REST, commands=(Command(P7, sent=True),)), wanted=(P7,)),
        Heard(Proof("P7", "B-W", "normal", mine=True)),
        ON_6,
        replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), wanted=(P7,), limit=TO_THE_END),
        (
            StopTimer(Timer("points", "P7")),
            Write(notes.Proven(points_id="P7", position=Position.NORMAL, token=0)),
            limit(5, None, "end of the path"),
        ),
    ),
    "a proof withdrawn draws the limit back, and the points are commanded anew": (
        replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), wanted=(P7,), limit=TO_THE_END),
        Heard(Proof("P7", "B-W", None, mine=True)),
        ON_6,
        replace(
            RUNNING,
            authority=replace(HOLDS_REST, commands=(Command(P7, sent=True),), unsaid=(P7,)),
            wanted=(P7,),
        ),
        (
            Commit(P7),
            Write(notes.ProofDropped(points_id="P7")),
            Commit(P7),
            *commanded(P7),
            limit(3, "7", "points not proven"),
        ),
    ),
    "a proof withdrawn under the train: neither commanded nor holding it back": (
        replace(
            RUNNING,
            authority=replace(HOLDS_REST, proven=(P7,)),
            wanted=(P7,),
            limit=TO_THE_END,
        ),
        Heard(Proof("P7", "B-W", None, mine=True)),
        moved(ON_6, here=3, sure=4, perhaps=4),
        replace(
            RUNNING,
            place=moved(ON_6, here=3, sure=4, perhaps=4),
            authority=replace(HOLDS_REST, unsaid=(P7,)),
            entered=frozenset({"5", "7"}),
            limit=TO_THE_END,
        ),
        (Commit(P7), Write(notes.ProofDropped(points_id="P7"))),
    ),
    **{
        f"a query is answered: {at.value}": (
            STATES[at],
            Heard(Queried()),
            STATES[at].place,
            STATES[at],
            (
                SendClaim(STATES[at].authority.held),
                Write(notes.Claimed(section_ids=STATES[at].authority.held, token=0)),
            ),
        )
        for at in Phase
    },
}
CASES: Final = PEOPLE | SENSED | TOLD


@pytest.mark.parametrize("name", CASES)
def test_row(name: str) -> None:
    state, event, place, after, actions = CASES[name]
    assert step(PLAN, TIMES, state, event, place, NOW_S) == (after, actions)


def test_every_row_has_a_case() -> None:
    cases = {(state.phase, type(event)) for state, event, _, _, _ in CASES.values()}
    assert cases == set(TABLE)


EXAMPLES: Final[dict[type[Event], Event]] = {type(event): event for _, event, _, _, _ in CASES.values()}
REFUSED: Final = [(at, kind) for at in Phase for kind in get_args(Event) if (at, kind) not in TABLE]


@pytest.mark.parametrize(("at", "kind"), REFUSED, ids=[f"{at.value}-{kind.__name__}" for at, kind in REFUSED])
def test_what_the_table_does_not_name_is_refused(at: Phase, kind: type[Event]) -> None:
    state = STATES[at]
    assert step(PLAN, TIMES, state, EXAMPLES[kind], state.place, NOW_S) == (state, ())


@pytest.mark.parametrize("at", [Phase.SIGNING_ON, Phase.SIGNING_OFF])
def test_a_timer_of_the_authority_repeats_its_request(at: Phase) -> None:
    state = STATES[at]
    (request,) = state.authority.requests
    assert step(PLAN, TIMES, state, TimerDue(request.timer), state.place, NOW_S) == (state, sent(request))
    assert step(PLAN, TIMES, state, Heard(PeerRestarted()), state.place, NOW_S) == (state, sent(request))


# the command for the driving part ------------------------------------------------------------------------------


@pytest.mark.parametrize("at", Phase)
def test_it_drives_only_running_or_on_sight(at: Phase) -> None:
    command = command_of(PLAN, STATES[at])
    assert command.drive is (at in (Phase.RUNNING, Phase.ON_SIGHT))
    assert command.on_sight is (at is Phase.ON_SIGHT)
    assert command.target == (1 if at is Phase.RUNNING else None)
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
    assert command_of(PLAN, RUNNING).rear == 2
    assert command_of(PLAN, FINISHED).rear is None
    assert command_of(PLAN, ON_SIGHT).rear is None


@pytest.mark.parametrize(
    ("state", "words"),
    [
        (SIGNING_ON, "signing on: no answer from the block manager"),
        (SIGNING_OFF, "signing off: no answer from the block manager"),
        (STANDING, "departure time"),
        (RUNNING, "nothing"),
        (ON_SIGHT, "a tag: its position is unknown"),
        (replace(ON_SIGHT, place=moved(LOST, emergency=True)), "release of the emergency brake"),
        (
            replace(STANDING, authority=replace(HOLDS_3, requests=(replace(ROUTE_OPEN, refusal="held: 6"),))),
            "route 3>8: held: 6",
        ),
        (replace(RUNNING, authority=replace(HOLDS_REST, commands=(Command(P7),))), "points P7: not proven"),
    ],
)
def test_a_train_says_what_it_waits_for(state: DutyState, words: str) -> None:
    assert waits_for(state) == words
