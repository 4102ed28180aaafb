"""Rows of the table of reports: next state and actions."""

from typing import Final

import pytest
from msgspec.structs import replace

from onboard import notes
from onboard.authority import report
from onboard.authority.machine import step
from onboard.authority.records import (
    Action,
    Authority,
    Cleared,
    ConfirmationHeard,
    OpenCommand,
    OpenRequest,
    Renew,
    RepeatDue,
    RequestKind,
    SendRequest,
    SetTimer,
    StopTimer,
    Take,
    Timer,
    Write,
)
from onboard.authority.tables import REFUSED_REPEAT_S, REPEAT_S, standing
from tests.onboard.duty.stage import P5, P7, AuthorityCase, became

REPORT: Final = Timer("report")
OPEN: Final = OpenRequest(RequestKind.REPORT, sent=True)
ASKED: Final = OpenRequest(RequestKind.ROUTE, "8>PE", ("10", "11", "PE"), sent=True)
LEAVING: Final = OpenRequest(RequestKind.SIGN_OFF, sent=True)

HOLDING: Final = Authority(held=("3", "5", "6", "7", "8"), commandable=("5", "7"), on_line=True)
REPORTING: Final = Authority(
    held=("6", "7", "8"), commandable=("7",), on_line=True, requests=(ASKED, OPEN), proven=(P7,)
)
SIGNING_OFF: Final = Authority(held=("PE",), on_line=True, requests=(LEAVING, OPEN))


def reported(*section_ids: str) -> tuple[Action, ...]:
    return (
        SendRequest(OpenRequest(RequestKind.REPORT, section_ids=section_ids)),
        SetTimer(REPORT, REPEAT_S),
        Write(notes.Reported(section_ids=section_ids, token=0)),
    )


LESS, CONTESTED = "the register has less", "contested: 6, 7"

