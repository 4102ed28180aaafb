"""Rows of the table of the duty for what the dispatcher orders: state, event, place; next state and actions."""

from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import (
    Action,
    GrantHeard,
    Renew,
    RequestKind,
    SendRefusal,
    SetTimer,
    StopTimer,
    TakeBackOrdered,
    TrackChangeOrdered,
    TrainEndOrdered,
    Write,
)
from onboard.duty.records import (
    ASK,
    DutyPhase,
    NoSuchWay,
    StopLimit,
    TakeUpWay,
    TelegramHeard,
    TrainEndsHere,
    WayOrdered,
)
from radio.messages import OrderRefusalReason
from tests.onboard.duty.stage import (
    AT_A,
    BEFORE_7,
    HOLDS_3,
    HOLDS_ALL,
    ON_THE_LINE,
    P5,
    PLAN,
    REPORT_OPEN,
    ROUTE_OPEN,
    SECTIONS,
    STANDING,
    STATES,
    Case,
    changed,
    holds,
    limit,
    moved,
    reported,
    sent,
)

ASKS: Final = replace(STANDING, may_ask=True, authority=replace(HOLDS_3, requests=(ROUTE_OPEN,)))
ENDS: Final = replace(ASKS, next_train="T2")
ORDERED: Final = replace(ASKS, ordered="3>9")
HOLDS_ROUTE: Final = replace(
    STANDING,
    may_ask=True,
    may_leave=True,
    authority=replace(HOLDS_ALL, proven=(P5,)),
    wanted=(P5,),
    limit=BEFORE_7,
)
GRANT: Final = GrantHeard("3>8", SECTIONS, ("5", "7"), answers=True, fresh=True, newer=True)
HAS_A_PART: Final = replace(
    ORDERED,
    authority=replace(
        HOLDS_3, held=("3", "5", "6"), requests=(replace(ROUTE_OPEN, section_ids=("7", "8")),), proven=(P5,)
    ),
    limit=StopLimit(3, "7", "not held"),
)
NOT_READY: Final = moved(AT_A, unfit="doors not closed")


def refused(reason: OrderRefusalReason, route_id: str = "3>8") -> tuple[Action, ...]:
    words = reason.name.lower().replace("_", " ")
    return Write(notes.OrderDenied(route_id=route_id, why=words)), SendRefusal(route_id, reason)


