"""What the train may occupy: sections asked for, held and given back, points commanded and proven.

Invariant: the unit counts as held only what the block manager granted to this boot and what has not been given
back; it gives a section back only after its safe rear has left it, or standing surely short of it, and drops it
here before it says so; points count as proven only while their section is held and by a proof for the position and
token of its own command.

A pure machine of five small tables (sign-on, route, points, report, agreement): `step(state, event, covered) ->
(state, actions)`. Requests are repeated with the same correlation until answered, and only where the radio reaches
(`covered`); silence changes nothing. Sugiyama et al. 2017, section 2.2 and table 1 (閉そく要求機能, 進路構成機能).
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from msgspec.structs import replace

from onboard import notes
from onboard.authority import agreement, points, report, route, sign_on
from onboard.authority.records import (
    Action,
    Authority,
    Event,
    PeerRestarted,
    RepeatDue,
    RequestKind,
    SendCommand,
    SendRequest,
    SetTimer,
    StopTimer,
    Write,
)
from onboard.authority.tables import REPEAT_S, Result, SignOnStanding, Table, standing

# of requests; after them points, and last the report
SAID_IN_ORDER: Final = (RequestKind.SIGN_OFF, RequestKind.SIGN_ON, RequestKind.ROUTE)


def due(state: Authority, event: RepeatDue) -> Result:
    """What this timer belongs to is due again; without one, whatever could not be sent for want of coverage."""
    return (
        replace(
            state,
            requests=tuple(replace(r, sent=r.sent and r.timer != event.timer) for r in state.requests),
            commands=tuple(replace(c, sent=c.sent and c.timer != event.timer) for c in state.commands),
        ),
        (),
    )


def peer_restarted(state: Authority, _event: PeerRestarted) -> Result:
    """All that is open is due again."""
    return _all_due(state), ()


_EVERYWHERE: Final[Table] = MappingProxyType(
    {
        (at, kind): handler
        for kind, handler in ((RepeatDue, due), (PeerRestarted, peer_restarted))
        for at in (SignOnStanding.SIGNING_ON, SignOnStanding.ON_LINE, SignOnStanding.SIGNING_OFF)
    }
)
TABLE: Final[Table] = MappingProxyType(
    {
        **sign_on.TABLE,
        **route.TABLE,
        **points.TABLE,
        **report.TABLE,
        **agreement.TABLE,
        **_EVERYWHERE,
    }
)


def step(state: Authority, event: Event, *, covered: bool) -> Result:
    """Next state and what to do. An event that does not fit the state changes nothing but what is due anyway."""
    handler = TABLE.get((standing(state), type(event)))
    after, actions = (state, ()) if handler is None else handler(state, event)
    after, said = say(after) if covered else defer(after)
    return after, (*actions, *said)


def say(state: Authority) -> Result:
    """Send what is due, and set the timers of its repeats."""
    actions: list[Action] = []
    for ask in SAID_IN_ORDER:
        actions += _say_request(state, ask)
    for command in state.commands:
        if not command.sent:
            actions += (SendCommand(command.needed), SetTimer(command.timer, REPEAT_S))
    report_ = state.open(RequestKind.REPORT)
    if report_ is not None and not report_.sent:  # always the whole of what is held now
        whole = replace(report_, section_ids=state.held, swept=state.swept)
        actions += (SendRequest(whole), SetTimer(report_.timer, REPEAT_S))
        actions.append(Write(notes.Reported(section_ids=state.held, token=0)))
    if not actions:
        return state, ()
    said = replace(
        state,
        requests=tuple(replace(request, sent=True) for request in state.requests),
        commands=tuple(replace(command, sent=True) for command in state.commands),
    )
    return said, tuple(actions)


def _say_request(state: Authority, ask: RequestKind) -> tuple[Action, ...]:
    request = state.open(ask)
    if request is None or request.sent:
        return ()
    return SendRequest(request), SetTimer(request.timer, REPEAT_S)


def defer(state: Authority) -> Result:
    """Out of reach: no timer runs; what is unanswered is due as soon as the radio reaches again."""
    deferred = _all_due(state)
    if deferred == state:
        return state, ()
    timers = (*(r.timer for r in state.requests), *(c.timer for c in state.commands))
    return deferred, tuple(StopTimer(timer) for timer in timers)


def _all_due(state: Authority) -> Authority:
    return replace(
        state,
        requests=tuple(replace(request, sent=False) for request in state.requests),
        commands=tuple(replace(command, sent=False) for command in state.commands),
    )
