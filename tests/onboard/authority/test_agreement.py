"""Rows of the table of agreement: register and unit contradict each other, and what ends that."""

from typing import Final

import pytest
from hypothesis import given
from msgspec.structs import replace

from onboard import notes
from onboard.authority import agreement, report
from onboard.authority.machine import TABLE, step
from onboard.authority.records import (
    Action,
    Authority,
    BeginOnLine,
    ConfirmationHeard,
    ContestHeard,
    FoundAt,
    OpenRequest,
    RefusalHeard,
    Renew,
    RequestKind,
    SendRequest,
    SetTimer,
    SignOffHeard,
    SignOnHeard,
    Take,
    Timer,
    Write,
)
from onboard.authority.tables import REFUSED_REPEAT_S, REPEAT_S, Result, SignOnStanding, Table, standing
from tests.onboard.authority.test_machine import Course, after_all, begun, courses_with_crew
from tests.onboard.duty.stage import AuthorityCase, became

REPORT: Final = Timer("report")
OPEN: Final = OpenRequest(RequestKind.REPORT, sent=True)
LEAVING: Final = OpenRequest(RequestKind.SIGN_OFF, sent=True)
CLAIMING: Final = OpenRequest(RequestKind.SIGN_ON, section_ids=("3",), sent=True)
HOLDING: Final = Authority(held=("3", "5", "6"), commandable=("5",), on_line=True)
SIGNING_ON: Final = Authority(held=("3",), requests=(CLAIMING,))
SIGNING_OFF: Final = Authority(held=("PE",), on_line=True, requests=(LEAVING,))
AT_8: Final = OpenRequest(RequestKind.SIGN_ON, section_ids=("6", "8"), sent=True)
ELSEWHERE: Final = "found in what it does not hold: 8"
DENIED: Final = RefusalHeard(
    RequestKind.SIGN_ON, "", "held: section 5 of V2", lost_sight=False, answers=False
)
LESS, CONTESTED, REFUSED = (
    "the register has less",
    "contested: 5, 6",
    "claim refused: held: section 5 of V2",
)


def stopped(state: Authority, why: str) -> Authority:
    """Of a state without a report: the contradiction is remembered, and reported."""
    return replace(state, mismatch=why, requests=(*state.requests, OPEN))


def said(why: str, *section_ids: str) -> tuple[Action, ...]:
    return (
        Renew(RequestKind.REPORT),
        Write(notes.Mismatch(why=why)),
        SendRequest(OpenRequest(RequestKind.REPORT, section_ids=section_ids)),
        SetTimer(REPORT, REPEAT_S),
        Write(notes.Reported(section_ids=section_ids, token=0)),
    )


