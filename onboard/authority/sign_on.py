"""Signing on and off (在線登録・抹消): which boot of which unit is on the line, and with what.

Invariant: a unit counts as held what the manager accepted, and what it claims as standing in, never what it wishes to
enter; it signs off only with its last section, and holds that until its train is off the line.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority.records import (
    Authority,
    BeginOnLine,
    EarlierBootCalled,
    EndOnLine,
    OpenRequest,
    QueryHeard,
    RefusalHeard,
    RequestKind,
    SendClaim,
    SignOffHeard,
    SignOnHeard,
    StopTimer,
    Take,
    TakenOff,
    TurnedBack,
    Write,
)
from onboard.authority.tables import (
    Result,
    SignOnStanding,
    Table,
    agrees,
    closed,
    holds,
    opened,
    points_anew,
    refused,
    report_now,
    take_newer,
)

FORGETS_PROOFS = True  # off: what was proven before its claim counts, though the points were another's since


def begin(state: Authority, event: BeginOnLine) -> Result:
    """Signs on with what it claims, with a wish for its portal, or with 'I do not know' after a restart."""
    begun = replace(
        state,
        held=() if event.enters else (event.section_ids or ()),
        commandable=(),
        entering=event.enters,
        requests=(),
        mismatch="",
        unswept=(),
        swept=(),
        unsure=False,
    )
    begun, actions = opened(begun, OpenRequest(RequestKind.SIGN_ON, section_ids=event.section_ids))
    # Who has just been switched on does not know what it holds, which is not the same as nothing.
    return begun, actions if event.section_ids is None else (*actions, holds(begun))


def end(state: Authority, _event: EndOnLine) -> Result:
    """Signs off, if nothing but one section is held."""
    if len(state.held) > 1:
        return state, ()
    return opened(state, OpenRequest(RequestKind.SIGN_OFF))


def signed_on(state: Authority, event: SignOnHeard) -> Result:
    """To its sign-on: holds what the manager says, if that has the portal that it wishes to enter."""
    request = state.open(RequestKind.SIGN_ON)
    if request is None or not event.answers:
        return state, ()
    # Asked on its sign-on, it has claimed nothing, and that is what was accepted: the wish is still to come.
    if state.entering and not set(request.section_ids or ()) <= set(event.section_ids):
        return state, ()
    accepted, actions = closed(state, RequestKind.SIGN_ON)
    accepted = replace(
        accepted,
        held=event.section_ids,
        commandable=event.commandable,
        on_line=True,
        entering=False,
        unswept=event.on_sight,
    )
    accepted, agreed = agrees(accepted)
    note = Write(notes.SignedOn(section_ids=event.section_ids))
    return accepted, (*actions, *agreed, Take(event.section_ids), note, holds(accepted))


def claim_accepted(state: Authority, event: SignOnHeard) -> Result:
    """To a claim: takes a greater token, never sections; what is open is asked anew, and points, which may have been
    another's meanwhile, are proven anew.
    """
    state = replace(state, unswept=tuple(s for s in event.on_sight if state.holds(s)))
    if not event.newer:
        return state, ()
    state, actions = take_newer(state)
    state, anew = points_anew(state, event.commandable) if FORGETS_PROOFS else (state, ())
    return state, (*actions, *anew)


def sign_on_refused(state: Authority, event: RefusalHeard) -> Result:
    """To its sign-on: waits and asks again."""
    request = state.open(RequestKind.SIGN_ON)
    if request is None or event.ask is not RequestKind.SIGN_ON or not event.answers:
        return state, ()
    waiting, actions = refused(state, request, event.why)
    return waiting, (*actions, Write(notes.SignOnDenied(why=event.why)))


def sign_off_refused(state: Authority, event: RefusalHeard) -> Result:
    """To its sign-off: asks again; reports first if the manager has lost sight of it."""
    request = state.open(RequestKind.SIGN_OFF)
    if request is None or event.ask is not RequestKind.SIGN_OFF or not event.answers:
        return state, ()
    waiting, actions = refused(state, request, event.why)
    if event.lost_sight and state.open(RequestKind.REPORT) is None:
        waiting, more = report_now(waiting)
        actions = (*actions, *more)
    return waiting, (*actions, Write(notes.SignOffDenied(why=event.why)))


def signed_off(state: Authority, event: SignOffHeard) -> Result:
    """To its sign-off: asks for nothing any more, and its train may leave; the portal is its own until it has."""
    if not event.answers:
        return state, ()
    timers = (*(r.timer for r in state.requests), *(c.timer for c in state.commands))
    leaving = Authority(held=state.held, leaving=True)
    return leaving, (*map(StopTimer, timers), Write(notes.SignedOff()))


def taken_off(state: Authority, _event: TakenOff) -> Result:
    """Holds nothing: the train is off the line."""
    gone = Authority()
    return gone, () if state == gone else (holds(gone),)


def queried(state: Authority, _event: QueryHeard) -> Result:
    """Answers at once with all that it holds, nothing while it waits to enter; and that it leaves, if it does."""
    return state, (
        SendClaim(state.held, leaving=state.leaving),
        Write(notes.Claimed(section_ids=state.held, token=0)),
    )


def queried_off_line(state: Authority, event: QueryHeard) -> Result:
    """Answers at once: that it holds nothing, or after a boot, where it may be on the line, that it does not know."""
    return (state, (SendClaim(None),)) if state.unsure else queried(state, event)


def called_off_line(state: Authority, _event: EarlierBootCalled) -> Result:
    """Off the line for sure, it asks for nothing by which the manager would hear of this boot: says that it holds
    nothing, and is asked again as who it is.
    """
    return (state, ()) if state.unsure else queried(state, QueryHeard())


def queried_signing_on(state: Authority, event: QueryHeard) -> Result:
    """Answers at once: with all that it claims, with nothing while it waits to enter, or that it does not know."""
    request = state.open(RequestKind.SIGN_ON)
    if request is not None and request.section_ids is None:
        return state, (SendClaim(None),)
    return queried(state, event)


def turned_back(state: Authority, _event: TurnedBack) -> Result:
    """Turns the order of what is held; forgets proofs and commands of the old way."""
    turned = replace(state, held=state.held[::-1], commands=(), proven=(), unsaid=())
    if turned == state:
        return state, ()
    return turned, (*(StopTimer(c.timer) for c in state.commands), holds(turned))


TABLE: Final[Table] = MappingProxyType(
    {
        (SignOnStanding.OFF_LINE, BeginOnLine): begin,
        (SignOnStanding.SIGNING_ON, BeginOnLine): begin,
        (SignOnStanding.SIGNING_ON, SignOnHeard): signed_on,
        (SignOnStanding.ON_LINE, EndOnLine): end,
        (SignOnStanding.SIGNING_OFF, SignOffHeard): signed_off,
        (SignOnStanding.OFF_LINE, TakenOff): taken_off,
        (SignOnStanding.LEAVING, TakenOff): taken_off,
        (SignOnStanding.OFF_LINE, QueryHeard): queried_off_line,
        (SignOnStanding.OFF_LINE, EarlierBootCalled): called_off_line,
        (SignOnStanding.SIGNING_ON, QueryHeard): queried_signing_on,
        (SignOnStanding.ON_LINE, QueryHeard): queried,
        (SignOnStanding.SIGNING_OFF, QueryHeard): queried,
        (SignOnStanding.LEAVING, QueryHeard): queried,
        **dict.fromkeys(((s, TurnedBack) for s in SignOnStanding), turned_back),
    }
)
