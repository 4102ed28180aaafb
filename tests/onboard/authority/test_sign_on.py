"""Rows of the table of signing on and off: next state and actions."""

from typing import Final

import pytest
from msgspec.structs import replace

from onboard import notes
from onboard.authority import sign_on
from onboard.authority.machine import step
from onboard.authority.records import (
    Action,
    Authority,
    BeginOnLine,
    Commit,
    EarlierBootCalled,
    EndOnLine,
    OpenCommand,
    OpenRequest,
    QueryHeard,
    RefusalHeard,
    Renew,
    RequestKind,
    SendClaim,
    SendCommand,
    SendRequest,
    SetTimer,
    SignOffHeard,
    SignOnHeard,
    StopTimer,
    Take,
    TakenOff,
    Timer,
    TurnedBack,
    Write,
)
from onboard.authority.tables import REFUSED_REPEAT_S, REPEAT_S, SignOnStanding, standing
from tests.onboard.duty.stage import P5, AuthorityCase, became, holds

SIGN_ON, SIGN_OFF, REPORT = Timer("sign on"), Timer("sign off"), Timer("report")

OFF: Final = Authority()
BOOTED: Final = Authority(unsure=True)
ON_LINE: Final = Authority(held=("PE",), on_line=True)
HOLDING: Final = Authority(held=("3", "5", "6"), commandable=("5",), on_line=True)
ASKED: Final = OpenRequest(RequestKind.ROUTE, "3>8", ("5", "6"), sent=True)
CLAIMING: Final = OpenRequest(RequestKind.SIGN_ON, section_ids=("3",), sent=True)
SIGNING_ON: Final = Authority(held=("3",), requests=(CLAIMING,))
WISHING: Final = Authority(entering=True, requests=(replace(CLAIMING, section_ids=("PW",)),))
IGNORANT: Final = Authority(requests=(replace(CLAIMING, section_ids=None),))
LEAVING: Final = OpenRequest(RequestKind.SIGN_OFF, sent=True)
SIGNED_OFF: Final = Authority(held=("PE",), leaving=True)
SIGNING_OFF: Final = replace(ON_LINE, requests=(LEAVING,))


GIVING_BACK: Final = OpenRequest(RequestKind.REPORT, sent=True)  # all that is not said


def claimed(*section_ids: str) -> Write:
    return Write(notes.Claimed(section_ids=section_ids, token=0))


def said(request: OpenRequest) -> tuple[Action, ...]:
    return SendRequest(replace(request, sent=False)), SetTimer(request.timer, REPEAT_S)


