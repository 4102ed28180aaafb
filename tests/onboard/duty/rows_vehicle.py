"""Rows of the table of the duty for what the vehicle shows of itself: next state and actions."""

from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import Renew, RequestKind, SetTimer, Write
from onboard.duty.fitness import LOOKS_AGAIN_S
from onboard.duty.records import (
    ABLE,
    ASK,
    LEAVE,
    DrivingOrder,
    DutyPhase,
    Looked,
    PositionLost,
    TimerDue,
    VehicleChecked,
)
from onboard.duty.unable import NoCharge, TooSteep
from tests.onboard.duty.stage import (
    AT_A,
    BEFORE_7,
    HOLDS_3,
    HOLDS_ALL,
    HOLDS_REST,
    ON_6,
    ON_THE_LINE,
    P5,
    P7,
    RELEASE_LATER,
    ROUTE_OPEN,
    RUNNING,
    STANDING,
    STATES,
    TO_THE_END,
    Case,
    changed,
    moved,
    sent,
)

CLEARED_TO_8: Final = replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), limit=TO_THE_END)

TOO_STEEP: Final = TooSteep("B", "6", 300.0, 40.0, 20e3, 32e3, 1.0, 0.5)
STEEPER: Final = TooSteep("B", "6", 300.0, 40.0, 10e3, 32e3, 1.0, 0.25)
BEFORE_A_CLIMB: Final = moved(AT_A, unable=TOO_STEEP)
UNABLE: Final = replace(STANDING, place=BEFORE_A_CLIMB, may_ask=True, unable=TOO_STEEP)
SAYS_UNABLE: Final = Write(notes.UnableToLeave(station="A", why=TOO_STEEP.words))
LOOKS_AGAIN: Final = SetTimer(ABLE, LOOKS_AGAIN_S)
CHARGES: Final = NoCharge("C", 60e3, 50e3, charges=True, connected=True, stays_up=True)
AT_A_CHARGER: Final = moved(AT_A, unable=CHARGES)
READY: Final = replace(
    STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7, may_ask=True, may_leave=True
)

VEHICLE: Final[dict[str, Case]] = {
    **{
        f"the vehicle is not in order: it does not start: {at.value}": changed(
            STATES[at],
            VehicleChecked(),
            moved(STATES[at].place, unfit="doors not closed"),
            (Write(notes.VehicleUnfit(why="doors not closed")),),
        )
        for at in ON_THE_LINE
        if at not in (DutyPhase.RUNNING, DutyPhase.ON_SIGHT)
    },
    **{
        f"the vehicle is not in order: it is stopped: {at.value}": changed(
            STATES[at],
            VehicleChecked(),
            moved(STATES[at].place, unfit="brake not in order"),
            (Write(notes.VehicleUnfit(why="brake not in order")), DrivingOrder.STOP),
        )
        for at in (DutyPhase.RUNNING, DutyPhase.ON_SIGHT)
    },
    "it stands short of its mark: stopped all the same, and the driver acknowledges": changed(
        CLEARED_TO_8,
        VehicleChecked(),
        moved(ON_6, stands=True, unfit="doors not closed"),
        (Write(notes.VehicleUnfit(why="doors not closed")), DrivingOrder.STOP, RELEASE_LATER),
        released=False,
    ),
    "a vehicle in order again lets a train depart that is ready": changed(
        replace(
            STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7, may_ask=True, may_leave=True
        ),
        VehicleChecked(),
        AT_A,
        (Write(notes.VehicleFit()), Write(notes.Departs(station="A")), DrivingOrder.DEPART),
        phase=DutyPhase.RUNNING,
    ),
    "unable to reach its next stop it says so when it would ask for a route, asks for none, and looks again": (
        STANDING,
        TimerDue(ASK),
        BEFORE_A_CLIMB,
        UNABLE,
        (SAYS_UNABLE, LOOKS_AGAIN),
    ),
    "still unable, it looks again": (UNABLE, TimerDue(ABLE), BEFORE_A_CLIMB, UNABLE, (LOOKS_AGAIN,)),
    "still unable when its time comes, it stays": changed(
        UNABLE, TimerDue(LEAVE), BEFORE_A_CLIMB, may_leave=True
    ),
    "less able than before: shown, and not said again": changed(
        UNABLE, Looked(), moved(AT_A, unable=STEEPER), unable=STEEPER
    ),
    "able again, it asks for its route": (
        UNABLE,
        TimerDue(ABLE),
        AT_A,
        replace(STANDING, may_ask=True, authority=replace(HOLDS_3, requests=(ROUTE_OPEN,))),
        (Write(notes.AbleToLeave(station="A")), Renew(RequestKind.ROUTE), *sent(ROUTE_OPEN)),
    ),
    "able again with its way free and its time come, it departs": (
        replace(READY, place=BEFORE_A_CLIMB, unable=TOO_STEEP),
        Looked(),
        AT_A,
        replace(READY, phase=DutyPhase.RUNNING),
        (Write(notes.AbleToLeave(station="A")), Write(notes.Departs(station="A")), DrivingOrder.DEPART),
    ),
    "ready in all but what its way asks of it, it does not depart": (
        replace(READY, may_leave=False),
        TimerDue(LEAVE),
        BEFORE_A_CLIMB,
        replace(READY, place=BEFORE_A_CLIMB, unable=TOO_STEEP),
        (SAYS_UNABLE, LOOKS_AGAIN),
    ),
    "its pantograph stays up until its way is free: it asks for its route meanwhile": changed(
        STANDING,
        TimerDue(ASK),
        AT_A_CHARGER,
        (Renew(RequestKind.ROUTE), *sent(ROUTE_OPEN)),
        may_ask=True,
        authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)),
    ),
    "with its way free and its time come, its pantograph is to come down first": (
        replace(READY, may_leave=False),
        TimerDue(LEAVE),
        AT_A_CHARGER,
        replace(READY, place=AT_A_CHARGER, unable=CHARGES),
        (LOOKS_AGAIN,),
    ),
    "its pantograph is down, and it departs": (
        replace(READY, place=AT_A_CHARGER, unable=CHARGES),
        Looked(),
        AT_A,
        replace(READY, phase=DutyPhase.RUNNING),
        (Write(notes.Departs(station="A")), DrivingOrder.DEPART),
    ),
    "unable and without a position, its crew decides": changed(
        replace(UNABLE, may_leave=True),
        PositionLost(),
        moved(AT_A, known=False),
        (RELEASE_LATER, Renew(RequestKind.ROUTE), *sent(ROUTE_OPEN)),
        phase=DutyPhase.ON_SIGHT,
        stands_at=0,
        unable=None,
        authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)),
        released=False,
    ),
}
