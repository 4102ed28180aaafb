"""Rows of the table of the duty for what is sensed: state, event, place; next state and actions."""

from __future__ import annotations

from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import (
    Ask,
    Command,
    Commit,
    Renew,
    SetTimer,
    StopTimer,
    Timer,
    Write,
)
from onboard.duty.records import (
    LEAVE,
    Finished,
    How,
    Looked,
    Order,
    Phase,
    Place,
    PositionLost,
    Started,
    Stopped,
    TagPassed,
    VehicleChecked,
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
    commanded,
    holds,
    moved,
    reported,
    sent,
)

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
            SetTimer(LEAVE, 20.0),
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
            SetTimer(LEAVE, 20.0),
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
    **{
        f"the vehicle is not in order: it does not start: {at.value}": (
            STATES[at],
            VehicleChecked(),
            moved(STATES[at].place, unfit="doors not closed"),
            replace(STATES[at], place=moved(STATES[at].place, unfit="doors not closed")),
            (Write(notes.VehicleUnfit(why="doors not closed")),),
        )
        for at in ON_THE_LINE
        if at not in (Phase.RUNNING, Phase.ON_SIGHT)
    },
    **{
        f"the vehicle is not in order: it is stopped: {at.value}": (
            STATES[at],
            VehicleChecked(),
            moved(STATES[at].place, unfit="brake not in order"),
            replace(STATES[at], place=moved(STATES[at].place, unfit="brake not in order")),
            (Write(notes.VehicleUnfit(why="brake not in order")), Order.STOP),
        )
        for at in (Phase.RUNNING, Phase.ON_SIGHT)
    },
    "it stands short of its mark: stopped all the same, and the driver acknowledges": (
        RUNNING,
        VehicleChecked(),
        moved(ON_6, stands=True, unfit="doors not closed"),
        replace(RUNNING, place=moved(ON_6, stands=True, unfit="doors not closed"), released=False),
        (Write(notes.VehicleUnfit(why="doors not closed")), Order.STOP, RELEASE_LATER),
    ),
    "a vehicle in order again lets a train depart that is ready": (
        replace(
            STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7, may_ask=True, may_leave=True
        ),
        VehicleChecked(),
        AT_A,
        replace(
            STANDING,
            phase=Phase.RUNNING,
            authority=replace(HOLDS_ALL, proven=(P5,)),
            limit=BEFORE_7,
            may_ask=True,
            may_leave=True,
        ),
        (Write(notes.VehicleFit()), Write(notes.Departs(station="A")), Order.DEPART),
    ),
}