REPORTED: Final[tuple[Action, ...]] = (
    Renew(RequestKind.REPORT),
    *said(replace(GIVING_BACK, section_ids=HOLDING.held)),
    Write(notes.Reported(section_ids=HOLDING.held, token=0)),
)
CASES: Final[dict[str, AuthorityCase]] = {
    "a train that stands somewhere counts that as held and says so": (
        OFF,
        BeginOnLine(("3",)),
        SIGNING_ON,
        (Renew(RequestKind.SIGN_ON), holds("3"), *said(CLAIMING)),
    ),
    "who waits to enter wishes, and holds nothing": (
        OFF,
        BeginOnLine(("PW",), enters=True),
        WISHING,
        (Renew(RequestKind.SIGN_ON), holds(), *said(WISHING.requests[0])),
    ),
    "who was switched on does not know": (
        OFF,
        BeginOnLine(None),
        IGNORANT,
        (Renew(RequestKind.SIGN_ON), *said(IGNORANT.requests[0])),
    ),
    "a sign-on begun anew takes the place of the one open": (
        WISHING,
        BeginOnLine(("3",)),
        SIGNING_ON,
        (Renew(RequestKind.SIGN_ON), holds("3"), *said(CLAIMING)),
    ),
    **{
        what: (
            IGNORANT,
            SignOnHeard(("3", "5", "6"), ("5",), answers=True, newer=True, on_sight=on_sight),
            replace(HOLDING, unswept=on_sight),
            (
                StopTimer(SIGN_ON),
                Take(("3", "5", "6")),
                Write(notes.SignedOn(section_ids=("3", "5", "6"))),
                holds("3", "5", "6"),
            ),
        )
        for what, on_sight in (
            ("accepted, it holds what the manager says", ()),
            ("accepted, it learns what must be swept", ("5", "6")),
        )
    },
    "accepted, the wish is a fact": (
        WISHING,
        SignOnHeard(("PW",), (), answers=True, newer=True),
        Authority(held=("PW",), on_line=True),
        (StopTimer(SIGN_ON), Take(("PW",)), Write(notes.SignedOn(section_ids=("PW",))), holds("PW")),
    ),
    "an acceptance of another sign-on is none": became(
        SIGNING_ON, SignOnHeard(("3", "5"), ("5",), answers=False, newer=True)
    ),
    "an answer to a claim brings a newer token and capabilities, never sections": (
        replace(HOLDING, commandable=()),
        SignOnHeard(("3", "5", "6", "7"), ("5", "7"), answers=False, newer=True),
        replace(HOLDING, requests=(GIVING_BACK,)),
        (Take(()), *REPORTED),
    ),
    "with a newer token what is open is asked anew": became(
        replace(HOLDING, requests=(ASKED,)),
        SignOnHeard(("3", "5", "6"), ("5",), answers=False, newer=True),
        (Take(()), Renew(RequestKind.ROUTE), *said(ASKED)),
    ),
    "and points, which may have been another's, are not proven any more": (
        replace(HOLDING, proven=(P5,), unsaid=(P5,)),
        SignOnHeard(("3", "5", "6"), ("5",), answers=False, newer=True),
        HOLDING,
        (Take(()),),
    ),
    "points under way are commanded anew under it": became(
        replace(HOLDING, commands=(OpenCommand(P5, sent=True),)),
        SignOnHeard(("3", "5", "6"), ("5",), answers=False, newer=True),
        (Take(()), Commit(P5), SendCommand(P5), SetTimer(Timer("points", "P5"), REPEAT_S)),
    ),
    "without a capability they are not commanded any more": (
        replace(HOLDING, commands=(OpenCommand(P5, sent=True),)),
        SignOnHeard(("3", "5", "6"), (), answers=False, newer=True),
        replace(HOLDING, commandable=()),
        (Take(()), StopTimer(Timer("points", "P5"))),
    ),
    "an answer to a claim that is not newer says nothing": became(
        HOLDING, SignOnHeard(("3", "5", "6"), (), answers=False, newer=False)
    ),
    "an answer to a claim says what of it must be swept, and no more": became(
        replace(HOLDING, unswept=("3",)),
        SignOnHeard(("3", "5", "6", "7"), (), answers=False, newer=False, on_sight=("6", "7")),
        REPORTED,
        unswept=("6",),
        requests=(GIVING_BACK,),
    ),
    "an answer to a claim that has more says nothing while a route is asked for": became(
        replace(HOLDING, requests=(ASKED,)), SignOnHeard(("3", "5", "6", "7"), (), answers=False, newer=False)
    ),
    "but gives back what is not the whole of that route": (
        Authority(held=("3",), on_line=True, requests=(ASKED,)),
        SignOnHeard(("3", "5"), (), answers=False, newer=False),
        Authority(held=("3",), on_line=True, requests=(ASKED, GIVING_BACK)),
        (
            Renew(RequestKind.REPORT),
            *said(replace(GIVING_BACK, section_ids=("3",))),
            Write(notes.Reported(section_ids=("3",), token=0)),
        ),
    ),
    "accepted, an older contradiction is over": (
        replace(SIGNING_ON, mismatch="contested: 3"),
        SignOnHeard(("3",), (), answers=True, newer=True),
        Authority(held=("3",), on_line=True),
        (
            StopTimer(SIGN_ON),
            Write(notes.Agreed()),
            Take(("3",)),
            Write(notes.SignedOn(section_ids=("3",))),
            holds("3"),
        ),
    ),
    "begun anew, what was contested or to be swept is forgotten": (
        Authority(requests=(CLAIMING,), mismatch="contested: 3", unswept=("3",), swept=("5",)),
        BeginOnLine(("3",)),
        SIGNING_ON,
        (Renew(RequestKind.SIGN_ON), holds("3"), *said(CLAIMING)),
    ),
    "signing off, too, a newer token is taken": became(
        SIGNING_OFF,
        SignOnHeard(("PE",), (), answers=False, newer=True),
        (Take(()), Renew(RequestKind.SIGN_OFF), *said(LEAVING)),
    ),
    "refused, it asks again later": became(
        WISHING,
        RefusalHeard(RequestKind.SIGN_ON, "", "held: section PW of V2", lost_sight=False, answers=True),
        (SetTimer(SIGN_ON, REFUSED_REPEAT_S), Write(notes.SignOnDenied(why="held: section PW of V2"))),
        requests=(replace(WISHING.requests[0], refusal="held: section PW of V2"),),
    ),
    "a refusal of an older sign-on is none": became(
        WISHING, RefusalHeard(RequestKind.SIGN_ON, "", "held", lost_sight=False, answers=False)
    ),
    "signing on, a refusal of a route is none": became(
        SIGNING_ON, RefusalHeard(RequestKind.ROUTE, "3>8", "held", lost_sight=False, answers=True)
    ),
    "it signs off with its last section": (
        ON_LINE,
        EndOnLine(),
        SIGNING_OFF,
        (Renew(RequestKind.SIGN_OFF), *said(LEAVING)),
    ),
    "it does not sign off with more": (HOLDING, EndOnLine(), HOLDING, ()),
    "a sign-off refused is said again later": became(
        SIGNING_OFF,
        RefusalHeard(RequestKind.SIGN_OFF, "", "UNDEFINED", lost_sight=False, answers=True),
        (SetTimer(SIGN_OFF, REFUSED_REPEAT_S), Write(notes.SignOffDenied(why="UNDEFINED"))),
        requests=(replace(LEAVING, refusal="UNDEFINED"),),
    ),
    "a manager that lost sight of who signs off gets a report first": became(
        SIGNING_OFF,
        RefusalHeard(RequestKind.SIGN_OFF, "", "STALE_TOKEN", lost_sight=True, answers=True),
        (
            SetTimer(SIGN_OFF, REFUSED_REPEAT_S),
            Renew(RequestKind.REPORT),
            Write(notes.SignOffDenied(why="STALE_TOKEN")),
            SendRequest(OpenRequest(RequestKind.REPORT, section_ids=("PE",))),
            SetTimer(REPORT, REPEAT_S),
            Write(notes.Reported(section_ids=("PE",), token=0)),
        ),
        requests=(replace(LEAVING, refusal="STALE_TOKEN"), OpenRequest(RequestKind.REPORT, sent=True)),
    ),
    "a refusal of another sign-off is none": became(
        SIGNING_OFF, RefusalHeard(RequestKind.SIGN_OFF, "", "STALE_TOKEN", lost_sight=True, answers=False)
    ),
    "signed off it holds its portal": (
        SIGNING_OFF,
        SignOffHeard(answers=True),
        SIGNED_OFF,
        (StopTimer(SIGN_OFF), Write(notes.SignedOff())),
    ),
    "asked while its train may still stand there, it claims it": became(
        SIGNED_OFF, QueryHeard(), (SendClaim(("PE",), leaving=True), claimed("PE"))
    ),
    "off the line it holds nothing": (SIGNED_OFF, TakenOff(), OFF, (holds(),)),
    "booted off the line, it is told so": (replace(OFF, unsure=True), TakenOff(), OFF, (holds(),)),
    "which says nothing new to one that was never on it": (OFF, TakenOff(), OFF, ()),
    "signed off it asks for nothing any more": (
        replace(SIGNING_OFF, requests=(ASKED, LEAVING), commands=(OpenCommand(P5, sent=True),), proven=(P5,)),
        SignOffHeard(answers=True),
        SIGNED_OFF,
        (
            StopTimer(Timer("route")),
            StopTimer(SIGN_OFF),
            StopTimer(Timer("points", "P5")),
            Write(notes.SignedOff()),
        ),
    ),
    "an acceptance of another sign-off is none": (SIGNING_OFF, SignOffHeard(answers=False), SIGNING_OFF, ()),
    "asked off the line, it claims nothing": (OFF, QueryHeard(), OFF, (SendClaim(()), claimed())),
    "spoken to as an earlier boot off the line, it says that it holds nothing": became(
        OFF, EarlierBootCalled(), (SendClaim(()), claimed())
    ),
    "but not before it has been told that it is off the line": (BOOTED, EarlierBootCalled(), BOOTED, ()),
    "asked after a boot, before its crew has entered a train number, it does not know": became(
        BOOTED, QueryHeard(), (SendClaim(None),)
    ),
    "asked while it waits to enter, it claims nothing": became(
        WISHING, QueryHeard(), (SendClaim(()), claimed())
    ),
    "asked while it signs on, it claims where it stands": became(
        SIGNING_ON, QueryHeard(), (SendClaim(("3",)), claimed("3"))
    ),
    "asked when it does not know, it says so": (IGNORANT, QueryHeard(), IGNORANT, (SendClaim(None),)),
    "asked on the line, it claims all that it holds": became(
        HOLDING, QueryHeard(), (SendClaim(("3", "5", "6")), claimed("3", "5", "6"))
    ),
    "asked while it signs off, it claims its portal": became(
        SIGNING_OFF, QueryHeard(), (SendClaim(("PE",)), claimed("PE"))
    ),
    "turned back off the line": (OFF, TurnedBack(), OFF, ()),
    "turned back while signing on": (SIGNING_ON, TurnedBack(), SIGNING_ON, ()),
    "turned back, the last is first and proofs are forgotten": (
        replace(HOLDING, commands=(OpenCommand(P5, sent=True),), proven=(P5,), unsaid=(P5,)),
        TurnedBack(),
        replace(HOLDING, held=("6", "5", "3")),
        (StopTimer(Timer("points", "P5")), holds("6", "5", "3")),
    ),
    "turned back while it leaves": (SIGNED_OFF, TurnedBack(), SIGNED_OFF, ()),
    "turned back while signing off": (SIGNING_OFF, TurnedBack(), SIGNING_OFF, ()),
}


@pytest.mark.parametrize("name", CASES)
def test_row(name: str) -> None:
    state, event, after, actions = CASES[name]
    assert step(state, event, covered=True) == (after, actions)


def test_every_row_has_a_case() -> None:
    """With the rows that it shares with `agreement`: answers to a claim, and refusals of a sign-on and a sign-off."""
    cases = {(standing(state), type(event)) for state, event, _, _ in CASES.values()}
    shared = {
        (SignOnStanding.ON_LINE, SignOnHeard),
        (SignOnStanding.SIGNING_OFF, SignOnHeard),
        (SignOnStanding.SIGNING_ON, RefusalHeard),
        (SignOnStanding.SIGNING_OFF, RefusalHeard),
    }
    assert cases == {*sign_on.TABLE, *shared}
