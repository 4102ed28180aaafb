"""The stage of the duty's tests: the run of the RTRI test line, a state for every phase, and actions."""

from typing import Any, Final

from msgspec.structs import replace

from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.model import Position
from network.timetable import load_timetable
from onboard import notes
from onboard.authority.machine import REPEAT_S
from onboard.authority.records import (
    Authority,
    OpenRequest,
    RequestKind,
    SendCommand,
    SendRequest,
    SetTimer,
    Timer,
    Write,
)
from onboard.authority.records import Event as AuthorityEvent
from onboard.duty.records import (
    ASK,
    LEAVE,
    RELEASE,
    DutyPhase,
    DutyState,
    Event,
    PlaceInJoints,
    SetTimerAt,
    StopLimit,
)
from onboard.duty.unable import Unable
from onboard.duty_parameters import DutyParameters
from onboard.mission import plan_mission
from onboard.plan import DutyPlan, PointsNeeded, plan_of


def papers_plan() -> DutyPlan:
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

AT_A: Final = PlaceInJoints(known=True, here=0, sure=1, perhaps=1, reach=1)
ON_6: Final = PlaceInJoints(
    known=True, stands=False, here=2, sure=3, perhaps=3, clear=2, clear_at_mark=2, reach=3
)
AT_B: Final = PlaceInJoints(
    known=True, here=4, sure=5, perhaps=5, clear=4, clear_at_mark=4, reach=5, near=1, passed=1
)
LOST: Final = PlaceInJoints(stands=False)

ROUTE_OPEN: Final = OpenRequest(RequestKind.ROUTE, "3>8", SECTIONS, sent=True)
REPORT_OPEN: Final = OpenRequest(RequestKind.REPORT, sent=True)
SIGN_ON_OPEN: Final = OpenRequest(RequestKind.SIGN_ON, section_ids=("3",), sent=True)
SIGN_OFF_OPEN: Final = OpenRequest(RequestKind.SIGN_OFF, sent=True)
HOLDS_3: Final = Authority(held=("3",), on_line=True)
HOLDS_ALL: Final = Authority(held=("3", *SECTIONS), commandable=("5", "7"), on_line=True)
HOLDS_REST: Final = Authority(held=("6", "7", "8"), commandable=("7",), on_line=True)
HOLDS_8: Final = Authority(held=("8",), on_line=True)
BEFORE_5: Final = StopLimit(1, "5", "not held")
BEFORE_7: Final = StopLimit(3, "7", "points not proven")
TO_THE_END: Final = StopLimit(5, None, "end of the path")

OFF: Final = DutyState(place=AT_A)
SIGNING_ON: Final = DutyState(
    DutyPhase.SIGNING_ON, AT_A, Authority(held=("3",), requests=(SIGN_ON_OPEN,)), limit=BEFORE_5
)
STANDING: Final = DutyState(DutyPhase.STANDING, AT_A, HOLDS_3, limit=BEFORE_5)
RUNNING: Final = DutyState(
    DutyPhase.RUNNING,
    ON_6,
    HOLDS_REST,
    entered=frozenset({"5"}),
    limit=BEFORE_7,
    may_ask=True,
    may_leave=True,
)
ON_SIGHT: Final = DutyState(
    DutyPhase.ON_SIGHT, LOST, HOLDS_REST, limit=BEFORE_7, may_ask=True, may_leave=True
)
FINISHED: Final = DutyState(DutyPhase.FINISHED, AT_B, HOLDS_8, at=1, limit=TO_THE_END)
SIGNING_OFF: Final = DutyState(
    DutyPhase.SIGNING_OFF, AT_B, replace(HOLDS_8, requests=(SIGN_OFF_OPEN,)), at=1, limit=TO_THE_END
)
LEAVING: Final = DutyState(
    DutyPhase.LEAVING, AT_B, Authority(held=("8",), leaving=True), at=1, limit=TO_THE_END
)
GONE: Final = DutyState(DutyPhase.GONE, AT_B, at=1, limit=TO_THE_END)
STATES: Final = {
    s.phase: s for s in (OFF, SIGNING_ON, STANDING, RUNNING, ON_SIGHT, FINISHED, SIGNING_OFF, LEAVING, GONE)
}
ON_THE_LINE: Final = tuple(
    p for p in DutyPhase if p not in (DutyPhase.OFF, DutyPhase.LEAVING, DutyPhase.GONE)
)


def sent(request: OpenRequest) -> tuple[Any, ...]:
    return SendRequest(replace(request, sent=False)), SetTimer(request.timer, REPEAT_S)


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


def moved(place: PlaceInJoints, **changes: bool | int | str | Unable | None) -> PlaceInJoints:
    return replace(place, **changes)


BEGUN: Final = Write(notes.MissionBegun(train="T1", direction="down"))
UNTIL_DEPARTURE: Final = (SetTimerAt(ASK, DEPARTURE_S - 45.0), SetTimerAt(LEAVE, DEPARTURE_S))
RELEASE_LATER: Final = SetTimer(RELEASE, 30.0)
DENIED: Final = Write(notes.GiveBackDenied(why="the train does not stand at a known place"))
ENTERED: Final = Write(notes.GiveBackDenied(why="the train may have entered the route"))
Case = tuple[DutyState, Event, PlaceInJoints, DutyState, tuple[Any, ...]]
AuthorityCase = tuple[Authority, AuthorityEvent, Authority, tuple[Any, ...]]


def changed(
    state: DutyState, event: Event, place: PlaceInJoints, actions: tuple[Any, ...] = (), /, **changes: object
) -> Case:
    """A row whose next state is the one before, at `place`, but for what changes."""
    return state, event, place, replace(state, **{"place": place, **changes}), actions


def became(
    state: Authority, event: AuthorityEvent, actions: tuple[Any, ...] = (), /, **changes: object
) -> AuthorityCase:
    """The same of what is held and asked for."""
    return state, event, replace(state, **changes), actions
