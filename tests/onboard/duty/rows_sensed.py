"""Rows of the table of the duty for what is sensed: state, event, place; next state and actions."""

from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import (
    Authority,
    Commit,
    OpenCommand,
    OpenRequest,
    Renew,
    RequestKind,
    SendRequest,
    SetTimer,
    StopTimer,
    Timer,
    Write,
)
from onboard.duty.records import (
    LEAVE,
    DrivingOrder,
    DutyPhase,
    Finished,
    Looked,
    MarkRelation,
    PlaceInJoints,
    PositionLost,
    StopLimit,
    Stopped,
    TagBelieved,
    WheelsTurning,
)
from tests.onboard.duty.stage import (
    APPROACH,
    AT_A,
    AT_B,
    BEFORE_7,
    FINISHED,
    HOLDS_3,
    HOLDS_8,
    HOLDS_ALL,
    HOLDS_REST,
    LOST,
    ON_6,
    ON_SIGHT,
    ON_THE_LINE,
    P5,
    P7,
    POSITION,
    RELEASE_LATER,
    REPORT_OPEN,
    ROUTE_OPEN,
    RUNNING,
    SIGN_ON_OPEN,
    SIGNING_ON,
    STANDING,
    STATES,
    TO_THE_END,
    Case,
    changed,
    commanded,
    holds,
    limit,
    moved,
    reported,
    sent,
)

ARRIVAL, TAG_701 = 7, 6  # tags 801 on the arrival track, 701 between the points and their section's end
BOTH: Final = frozenset({"5", "7"})
HOLDS_PASSED: Final = Authority(held=("5", "6", "7", "8"), commandable=("5", "7"), on_line=True)
HOLDS_5_6: Final = Authority(held=("5", "6"), commandable=("5",), on_line=True)
UNSWEPT: Final = replace(HOLDS_ALL, unswept=("6",))
BEFORE_6_ON_SIGHT: Final = StopLimit(2, "6", "to be passed on sight")
NO_FURTHER: Final = StopLimit(3, "7", "not held")
AT_STAND: Final = moved(ON_6, stands=True)
RUNNING_ON_5: Final = PlaceInJoints(known=True, stands=False, here=1, sure=2, perhaps=2, reach=2)
IN_8: Final = PlaceInJoints(
    known=True, stands=False, here=4, sure=5, perhaps=5, clear=4, clear_at_mark=4, reach=5
)
REAR_IN_7: Final = moved(IN_8, clear=3, clear_at_mark=3)
ARRIVING: Final = replace(RUNNING, place=IN_8, authority=HOLDS_PASSED, entered=BOTH, limit=TO_THE_END)
CLAIMS: Final = replace(SIGN_ON_OPEN, section_ids=("5", "6", "7"))
IGNORANT: Final = replace(SIGN_ON_OPEN, section_ids=None)
NOBODY_KNOWS: Final = Authority(requests=(replace(IGNORANT, refusal="claim needed"),))