CASES: Final[dict[str, AuthorityCase]] = {
    "contested, the train is stopped, and says what it holds": (
        HOLDING,
        ContestHeard(("5", "6")),
        stopped(HOLDING, CONTESTED),
        said(CONTESTED, "3", "5", "6"),
    ),
    "contested again, nothing new is said": became(stopped(HOLDING, CONTESTED), ContestHeard(("5", "6"))),
    "contested while it reports, its report stays open": (
        replace(HOLDING, requests=(OPEN,)),
        ContestHeard(("5", "6")),
        stopped(HOLDING, CONTESTED),
        (Write(notes.Mismatch(why=CONTESTED)),),
    ),
    "contested while it signs on, only remembered: its sign-on is open": became(
        SIGNING_ON, ContestHeard(("5", "6")), (Write(notes.Mismatch(why=CONTESTED)),), mismatch=CONTESTED
    ),
    "contested while it signs off": (
        SIGNING_OFF,
        ContestHeard(("5", "6")),
        stopped(SIGNING_OFF, CONTESTED),
        said(CONTESTED, "PE"),
    ),
    "its claim refused, the train is stopped": (
        HOLDING,
        DENIED,
        stopped(HOLDING, REFUSED),
        said(REFUSED, "3", "5", "6"),
    ),
    "its claim refused while it signs off": (
        SIGNING_OFF,
        DENIED,
        stopped(SIGNING_OFF, REFUSED),
        said(REFUSED, "PE"),
    ),
    "its sign-on refused where it says that it stands, the train is stopped, and it asks again": became(
        SIGNING_ON,
        replace(DENIED, answers=True),
        (
            SetTimer(CLAIMING.timer, REFUSED_REPEAT_S),
            Write(notes.SignOnDenied(why=DENIED.why)),
            Write(notes.Mismatch(why=REFUSED)),
        ),
        mismatch=REFUSED,
        requests=(replace(CLAIMING, refusal=DENIED.why),),
    ),
    "refused again, it is stopped already": became(
        replace(SIGNING_ON, mismatch=REFUSED),
        replace(DENIED, answers=True),
        (SetTimer(CLAIMING.timer, REFUSED_REPEAT_S), Write(notes.SignOnDenied(why=DENIED.why))),
        requests=(replace(CLAIMING, refusal=DENIED.why),),
    ),
    "a refusal of another sign-on stops nothing": (SIGNING_ON, DENIED, SIGNING_ON, ()),
    "a wish to enter that is refused stops nothing": became(
        replace(SIGNING_ON, held=(), entering=True),
        replace(DENIED, answers=True),
        (SetTimer(CLAIMING.timer, REFUSED_REPEAT_S), Write(notes.SignOnDenied(why=DENIED.why))),
        requests=(replace(CLAIMING, refusal=DENIED.why),),
    ),
    "who does not know what it holds claims nothing that could be refused": (
        Authority(requests=(replace(CLAIMING, section_ids=None),)),
        replace(DENIED, answers=True),
        Authority(requests=(replace(CLAIMING, section_ids=None, refusal=DENIED.why),)),
        (SetTimer(CLAIMING.timer, REFUSED_REPEAT_S), Write(notes.SignOnDenied(why=DENIED.why))),
    ),
    "its claim accepted with less than it holds, the train is stopped": (
        HOLDING,
        SignOnHeard(("3", "5"), ("5",), answers=False, newer=False),
        stopped(HOLDING, LESS),
        said(LESS, "3", "5", "6"),
    ),
    "accepted with less under a newer token, that is taken": (
        HOLDING,
        SignOnHeard(("3", "5"), ("5",), answers=False, newer=True),
        stopped(HOLDING, LESS),
        (Take(()), *said(LESS, "3", "5", "6")),
    ),
    "signing off, its claim accepted with nothing": (
        SIGNING_OFF,
        SignOnHeard((), (), answers=False, newer=False),
        stopped(SIGNING_OFF, LESS),
        said(LESS, "PE"),
    ),
    "found where it holds nothing, the train is stopped, and signs on with where it is": (
        HOLDING,
        FoundAt(("6", "8")),
        Authority(held=("6", "8"), mismatch=ELSEWHERE, requests=(AT_8,)),
        (
            Renew(RequestKind.SIGN_ON),
            Write(notes.Holds(section_ids=("6", "8"), token=0)),
            Write(notes.Mismatch(why=ELSEWHERE)),
            SendRequest(replace(AT_8, sent=False)),
            SetTimer(AT_8.timer, REPEAT_S),
        ),
    ),
    "an acceptance with all and more ends nothing: only the answer to its report does": became(
        stopped(HOLDING, REFUSED), SignOnHeard(("3", "5", "6", "7"), (), answers=False, newer=False)
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_row(name: str) -> None:
    state, event, after, actions = CASES[name]
    assert step(state, event, covered=True) == (after, actions)


def test_every_row_has_a_case() -> None:
    assert {(standing(state), type(event)) for state, event, _, _ in CASES.values()} == set(agreement.TABLE)


def check_ends_by_agreement_alone(state: Authority, course: Course) -> None:
    """A contradiction ends when the register confirms what is held, whole and uncontested, or with a new sign-on."""
    for before, event, after, _ in after_all(state, course):
        if not before.mismatch or after.mismatch:
            continue
        match event:
            case ConfirmationHeard(answers=True, contested=()):
                assert set(event.section_ids) == set(before.held)
            case SignOnHeard(answers=True):
                assert not before.on_line
            case BeginOnLine() | SignOffHeard(answers=True):
                pass
            case _:
                raise AssertionError(event)


@given(begun, courses_with_crew)
def test_a_contradiction_ends_by_agreement_alone(state: Authority, course: Course) -> None:
    check_ends_by_agreement_alone(state, course)


@given(begun, courses_with_crew)
def test_a_unit_on_the_line_that_disagrees_reports_until_it_is_over(state: Authority, course: Course) -> None:
    """So that no contradiction lasts for ever for want of a question."""
    for _, _, after, _ in after_all(state, course):
        if after.mismatch and after.on_line:
            assert after.open(RequestKind.REPORT) is not None


def _forgets(state: Authority, event: ConfirmationHeard) -> Result:
    after, actions = report.confirmed(state, event)
    return replace(after, mismatch=""), actions


def test_a_unit_that_any_confirmation_satisfies_breaks_that(monkeypatch: pytest.MonkeyPatch) -> None:
    course: Course = [
        (ContestHeard(("5",)), True),
        (ConfirmationHeard(("3", "5", "6"), answers=True, newer=False, contested=("5",)), True),
    ]
    check_ends_by_agreement_alone(HOLDING, course)
    forgetful: Table = {**TABLE, (SignOnStanding.ON_LINE, ConfirmationHeard): _forgets}
    monkeypatch.setattr("onboard.authority.machine.TABLE", forgetful)
    with pytest.raises(AssertionError):
        check_ends_by_agreement_alone(HOLDING, course)
