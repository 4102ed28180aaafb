"""Rows of the table of points: next state and actions."""

from typing import Final

import pytest
from msgspec.structs import replace

from network.model import Position
from onboard import notes
from onboard.authority import points
from onboard.authority.machine import step
from onboard.authority.records import (
    Authority,
    CheckedByCrew,
    Commit,
    OpenCommand,
    OpenRequest,
    PointsDenialHeard,
    ProofHeard,
    Renew,
    RequestKind,
    SendCommand,
    SendRequest,
    SetTimer,
    StopTimer,
    Throw,
    Timer,
    Withdrawn,
    Write,
)
from onboard.authority.tables import REFUSED_REPEAT_S, REPEAT_S, standing
from tests.onboard.duty.stage import P5, P7, AuthorityCase, became

TIMER: Final = Timer("points", "P5")
HOLDING: Final = Authority(held=("3", "5", "6", "7", "8"), commandable=("5", "7"), on_line=True)
OPEN: Final = OpenCommand(P5, sent=True)
THROWING: Final = replace(HOLDING, commands=(OPEN,))
REFUSED: Final = replace(
    HOLDING,
    commands=(replace(OPEN, refusal="old token"),),
    requests=(OpenRequest(RequestKind.REPORT, sent=True),),
)
PROVEN: Final = replace(HOLDING, proven=(P5,))
WITHDRAWN: Final = replace(HOLDING, unsaid=(P5,))
SIGNING_ON: Final = Authority(requests=(OpenRequest(RequestKind.SIGN_ON, section_ids=None, sent=True),))
SHOWN: Final = ProofHeard("P5", "A-E", "normal", mine=True)
DENIED: Final = PointsDenialHeard("P5", "A-E", "not detected", mine=True)


def proven(by_crew: bool = False) -> Write:
    return Write(notes.Proven(points_id="P5", position=Position.NORMAL, token=0, by_crew=by_crew))


def other(shown: ProofHeard, **changes: object) -> ProofHeard:
    return replace(shown, **changes)


REPORTED: Final = (
    SendRequest(OpenRequest(RequestKind.REPORT, section_ids=HOLDING.held)),
    SetTimer(Timer("report"), REPEAT_S),
    Write(notes.Reported(section_ids=HOLDING.held, token=0)),
)
DROPPED: Final = Write(notes.ProofDropped(points_id="P5"))

CASES: Final[dict[str, AuthorityCase]] = {
    "commanded under the token of their section, and repeated": (
        HOLDING,
        Throw((P5,)),
        THROWING,
        (Commit(P5), SendCommand(P5), SetTimer(TIMER, REPEAT_S)),
    ),
    "not commanded without a capability": became(replace(HOLDING, commandable=("7",)), Throw((P5,))),
    "commanded once": (THROWING, Throw((P5,)), THROWING, ()),
    "not commanded when proven": (PROVEN, Throw((P5,)), PROVEN, ()),
    "the crew's eye counts as a proof": (
        THROWING,
        CheckedByCrew(P5),
        PROVEN,
        (StopTimer(TIMER), proven(by_crew=True)),
    ),
    "seen by the crew after its proof was withdrawn, it is proven and nothing else": (
        WITHDRAWN,
        CheckedByCrew(P5),
        PROVEN,
        (proven(by_crew=True),),
    ),
    "the crew looks at what is proven": (PROVEN, CheckedByCrew(P5), PROVEN, ()),
    "the crew's eye counts while signing on": became(
        SIGNING_ON, CheckedByCrew(P5), (proven(by_crew=True),), proven=(P5,)
    ),
    "given up where the front may be on them": (THROWING, Withdrawn(("5",)), WITHDRAWN, (StopTimer(TIMER),)),
    "given up twice, remembered once": (
        replace(THROWING, unsaid=(P5,)),
        Withdrawn(("5",)),
        WITHDRAWN,
        (StopTimer(TIMER),),
    ),
    "only those are given up": (THROWING, Withdrawn(("7",)), THROWING, ()),
    "proven by their terminal": (THROWING, SHOWN, PROVEN, (StopTimer(TIMER), proven())),
    "given up and proven all the same": (WITHDRAWN, SHOWN, PROVEN, (proven(),)),
    "shown in the other position": (THROWING, other(SHOWN, position="reverse"), THROWING, (Commit(P5),)),
    "not detected or not locked": (THROWING, other(SHOWN, position=None), THROWING, (Commit(P5),)),
    "an earlier command's withdrawn": (THROWING, other(SHOWN, position=None, mine=False), THROWING, ()),
    "shown for another token": (THROWING, other(SHOWN, mine=False), THROWING, ()),
    "shown by another terminal": (THROWING, other(SHOWN, terminal_id="B-W"), THROWING, ()),
    "proven twice": (PROVEN, SHOWN, PROVEN, ()),
    "a proof that no longer holds is dropped at once": (
        PROVEN,
        other(SHOWN, position=None),
        WITHDRAWN,
        (Commit(P5), DROPPED),
    ),
    "dropped whoever commands them now": (
        PROVEN,
        other(SHOWN, position="reverse", mine=False),
        WITHDRAWN,
        (Commit(P5), DROPPED),
    ),
    "what the crew saw of a section not held is dropped for good": (
        replace(HOLDING, held=("3",), commandable=(), proven=(P5,)),
        other(SHOWN, position=None),
        replace(HOLDING, held=("3",), commandable=()),
        (DROPPED,),
    ),
    "while signing on, what the crew saw is dropped": (
        replace(SIGNING_ON, proven=(P5,)),
        other(SHOWN, position=None),
        SIGNING_ON,
        (DROPPED,),
    ),
    "refused, they are commanded again later": (
        THROWING,
        DENIED,
        replace(HOLDING, commands=(replace(OPEN, refusal="not detected"),)),
        (Write(notes.ThrowDenied(points_id="P5", why="not detected")), SetTimer(TIMER, REFUSED_REPEAT_S)),
    ),
    "refused for the same reason, nothing new is written": became(
        replace(HOLDING, commands=(replace(OPEN, refusal="not detected"),)),
        DENIED,
        (SetTimer(TIMER, REFUSED_REPEAT_S),),
    ),
    "refused because the grant is not the newest, it is reported, so that the manager can say so": (
        THROWING,
        replace(DENIED, why="old token", stale=True),
        REFUSED,
        (
            Write(notes.ThrowDenied(points_id="P5", why="old token")),
            SetTimer(TIMER, REFUSED_REPEAT_S),
            Renew(RequestKind.REPORT),
            *REPORTED,
        ),
    ),
    "refused so again, one report is enough": became(
        REFUSED, replace(DENIED, why="old token", stale=True), (SetTimer(TIMER, REFUSED_REPEAT_S),)
    ),
    "refused for another token": (THROWING, replace(DENIED, mine=False, stale=True), THROWING, ()),
    "refused by another terminal": (THROWING, replace(DENIED, terminal_id="B-W"), THROWING, ()),
}


@pytest.mark.parametrize("name", CASES)
def test_row(name: str) -> None:
    state, event, after, actions = CASES[name]
    assert step(state, event, covered=True) == (after, actions)


def test_every_row_has_a_case() -> None:
    assert {(standing(state), type(event)) for state, event, _, _ in CASES.values()} == set(points.TABLE)


def test_several_are_commanded_in_order() -> None:
    _, actions = step(HOLDING, Throw((P5, P7)), covered=True)
    assert [action.needed for action in actions if isinstance(action, SendCommand)] == [P5, P7]
