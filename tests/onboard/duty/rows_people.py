"""Rows of the table of the duty for what people do: state, event, place; next state and actions."""

from typing import Final

from msgspec.structs import replace

from network.model import Position
from onboard import notes
from onboard.authority.records import (
    Authority,
    Commit,
    OpenCommand,
    Renew,
    RequestKind,
    SetTimer,
    StopTimer,
    Timer,
    Write,
)
from onboard.duty.records import (
    ASK,
    LEAVE,
    AtMark,
    Begin,
    ChangeEnds,
    DrivingOrder,
    DutyPhase,
    DutyState,
    EndOfHeld,
    Finished,
    Leave,
    NotAtMark,
    OffTheLine,
    PlaceInJoints,
    PointsSeen,
    PointsWrong,
    SetBack,
    StopLimit,
    SwitchedOn,
)
from tests.onboard.duty.stage import (
    AT_A,
    AT_B,
    BEFORE_5,
    BEFORE_7,
    BEGUN,
    DENIED,
    ENTERED,
    FINISHED,
    GONE,
    HOLDS_3,
    HOLDS_8,
    HOLDS_ALL,
    HOLDS_REST,
    LEAVING,
    LOST,
    OFF,
    ON_6,
    ON_SIGHT,
    ON_THE_LINE,
    P5,
    P7,
    PLAN,
    RELEASE_LATER,
    REPORT_OPEN,
    ROUTE_OPEN,
    RUNNING,
    SECTIONS,
    SIGN_OFF_OPEN,
    SIGN_ON_OPEN,
    SIGNING_OFF,
    SIGNING_ON,
    STANDING,
    STATES,
    TO_THE_END,
    UNTIL_DEPARTURE,
    Case,
    changed,
    commanded,
    holds,
    limit,
    moved,
    reported,
    sent,
)

BOTH: Final = frozenset({"5", "7"})
P7_OPEN: Final = OpenCommand(P7, sent=True)
HALT: Final = moved(ON_6, stands=True)
HOLDS_ON_6: Final = Authority(held=("5", "6", "7", "8"), commandable=("5", "7"), on_line=True)
PAST_P7: Final = replace(HOLDS_ON_6, proven=(P7,))
HOLDS_7_8: Final = Authority(held=("7", "8"), on_line=True)

