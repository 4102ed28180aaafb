"""What the train may occupy: sections asked for, held and given back, points commanded and proven.

Invariant: the unit counts as held only what the block manager granted to this boot and what has not been given
back; it gives a section back only after its safe rear has left it, or standing surely short of it, and drops it
here before it says so; points
count as proven only while their section is held and by a proof for the position and token of its own command.

A pure machine: `step(state, event, now_s, covered) -> (state, actions)`. Requests are repeated with the same
correlation until answered, and only where the radio reaches (`covered`); silence changes nothing. An answer
counts only for the request outstanding, by its correlation; a grant only with a token greater than the unit's.
Sugiyama et al. 2017, section 2.2 and table 1 (閉そく要求機能, 進路構成機能).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Final

from onboard import notes
from onboard.authority.records import (
    NEVER,
    Action,
    Ask,
    Authority,
    BeginOnLine,
    CheckedByCrew,
    Cleared,
    Command,
    EndOnLine,
    Event,
    GiveBack,
    Heard,
    Held,
    PointsNeeded,
    Send,
    Throw,
    Tick,
    TurnedBack,
    Withdrawn,
)
from radio.messages import (
    AnyMessage,
    Capability,
    Claim,
    ClaimQuery,
    HoldingConfirmed,
    HoldingReport,
    PointsCommand,
    PointsProof,
    PointsRefused,
    RefusalReason,
    Restarted,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    SignOff,
    SignOffAccepted,
    SignOffRefused,
    SignOn,
    SignOnAccepted,
    SignOnRefused,
)

__all__ = [
    "NEVER",
    "Action",
    "Ask",
    "Authority",
    "BeginOnLine",
    "CheckedByCrew",
    "Cleared",
    "Command",
    "EndOnLine",
    "Event",
    "GiveBack",
    "Heard",
    "Held",
    "PointsNeeded",
    "Send",
    "Throw",
    "Tick",
    "TurnedBack",
    "Withdrawn",
    "step",
    "waiting_for_radio",
]

REPEAT_S: Final = 2.0
REFUSED_REPEAT_S: Final = 5.0


Result = tuple[Authority, tuple[Action, ...]]


def step(state: Authority, event: Event, now_s: float, covered: bool) -> Result:
    """Next state and what to do. An event that does not fit the state changes nothing."""
    return _EVENTS[type(event)](state, event, now_s, covered)


def _begin(state: Authority, event: BeginOnLine, now_s: float, covered: bool) -> Result:
    if state.on_line:
        return state, ()
    held = tuple(Held(section_id, 0) for section_id in event.section_ids or ())
    begun = replace(
        _counted(state),
        held=held,
        sign_on=SignOn(state.unit_id, event.section_ids),
        sign_off=None,
        next_sign_s=now_s,
        sign_correlation=state.correlation + 1,
    )
    # Who has just been switched on does not know what it holds, which is not the same as nothing.
    said = () if event.section_ids is None else (_holds(begun),)
    return _due(begun, now_s, covered, said)


def _withdrawn(state: Authority, event: Withdrawn, _now_s: float, _covered: bool) -> Result:
    kept = tuple(c for c in state.commands if c.needed.section_id not in event.section_ids)
    gone = tuple(c for c in state.commands if c not in kept)
    return replace(state, commands=kept, unsaid=(*state.unsaid, *gone)), ()


def _checked_by_crew(state: Authority, event: CheckedByCrew, _now_s: float, _covered: bool) -> Result:
    needed = event.points
    if needed in state.proven:
        return state, ()
    checked = replace(
        state,
        proven=(*state.proven, needed),
        commands=tuple(c for c in state.commands if c.needed != needed),
    )
    note = notes.Proven(points_id=needed.points_id, position=needed.position, token=state.token, by_crew=True)
    return checked, (note,)


def _end(state: Authority, _event: EndOnLine, now_s: float, covered: bool) -> Result:
    if len(state.held) > 1 or not state.on_line or state.sign_off is not None:
        return state, ()
    ending = replace(
        _counted(state),
        sign_off=SignOff(state.unit_id, state.token),
        next_sign_s=now_s,
        sign_correlation=state.correlation + 1,
    )
    return _due(ending, now_s, covered)


def _ask(state: Authority, event: Ask, now_s: float, covered: bool) -> Result:
    if not state.on_line or state.asked is not None:
        return state, ()
    asking = replace(
        _counted(state),
        asked=event.route,
        next_ask_s=now_s,
        refusal="",
        ask_correlation=state.correlation + 1,
    )
    return _due(asking, now_s, covered)


def _turned_back(state: Authority, _event: TurnedBack, _now_s: float, _covered: bool) -> Result:
    turned = replace(state, held=state.held[::-1], commands=(), proven=(), unsaid=())
    if turned == state:
        return state, ()
    return turned, (_holds(turned),)


def _heard(state: Authority, event: Heard, now_s: float, covered: bool) -> Result:
    handler = _HEARD.get(type(event.message))
    return (state, ()) if handler is None else handler(state, event, now_s, covered)


def _tick(state: Authority, _event: Tick, now_s: float, covered: bool) -> Result:
    return _due(state, now_s, covered)


def _counted(state: Authority) -> Authority:
    return replace(state, correlation=state.correlation + 1)


def _holds(state: Authority) -> notes.Holds:
    return notes.Holds(section_ids=state.section_ids(), token=state.token)


def _throw(state: Authority, event: Throw, now_s: float, covered: bool) -> Result:
    under_way = {command.needed for command in state.commands} | set(state.proven)
    new: list[Command] = []
    for needed in event.points:
        held = next((h for h in state.held if h.section_id == needed.section_id), None)
        mac = b"" if held is None else held.mac_for(needed.terminal_id)
        if held is None or not mac or needed in under_way:
            continue
        state = _counted(state)
        new.append(Command(needed, held.token, mac, state.correlation, now_s))
    return _due(replace(state, commands=(*state.commands, *new)), now_s, covered)


def _give_back(state: Authority, event: GiveBack, now_s: float, covered: bool) -> Result:
    """A request still open is dropped too: its answer fits nothing, and the report frees what it may have given."""
    if state.asked is not None:
        state = _report_now(replace(state, asked=None, next_ask_s=NEVER, refusal=""), now_s)
    given, actions = _cleared(state, event, now_s, covered)
    return (given, actions) if actions else _due(given, now_s, covered)


def _cleared(state: Authority, event: Cleared | GiveBack, now_s: float, covered: bool) -> Result:
    section_ids = event.section_ids
    kept = tuple(held for held in state.held if held.section_id not in section_ids)
    if len(kept) == len(state.held):
        return state, ()
    dropped = replace(
        _counted(state),
        held=kept,
        proven=tuple(needed for needed in state.proven if needed.section_id not in section_ids),
        commands=tuple(c for c in state.commands if c.needed.section_id not in section_ids),
        unsaid=tuple(c for c in state.unsaid if c.needed.section_id not in section_ids),
        report_due=True,
        next_report_s=now_s,
        report_correlation=state.correlation + 1,
    )
    return _due(dropped, now_s, covered, (_holds(dropped),))


def _due(state: Authority, now_s: float, covered: bool, before: tuple[Action, ...] = ()) -> Result:
    """Send what is due. Where the radio does not reach, nothing is sent and all stays due."""
    actions: list[Action] = list(before)
    if not covered:
        return _deferred(state), tuple(actions)
    if state.next_sign_s <= now_s:
        message: AnyMessage | None = state.sign_off or state.sign_on
        if message is not None:
            actions.append(Send(state.manager_id, message, state.sign_correlation))
        state = replace(state, next_sign_s=now_s + REPEAT_S if message is not None else NEVER)
    if state.next_ask_s <= now_s and state.asked is not None:
        route = state.asked
        request = RouteRequest(state.unit_id, route.id, route.section_ids)
        actions.append(Send(state.manager_id, request, state.ask_correlation))
        state = replace(state, next_ask_s=now_s + REPEAT_S)
    commands: list[Command] = []
    for command in state.commands:
        if command.next_s > now_s:
            commands.append(command)
            continue
        needed = command.needed
        order = PointsCommand(
            needed.points_id, needed.position, needed.section_id, command.token, command.mac
        )
        actions.append(Send(needed.terminal_id, order, command.correlation))
        commands.append(replace(command, next_s=now_s + REPEAT_S))
    state = replace(state, commands=tuple(commands))
    if state.report_due and state.next_report_s <= now_s:
        report = HoldingReport(state.section_ids(), state.token)
        actions.append(Send(state.manager_id, report, state.report_correlation))
        actions.append(notes.Reported(section_ids=state.section_ids(), token=state.token))
        state = replace(state, next_report_s=now_s + REPEAT_S)
    return state, tuple(actions)


def _deferred(state: Authority) -> Authority:
    """Out of reach: no timer runs; what is unanswered is due as soon as the radio reaches again."""
    return replace(
        state,
        next_sign_s=NEVER if state.next_sign_s == NEVER else -NEVER,
        next_ask_s=NEVER if state.next_ask_s == NEVER else -NEVER,
        next_report_s=NEVER if state.next_report_s == NEVER else -NEVER,
        commands=tuple(replace(command, next_s=-NEVER) for command in state.commands),
    )


def waiting_for_radio(state: Authority) -> bool:
    """Whether something is due that could not be sent for want of coverage."""
    return state.next_timer_s() == -NEVER


def _macs(capabilities: Iterable[Capability], section_id: str) -> tuple[tuple[str, bytes], ...]:
    return tuple((c.terminal_id, c.mac) for c in capabilities if c.section_id == section_id)


def _newer_token(
    state: Authority, token: int, capabilities: tuple[Capability, ...], now_s: float
) -> Authority:
    """Take a greater token. What is outstanding is asked anew, so that no answer to the old request fits."""
    if token <= state.token:
        return state
    held = tuple(
        Held(h.section_id, token, macs) if (macs := _macs(capabilities, h.section_id)) else h
        for h in state.held
    )
    state = replace(_counted(state), held=held, token=token)
    if state.asked is not None:
        state = replace(state, ask_correlation=state.correlation, next_ask_s=now_s)
    if state.sign_off is not None:
        sign_off = SignOff(state.unit_id, token)
        state = _counted(replace(state, sign_off=sign_off, next_sign_s=now_s))
        state = replace(state, sign_correlation=state.correlation)
    return state


def _report_now(state: Authority, now_s: float) -> Authority:
    """Report what is held: a manager that has lost sight of the unit answers with its token or a query."""
    state = _counted(state)
    return replace(state, report_due=True, next_report_s=now_s, report_correlation=state.correlation)


def _sign_on_accepted(state: Authority, event: Heard, now_s: float, covered: bool) -> Result:
    message = event.message
    if not isinstance(message, SignOnAccepted):
        return state, ()
    if state.on_line:  # the answer to a claim: the unit knows better what it holds
        return _due(_newer_token(state, message.token, message.capabilities, now_s), now_s, covered)
    if state.sign_on is None or event.correlation != state.sign_correlation:
        return state, ()
    accepted = replace(
        state,
        held=tuple(Held(s, message.token, _macs(message.capabilities, s)) for s in message.section_ids),
        token=message.token,
        on_line=True,
        sign_on=None,
        next_sign_s=NEVER,
        refusal="",
    )
    return accepted, (notes.SignedOn(section_ids=message.section_ids), _holds(accepted))


def _sign_on_refused(state: Authority, event: Heard, now_s: float, _covered: bool) -> Result:
    message = event.message
    if not isinstance(message, SignOnRefused) or state.sign_on is None:
        return state, ()
    if event.correlation != state.sign_correlation:
        return state, ()
    waiting = replace(state, next_sign_s=now_s + REFUSED_REPEAT_S, refusal=_why(message))
    return waiting, (notes.SignOnDenied(why=waiting.refusal),)


def _sign_off_answer(state: Authority, event: Heard, now_s: float, covered: bool) -> Result:
    message = event.message
    if state.sign_off is None or event.correlation != state.sign_correlation:
        return state, ()
    if isinstance(message, SignOffRefused):
        waiting = replace(state, next_sign_s=now_s + REFUSED_REPEAT_S)
        if message.reason in _LOST_SIGHT and not state.report_due:
            waiting = _report_now(waiting, now_s)
        return _due(waiting, now_s, covered, (notes.SignOffDenied(why=message.reason.name),))
    gone = replace(state, held=(), on_line=False, sign_off=None, next_sign_s=NEVER)
    return gone, (notes.SignedOff(), _holds(gone))


def _granted(state: Authority, event: Heard, _now_s: float, _covered: bool) -> Result:
    message = event.message
    if not isinstance(message, RouteGranted) or state.asked is None or not event.fresh:
        return state, ()
    if event.correlation != state.ask_correlation or message.token <= state.token:
        return state, ()
    if message.route_id != state.asked.id or message.section_ids != state.asked.section_ids:
        return state, ()
    granted_now = {s: Held(s, message.token, _macs(message.capabilities, s)) for s in message.section_ids}
    held = tuple(granted_now.pop(h.section_id, h) for h in state.held)
    granted = replace(
        state,
        held=(*held, *granted_now.values()),
        token=message.token,
        asked=None,
        next_ask_s=NEVER,
        refusal="",
        # What the crew saw while another could throw the points is no proof any more.
        proven=tuple(needed for needed in state.proven if state.holds(needed.section_id)),
    )
    note = notes.RouteHeld(route_id=message.route_id, token=message.token)
    return granted, (note, _holds(granted))


def _refused(state: Authority, event: Heard, now_s: float, covered: bool) -> Result:
    message = event.message
    if not isinstance(message, RouteRefused) or state.asked is None or message.route_id != state.asked.id:
        return state, ()
    if event.correlation != state.ask_correlation:
        return state, ()
    refusal = _why(message)
    denied = notes.RouteDenied(route_id=message.route_id, why=refusal)
    said = () if refusal == state.refusal else (denied,)
    again = replace(
        _counted(state),
        next_ask_s=now_s + REFUSED_REPEAT_S,
        refusal=refusal,
        ask_correlation=state.correlation + 1,
    )
    if message.reason in _LOST_SIGHT and not state.report_due:
        again = _report_now(again, now_s)
    return _due(again, now_s, covered, said)


def _why(message: RouteRefused | SignOnRefused) -> str:
    why = message.reason.name.lower().replace("_", " ")
    if message.section_id is not None:
        why += f": section {message.section_id}"
    if message.holder is not None:
        why += f" of {message.holder}"
    return why


def _proof(state: Authority, event: Heard, _now_s: float, _covered: bool) -> Result:
    message = event.message
    if not isinstance(message, PointsProof):
        return state, ()
    good = message.locked and message.detected
    for command in (*state.commands, *state.unsaid):
        needed = command.needed
        if needed.points_id != message.points_id or event.source != needed.terminal_id:
            continue
        if not good or message.position is not needed.position or message.token != command.token:
            return state, ()
        proven = replace(
            state,
            commands=tuple(c for c in state.commands if c.needed != needed),
            unsaid=tuple(c for c in state.unsaid if c.needed != needed),
            proven=(*state.proven, needed),
        )
        note = notes.Proven(points_id=needed.points_id, position=needed.position, token=command.token)
        return proven, (note,)
    lost = [n for n in state.proven if n.points_id == message.points_id and n.terminal_id == event.source]
    if not lost or (good and message.position is lost[0].position):
        return state, ()
    tokens = {h.section_id: h.token for h in state.held}
    unsaid = (Command(n, tokens[n.section_id], b"", 0, NEVER) for n in lost if n.section_id in tokens)
    kept = tuple(n for n in state.proven if n not in lost)
    dropped = replace(state, proven=kept, unsaid=(*state.unsaid, *unsaid))
    return dropped, (notes.ProofDropped(points_id=message.points_id),)


def _points_refused(state: Authority, event: Heard, now_s: float, _covered: bool) -> Result:
    message = event.message
    if not isinstance(message, PointsRefused):
        return state, ()
    why = message.reason.name.lower().replace("_", " ")
    commands: list[Command] = []
    denied: list[Action] = []
    for command in state.commands:
        needed = command.needed
        mine = (needed.points_id, needed.terminal_id) == (message.points_id, event.source)
        mine = mine and command.token == message.token
        if mine and command.refusal != why:
            denied.append(notes.ThrowDenied(points_id=message.points_id, why=why))
        commands.append(replace(command, next_s=now_s + REFUSED_REPEAT_S, refusal=why) if mine else command)
    return replace(state, commands=tuple(commands)), tuple(denied)


def _confirmed(state: Authority, event: Heard, now_s: float, covered: bool) -> Result:
    message = event.message
    if not isinstance(message, HoldingConfirmed) or not state.report_due:
        return state, ()
    if event.correlation != state.report_correlation:
        return state, ()
    if set(message.section_ids) == set(state.section_ids()):
        state = replace(state, report_due=False, next_report_s=NEVER)
    elif message.token > state.token:  # refused for its token: the same report again under the newer one
        state = replace(state, next_report_s=now_s)
    return _due(_newer_token(state, message.token, (), now_s), now_s, covered)


def _claim_query(state: Authority, event: Heard, _now_s: float, _covered: bool) -> Result:
    if not state.on_line and state.sign_on is not None and state.sign_on.section_ids is None:
        return state, (Send(state.manager_id, Claim(None, 0), event.correlation),)
    waits_to_enter = state.entering and not state.on_line
    sections = () if waits_to_enter else state.section_ids()
    return state, (
        Send(state.manager_id, Claim(sections, state.token), event.correlation),
        notes.Claimed(section_ids=sections, token=state.token),
    )


def _peer_restarted(state: Authority, _event: Heard, now_s: float, covered: bool) -> Result:
    """Nothing that was sent before is known to have arrived: all that is open is due again."""
    again = replace(
        state,
        next_sign_s=NEVER if state.next_sign_s == NEVER else now_s,
        next_ask_s=NEVER if state.asked is None else now_s,
        next_report_s=now_s if state.report_due else NEVER,
        commands=tuple(replace(command, next_s=now_s) for command in state.commands),
    )
    return _due(again, now_s, covered)


_LOST_SIGHT: Final = (RefusalReason.NOT_SIGNED_ON, RefusalReason.STALE_TOKEN)

_HEARD: Final[Mapping[type[AnyMessage], Callable[[Authority, Heard, float, bool], Result]]] = {
    SignOnAccepted: _sign_on_accepted,
    SignOnRefused: _sign_on_refused,
    SignOffAccepted: _sign_off_answer,
    SignOffRefused: _sign_off_answer,
    RouteGranted: _granted,
    RouteRefused: _refused,
    PointsProof: _proof,
    PointsRefused: _points_refused,
    HoldingConfirmed: _confirmed,
    ClaimQuery: _claim_query,
    Restarted: _peer_restarted,
}

_EVENTS: Final[Mapping[type[Event], Callable[..., Result]]] = {
    BeginOnLine: _begin,
    EndOnLine: _end,
    Ask: _ask,
    Throw: _throw,
    CheckedByCrew: _checked_by_crew,
    Withdrawn: _withdrawn,
    Cleared: _cleared,
    GiveBack: _give_back,
    TurnedBack: _turned_back,
    Heard: _heard,
    Tick: _tick,
}