CASES: Final[dict[str, AuthorityCase]] = {
    "dropped here, with proofs and commands, before it is said": (
        replace(HOLDING, commands=(OpenCommand(P5, sent=True),), proven=(P7,), unsaid=(P5,)),
        Cleared(("3", "5")),
        replace(HOLDING, held=("6", "7", "8"), commandable=("7",), proven=(P7,), requests=(OPEN,)),
        (
            StopTimer(Timer("points", "P5")),
            Renew(RequestKind.REPORT),
            Write(notes.Holds(section_ids=("6", "7", "8"), token=0)),
            *reported("6", "7", "8"),
        ),
    ),
    "what is not held cannot be dropped": (HOLDING, Cleared(("99",)), HOLDING, ()),
    "more dropped while a report is open: it becomes a new one": became(
        REPORTING,
        Cleared(("6",)),
        (Renew(RequestKind.REPORT), Write(notes.Holds(section_ids=("7", "8"), token=0)), *reported("7", "8")),
        held=("7", "8"),
    ),
    "done when the register has the same, in whatever order": became(
        REPORTING,
        ConfirmationHeard(("8", "7", "6"), answers=True, newer=False),
        (StopTimer(REPORT),),
        requests=(ASKED,),
    ),
    "while the register has more, the report stays open": became(
        REPORTING, ConfirmationHeard(("5", "6", "7", "8"), answers=True, newer=False)
    ),
    "refused for its token, it is said again under the newer one, and no section is added": became(
        REPORTING,
        ConfirmationHeard(("5", "6", "7", "8"), answers=True, newer=True),
        (
            Take(()),
            Renew(RequestKind.ROUTE),
            SendRequest(replace(ASKED, sent=False)),
            SetTimer(Timer("route"), REPEAT_S),
            *reported("6", "7", "8"),
        ),
    ),
    "confirmed under a newer token, that is taken": became(
        REPORTING,
        ConfirmationHeard(("6", "7", "8"), answers=True, newer=True),
        (
            StopTimer(REPORT),
            Take(()),
            Renew(RequestKind.ROUTE),
            SendRequest(replace(ASKED, sent=False)),
            SetTimer(Timer("route"), REPEAT_S),
        ),
        requests=(ASKED,),
    ),
    "what is left that had to be swept was swept, and the report says so": became(
        replace(HOLDING, unswept=("3", "6")),
        Cleared(("3", "5")),
        (
            Renew(RequestKind.REPORT),
            Write(notes.Holds(section_ids=("6", "7", "8"), token=0)),
            SendRequest(OpenRequest(RequestKind.REPORT, section_ids=("6", "7", "8"), swept=("3",))),
            *reported("6", "7", "8")[1:],
        ),
        held=("6", "7", "8"),
        commandable=("7",),
        requests=(OPEN,),
        unswept=("6",),
        swept=("3",),
    ),
    "what was swept and never held is not said": became(replace(HOLDING, unswept=("99",)), Cleared(("99",))),
    "confirmed, what was swept is said no more": (
        replace(REPORTING, swept=("5",)),
        ConfirmationHeard(("6", "7", "8"), answers=True, newer=False),
        replace(REPORTING, requests=(ASKED,)),
        (StopTimer(REPORT),),
    ),
    "confirmed with more, what was swept stays to be said": became(
        replace(REPORTING, swept=("5",)), ConfirmationHeard(("5", "6", "7", "8"), answers=True, newer=False)
    ),
    "confirmed with less, the train is stopped, and it is reported again": became(
        REPORTING,
        ConfirmationHeard(("6", "7"), answers=True, newer=False),
        (Write(notes.Mismatch(why=LESS)), SetTimer(REPORT, REFUSED_REPEAT_S)),
        requests=(ASKED, replace(OPEN, refusal=LESS)),
        mismatch=LESS,
    ),
    "confirmed with less for the second time, nothing new is written": became(
        replace(REPORTING, mismatch=LESS),
        ConfirmationHeard(("6", "7"), answers=True, newer=False),
        (SetTimer(REPORT, REFUSED_REPEAT_S),),
        requests=(ASKED, replace(OPEN, refusal=LESS)),
    ),
    "confirmed and contested, the train is stopped, and it is reported again": became(
        REPORTING,
        ConfirmationHeard(("6", "7", "8"), answers=True, newer=False, contested=("6", "7")),
        (Write(notes.Mismatch(why=CONTESTED)), SetTimer(REPORT, REFUSED_REPEAT_S)),
        requests=(ASKED, replace(OPEN, refusal=CONTESTED)),
        mismatch=CONTESTED,
    ),
    "contested under a newer token, that is taken all the same": became(
        REPORTING,
        ConfirmationHeard(("6", "7", "8"), answers=True, newer=True, contested=("6", "7")),
        (
            Write(notes.Mismatch(why=CONTESTED)),
            SetTimer(REPORT, REFUSED_REPEAT_S),
            Take(()),
            Renew(RequestKind.ROUTE),
            SendRequest(replace(ASKED, sent=False)),
            SetTimer(Timer("route"), REPEAT_S),
        ),
        requests=(ASKED, replace(OPEN, refusal=CONTESTED)),
        mismatch=CONTESTED,
    ),
    "agreement restored: the same is held, with nothing contested": (
        replace(REPORTING, requests=(ASKED, replace(OPEN, refusal=CONTESTED)), mismatch=CONTESTED),
        ConfirmationHeard(("6", "7", "8"), answers=True, newer=False),
        replace(REPORTING, requests=(ASKED,)),
        (StopTimer(REPORT), Write(notes.Agreed())),
    ),
    "more in the register restores no agreement: it is reported until that has the same": became(
        replace(REPORTING, mismatch=CONTESTED),
        ConfirmationHeard(("5", "6", "7", "8"), answers=True, newer=False),
    ),
    "signing off, too, it is stopped while its portal is contested": became(
        SIGNING_OFF,
        ConfirmationHeard(("PE",), answers=True, newer=False, contested=("PE",)),
        (Write(notes.Mismatch(why="contested: PE")), SetTimer(REPORT, REFUSED_REPEAT_S)),
        requests=(LEAVING, replace(OPEN, refusal="contested: PE")),
        mismatch="contested: PE",
    ),
    "a confirmation of an older report is none": became(
        REPORTING, ConfirmationHeard(("6", "7", "8"), answers=False, newer=True)
    ),
    "a confirmation without a report is none": became(
        HOLDING, ConfirmationHeard(("3",), answers=True, newer=True)
    ),
    "signing off, too, a report is confirmed": became(
        SIGNING_OFF,
        ConfirmationHeard(("PE",), answers=True, newer=False),
        (StopTimer(REPORT),),
        requests=(LEAVING,),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_row(name: str) -> None:
    state, event, after, actions = CASES[name]
    assert step(state, event, covered=True) == (after, actions)


def test_every_row_has_a_case() -> None:
    assert {(standing(state), type(event)) for state, event, _, _ in CASES.values()} == set(report.TABLE)


def test_a_lost_report_heals_with_the_next_one_which_says_what_is_held_then() -> None:
    more, _ = step(REPORTING, Cleared(("6",)), covered=False)  # lost: the radio does not reach
    _, actions = step(more, RepeatDue(None), covered=True)
    assert actions[-3:] == reported("7", "8")
