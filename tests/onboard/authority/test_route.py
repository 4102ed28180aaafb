"""Rows of the table of routes: next state and actions."""

from typing import Final

import pytest
from msgspec.structs import replace

from onboard import notes
from onboard.authority import route
from onboard.authority.machine import step
from onboard.authority.records import (
    AskRoute,
    Authority,
    GiveBack,
    GrantHeard,
    OpenRequest,
    RefusalHeard,
    Renew,
    RequestKind,
    SendRequest,
    SetTimer,
    StopTimer,
    Take,
    Timer,
    Write,
)
from onboard.authority.tables import REFUSED_REPEAT_S, REPEAT_S, SignOnStanding, standing
from tests.onboard.authority.test_report import reported
from tests.onboard.duty.stage import P5, SECTIONS, AuthorityCase, became, holds

ROUTE: Final = Timer("route")

ON_LINE: Final = Authority(held=("3",), on_line=True)
OPEN: Final = OpenRequest(RequestKind.ROUTE, "3>8", SECTIONS, sent=True)
ASKING: Final = replace(ON_LINE, requests=(OPEN,))
HOLDING: Final = replace(ON_LINE, held=("3", *SECTIONS), commandable=("5", "7"))
GRANT: Final = GrantHeard("3>8", SECTIONS, ("5", "7"), answers=True, fresh=True, newer=True)
REFUSAL: Final = RefusalHeard(
    RequestKind.ROUTE, "3>8", "held: section 6 of V2", lost_sight=False, answers=True
)
TAKEN: Final = (StopTimer(ROUTE), Take(SECTIONS), Write(notes.RouteHeld(route_id="3>8", token=0)))


def other(grant: GrantHeard, **changes: object) -> GrantHeard:
    return replace(grant, **changes)


CASES: Final[dict[str, AuthorityCase]] = {
    "asked for": (
        ON_LINE,
        AskRoute("3>8", SECTIONS),
        ASKING,
        (Renew(RequestKind.ROUTE), SendRequest(replace(OPEN, sent=False)), SetTimer(ROUTE, REPEAT_S)),
    ),
    "one at a time": (ASKING, AskRoute("3>9", ("5", "6", "7", "9")), ASKING, ()),
    "granted, it is held whole": (ASKING, GRANT, HOLDING, (*TAKEN, holds("3", *SECTIONS))),
    "a grant in answer to another request is none": (ASKING, other(GRANT, answers=False), ASKING, ()),
    "a grant to an earlier boot is none": (ASKING, other(GRANT, fresh=False), ASKING, ()),
    "a grant whose token is not newer is none": (ASKING, other(GRANT, newer=False), ASKING, ()),
    "a grant of another route is none": (ASKING, other(GRANT, route_id="3>9"), ASKING, ()),
    "a grant of other sections is none": (ASKING, other(GRANT, section_ids=("6", "7")), ASKING, ()),
    "of a grant of the beginning the rest is asked for again": (
        ASKING,
        other(GRANT, section_ids=("5", "6"), commandable=("5",)),
        replace(
            HOLDING,
            held=("3", "5", "6"),
            commandable=("5",),
            requests=(replace(OPEN, section_ids=("7", "8"), refusal="the rest is not free"),),
        ),
        (
            *(Renew(RequestKind.ROUTE), SetTimer(ROUTE, REFUSED_REPEAT_S)),
            *(Take(("5", "6")), Write(notes.RouteHeld(route_id="3>8", token=0)), holds("3", "5", "6")),
        ),
    ),
    "a grant without a request is none": (ON_LINE, GRANT, ON_LINE, ()),
    "what is held already is renewed, with its capabilities": (
        replace(HOLDING, requests=(OPEN,)),
        other(GRANT, commandable=("7",)),
        replace(HOLDING, commandable=("7",)),
        (*TAKEN, holds("3", *SECTIONS)),
    ),
    "what the crew saw before does not outlast the grant: another could throw the points": (
        replace(ASKING, proven=(P5,)),
        GRANT,
        HOLDING,
        (*TAKEN, holds("3", *SECTIONS)),
    ),
    "refused, it is asked for again later, as a new request": became(
        ASKING,
        REFUSAL,
        (
            Renew(RequestKind.ROUTE),
            SetTimer(ROUTE, REFUSED_REPEAT_S),
            Write(notes.RouteDenied(route_id="3>8", why=REFUSAL.why)),
        ),
        requests=(replace(OPEN, refusal=REFUSAL.why),),
    ),
    "refused for the same reason, nothing new is written": became(
        replace(ASKING, requests=(replace(OPEN, refusal=REFUSAL.why),)),
        REFUSAL,
        (Renew(RequestKind.ROUTE), SetTimer(ROUTE, REFUSED_REPEAT_S)),
    ),
    "a manager that lost sight of the unit gets a report": became(
        ASKING,
        replace(REFUSAL, why="stale token", lost_sight=True),
        (
            Renew(RequestKind.ROUTE),
            SetTimer(ROUTE, REFUSED_REPEAT_S),
            Write(notes.RouteDenied(route_id="3>8", why="stale token")),
            Renew(RequestKind.REPORT),
            *reported("3"),
        ),
        requests=(replace(OPEN, refusal="stale token"), OpenRequest(RequestKind.REPORT, sent=True)),
    ),
    "a refusal of another request is none": (ASKING, replace(REFUSAL, answers=False), ASKING, ()),
    "a refusal of another route is none": (ASKING, replace(REFUSAL, subject="3>9"), ASKING, ()),
    "a route that must be swept is passed on sight": (
        ASKING,
        other(GRANT, on_sight=("6",)),
        replace(HOLDING, unswept=("6",)),
        (*TAKEN, holds("3", *SECTIONS)),
    ),
    "granted anew after another has swept it, it is as any other": (
        replace(HOLDING, requests=(OPEN,), unswept=("3", "6")),
        other(GRANT, on_sight=()),
        replace(HOLDING, unswept=("3",)),
        (*TAKEN, holds("3", *SECTIONS)),
    ),
    "given back, what is left is reported": (
        replace(HOLDING, proven=(P5,)),
        GiveBack(SECTIONS),
        replace(ON_LINE, requests=(OpenRequest(RequestKind.REPORT, sent=True),)),
        (Renew(RequestKind.REPORT), holds("3"), *reported("3")),
    ),
    "given back while its grant may be on its way: that fits nothing, and the report frees it": (
        ASKING,
        GiveBack(SECTIONS),
        replace(ON_LINE, requests=(OpenRequest(RequestKind.REPORT, sent=True),)),
        (StopTimer(ROUTE), Renew(RequestKind.REPORT), *reported("3")),
    ),
    "nothing to give back": (ON_LINE, GiveBack(SECTIONS), ON_LINE, ()),
}


@pytest.mark.parametrize("name", CASES)
def test_row(name: str) -> None:
    state, event, after, actions = CASES[name]
    assert step(state, event, covered=True) == (after, actions)


def test_every_row_has_a_case() -> None:
    """With the refusal of a route, whose row also takes that of a claim (`agreement`)."""
    cases = {(standing(state), type(event)) for state, event, _, _ in CASES.values()}
    assert cases == {*route.TABLE, (SignOnStanding.ON_LINE, RefusalHeard)}
