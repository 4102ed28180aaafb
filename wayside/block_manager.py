"""Invariant: a section has at most one holder; while any registered unit is unknown or disputed nothing is
granted; a section is freed only by its holder's own report (same boot, current token), by its holder's train having
left the line, or by a person's entry. Silence, a lease or a timeout never frees anything.

The block manager (閉そく管理装置) of Sugiyama et al. 2017, sections 2.1 (1) and 4.4, as a pure machine:
`step(register, event, now_s) -> (register, actions)`. A route is granted whole or not at all. Tokens are
(boot << 32) + counter: they grow with every grant and over restarts.

Re-entry after a restart (the open problem of section 5 and 4.4 (4)): the manager asks every unknown unit. What
becomes of what units then say is in `wayside.claims`, what persons may enter in `wayside.acts`, and when the line is
defined again in `wayside.reentry`.

A sign-off frees nothing: from then on the unit is LEAVING, and its portal is its own until the contact at the boundary
has counted its train out, or the unit itself, in the boot that signed off, says that it holds nothing.

`TELEGRAMS` is the whole table of telegrams; what it does not name is refused and changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

from msgspec.structs import replace

from radio.messages import (
    AnyMessage,
    Claim,
    ClaimQuery,
    HoldingReport,
    LeavingClaim,
    NextTrainReport,
    OrderRefused,
    RefusalReason,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    SignOff,
    SignOn,
    TrackOrdered,
)
from radio.table import TableCell, rows
from wayside import acts, bidden, claims, cutting, dispatch, entering, leaving, orders, reentry, reports
from wayside.actions import Action, Send, Show
from wayside.dispatch import DispatchRequest
from wayside.heard import (
    Heard,
    challenge,
    has_heard,
    newly_contested,
    show_refusal,
    tell_contested,
)
from wayside.reentry import Step
from wayside.register import Against, Register, UnitStanding
from wayside.said import (
    BoundaryPassed,
    EndTrain,
    Granted,
    LetGo,
    LetWait,
    Refused,
)

__all__ = ["TELEGRAMS", "AskUnits", "Event", "Heard", "step", "table_rows", "wake_at_s"]


@dataclass(frozen=True, slots=True)
class AskUnits:
    """Look whether it is time to ask the units that block the line what they hold."""


Event = Heard[AnyMessage] | acts.Act | bidden.Bid | BoundaryPassed | AskUnits


def step(register: Register, event: Event, now_s: float) -> Step:
    """The next register and what to do. Never raises for what a unit or an operator sends."""
    started_s = now_s if register.started_s is None else register.started_s
    before = register = replace(register, started_s=started_s)
    if isinstance(event, AskUnits):
        return _ask(register, now_s)
    match event:
        case Heard():
            register, actions = _heard(register, event, now_s)
        case LetWait() | LetGo() | EndTrain():
            register, actions = bidden.bid(register, event, now_s)
        case BoundaryPassed(section_id):
            register, actions = leaving.boundary_passed(register, section_id)
        case _:
            register, actions = acts.act(register, event, now_s)
    register = leaving.asked_later(before, register, now_s)
    register, following = reentry.settle(register, now_s)
    register, over = bidden.settled(register)
    return register, (*actions, *following, *over, *newly_contested(before, register))


def wake_at_s(register: Register) -> float | None:
    """When the manager wants to ask again; None while the line is defined and every unit speaks for itself."""
    return register.ask_at_s if register.units_asked() or register.in_dispute else None


def _heard(register: Register, heard: Heard[AnyMessage], now_s: float) -> Step:
    if heard.unit_id not in register.plan.unit_ids:
        return register, (Show(Refused(unit_id=heard.unit_id, why="not on the fleet list")),)
    if heard.unit_id in register.bars.barred:
        return register, (Show(Refused(unit_id=heard.unit_id, why="barred")),)
    if register.restoring:
        heard_s = {**register.reentry.heard_s, heard.unit_id: now_s}
        register = replace(register, reentry=replace(register.reentry, heard_s=heard_s))
    register, taken_back = acts.spoke(register, heard.unit_id, heard.epoch, heard.message)
    if register.days is not None or register.bidden:
        register = replace(register, now_s=now_s)
    register = has_heard(register, heard)
    unit = register.unit(heard.unit_id)
    if unit.claim_needed and heard.epoch <= unit.epoch and not isinstance(heard.message, Claim):
        return register, (*taken_back, Send(heard.unit_id, ClaimQuery(), heard.correlation))
    row = unit.standing, type(heard.message)
    register, actions = TELEGRAMS.get(row, _not_for_manager)(register, heard)
    if isinstance(heard.message, NextTrainReport | OrderRefused):
        register = bidden.answered(register, heard.unit_id)
    return register, (*taken_back, *actions)


def _ask(register: Register, now_s: float) -> Step:
    asked = register.units_asked()
    if not (asked or register.in_dispute) or now_s < register.ask_at_s:
        return register, ()
    in_vain = {unit_id: times + 1 for unit_id, times in register.doubted.items()}
    register = replace(register, ask_at_s=now_s + register.plan.ask_interval_s, doubted=in_vain)
    return register, (*(Send(unit_id, ClaimQuery()) for unit_id in asked), *tell_contested(register))


def _request(register: Register, heard: Heard[RouteRequest]) -> Step:
    """Granted whole if the line is defined and all of it free or its own, or a part (`wayside.parts`); else refused."""
    held = register.held_by(heard.unit_id)
    register = cutting.followed_cut(register, heard.unit_id, heard.message.route_id)
    register, instead = orders.followed(register, heard.unit_id, heard.message.route_id)
    if instead:
        order = TrackOrdered(heard.message.route_id, instead)
        return register, (Send(heard.unit_id, order, heard.correlation),)
    refused = against = _against(register, heard, frozenset(held))
    wanted, part = (
        heard.message.section_ids,
        dispatch.part_to_grant(register, heard.unit_id, heard.message, against),
    )
    shown, more = tuple[Action, ...](), tuple[Action, ...]()
    if part:  # what keeps a whole route back keeps its beginning back, too
        wanted, against = part, None
    asks = replace(heard.message, section_ids=wanted)
    register, against, ends = bidden.weighed(register, heard.unit_id, asks, against)
    if ends is not None:
        return register, (Send(heard.unit_id, ends, heard.correlation),)
    register, against, leave = entering.weighed(register, heard.unit_id, asks, against)
    asked = DispatchRequest(heard.unit_id, heard.message.route_id)
    if part and against is None:
        register, part, shown = dispatch.weigh_part(register, asked, part)
        against = None if part else refused
    if not (leave or (part and against is None)) and (against is not None or not set(wanted) <= set(held)):
        decision = orders.decide(register, asked, against)
        register, against, more = decision.register, decision.against, decision.actions
        if decision.order is not None:
            return register, (*shown, *more, Send(heard.unit_id, decision.order, heard.correlation))
    answer = _grant(register, heard, wanted) if against is None else _refuse_route(register, heard, *against)
    return answer[0], (*shown, *more, *answer[1])


def _against(register: Register, heard: Heard[RouteRequest], held: frozenset[str]) -> Against | None:
    """Why the route may not be granted, and the section and unit in the way; or None."""
    message, unit_id = heard.message, heard.unit_id
    route = register.plan.routes.get(message.route_id)
    blocking = register.undefined_because_of()
    against: Against | None = None
    if message.unit_id != unit_id:
        against = (RefusalReason.WRONG_UNIT, None, None)
    elif heard.epoch != register.unit(unit_id).epoch:
        against = (RefusalReason.NOT_SIGNED_ON, None, None)
    elif not register.defined:
        against = (RefusalReason.UNDEFINED, None, blocking[0] if blocking else None)
    elif route is None or not route.has_part(message.section_ids):
        against = (RefusalReason.UNKNOWN_ROUTE, None, None)
    elif held.isdisjoint(route.leads_to(message.section_ids)):
        against = (RefusalReason.NOT_CONNECTED, route.from_section, None)
    elif (conflict := register.other_holder(unit_id, message.section_ids)) is not None:
        against = (RefusalReason.HELD, *conflict)
    return against


def _grant(register: Register, heard: Heard[RouteRequest], section_ids: tuple[str, ...]) -> Step:
    message, unit_id = heard.message, heard.unit_id
    register = entering.leave_given(register, unit_id, register.plan.routes[message.route_id], section_ids)
    unit, held = register.unit(unit_id), register.held_by(unit_id)
    same_request = (unit.route_id, unit.correlation) == (message.route_id, heard.correlation)
    repeated = heard.correlation > 0 and same_request and set(section_ids) <= set(held)
    actions: list[Action] = []
    if not repeated:
        register, token = register.next_token()
        unit = replace(unit, token=token, route_id=message.route_id, correlation=heard.correlation)
        register = register.with_held(unit_id, (*held, *section_ids)).with_unit(unit_id, unit)
        note = Granted(unit_id=unit_id, section_ids=section_ids, token=token, route_id=message.route_id)
        actions.append(Show(note))
    capabilities = register.capabilities(unit_id, section_ids, unit.token)
    on_sight = register.on_sight(section_ids)
    granted = RouteGranted(message.route_id, section_ids, unit.token, capabilities, on_sight)
    return register, (*actions, Send(unit_id, granted, heard.correlation))


def _refuse_route(
    register: Register,
    heard: Heard[RouteRequest],
    reason: RefusalReason,
    section_id: str | None = None,
    holder: str | None = None,
) -> Step:
    refused = RouteRefused(heard.message.route_id, reason, section_id, holder)
    return register, (
        show_refusal(heard.unit_id, reason, section_id, holder),
        Send(heard.unit_id, refused, heard.correlation),
    )


def _request_undefined(register: Register, heard: Heard[RouteRequest]) -> Step:
    """Refused, and asked what it holds."""
    _, refusal = _refuse_route(register, heard, RefusalReason.UNDEFINED, holder=heard.unit_id)
    return register, (*refusal, Send(heard.unit_id, ClaimQuery(), heard.correlation))


def _request_not_signed_on(register: Register, heard: Heard[RouteRequest]) -> Step:
    """Refused: the unit must sign on first."""
    return _refuse_route(register, heard, RefusalReason.NOT_SIGNED_ON)


def _not_for_manager(register: Register, heard: Heard[Any]) -> Step:
    return register, (Show(Refused(unit_id=heard.unit_id, why=type(heard.message).__name__)),)


_Handler = Callable[[Register, Heard[Any]], Step]

TELEGRAMS: Final[Mapping[tuple[UnitStanding, type], _Handler]] = MappingProxyType(
    {
        (UnitStanding.UNKNOWN, RouteRequest): _request_undefined,
        (UnitStanding.UNKNOWN, HoldingReport): challenge,
        (UnitStanding.UNKNOWN, OrderRefused): challenge,
        (UnitStanding.UNKNOWN, NextTrainReport): challenge,
        (UnitStanding.UNKNOWN, SignOn): claims.sign_on,
        (UnitStanding.UNKNOWN, SignOff): leaving.sign_off_not_signed_on,
        (UnitStanding.UNKNOWN, Claim): claims.claim,
        (UnitStanding.UNKNOWN, LeavingClaim): claims.claim,
        (UnitStanding.OUTSIDE, RouteRequest): _request_not_signed_on,
        (UnitStanding.OUTSIDE, HoldingReport): challenge,
        (UnitStanding.OUTSIDE, OrderRefused): challenge,
        (UnitStanding.OUTSIDE, NextTrainReport): challenge,
        (UnitStanding.OUTSIDE, SignOn): claims.sign_on,
        (UnitStanding.OUTSIDE, SignOff): leaving.sign_off_again,
        (UnitStanding.OUTSIDE, Claim): claims.claim,
        (UnitStanding.OUTSIDE, LeavingClaim): claims.claim,
        (UnitStanding.BY_HAND, RouteRequest): _request_not_signed_on,
        (UnitStanding.BY_HAND, HoldingReport): challenge,
        (UnitStanding.BY_HAND, OrderRefused): challenge,
        (UnitStanding.BY_HAND, NextTrainReport): challenge,
        (UnitStanding.BY_HAND, SignOn): claims.sign_on,
        (UnitStanding.BY_HAND, SignOff): leaving.sign_off_not_signed_on,
        (UnitStanding.BY_HAND, Claim): claims.claim,
        (UnitStanding.BY_HAND, LeavingClaim): claims.claim,
        (UnitStanding.REPORTED, RouteRequest): _request,
        (UnitStanding.REPORTED, HoldingReport): reports.report,
        (UnitStanding.REPORTED, OrderRefused): orders.refused,
        (UnitStanding.REPORTED, NextTrainReport): reports.next_train,
        (UnitStanding.REPORTED, SignOn): claims.sign_on,
        (UnitStanding.REPORTED, SignOff): leaving.sign_off,
        (UnitStanding.REPORTED, Claim): claims.claim,
        (UnitStanding.REPORTED, LeavingClaim): claims.claim,
        (UnitStanding.LEAVING, RouteRequest): _request_not_signed_on,
        (UnitStanding.LEAVING, HoldingReport): reports.report,
        (UnitStanding.LEAVING, OrderRefused): orders.refused,
        (UnitStanding.LEAVING, NextTrainReport): reports.next_train,
        (UnitStanding.LEAVING, SignOn): claims.sign_on_leaving,
        (UnitStanding.LEAVING, SignOff): leaving.sign_off,
        (UnitStanding.LEAVING, Claim): claims.claim_leaving,
        (UnitStanding.LEAVING, LeavingClaim): claims.claim_leaving,
        (UnitStanding.DISPUTED, RouteRequest): _request_undefined,
        (UnitStanding.DISPUTED, HoldingReport): challenge,
        (UnitStanding.DISPUTED, OrderRefused): challenge,
        (UnitStanding.DISPUTED, NextTrainReport): challenge,
        (UnitStanding.DISPUTED, SignOn): claims.sign_on,
        (UnitStanding.DISPUTED, SignOff): leaving.sign_off_not_signed_on,
        (UnitStanding.DISPUTED, Claim): claims.claim,
        (UnitStanding.DISPUTED, LeavingClaim): claims.claim,
    }
)


def table_rows() -> tuple[TableCell, ...]:
    """Standing of the unit and telegram, then phase, standing and input of a person, for the documentation."""
    return (*rows(TELEGRAMS), *rows(acts.UNIT_ACTS), *rows(acts.LINE_ACTS))