ORDERS: Final[dict[str, Case]] = {
    "another track, to the request outstanding": (
        ASKS,
        TrackChangeOrdered("3>8", "3>9", answers=True),
        AT_A,
        ORDERED,
        (WayOrdered("3>8", "3>9"),),
    ),
    "another track, to a request that was answered before": changed(
        ASKS, TrackChangeOrdered("3>8", "3>9", answers=False), AT_A
    ),
    "another track for a route that is held by now": changed(
        HOLDS_ROUTE, TrackChangeOrdered("3>8", "3>9", answers=True), NOT_READY
    ),
    "a grant of the way that its driver is giving up": (ORDERED, TelegramHeard(GRANT), AT_A, ORDERED, ()),
    "a grant to who is ending its train": (ENDS, TelegramHeard(GRANT), AT_A, ENDS, ()),
    "a second order, before its driver has spoken": changed(
        ORDERED, TrackChangeOrdered("3>8", "3>10", answers=True), AT_A
    ),
    "a route of which it has a part, which its driver is giving up": changed(
        HAS_A_PART,
        TakeBackOrdered("3>8", newest=True, hold_s=30.0),
        AT_A,
        refused(OrderRefusalReason.NOT_HELD),
    ),
    "no other track once the front may have left": changed(
        ASKS,
        TrackChangeOrdered("3>8", "3>9", answers=True),
        moved(AT_A, perhaps=2),
        refused(OrderRefusalReason.MAY_HAVE_ENTERED),
    ),
    "the driver has taken up the way ordered: its old request counts no more": (
        ORDERED,
        TakeUpWay(PLAN),
        AT_A,
        replace(ASKS, authority=replace(HOLDS_3, requests=(REPORT_OPEN, ROUTE_OPEN))),
        (
            Write(notes.WayChanged(route_id="3>8", instead="3>9")),
            StopTimer(ROUTE_OPEN.timer),
            Renew(RequestKind.REPORT),
            *reported("3"),
            Renew(RequestKind.ROUTE),
            *sent(ROUTE_OPEN),
        ),
    ),
    "to end its train here, to the request outstanding": (
        ASKS,
        TrainEndOrdered("3>8", "T2", answers=True),
        AT_A,
        ENDS,
        (TrainEndsHere("T2"),),
    ),
    "to end its train, to a request that was answered before": changed(
        ASKS, TrainEndOrdered("3>8", "T2", answers=False), AT_A
    ),
    "no train is ended that holds its route by now": changed(
        HOLDS_ROUTE, TrainEndOrdered("3>8", "T2", answers=True), NOT_READY
    ),
    "none whose front may have left": changed(
        ASKS,
        TrainEndOrdered("3>8", "T2", answers=True),
        moved(AT_A, perhaps=2),
        refused(OrderRefusalReason.MAY_HAVE_ENTERED),
    ),
    "its set has no such train": (ENDS, NoSuchWay(), AT_A, ASKS, refused(OrderRefusalReason.UNKNOWN_TRAIN)),
    "the train has no such way": (
        ORDERED,
        NoSuchWay(),
        AT_A,
        ASKS,
        refused(OrderRefusalReason.UNKNOWN_TRACK),
    ),
    "a route is taken back from a train that cannot leave": (
        HOLDS_ROUTE,
        TakeBackOrdered("3>8", newest=True, hold_s=30.0),
        NOT_READY,
        replace(
            STANDING, place=NOT_READY, may_leave=True, authority=replace(HOLDS_3, requests=(REPORT_OPEN,))
        ),
        (
            SetTimer(ASK, 30.0),
            Write(notes.GaveBack(section_ids=SECTIONS)),
            Renew(RequestKind.REPORT),
            holds("3"),
            *reported("3"),
            limit(1, "5", "not held"),
        ),
    ),
    "a route granted anew is not taken back by an old order": changed(
        HOLDS_ROUTE,
        TakeBackOrdered("3>8", newest=False, hold_s=30.0),
        NOT_READY,
        refused(OrderRefusalReason.NOT_HELD),
    ),
    "one that it has not is not taken back": changed(
        ASKS, TakeBackOrdered("3>8", newest=True, hold_s=30.0), AT_A, refused(OrderRefusalReason.NOT_HELD)
    ),
    "another's is not taken back": changed(
        HOLDS_ROUTE,
        TakeBackOrdered("3>9", newest=True, hold_s=30.0),
        NOT_READY,
        refused(OrderRefusalReason.NOT_HELD, "3>9"),
    ),
    "none is taken back that the front may have entered": changed(
        replace(HOLDS_ROUTE, may_leave=False),
        TakeBackOrdered("3>8", newest=True, hold_s=30.0),
        moved(AT_A, perhaps=2),
        refused(OrderRefusalReason.MAY_HAVE_ENTERED),
        wanted=(),
    ),
    **{
        f"{what}: {at.value}": changed(
            STATES[at], order, STATES[at].place, refused(OrderRefusalReason.NOT_AT_A_STOP)
        )
        for what, order in (
            ("no other track", TrackChangeOrdered("3>8", "3>9", answers=True)),
            ("it is not ended", TrainEndOrdered("3>8", "T2", answers=True)),
            ("nothing is taken back", TakeBackOrdered("3>8", newest=True, hold_s=30.0)),
        )
        for at in ON_THE_LINE
        if at is not DutyPhase.STANDING
    },
}