SENSED: Final[dict[str, Case]] = {
    **{
        what: changed(
            RUNNING,
            TagBelieved(tag, found=False),
            ON_6,
            (Commit(P7), *commanded(P7)),
            authority=replace(HOLDS_REST, commands=(OpenCommand(P7, sent=True),)),
            wanted=(P7,),
            proved=2,
        )
        for what, tag in (
            ("at the approach tag the arrival points are thrown", APPROACH),
            ("at the next tag, if the approach tag was missed", POSITION),
        )
    },
    "at a tag before the approach nothing is thrown": changed(
        RUNNING, TagBelieved(3, found=False), ON_6, proved=1
    ),
    "nor beyond the arrival tag": changed(FINISHED, TagBelieved(8, found=False), AT_B, proved=4, freed=4),
    "a tag proves what is behind, but before the arrival tag nothing is given back": changed(
        ARRIVING, TagBelieved(TAG_701, found=False), IN_8, proved=2
    ),
    "at the arrival tag all that it proves to be behind is given back": changed(
        ARRIVING,
        TagBelieved(ARRIVAL, found=False),
        IN_8,
        (Renew(RequestKind.REPORT), holds("8"), *reported("8")),
        proved=4,
        freed=4,
        authority=replace(HOLDS_8, requests=(REPORT_OPEN,)),
    ),
    "at the arrival tag, and the safe rear by the odometer not clear yet: only what it has left": changed(
        replace(ARRIVING, place=REAR_IN_7),
        TagBelieved(ARRIVAL, found=False),
        REAR_IN_7,
        (Renew(RequestKind.REPORT), holds("7", "8"), *reported("7", "8")),
        proved=4,
        freed=4,
        authority=replace(HOLDS_PASSED, held=("7", "8"), commandable=("7",), requests=(REPORT_OPEN,)),
    ),
    "a tag that tells the position late, the arrival tag missed: nothing before the mark": changed(
        ARRIVING, TagBelieved(ARRIVAL + 1, found=False), IN_8, proved=4
    ),
    "a tag that tells the position ends running on sight": (
        ON_SIGHT,
        TagBelieved(3, found=True),
        ON_6,
        replace(
            RUNNING,
            authority=replace(HOLDS_REST, commands=(OpenCommand(P7, sent=True),)),
            entered=frozenset({"3", "5", "6"}),
            wanted=(P7,),
            proved=1,
        ),
        (
            Write(notes.PositionFound()),
            Write(notes.Resumed(next_target=1)),
            DrivingOrder.RESUME,
            Commit(P7),
            *commanded(P7),
        ),
    ),
    "a tag tells the position of a unit that the manager does not know either: it claims where it may stand": changed(
        replace(ON_SIGHT, authority=NOBODY_KNOWS),
        TagBelieved(3, found=True),
        moved(ON_6, clear=1, perhaps=4),
        (Write(notes.PositionFound()), Renew(RequestKind.SIGN_ON), holds("5", "6", "7"), *sent(CLAIMS)),
        authority=Authority(held=("5", "6", "7"), requests=(CLAIMS,)),
        proved=1,
    ),
    "a tag tells the position before the manager has answered: it waits for what that has": changed(
        replace(ON_SIGHT, authority=replace(NOBODY_KNOWS, requests=(IGNORANT,))),
        TagBelieved(3, found=True),
        ON_6,
        (Write(notes.PositionFound()),),
        proved=1,
    ),
    **{
        f"a tag of the track: {at.value}": changed(STATES[at], TagBelieved(0, found=False), STATES[at].place)
        for at in (DutyPhase.SIGNING_ON, DutyPhase.STANDING, DutyPhase.ON_SIGHT, DutyPhase.SIGNING_OFF)
    },
    "position lost at a stop: it stands there, by its crew": changed(
        STANDING,
        PositionLost(),
        PlaceInJoints(),
        (RELEASE_LATER, Renew(RequestKind.ROUTE), *sent(ROUTE_OPEN)),
        phase=DutyPhase.ON_SIGHT,
        authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)),
        stands_at=0,
        released=False,
    ),
    "position lost under way: on sight": (
        RUNNING,
        PositionLost(),
        LOST,
        replace(ON_SIGHT, entered=frozenset({"5"})),
        (),
    ),
    **{
        f"position lost elsewhere: {at.value}": changed(
            STATES[at], PositionLost(), PlaceInJoints(), (RELEASE_LATER,), released=False
        )
        for at in (DutyPhase.SIGNING_ON, DutyPhase.ON_SIGHT, DutyPhase.FINISHED, DutyPhase.SIGNING_OFF)
    },
    "position lost under way: throws still open are given up, the front may be upon the points": (
        replace(RUNNING, authority=replace(HOLDS_REST, commands=(OpenCommand(P7, sent=True),)), wanted=(P7,)),
        PositionLost(),
        LOST,
        replace(
            ON_SIGHT, authority=replace(HOLDS_REST, unsaid=(P7,)), entered=frozenset({"5"}), wanted=(P7,)
        ),
        (StopTimer(Timer("points", "P7")),),
    ),
    "position lost under way where no radio reached: what waited for it is tried": (
        replace(RUNNING, authority=replace(HOLDS_REST, requests=(replace(ROUTE_OPEN, sent=False),))),
        PositionLost(),
        LOST,
        replace(ON_SIGHT, authority=replace(HOLDS_REST, requests=(ROUTE_OPEN,)), entered=frozenset({"5"})),
        sent(ROUTE_OPEN),
    ),
    "the wheels turn": (RUNNING, WheelsTurning(), ON_6, RUNNING, (Write(notes.Moving()),)),
    "stopped short of points, with all that it needs: it throws them": changed(
        replace(RUNNING, authority=HOLDS_PASSED),
        Stopped(MarkRelation.SHORT, -120.004),
        AT_STAND,
        (Write(notes.StoppedShort(short_m=120.0, why="points not proven")), Commit(P7), *commanded(P7)),
        authority=replace(HOLDS_PASSED, commands=(OpenCommand(P7, sent=True),)),
        wanted=(P7,),
    ),
    "stopped short, the route ahead given back: it asks for what it lacks": changed(
        replace(RUNNING, authority=HOLDS_5_6, limit=NO_FURTHER),
        Stopped(MarkRelation.SHORT, -120.004),
        AT_STAND,
        (
            Write(notes.StoppedShort(short_m=120.0, why="not held")),
            Renew(RequestKind.ROUTE),
            *sent(ROUTE_OPEN),
        ),
        authority=replace(HOLDS_5_6, requests=(ROUTE_OPEN,)),
    ),
    "standing short of its mark it asks again when it may": changed(
        replace(RUNNING, authority=HOLDS_5_6, limit=NO_FURTHER, place=AT_STAND),
        Looked(),
        AT_STAND,
        (Renew(RequestKind.ROUTE), *sent(ROUTE_OPEN)),
        authority=replace(HOLDS_5_6, requests=(ROUTE_OPEN,)),
    ),
    "standing where its bounds reach onto points not proven: the position is given up": changed(
        replace(RUNNING, authority=HOLDS_PASSED),
        Stopped(MarkRelation.SHORT, -1.0),
        moved(AT_STAND, perhaps=4),
        (Write(notes.StoppedShort(short_m=1.0, why="points not proven")), DrivingOrder.LOSE, RELEASE_LATER),
        phase=DutyPhase.ON_SIGHT,
        place=moved(AT_STAND, perhaps=4, known=False, emergency=True),
        released=False,
    ),
    "arrived: what the tags read so far prove to be behind is given back": changed(
        replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), limit=TO_THE_END, proved=4),
        Stopped(MarkRelation.AT, 0.1234),
        AT_B,
        (
            SetTimer(LEAVE, 20.0),
            Write(notes.Arrived(station="B", error_m=0.123)),
            Renew(RequestKind.REPORT),
            holds("8"),
            *reported("8"),
        ),
        phase=DutyPhase.STANDING,
        authority=replace(HOLDS_8, requests=(REPORT_OPEN,)),
        at=1,
        may_leave=False,
        freed=4,
    ),
    "arrived by the tachometer alone: nothing is given back before the driver has looked": changed(
        replace(RUNNING, authority=HOLDS_PASSED, limit=TO_THE_END, entered=BOTH, proved=1),
        Stopped(MarkRelation.AT, 0.1234),
        AT_B,
        (SetTimer(LEAVE, 20.0), Write(notes.Arrived(station="B", error_m=0.123))),
        phase=DutyPhase.STANDING,
        authority=replace(HOLDS_PASSED, requests=()),
        at=1,
        may_leave=False,
        freed=1,
    ),
    "overran: no train sets back here, it has arrived": (
        replace(RUNNING, authority=HOLDS_8, limit=TO_THE_END),
        Stopped(MarkRelation.BEYOND, 7.126),
        AT_B,
        replace(FINISHED, entered=frozenset({"5"}), may_ask=True),
        (
            Write(notes.Overran(beyond_m=7.13)),
            SetTimer(LEAVE, 20.0),
            Write(notes.Arrived(station="B", error_m=7.126)),
            Finished("T1"),
        ),
    ),
    **{
        f"an emergency stop waits for the driver: {at.value}": changed(
            STATES[at],
            Stopped(MarkRelation.AT, 0.0),
            moved(STATES[at].place, stands=True, emergency=True),
            (RELEASE_LATER,),
            released=False,
        )
        for at in ON_THE_LINE
        if at is not DutyPhase.RUNNING
    },
    **{
        f"out of reach: what is open waits for its timer: {at.value}": changed(
            STATES[at], Looked(), moved(STATES[at].place, covered=False)
        )
        for at in ON_THE_LINE
    },
    "a joint passed by the safe rear before the arrival tag: nothing is given back": changed(
        replace(RUNNING, authority=HOLDS_PASSED, proved=2), Looked(), ON_6
    ),
    "a joint passed by the safe rear after it: its section is given back": changed(
        replace(
            ARRIVING, proved=4, freed=4, authority=replace(HOLDS_PASSED, held=("7", "8"), commandable=("7",))
        ),
        Looked(),
        IN_8,
        (Renew(RequestKind.REPORT), holds("8"), *reported("8")),
        authority=replace(HOLDS_8, requests=(REPORT_OPEN,)),
    ),
    "what lies not on its path is given back": changed(
        replace(RUNNING, authority=replace(HOLDS_PASSED, held=("9", "5", "6", "7", "8"))),
        Looked(),
        ON_6,
        (Renew(RequestKind.REPORT), holds("5", "6", "7", "8"), *reported("5", "6", "7", "8")),
        authority=replace(HOLDS_PASSED, requests=(REPORT_OPEN,)),
    ),
    "from a stand it goes on on sight through what must be swept": changed(
        replace(STANDING, authority=replace(UNSWEPT, proven=(P5,)), limit=BEFORE_6_ON_SIGHT),
        Looked(),
        AT_A,
        (limit(3, "7", "points not proven"),),
        limit=BEFORE_7,
        sweeps=True,
    ),
    "moving, it stops before what must be swept": changed(
        replace(RUNNING, place=RUNNING_ON_5, authority=replace(UNSWEPT, proven=(P5,)), limit=BEFORE_7),
        Looked(),
        RUNNING_ON_5,
        (limit(2, "6", "to be passed on sight"),),
        limit=BEFORE_6_ON_SIGHT,
    ),
    "it sweeps until none of it is held": (
        replace(ARRIVING, freed=4, proved=4, sweeps=True, authority=replace(HOLDS_PASSED, unswept=("6",))),
        Looked(),
        IN_8,
        replace(
            ARRIVING, proved=4, freed=4, authority=replace(HOLDS_8, requests=(REPORT_OPEN,), swept=("6",))
        ),
        (
            Renew(RequestKind.REPORT),
            holds("8"),
            SendRequest(OpenRequest(RequestKind.REPORT, section_ids=("8",), swept=("6",))),
            *reported("8")[1:],
        ),
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
        replace(RUNNING, authority=replace(HOLDS_REST, commands=(OpenCommand(P7, sent=True),)), wanted=(P7,)),
        Looked(),
        moved(ON_6, perhaps=4),
        replace(RUNNING, place=moved(ON_6, perhaps=4), authority=replace(HOLDS_REST, unsaid=(P7,))),
        (StopTimer(Timer("points", "P7")),),
    ),
}
