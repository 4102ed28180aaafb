"""Invariant: a section has at most one holder; while any registered unit is unknown or disputed nothing is
granted; a section is freed only by its holder's own report (same boot, current token), by its holder's train having
left the line, or by a person's entry. Silence, a lease or a timeout never frees anything.

The block manager (閉そく管理装置) of Sugiyama et al. 2017, sections 2.1 (1) and 4.4, as a pure machine:
`step(register, event, now_s) -> (register, actions)`. A route is granted whole or not at all. Tokens are
(boot << 32) + counter: they grow with every grant and over restarts.

Re-entry after a restart (the open problem of section 5 and 4.4 (4)): the manager asks every unknown unit; a
claim counts only if its sender has heard this boot, so no claim from before the restart does. Claims and
sign-ons add to the register and never free. A claim against another holder, or of what a person entered for
another, is shown, its sender is DISPUTED, and nothing is granted until the other releases or the person
corrects the entry; so a wrong entry shows as soon as the unit speaks. What persons may enter is in
`wayside.acts`, when the line is defined again in `wayside.reentry`.

A sign-off frees nothing: from then on the unit is LEAVING, and its portal is its own until the contact at the boundary
has counted its train out, or the unit itself, in the boot that signed off, says that it holds nothing.

`TELEGRAMS` is the whole table of telegrams; what it does not name is refused and changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final, TypeVar

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
    SignOnAccepted,
    TrackOrdered,
    TrainOrdered,
)
from radio.table import TableCell, rows
from wayside import acts, bidden, cutting, dispatch, entering, leaving, orders, reentry, reports
from wayside.actions import Action, Send, Show
from wayside.dispatch import DispatchRequest
from wayside.heard import (
    Heard,
    challenge,
    has_heard,
    is_to_hear,
    newly_contested,
    refuse_claim,
    show_refusal,
    tell_contested,
)
from wayside.reentry import Step
from wayside.register import Against, Register, RegisteredUnit, UnitStanding
from wayside.said import (
    Accepted,
    BoundaryPassed,
    Contradicted,
    EndTrain,
    Granted,
    LetGo,
    LetWait,
    Outside,
    Refused,
)

M = TypeVar("M")

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
    register, over = bidden.settled(before, register)
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


def _sign_on(register: Register, heard: Heard[SignOn]) -> Step:
    """A claim: added if nobody else holds it, else disputed. A portal it does not hold yet: a wish to enter."""
    if heard.message.unit_id != heard.unit_id:
        return refuse_claim(register, heard, RefusalReason.WRONG_UNIT)
    standing, claimed = register.unit(heard.unit_id).standing, heard.message.section_ids
    # Of a unit known to be outside, even an old wish to enter is only a wish; and a unit that reports is only added to.
    outside = standing is UnitStanding.OUTSIDE and register.asks_to_enter(heard.unit_id, claimed or ())
    if not (heard.fresh or outside or standing in (UnitStanding.REPORTED, UnitStanding.LEAVING)):
        return challenge(register, heard)
    return _take_claim(register, heard)


def _claim(register: Register, heard: Heard[Claim]) -> Step:
    """Added if fresh and nobody else holds it, else asked again or disputed; empty: outside; unknown: nothing."""
    if not heard.fresh:
        return challenge(register, heard)
    if leaving.may_have_crossed(register, heard):
        left = leaving.left_before(register, heard.message.section_ids or ())
        return register, (Send(heard.unit_id, ClaimQuery(), left),)
    return _take_claim(register, heard)


def _take_claim(register: Register, heard: Heard[SignOn] | Heard[Claim]) -> Step:
    unit_id, claimed = heard.unit_id, heard.message.section_ids
    if heard.message.token > register.token_max:
        return _never_granted(register, heard)
    unit = register.unit(unit_id)
    if claimed is None and (isinstance(heard.message, Claim) or not reentry.known(register, unit_id)):
        return _does_not_know(register, heard)
    if claimed == () and leaving.has_left(register, heard):
        return leaving.left_line(register, unit_id)
    if claimed == () and unit.standing is UnitStanding.BY_HAND:
        return _deny_entry(register, heard)
    if unknown := [section_id for section_id in claimed or () if section_id not in register.plan.order]:
        return refuse_claim(register, heard, RefusalReason.UNKNOWN_SECTION, unknown[0])
    return _weigh_claim(register, heard, claimed or ())


def _weigh_claim(register: Register, heard: Heard[SignOn] | Heard[Claim], claimed: tuple[str, ...]) -> Step:
    unit_id = heard.unit_id
    unit = register.unit(unit_id)
    conflict = register.other_holder(unit_id, claimed)
    if _wishes(register, heard, claimed):
        # Where it was last known on the line, a wish may as well be its place: let the claim tell.
        lost = unit.standing is UnitStanding.UNKNOWN and unit_id in register.ledger
        return challenge(register, heard) if lost else _enter(register, heard, claimed, conflict)
    conflict = conflict or reentry.entered_for_another(register, unit_id, claimed)
    if conflict is not None:
        free = [section_id for section_id in claimed if register.holders.get(section_id, unit_id) == unit_id]
        register = register.with_held(unit_id, (*register.held_by(unit_id), *free))
        leaves = isinstance(heard.message, LeavingClaim)
        disputed = replace(unit, standing=UnitStanding.DISPUTED, claim=claimed, leaves=leaves)
        disputed = replace(disputed, epoch=heard.epoch, counted_out=leaving.counted_out(unit, heard))
        register = register.with_unit(unit_id, disputed)
        section_id, other_id = conflict
        shown = Contradicted(unit_id=unit_id, section_ids=(section_id,), token=unit.token, other_id=other_id)
        register, refusal = refuse_claim(register, heard, RefusalReason.HELD, section_id, other_id)
        return register, (Show(shown), *refusal)
    return _accept_claim(register, heard, claimed)


def _does_not_know(register: Register, heard: Heard[SignOn] | Heard[Claim]) -> Step:
    """Nobody knows what it holds: refused. One that counts as outside signs on so only where that is wrong; what one in
    dispute has claimed, it does not know any more. Of one that persons speak for, its claim says that it has heard of
    nothing since, and their word stands: what it sends from now on is no word from before theirs.
    """
    unit = register.unit(heard.unit_id)
    standing = unit.standing
    if isinstance(heard.message, Claim) and standing not in (UnitStanding.UNKNOWN, UnitStanding.DISPUTED):
        answered = unit.claim_needed and unit.epoch == heard.epoch
        return (
            register.with_unit(heard.unit_id, replace(unit, claim_needed=False)) if answered else register
        ), ()
    if standing is UnitStanding.DISPUTED:
        register = reentry.unheard(register, heard.unit_id)
    register, shown = reentry.on_line_after_all(register, heard.unit_id, heard.epoch)
    register, refusal = refuse_claim(register, heard, RefusalReason.CLAIM_NEEDED)
    return register, (*shown, *refusal)


def _deny_entry(register: Register, heard: Heard[SignOn] | Heard[Claim]) -> Step:
    """It says that it is outside, persons say it holds something: it would never report, so persons must."""
    unit_id = heard.unit_id
    why = "entered by hand, says it is outside"
    shown = Contradicted(unit_id=unit_id, section_ids=register.held_by(unit_id), why=why)
    register, refusal = refuse_claim(register, heard, RefusalReason.CLAIM_NEEDED)
    return register, (Show(shown), *refusal)


def _never_granted(register: Register, heard: Heard[SignOn] | Heard[Claim]) -> Step:
    """A token that no boot gave contradicts this unit alone: that is shown, and its claim refused.

    But where nobody knows what it holds, what it claims may be so, and is taken without the token.
    """
    unit_id, token, claimed = heard.unit_id, heard.message.token, heard.message.section_ids
    shown = Show(Contradicted(unit_id=unit_id, token=token, why="a token that was never granted"))
    if claimed and register.unit(unit_id).standing is UnitStanding.UNKNOWN:
        register, actions = _take_claim(register, replace(heard, message=replace(heard.message, token=0)))
    else:
        register = replace(register, ledger=register.ledger | {unit_id})  # two persons must say where it is
        register, actions = refuse_claim(register, heard, RefusalReason.UNKNOWN_TOKEN)
    return register, (shown, *actions)


def _wishes(register: Register, heard: Heard[SignOn] | Heard[Claim], claimed: tuple[str, ...]) -> bool:
    """Whether it only wants to enter. Who was never on the line cannot claim a portal, whatever it sends."""
    stranger = register.restoring and heard.unit_id not in register.ledger
    return (isinstance(heard.message, SignOn) or stranger) and register.asks_to_enter(heard.unit_id, claimed)


def _enter(
    register: Register, heard: Heard[Any], portals: tuple[str, ...], conflict: tuple[str, str] | None
) -> Step:
    """A wish, not a fact: it shows that an unknown unit is outside, and needs a defined line and a free portal."""
    unit_id = heard.unit_id
    shows: tuple[Action, ...] = ()
    if register.unit(unit_id).standing is UnitStanding.UNKNOWN:
        register = register.with_unit(unit_id, RegisteredUnit(UnitStanding.OUTSIDE, heard.epoch))
        shows = (Show(Outside(unit_id=unit_id, was=UnitStanding.UNKNOWN.value)),)
    against: Against | None = None
    if not register.defined:
        against = (RefusalReason.UNDEFINED, None, (*register.undefined_because_of(), None)[0])
    elif conflict is not None:
        against = (RefusalReason.HELD, *conflict)
    else:
        register, waits = bidden.heard(register, unit_id, "", register.now_s)
        against = None if isinstance(waits, TrainOrdered) else waits
    asked = DispatchRequest(unit_id, portal=next(iter(portals), ""))
    register, against, shown = dispatch.weigh_request(register, asked, against)
    if against is None:
        register, actions = _accept_claim(register, heard, portals)
    else:
        register, actions = refuse_claim(register, heard, *against)
    return register, (*shows, *shown, *actions)


def _accept_claim(register: Register, heard: Heard[SignOn] | Heard[Claim], claimed: tuple[str, ...]) -> Step:
    unit_id = heard.unit_id
    unit, before = register.unit(unit_id), register.held_by(unit_id)
    said = reentry.said_outside if not claimed and isinstance(heard.message, Claim) else acts.speaks
    register, shown = said(register, unit_id)
    added = tuple(section_id for section_id in claimed if section_id not in before)
    register = register.with_held(unit_id, (*before, *added))
    held, token = register.held_by(unit_id), max(unit.token, heard.message.token)
    # What it claims may have been another's since, who then commanded points in it under a greater token.
    lost = not register.restoring and (bool(added) or unit.standing is not UnitStanding.REPORTED)
    if held and (lost or token == 0 or token > register.token_max):
        register, token = register.next_token()
    standing = leaving.claimed_standing(register, heard.message, held)
    # A unit that has started again numbers its requests anew, so its old request cannot be repeated.
    correlation = unit.correlation if heard.epoch == unit.epoch else 0
    after = RegisteredUnit(standing, heard.epoch, token, unit.route_id, correlation)
    unproven = not held and (bool(shown) or unit.unproven)
    to_give_back = isinstance(heard.message, Claim) and 0 < len(claimed) < len(held)
    needed = (lost or unit.claim_needed) and is_to_hear(heard, after)
    after = replace(after, unproven=unproven, silent=to_give_back, claim_needed=needed)
    after = replace(after, counted_out=leaving.counted_out(unit, heard))
    after = entering.carried_over(unit, after, held)
    register = register.with_unit(unit_id, after)
    actions, was = list[Action](shown), unit.standing.value
    if added or after.standing is not unit.standing or after.epoch != unit.epoch:
        taken = Accepted(unit_id=unit_id, section_ids=held, token=token, was=was)
        actions.append(Show(taken if held else Outside(unit_id=unit_id, token=token, was=was)))
        actions += reentry.shown_against(register, unit_id)
    capabilities = register.capabilities(unit_id, held, token)
    accepted = SignOnAccepted(held, token, after.route_id, capabilities, register.on_sight(held))
    return register, (*actions, Send(unit_id, accepted, heard.correlation))


def _sign_on_leaving(register: Register, heard: Heard[SignOn]) -> Step:
    """Still in its portal, it is on the line again; one that wishes to enter elsewhere is asked whether it has left."""
    if register.asks_to_enter(heard.unit_id, heard.message.section_ids or ()) and heard.message.section_ids:
        return challenge(register, heard)
    return _sign_on(register, heard)


def _claim_leaving(register: Register, heard: Heard[Claim]) -> Step:
    """Empty: its train may have left. Its portal alone: not yet. Else as any claim."""
    unit_id, claimed = heard.unit_id, heard.message.section_ids
    same_boot = heard.epoch == register.unit(unit_id).epoch
    if not heard.fresh:
        return challenge(register, heard)
    if claimed == ():
        return leaving.says_gone(register, heard)
    if same_boot and claimed == register.held_by(unit_id):
        return register, ()
    return _take_claim(register, heard)


def _not_for_manager(register: Register, heard: Heard[Any]) -> Step:
    return register, (Show(Refused(unit_id=heard.unit_id, why=type(heard.message).__name__)),)


_Handler = Callable[[Register, Heard[Any]], Step]

TELEGRAMS: Final[Mapping[tuple[UnitStanding, type], _Handler]] = MappingProxyType(
    {
        (UnitStanding.UNKNOWN, RouteRequest): _request_undefined,
        (UnitStanding.UNKNOWN, HoldingReport): challenge,
        (UnitStanding.UNKNOWN, OrderRefused): challenge,
        (UnitStanding.UNKNOWN, NextTrainReport): challenge,
        (UnitStanding.UNKNOWN, SignOn): _sign_on,
        (UnitStanding.UNKNOWN, SignOff): leaving.sign_off_not_signed_on,
        (UnitStanding.UNKNOWN, Claim): _claim,
        (UnitStanding.UNKNOWN, LeavingClaim): _claim,
        (UnitStanding.OUTSIDE, RouteRequest): _request_not_signed_on,
        (UnitStanding.OUTSIDE, HoldingReport): challenge,
        (UnitStanding.OUTSIDE, OrderRefused): challenge,
        (UnitStanding.OUTSIDE, NextTrainReport): challenge,
        (UnitStanding.OUTSIDE, SignOn): _sign_on,
        (UnitStanding.OUTSIDE, SignOff): leaving.sign_off_again,
        (UnitStanding.OUTSIDE, Claim): _claim,
        (UnitStanding.OUTSIDE, LeavingClaim): _claim,
        (UnitStanding.BY_HAND, RouteRequest): _request_not_signed_on,
        (UnitStanding.BY_HAND, HoldingReport): challenge,
        (UnitStanding.BY_HAND, OrderRefused): challenge,
        (UnitStanding.BY_HAND, NextTrainReport): challenge,
        (UnitStanding.BY_HAND, SignOn): _sign_on,
        (UnitStanding.BY_HAND, SignOff): leaving.sign_off_not_signed_on,
        (UnitStanding.BY_HAND, Claim): _claim,
        (UnitStanding.BY_HAND, LeavingClaim): _claim,
        (UnitStanding.REPORTED, RouteRequest): _request,
        (UnitStanding.REPORTED, HoldingReport): reports.report,
        (UnitStanding.REPORTED, OrderRefused): orders.refused,
        (UnitStanding.REPORTED, NextTrainReport): reports.next_train,
        (UnitStanding.REPORTED, SignOn): _sign_on,
        (UnitStanding.REPORTED, SignOff): leaving.sign_off,
        (UnitStanding.REPORTED, Claim): _claim,
        (UnitStanding.REPORTED, LeavingClaim): _claim,
        (UnitStanding.LEAVING, RouteRequest): _request_not_signed_on,
        (UnitStanding.LEAVING, HoldingReport): reports.report,
        (UnitStanding.LEAVING, OrderRefused): orders.refused,
        (UnitStanding.LEAVING, NextTrainReport): reports.next_train,
        (UnitStanding.LEAVING, SignOn): _sign_on_leaving,
        (UnitStanding.LEAVING, SignOff): leaving.sign_off,
        (UnitStanding.LEAVING, Claim): _claim_leaving,
        (UnitStanding.LEAVING, LeavingClaim): _claim_leaving,
        (UnitStanding.DISPUTED, RouteRequest): _request_undefined,
        (UnitStanding.DISPUTED, HoldingReport): challenge,
        (UnitStanding.DISPUTED, OrderRefused): challenge,
        (UnitStanding.DISPUTED, NextTrainReport): challenge,
        (UnitStanding.DISPUTED, SignOn): _sign_on,
        (UnitStanding.DISPUTED, SignOff): leaving.sign_off_not_signed_on,
        (UnitStanding.DISPUTED, Claim): _claim,
        (UnitStanding.DISPUTED, LeavingClaim): _claim,
    }
)


def table_rows() -> tuple[TableCell, ...]:
    """Standing of the unit and telegram, then phase, standing and input of a person, for the documentation."""
    return (*rows(TELEGRAMS), *rows(acts.UNIT_ACTS), *rows(acts.LINE_ACTS))
