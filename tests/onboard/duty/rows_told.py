"""Rows of the table of the duty for what timers and telegrams tell: state, event, place; next state and actions."""

from typing import Final

from msgspec.structs import replace

from network.model import Position
from onboard import notes
from onboard.authority.records import (
    Action,
    Commit,
    ConfirmationHeard,
    ContestHeard,
    GrantHeard,
    OpenCommand,
    OpenRequest,
    ProofHeard,
    QueryHeard,
    RefusalHeard,
    Renew,
    RequestKind,
    SendClaim,
    SetTimer,
    SignOffHeard,
    SignOnHeard,
    StopTimer,
    Take,
    Timer,
    Write,
)
from onboard.authority.tables import REFUSED_REPEAT_S
from onboard.duty.records import (
    ASK,
    LEAVE,
    RELEASE,
    DrivingOrder,
    DutyPhase,
    DutyState,
    EntryAllowed,
    LeftLine,
    PlaceInJoints,
    StopLimit,
    TelegramHeard,
    TimerDue,
)
from tests.onboard.duty.stage import (
    AT_A,
    AT_B,
    BEFORE_7,
    HOLDS_3,
    HOLDS_ALL,
    HOLDS_REST,
    LEAVING,
    ON_6,
    ON_THE_LINE,
    P5,
    P7,
    RELEASE_LATER,
    REPORT_OPEN,
    ROUTE_OPEN,
    RUNNING,
    SECTIONS,
    SIGNING_OFF,
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

LESS, CONTESTED = "the register has less", "contested: 7"


def halted(state: DutyState, why: str = CONTESTED, report: OpenRequest = REPORT_OPEN) -> DutyState:
    """The state with a contradiction that is being reported, and braked."""
    authority = replace(state.authority, mismatch=why, requests=(*state.authority.requests, report))
    return replace(state, place=moved(state.place, emergency=True), authority=authority, halted=True)


def disagreed(*held: str, why: str = CONTESTED) -> tuple[Action, ...]:
    return Renew(RequestKind.REPORT), Write(notes.Mismatch(why=why)), *reported(*(held or HOLDS_REST.held))


TOLD: Final[dict[str, Case]] = {
    "a route may be asked for": changed(
        STANDING,
        TimerDue(ASK),
        AT_A,
        (Renew(RequestKind.ROUTE), *sent(ROUTE_OPEN)),
        may_ask=True,
        authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)),
    ),
    "the time has come, but not the way": changed(STANDING, TimerDue(LEAVE), AT_A, may_leave=True),
    "the time has come and the way is free": (
        replace(STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7),
        TimerDue(LEAVE),
        AT_A,
        DutyState(DutyPhase.RUNNING, AT_A, replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7, may_leave=True),
        (Write(notes.Departs(station="A")), DrivingOrder.DEPART),
    ),
    **{
        f"the driver acknowledges an emergency stop: {at.value}": (
            replace(STATES[at], released=False),
            TimerDue(RELEASE),
            moved(STATES[at].place, emergency=True),
            STATES[at],
            (Write(notes.EmergencyReleased()), DrivingOrder.RELEASE),
        )
        for at in ON_THE_LINE
    },
    **{
        f"an emergency stop is not acknowledged while the vehicle is not in order: {at.value}": changed(
            replace(STATES[at], released=False),
            TimerDue(RELEASE),
            moved(STATES[at].place, emergency=True, unfit="brake not in order"),
            (RELEASE_LATER,),
        )
        for at in ON_THE_LINE
    },
    "ready in all but its driver's word that it is at its mark, it does not depart": changed(
        replace(STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7),
        TimerDue(LEAVE),
        moved(AT_A, unsure=True),
        may_leave=True,
    ),
    "ready in all but its vehicle, it does not depart": changed(
        replace(STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7),
        TimerDue(LEAVE),
        moved(AT_A, unfit="doors not closed"),
        may_leave=True,
    ),
    **{
        f"not before register and unit agree: {at.value}": changed(
            halted(STATES[at]),
            TimerDue(RELEASE),
            halted(STATES[at]).place,
            (RELEASE_LATER,),
            released=False,
            listens=at is DutyPhase.ON_SIGHT,
        )
        for at in (DutyPhase.STANDING, DutyPhase.RUNNING, DutyPhase.ON_SIGHT)
    },
    "the time has come and the way is free, but not while register and unit contradict each other": (
        halted(replace(STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7)),
        TimerDue(LEAVE),
        halted(STANDING).place,
        halted(replace(STANDING, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7, may_leave=True)),
        (),
    ),
    "contested, a train that runs is braked at once": (
        RUNNING,
        TelegramHeard(ContestHeard(("7",))),
        ON_6,
        halted(RUNNING),
        (*disagreed(), DrivingOrder.STOP),
    ),
    "contested, a train that stands is held by its emergency brake": (
        STANDING,
        TelegramHeard(ContestHeard(("7",))),
        AT_A,
        replace(halted(STANDING), released=False),
        (*disagreed("3"), DrivingOrder.STOP, RELEASE_LATER),
    ),
    "contested, what tags prove to be behind is given back: it may be all that is contested": (
        replace(RUNNING, proved=2, authority=replace(HOLDS_REST, held=("5", *HOLDS_REST.held))),
        TelegramHeard(ContestHeard(("5",))),
        ON_6,
        replace(halted(RUNNING, "contested: 5"), proved=2, freed=2),
        (
            *disagreed("5", *HOLDS_REST.held, why="contested: 5"),
            DrivingOrder.STOP,
            Renew(RequestKind.REPORT),
            holds(*HOLDS_REST.held),
            *reported(*HOLDS_REST.held),
        ),
    ),
    "standing before points not proven it throws none while it is halted": changed(
        halted(replace(RUNNING, authority=replace(HOLDS_REST, held=("5", *HOLDS_REST.held)))),
        TelegramHeard(ContestHeard(("7",))),
        moved(ON_6, stands=True, emergency=True),
    ),
    "contested twice, it is braked once": changed(
        halted(RUNNING), TelegramHeard(ContestHeard(("7",))), halted(RUNNING).place
    ),
    "its claim refused, the train is braked": (
        RUNNING,
        TelegramHeard(RefusalHeard(RequestKind.SIGN_ON, "", "held", lost_sight=False, answers=False)),
        ON_6,
        halted(RUNNING, "claim refused: held"),
        (*disagreed(why="claim refused: held"), DrivingOrder.STOP),
    ),
    "confirmed with less, the train is braked": (
        replace(RUNNING, authority=replace(HOLDS_REST, requests=(REPORT_OPEN,))),
        TelegramHeard(ConfirmationHeard(("6", "7"), answers=True, newer=False)),
        ON_6,
        halted(RUNNING, LESS, replace(REPORT_OPEN, refusal=LESS)),
        (Write(notes.Mismatch(why=LESS)), SetTimer(Timer("report"), REFUSED_REPEAT_S), DrivingOrder.STOP),
    ),
    "confirmed and contested, the train is braked": (
        replace(RUNNING, authority=replace(HOLDS_REST, requests=(REPORT_OPEN,))),
        TelegramHeard(ConfirmationHeard(("6", "7", "8"), answers=True, newer=False, contested=("7",))),
        ON_6,
        halted(RUNNING, CONTESTED, replace(REPORT_OPEN, refusal=CONTESTED)),
        (
            Write(notes.Mismatch(why=CONTESTED)),
            SetTimer(Timer("report"), REFUSED_REPEAT_S),
            DrivingOrder.STOP,
        ),
    ),
    "agreement restored: it goes on when the driver has acknowledged the stop": (
        replace(
            halted(replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), limit=TO_THE_END)),
            released=False,
        ),
        TelegramHeard(ConfirmationHeard(HOLDS_REST.held, answers=True, newer=False)),
        moved(ON_6, stands=True, emergency=True),
        replace(
            RUNNING,
            place=moved(ON_6, stands=True, emergency=True),
            authority=replace(HOLDS_REST, proven=(P7,)),
            limit=TO_THE_END,
            released=False,
        ),
        (StopTimer(Timer("report")), Write(notes.Agreed())),
    ),
    "agreement restored at a stop, and its time has come: it leaves": (
        halted(replace(STANDING, may_leave=True, authority=replace(HOLDS_ALL, proven=(P5,)), limit=BEFORE_7)),
        TelegramHeard(ConfirmationHeard(HOLDS_ALL.held, answers=True, newer=False)),
        halted(STANDING).place,
        DutyState(
            DutyPhase.RUNNING,
            halted(STANDING).place,
            replace(HOLDS_ALL, proven=(P5,)),
            limit=BEFORE_7,
            may_leave=True,
        ),
        (
            StopTimer(Timer("report")),
            Write(notes.Agreed()),
            Write(notes.Departs(station="A")),
            DrivingOrder.DEPART,
        ),
    ),
    "granted, the departure points are thrown": changed(
        replace(STANDING, may_ask=True, authority=replace(HOLDS_3, requests=(ROUTE_OPEN,))),
        TelegramHeard(GrantHeard("3>8", SECTIONS, ("5", "7"), answers=True, fresh=True, newer=True)),
        AT_A,
        (
            StopTimer(Timer("route")),
            Take(SECTIONS),
            Write(notes.RouteHeld(route_id="3>8", token=0)),
            holds("3", *SECTIONS),
            Commit(P5),
            *commanded(P5),
            limit(1, "5", "points not proven"),
        ),
        authority=replace(HOLDS_ALL, commands=(OpenCommand(P5, sent=True),)),
        wanted=(P5,),
        limit=StopLimit(1, "5", "points not proven"),
    ),
    "signed on, who waits outside may enter": (
        SIGNING_ON,
        TelegramHeard(SignOnHeard(("3",), (), answers=True, newer=True)),
        AT_A,
        STANDING,
        (
            StopTimer(Timer("sign on")),
            Take(("3",)),
            Write(notes.SignedOn(section_ids=("3",))),
            holds("3"),
            EntryAllowed("T1"),
        ),
    ),
    "signed on without a position: on sight, where it stands": (
        replace(SIGNING_ON, place=PlaceInJoints()),
        TelegramHeard(SignOnHeard(("3",), (), answers=True, newer=True)),
        PlaceInJoints(),
        replace(
            STANDING,
            phase=DutyPhase.ON_SIGHT,
            place=PlaceInJoints(),
            authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)),
            stands_at=0,
        ),
        (
            StopTimer(Timer("sign on")),
            Take(("3",)),
            Write(notes.SignedOn(section_ids=("3",))),
            holds("3"),
            EntryAllowed("T1"),
            Renew(RequestKind.ROUTE),
            *sent(ROUTE_OPEN),
        ),
    ),
    "signed off, the train may be taken off the line": (
        SIGNING_OFF,
        TelegramHeard(SignOffHeard(answers=True)),
        AT_B,
        LEAVING,
        (StopTimer(Timer("sign off")), Write(notes.SignedOff()), LeftLine("T1")),
    ),
    "leaving, it says that it holds its portal": changed(
        LEAVING,
        TelegramHeard(QueryHeard()),
        AT_B,
        (SendClaim(("8",), leaving=True), Write(notes.Claimed(section_ids=("8",), token=0))),
    ),
    "proven, the stop limit moves on": changed(
        replace(RUNNING, authority=replace(HOLDS_REST, commands=(OpenCommand(P7, sent=True),)), wanted=(P7,)),
        TelegramHeard(ProofHeard("P7", "B-W", "normal", mine=True)),
        ON_6,
        (
            StopTimer(Timer("points", "P7")),
            Write(notes.Proven(points_id="P7", position=Position.NORMAL, token=0)),
            limit(5, None, "end of the path"),
        ),
        authority=replace(HOLDS_REST, proven=(P7,)),
        limit=TO_THE_END,
    ),
    "a proof withdrawn draws the limit back, and the points are commanded anew": (
        replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), wanted=(P7,), limit=TO_THE_END),
        TelegramHeard(ProofHeard("P7", "B-W", None, mine=True)),
        ON_6,
        replace(
            RUNNING,
            authority=replace(HOLDS_REST, commands=(OpenCommand(P7, sent=True),), unsaid=(P7,)),
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
        replace(RUNNING, authority=replace(HOLDS_REST, proven=(P7,)), wanted=(P7,), limit=TO_THE_END),
        TelegramHeard(ProofHeard("P7", "B-W", None, mine=True)),
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
        f"a query is answered: {at.value}": changed(
            STATES[at],
            TelegramHeard(QueryHeard()),
            STATES[at].place,
            (
                SendClaim(STATES[at].authority.held, leaving=at is DutyPhase.LEAVING),
                Write(notes.Claimed(section_ids=STATES[at].authority.held, token=0)),
            ),
        )
        for at in DutyPhase
    },
}