PEOPLE: Final[dict[str, Case]] = {
    "on sight at the end of what it holds, it asks for the way that leads on": changed(
        replace(ON_SIGHT, authority=HOLDS_3, limit=BEFORE_5),
        EndOfHeld(0),
        LOST,
        (Renew(RequestKind.ROUTE), *sent(ROUTE_OPEN)),
        authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)),
    ),
    "stock that comes onto the line signs on": (
        OFF,
        Begin(PLAN, signs_on=True),
        AT_A,
        SIGNING_ON,
        (
            BEGUN,
            *UNTIL_DEPARTURE,
            Renew(RequestKind.SIGN_ON),
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
        PlaceInJoints(),
        DutyState(DutyPhase.ON_SIGHT, PlaceInJoints(), replace(HOLDS_3, requests=(ROUTE_OPEN,)), stands_at=0),
        (BEGUN, *UNTIL_DEPARTURE, Renew(RequestKind.ROUTE), *sent(ROUTE_OPEN)),
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
            Renew(RequestKind.SIGN_ON),
            holds("3"),
            *sent(SIGN_ON_OPEN),
            limit(1, "5", "not held"),
        ),
    ),
    "switched on at open line: it knows nothing, and may run on sight when the brake is released": (
        DutyState(),
        SwitchedOn(PLAN, None, epoch=2),
        PlaceInJoints(),
        DutyState(
            DutyPhase.ON_SIGHT,
            PlaceInJoints(),
            Authority(requests=(replace(SIGN_ON_OPEN, section_ids=None),)),
            may_ask=True,
            may_leave=True,
            released=False,
        ),
        (
            BEGUN,
            Write(notes.UnitRestarted(epoch=2)),
            RELEASE_LATER,
            Renew(RequestKind.SIGN_ON),
            *sent(replace(SIGN_ON_OPEN, section_ids=None)),
        ),
    ),
    "switched on at a stop: it leaves when its time has come": (
        DutyState(),
        SwitchedOn(PLAN, 0, epoch=2),
        PlaceInJoints(),
        DutyState(
            DutyPhase.ON_SIGHT,
            PlaceInJoints(),
            Authority(requests=(replace(SIGN_ON_OPEN, section_ids=None),)),
            stands_at=0,
            released=False,
        ),
        (
            BEGUN,
            Write(notes.UnitRestarted(epoch=2)),
            *UNTIL_DEPARTURE,
            RELEASE_LATER,
            Renew(RequestKind.SIGN_ON),
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
    "it signs off": (
        FINISHED,
        Leave(),
        AT_B,
        SIGNING_OFF,
        (Renew(RequestKind.SIGN_OFF), *sent(SIGN_OFF_OPEN)),
    ),
    "a route is set back, and asked for again after the hold": (
        replace(STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), wanted=(P5,), limit=BEFORE_7),
        SetBack(60.0),
        AT_A,
        replace(STANDING, authority=replace(HOLDS_3, requests=(REPORT_OPEN,))),
        (
            *(
                replace(timer, after_s=60.0 + late_s)
                for timer, late_s in zip(UNTIL_DEPARTURE, (0.0, 45.0), strict=True)
            ),
            Write(notes.GaveBack(section_ids=SECTIONS)),
            Renew(RequestKind.REPORT),
            holds("3"),
            *reported("3"),
            limit(1, "5", "not held"),
        ),
    ),
    "no route is set back that the front may have entered": changed(
        replace(STANDING, authority=HOLDS_ALL, limit=StopLimit(1, "5", "points not proven")),
        SetBack(60.0),
        moved(AT_A, perhaps=2),
        (ENTERED,),
    ),
    "none while it rolls": changed(STANDING, SetBack(60.0), moved(AT_A, stands=False), (DENIED,)),
    "none without a position": changed(STANDING, SetBack(60.0), PlaceInJoints(), (DENIED,)),
    "set back at a halt on open line: the route beyond it, and asked for again after the hold": (
        replace(RUNNING, place=HALT, authority=replace(HOLDS_ON_6, commands=(P7_OPEN,)), wanted=(P7,)),
        SetBack(60.0),
        HALT,
        replace(
            RUNNING,
            place=HALT,
            authority=replace(HOLDS_ON_6, held=("5", "6"), commandable=("5",), requests=(REPORT_OPEN,)),
            limit=StopLimit(3, "7", "not held"),
            may_ask=False,
        ),
        (
            SetTimer(ASK, 60.0),
            Write(notes.GaveBack(section_ids=("7", "8"))),
            StopTimer(Timer("points", "P7")),
            Renew(RequestKind.REPORT),
            holds("5", "6"),
            *reported("5", "6"),
            limit(3, "7", "not held"),
        ),
    ),
    "at a halt no section is set back that the front may have entered": changed(
        replace(RUNNING, place=moved(HALT, perhaps=4), authority=PAST_P7, limit=TO_THE_END, entered=BOTH),
        SetBack(60.0),
        moved(HALT, perhaps=4),
        (
            SetTimer(ASK, 60.0),
            Write(notes.GaveBack(section_ids=("8",))),
            Renew(RequestKind.REPORT),
            holds("5", "6", "7"),
            *reported("5", "6", "7"),
            limit(4, "8", "not held"),
        ),
        authority=replace(PAST_P7, held=("5", "6", "7"), requests=(REPORT_OPEN,)),
        limit=StopLimit(4, "8", "not held"),
        may_ask=False,
    ),
    **{
        f"none but at a stand: {at.value}": changed(STATES[at], SetBack(60.0), STATES[at].place, (DENIED,))
        for at in ON_THE_LINE
        if at is not DutyPhase.STANDING
    },
    **{
        f"asked, the driver sees the whole train at its mark: {at.value}": changed(
            replace(STATES[at], at=1, place=AT_B, authority=HOLDS_7_8, entered=BOTH),
            AtMark(1),
            AT_B,
            (
                Renew(RequestKind.REPORT),
                holds("8"),
                *reported("8"),
                *([] if at is not DutyPhase.STANDING else [limit(5, None, "end of the path")]),
            ),
            authority=replace(HOLDS_8, requests=(REPORT_OPEN,)),
            limit=TO_THE_END,
        )
        for at in (DutyPhase.STANDING, DutyPhase.FINISHED)
    },
    "of another mark than that where it stands his word frees nothing": changed(
        replace(FINISHED, authority=HOLDS_7_8, entered=BOTH), AtMark(0), AT_B
    ),
    "seen at its mark, a train that leaves signs off once nothing but the portal is held": changed(
        replace(SIGNING_OFF, authority=HOLDS_7_8),
        AtMark(1),
        AT_B,
        (
            Renew(RequestKind.REPORT),
            holds("8"),
            *reported("8"),
            Renew(RequestKind.SIGN_OFF),
            *sent(SIGN_OFF_OPEN),
        ),
        authority=replace(HOLDS_8, requests=(REPORT_OPEN, SIGN_OFF_OPEN)),
    ),
    "off the line, told after its boot, it holds nothing": (
        DutyState(authority=Authority(unsure=True)),
        OffTheLine(),
        AT_B,
        DutyState(place=AT_B),
        (holds(),),
    ),
    "off the line, it holds its portal no more": (LEAVING, OffTheLine(), AT_B, GONE, (holds(),)),
    "a train that leaves and holds more does not sign off yet": (
        replace(FINISHED, authority=HOLDS_7_8, entered=BOTH),
        Leave(),
        AT_B,
        replace(SIGNING_OFF, authority=HOLDS_7_8, entered=BOTH),
        (),
    ),
    **{
        f"asked, the driver sees the train short of its mark: it goes on on sight: {at.value}": changed(
            replace(STATES[at], at=1, place=AT_B, authority=HOLDS_7_8, limit=TO_THE_END),
            NotAtMark(),
            AT_B,
            (DrivingOrder.LOSE, RELEASE_LATER),
            phase=DutyPhase.ON_SIGHT,
            at=0,
            place=moved(AT_B, known=False, emergency=True),
            may_leave=True,
            released=False,
        )
        for at in (DutyPhase.STANDING, DutyPhase.FINISHED, DutyPhase.SIGNING_OFF)
    },
    "the manager has been asked already whether it may leave: it goes nowhere": changed(
        SIGNING_OFF, NotAtMark(), AT_B
    ),
    "the crew sees points lie as needed": changed(
        ON_SIGHT,
        PointsSeen(P7),
        LOST,
        (Write(notes.Proven(points_id="P7", position=Position.NORMAL, token=0, by_crew=True)),),
        authority=replace(HOLDS_REST, proven=(P7,)),
    ),
    "the crew sees points lie otherwise, and has them thrown": changed(
        ON_SIGHT,
        PointsWrong(P7),
        LOST,
        (Commit(P7), *commanded(P7)),
        authority=replace(HOLDS_REST, commands=(OpenCommand(P7, sent=True),)),
    ),
    "points that it does not hold are not thrown": (ON_SIGHT, PointsWrong(P5), LOST, ON_SIGHT, ()),
    "brought to the last mark by its driver: what is surely behind is given back": changed(
        ON_SIGHT,
        AtMark(1),
        PlaceInJoints(),
        (
            SetTimer(LEAVE, 20.0),
            Write(notes.Arrived(station="B", error_m=None)),
            Renew(RequestKind.REPORT),
            holds("8"),
            *reported("8"),
            Finished("T1"),
        ),
        phase=DutyPhase.FINISHED,
        authority=replace(HOLDS_8, requests=(REPORT_OPEN,)),
        at=1,
        stands_at=1,
        may_ask=True,
        may_leave=False,
    ),
    "at its mark by the driver's eye, though it believes to be short of it: on sight from there": changed(
        RUNNING,
        AtMark(1),
        moved(ON_6, stands=True),
        (
            DrivingOrder.LOSE,
            RELEASE_LATER,
            SetTimer(LEAVE, 20.0),
            Write(notes.Arrived(station="B", error_m=None)),
            Renew(RequestKind.REPORT),
            holds("8"),
            *reported("8"),
            Finished("T1"),
        ),
        phase=DutyPhase.FINISHED,
        place=moved(ON_6, stands=True, known=False, emergency=True),
        authority=replace(HOLDS_8, requests=(REPORT_OPEN,)),
        at=1,
        stands_at=1,
        may_leave=False,
        released=False,
    ),
}
