"""Invariant: a claim or sign-on adds to the register and never frees, and counts only if its sender has heard this boot
of the manager, so that none from before a restart does.

One against another holder, or of what a person entered for another, is shown, its sender is DISPUTED, and nothing is
granted until the other releases or the person corrects the entry; so a wrong entry shows as soon as the unit speaks.
Handlers of the block manager (在線登録, sections 2.1 (1) and 4.4 of Sugiyama et al. 2017).
"""

from __future__ import annotations

from typing import Any

from msgspec.structs import replace

from radio.messages import (
    Claim,
    ClaimQuery,
    LeavingClaim,
    RefusalReason,
    SignOn,
    SignOnAccepted,
    TrainOrdered,
)
from wayside import acts, bidden, dispatch, entering, leaving, reentry
from wayside.actions import Action, Send, Show
from wayside.dispatch import DispatchRequest
from wayside.heard import Heard, challenge, is_to_hear, refuse_claim
from wayside.reentry import Step
from wayside.register import Against, Register, RegisteredUnit, UnitStanding
from wayside.said import Accepted, Contradicted, Outside


def sign_on(register: Register, heard: Heard[SignOn]) -> Step:
    """A claim: added if nobody else holds it, else disputed. A portal it does not hold yet: a wish to enter."""
    if heard.message.unit_id != heard.unit_id:
        return refuse_claim(register, heard, RefusalReason.WRONG_UNIT)
    standing, claimed = register.unit(heard.unit_id).standing, heard.message.section_ids
    # Of a unit known to be outside, even an old wish to enter is only a wish; and a unit that reports is only added to.
    outside = standing is UnitStanding.OUTSIDE and register.asks_to_enter(heard.unit_id, claimed or ())
    if not (heard.fresh or outside or standing in (UnitStanding.REPORTED, UnitStanding.LEAVING)):
        return challenge(register, heard)
    return _take_claim(register, heard)


def claim(register: Register, heard: Heard[Claim]) -> Step:
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
    by_hand = unit.standing is UnitStanding.BY_HAND or (unit.standing is UnitStanding.DISPUTED and unit.by)
    if claimed == () and by_hand and register.held_by(unit_id):
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
    """It says that it is outside, persons say it holds something: it would never report, so persons must; and what it
    has claimed against another it claims no more.
    """
    unit_id, unit = heard.unit_id, register.unit(heard.unit_id)
    by_hand = replace(unit, standing=UnitStanding.BY_HAND, claim=None, leaves=False, counted_out=False)
    register = register.with_unit(unit_id, by_hand)
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
    standing = leaving.claimed_standing(register, heard, held)
    # A unit that has started again numbers its requests anew, so its old request cannot be repeated.
    correlation = unit.correlation if heard.epoch == unit.epoch else 0
    after = RegisteredUnit(standing, heard.epoch, token, unit.route_id, correlation)
    unproven = not held and (bool(shown) or unit.unproven)
    to_give_back = 0 < len(claimed) < len(held)
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


def sign_on_leaving(register: Register, heard: Heard[SignOn]) -> Step:
    """Still in its portal, it is on the line again; one that wishes to enter elsewhere is asked whether it has left."""
    if register.asks_to_enter(heard.unit_id, heard.message.section_ids or ()) and heard.message.section_ids:
        return challenge(register, heard)
    return sign_on(register, heard)


def claim_leaving(register: Register, heard: Heard[Claim]) -> Step:
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
