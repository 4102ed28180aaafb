"""What the train may occupy: sections asked for, held and given back, points commanded and proven.

Invariant: the unit counts as held only what the block manager granted to this boot and what has not been given
back; it gives a section back only after its safe rear has left it, and drops it here before it says so; points
count as proven only while their section is held and by a proof for the position and token of its own command.

A pure machine: `step(state, event, now_s, covered) -> (state, actions)`. Requests are repeated with the same
correlation until answered, and only where the radio reaches (`covered`); silence changes nothing.
Sugiyama et al. 2017, section 2.2 and table 1 (閉そく要求機能, 進路構成機能).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from network.model import Position, Route
from radio.messages import (
    AnyMessage,
    Claim,
    ClaimQuery,
    HoldingConfirmed,
    HoldingReport,
    PointsCommand,
    PointsProof,
    PointsRefused,
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

REPEAT_S: Final = 2.0
REFUSED_REPEAT_S: Final = 5.0
NEVER: Final = math.inf


@dataclass(frozen=True, slots=True)
class Held:
    """A section held: under which token, and for a points section what proves it to its terminal."""

    section_id: str
    token: int
    mac: bytes = b""


@dataclass(frozen=True, slots=True)
class PointsNeeded:
    """A set of points as the path needs it."""

    points_id: str
    position: Position
    section_id: str
    terminal_id: str


@dataclass(frozen=True, slots=True)
class Command:
    """A points command not yet proven."""

    needed: PointsNeeded
    token: int
    mac: bytes
    correlation: int
    next_s: float
    refusal: str = ""


@dataclass(frozen=True, slots=True)
class Authority:
    """The state. `refusal` says why the last request was not granted: what the train waits for."""

    unit_id: str
    manager_id: str
    held: tuple[Held, ...] = ()
    token: int = 0
    on_line: bool = False  # signed on and not signed off
    sign_on: SignOn | None = None
    sign_off: SignOff | None = None
    next_sign_s: float = NEVER
    asked: Route | None = None
    next_ask_s: float = NEVER
    refusal: str = ""
    commands: tuple[Command, ...] = ()
    proven: tuple[PointsNeeded, ...] = ()
    report_due: bool = False
    next_report_s: float = NEVER
    correlation: int = 0  # of the newest request; each open request keeps its own
    sign_correlation: int = 0
    ask_correlation: int = 0
    report_correlation: int = 0

    def holds(self, section_id: str) -> bool:
        """Whether the unit holds a section."""
        return any(held.section_id == section_id for held in self.held)

    def section_ids(self) -> tuple[str, ...]:
        """Sections held, in order of travel."""
        return tuple(held.section_id for held in self.held)

    def next_timer_s(self) -> float:
        """When the machine wants a Tick; NEVER if it waits for nothing."""
        times = [self.next_sign_s, self.next_ask_s, self.next_report_s]
        return min([*times, *(command.next_s for command in self.commands)])


@dataclass(frozen=True, slots=True)
class BeginOnLine:
    """The train has come onto the line, or has been switched on, and claims these sections."""

    section_ids: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EndOnLine:
    """The train leaves the line; it holds nothing but its portal."""


@dataclass(frozen=True, slots=True)
class Ask:
    """Ask for a route (閉そく確保要求)."""

    route: Route


@dataclass(frozen=True, slots=True)
class Throw:
    """Command points inside what is held (転換指示)."""

    points: tuple[PointsNeeded, ...]


@dataclass(frozen=True, slots=True)
class Cleared:
    """The safe rear has left these sections."""

    section_ids: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TurnedBack:
    """The train changed ends: what was behind is ahead; proofs made for the old path are forgotten."""


@dataclass(frozen=True, slots=True)
class Heard:
    """An authentic telegram."""

    source: str
    message: AnyMessage
    fresh: bool


@dataclass(frozen=True, slots=True)
class Tick:
    """A timer is due, or the radio reaches again."""


Event = BeginOnLine | EndOnLine | Ask | Throw | Cleared | TurnedBack | Heard | Tick


@dataclass(frozen=True, slots=True)
class Send:
    """Send a telegram."""

    destination: str
    message: AnyMessage
    correlation: int


@dataclass(frozen=True, slots=True)
class Noted:
    """Something for the journal."""

    what: str
    data: Mapping[str, Any]


Action = Send | Noted
Result = tuple[Authority, tuple[Action, ...]]


def step(state: Authority, event: Event, now_s: float, covered: bool) -> Result:
    """Next state and what to do. An event that does not fit the state changes nothing."""
    return _EVENTS[type(event)](state, event, now_s, covered)


def _begin(state: Authority, event: BeginOnLine, now_s: float, covered: bool) -> Result:
    held = tuple(Held(section_id, 0) for section_id in event.section_ids)
    begun = replace(
        _counted(state),
        held=held,
        sign_on=SignOn(state.unit_id, event.section_ids),
        sign_off=None,
        next_sign_s=now_s,
        sign_correlation=state.correlation + 1,
    )
    return _due(begun, now_s, covered, (_holds(begun),))


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
    turned = replace(state, held=state.held[::-1], commands=(), proven=())
    return turned, (_holds(turned),)


def _heard(state: Authority, event: Heard, now_s: float, covered: bool) -> Result:
    handler = _HEARD.get(type(event.message))
    return (state, ()) if handler is None else handler(state, event, now_s, covered)


def _tick(state: Authority, _event: Tick, now_s: float, covered: bool) -> Result:
    return _due(state, now_s, covered)


def _counted(state: Authority) -> Authority:
    return replace(state, correlation=state.correlation + 1)


def _holds(state: Authority) -> Noted:
    return Noted("holds", {"sections": state.section_ids(), "token": state.token})


def _throw(state: Authority, event: Throw, now_s: float, covered: bool) -> Result:
    under_way = {command.needed for command in state.commands} | set(state.proven)
    new: list[Command] = []
    for needed in event.points:
        held = next((h for h in state.held if h.section_id == needed.section_id), None)
        if held is None or not held.mac or needed in under_way:
            continue
        state = _counted(state)
        new.append(Command(needed, held.token, held.mac, state.correlation, now_s))
    return _due(replace(state, commands=(*state.commands, *new)), now_s, covered)


def _cleared(state: Authority, event: Cleared, now_s: float, covered: bool) -> Result:
    section_ids = event.section_ids
    kept = tuple(held for held in state.held if held.section_id not in section_ids)
    if len(kept) == len(state.held):
        return state, ()
    dropped = replace(
        _counted(state),
        held=kept,
        proven=tuple(needed for needed in state.proven if needed.section_id not in section_ids),
        commands=tuple(c for c in state.commands if c.needed.section_id not in section_ids),
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
        actions.append(Noted("reported", {"sections": state.section_ids(), "token": state.token}))
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


def _sign_on_accepted(state: Authority, event: Heard, _now_s: float, _covered: bool) -> Result:
    message = event.message
    if not isinstance(message, SignOnAccepted) or state.sign_on is None:
        return state, ()
    macs = {capability.section_id: capability.mac for capability in message.capabilities}
    accepted = replace(
        state,
        held=tuple(Held(s, message.token, macs.get(s, b"")) for s in message.section_ids),
        token=message.token,
        on_line=True,
        sign_on=None,
        next_sign_s=NEVER,
    )
    return accepted, (Noted("signed_on", {"sections": message.section_ids}), _holds(accepted))


def _sign_on_refused(state: Authority, event: Heard, now_s: float, _covered: bool) -> Result:
    message = event.message
    if not isinstance(message, SignOnRefused) or state.sign_on is None:
        return state, ()
    waiting = replace(state, next_sign_s=now_s + REFUSED_REPEAT_S, refusal=_why(message))
    return waiting, (Noted("sign_on_refused", {"why": waiting.refusal}),)


def _sign_off_answer(state: Authority, event: Heard, now_s: float, _covered: bool) -> Result:
    if state.sign_off is None:
        return state, ()
    if isinstance(event.message, SignOffRefused):
        why = event.message.reason.name
        return replace(state, next_sign_s=now_s + REFUSED_REPEAT_S), (
            Noted("sign_off_refused", {"why": why}),
        )
    gone = replace(state, held=(), on_line=False, sign_off=None, next_sign_s=NEVER)
    return gone, (Noted("signed_off", {}), _holds(gone))


def _granted(state: Authority, event: Heard, _now_s: float, _covered: bool) -> Result:
    message = event.message
    if not isinstance(message, RouteGranted) or state.asked is None:
        return state, ()
    if (
        message.route_id != state.asked.id
        or message.section_ids != state.asked.section_ids
        or not event.fresh
    ):
        return state, ()
    macs = {capability.section_id: capability.mac for capability in message.capabilities}
    new = tuple(Held(s, message.token, macs.get(s, b"")) for s in message.section_ids if not state.holds(s))
    granted = replace(
        state, held=(*state.held, *new), token=message.token, asked=None, next_ask_s=NEVER, refusal=""
    )
    note = Noted("route_held", {"route": message.route_id, "token": message.token})
    return granted, (note, _holds(granted))


def _refused(state: Authority, event: Heard, now_s: float, _covered: bool) -> Result:
    message = event.message
    if not isinstance(message, RouteRefused) or state.asked is None or message.route_id != state.asked.id:
        return state, ()
    refusal = _why(message)
    notes = (
        () if refusal == state.refusal else (Noted("refused", {"route": message.route_id, "why": refusal}),)
    )
    again = replace(
        _counted(state),
        next_ask_s=now_s + REFUSED_REPEAT_S,
        refusal=refusal,
        ask_correlation=state.correlation + 1,
    )
    return again, notes


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
    for command in state.commands:
        needed = command.needed
        if needed.points_id != message.points_id or event.source != needed.terminal_id:
            continue
        if not good or message.position is not needed.position or message.token != command.token:
            return state, ()
        proven = replace(
            state,
            commands=tuple(c for c in state.commands if c is not command),
            proven=(*state.proven, needed),
        )
        data = {"points": needed.points_id, "position": needed.position.value, "token": command.token}
        return proven, (Noted("proven", data),)
    lost = [n for n in state.proven if n.points_id == message.points_id and n.terminal_id == event.source]
    if not lost or (good and message.position is lost[0].position):
        return state, ()
    dropped = replace(state, proven=tuple(n for n in state.proven if n not in lost))
    return dropped, (Noted("proof_dropped", {"points": message.points_id}),)


def _points_refused(state: Authority, event: Heard, now_s: float, _covered: bool) -> Result:
    message = event.message
    if not isinstance(message, PointsRefused):
        return state, ()
    why = message.reason.name.lower().replace("_", " ")
    commands: list[Command] = []
    notes: list[Action] = []
    for command in state.commands:
        mine = command.needed.points_id == message.points_id and command.token == message.token
        if mine and command.refusal != why:
            notes.append(Noted("points_refused", {"points": message.points_id, "why": why}))
        commands.append(replace(command, next_s=now_s + REFUSED_REPEAT_S, refusal=why) if mine else command)
    return replace(state, commands=tuple(commands)), tuple(notes)


def _confirmed(state: Authority, event: Heard, now_s: float, covered: bool) -> Result:
    message = event.message
    if not isinstance(message, HoldingConfirmed) or not state.report_due:
        return state, ()
    if set(message.section_ids) != set(state.section_ids()):
        return state, ()
    done = replace(state, token=max(state.token, message.token), report_due=False, next_report_s=NEVER)
    return _due(done, now_s, covered)


def _claim_query(state: Authority, _event: Heard, _now_s: float, _covered: bool) -> Result:
    sections = state.section_ids() if state.on_line or state.held else ()
    return state, (
        Send(state.manager_id, Claim(sections, state.token), state.correlation),
        Noted("claimed", {"sections": sections, "token": state.token}),
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
    Cleared: _cleared,
    TurnedBack: _turned_back,
    Heard: _heard,
    Tick: _tick,
}
