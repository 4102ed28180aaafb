"""What the tables of the authority have in common: where the unit stands with the manager, and open requests.

A table maps (standing, type of the event) to a handler `(state, event) -> (state, actions)`, whose docstring says what
happens. What no table names is refused and changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any, Final, TypeAlias

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import (
    Action,
    Authority,
    Commit,
    Event,
    OpenRequest,
    Renew,
    RequestKind,
    SetTimer,
    StopTimer,
    Take,
    Write,
)

REPEAT_S: Final = 2.0
REFUSED_REPEAT_S: Final = 5.0


class SignOnStanding(Enum):
    """Where the unit stands with the block manager; derived from its state."""

    OFF_LINE = "off the line"
    SIGNING_ON = "signing on"
    ON_LINE = "on the line"
    SIGNING_OFF = "signing off"
    LEAVING = "leaving"


Result: TypeAlias = tuple[Authority, tuple[Action, ...]]
Handler: TypeAlias = Callable[[Authority, Any], Result]
Table: TypeAlias = Mapping[tuple[SignOnStanding, type[Event]], Handler]


def standing(state: Authority) -> SignOnStanding:
    """Where the unit stands with the manager."""
    if state.open(RequestKind.SIGN_OFF) is not None:
        return SignOnStanding.SIGNING_OFF
    if state.leaving:
        return SignOnStanding.LEAVING
    if state.on_line:
        return SignOnStanding.ON_LINE
    return SignOnStanding.OFF_LINE if state.open(RequestKind.SIGN_ON) is None else SignOnStanding.SIGNING_ON


def opened(state: Authority, request: OpenRequest) -> Result:
    """A new request, in place of one of its kind that may be open: an answer to that fits no more."""
    others = tuple(other for other in state.requests if other.ask is not request.ask)
    return replace(state, requests=(*others, request)), (Renew(request.ask),)


def changed(state: Authority, request: OpenRequest) -> Authority:
    """The open request of this kind, changed; its place among the others stays."""
    requests = tuple(request if other.ask is request.ask else other for other in state.requests)
    return replace(state, requests=requests)


def closed(state: Authority, ask: RequestKind) -> Result:
    """The request of this kind is over."""
    request = state.open(ask)
    if request is None:
        return state, ()
    return replace(state, requests=tuple(r for r in state.requests if r.ask is not ask)), (
        StopTimer(request.timer),
    )


def refused(state: Authority, request: OpenRequest, why: str) -> Result:
    """The request stays open and is repeated, later than one that was not answered."""
    waiting = replace(request, sent=True, refusal=why)
    return changed(state, waiting), (SetTimer(request.timer, REFUSED_REPEAT_S),)


def holds(state: Authority) -> Write:
    """The line of the journal that says what is held."""
    return Write(notes.Holds(section_ids=state.held, token=0))


def report_now(state: Authority, next_train: str = "") -> Result:
    """Report what is held: as a new request, at once; with the next train of a set, until that is confirmed."""
    before = state.open(RequestKind.REPORT)
    named = next_train or ("" if before is None else before.subject)
    return opened(state, OpenRequest(RequestKind.REPORT, named))


def disagrees(state: Authority, why: str) -> Result:
    """Register and unit contradict each other: that is remembered, and reported until it is over."""
    actions: tuple[Action, ...] = ()
    if state.on_line and state.open(RequestKind.REPORT) is None:
        state, actions = report_now(state)
    if why == state.mismatch:
        return state, actions
    return replace(state, mismatch=why), (*actions, Write(notes.Mismatch(why=why)))


def agrees(state: Authority) -> Result:
    """They have the same again."""
    if not state.mismatch:
        return state, ()
    return replace(state, mismatch=""), (Write(notes.Agreed()),)


def take_newer(state: Authority) -> Result:
    """Take a greater token. What is outstanding is asked anew, so that no answer to the old request fits."""
    actions: tuple[Action, ...] = (Take(()),)
    for ask in (RequestKind.ROUTE, RequestKind.SIGN_OFF):
        request = state.open(ask)
        if request is not None:
            state = changed(state, replace(request, sent=False))
            actions = (*actions, Renew(ask))
    return state, actions


def points_anew(state: Authority, commandable: tuple[str, ...]) -> Result:
    """Of points nothing is known any more, nor may be commanded but with a capability that came with the newer token.

    Those under way are commanded anew under that; others are given up.
    """
    anew = tuple(c for c in state.commands if c.needed.section_id in commandable)
    gone = tuple(c for c in state.commands if c not in anew)
    known = tuple(s for s in state.held if s in commandable)
    commands = tuple(replace(c, sent=False) for c in anew)
    state = replace(state, commandable=known, commands=commands, proven=(), unsaid=())
    return state, (*(Commit(c.needed) for c in anew), *(StopTimer(c.timer) for c in gone))
