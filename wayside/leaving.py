"""Invariant: a portal is its unit's until its train is known to have left the line: by the contact at the boundary,
which has counted it out, or by the unit's own word that it holds nothing, in the boot that signed off. Silence keeps
it. A unit that says after the contact that it is still in the portal is believed, as long as it says so: its portal is
its own again until it says that it holds nothing, in whatever boot, as two that know then say that it has left.

Signing off (在線抹消) in two steps, as handlers of the block manager: an answer may be lost, and a unit may lose its
power before it hears it; so the manager's acceptance says only that the train may leave.
"""

from __future__ import annotations

from typing import Final

from msgspec.structs import replace

from radio.messages import (
    Claim,
    LeavingClaim,
    RefusalReason,
    SignOff,
    SignOffAccepted,
    SignOffRefused,
    SignOn,
)
from wayside import reentry
from wayside.actions import Send, Show
from wayside.heard import Heard, show_refusal
from wayside.reentry import Step
from wayside.register import Register, RegisteredUnit, UnitStanding
from wayside.said import Contradicted, Freed, Leaving, Outside

FORGOTTEN_OR_GONE: Final = (
    "booted since it signed off, it says that it is outside: two persons must say so too"
)
_HOLDING: Final = (UnitStanding.REPORTED, UnitStanding.BY_HAND)


def sign_off(register: Register, heard: Heard[SignOff]) -> Step:
    """Its train may leave its portal, under the current token and boot; refused while it holds more."""
    message, unit_id = heard.message, heard.unit_id
    unit, held = register.unit(unit_id), register.held_by(unit_id)
    if message.unit_id != unit_id:
        return _refuse_sign_off(register, heard, RefusalReason.WRONG_UNIT)
    if heard.epoch != unit.epoch:
        return _refuse_sign_off(register, heard, RefusalReason.NOT_SIGNED_ON)
    if message.token != unit.token:
        return _refuse_sign_off(register, heard, RefusalReason.STALE_TOKEN)
    if not register.plan.portals.issuperset(held):
        return _refuse_sign_off(register, heard, RefusalReason.STILL_HOLDING)
    leaving = replace(unit, standing=UnitStanding.LEAVING)
    shows = () if unit == leaving else (Show(Leaving(unit_id=unit_id, section_ids=held, token=unit.token)),)
    register = register.with_unit(unit_id, leaving)
    return register, (*shows, Send(unit_id, SignOffAccepted(), heard.correlation))


def left_line(register: Register, unit_id: str) -> Step:
    """Its whole train is off the line: it holds nothing any more."""
    unit, held = register.unit(unit_id), register.held_by(unit_id)
    register = reentry.released(register.with_held(unit_id, ()), unit_id, held)
    # Entering again gives a new token, so nothing said before this counts then.
    register = register.with_unit(
        unit_id, RegisteredUnit(UnitStanding.OUTSIDE, unit.epoch, claim_needed=unit.claim_needed)
    )
    return register, (
        Show(Freed(unit_id=unit_id, section_ids=held, token=unit.token)),
        Show(Outside(unit_id=unit_id, token=unit.token, was=unit.standing.value)),
    )


def boundary_passed(register: Register, portal: str) -> Step:
    """The train of the portal's holder has left, whatever its unit says; shown if that holds more than the portal."""
    counted = register.left_through.get(portal, 0) + 1
    register = replace(register, left_through={**register.left_through, portal: counted})
    unit_id = register.holders.get(portal)
    if unit_id is None:
        return register, ()
    standing, held = register.unit(unit_id).standing, register.held_by(unit_id)
    if standing is UnitStanding.LEAVING or (standing in _HOLDING and held == (portal,)):
        return left_line(register, unit_id)
    why = "a train has left by this portal, and its holder may be elsewhere"
    return register, (Show(Contradicted(unit_id=unit_id, section_ids=held, why=why)),)


def claimed_standing(
    register: Register, heard: Heard[SignOn] | Heard[Claim], held: tuple[str, ...]
) -> UnitStanding:
    """Where a unit stands whose claim is accepted: one that has signed off, as it says itself or as was accepted of
    this boot, goes on leaving, and is asked on.

    Whatever persons have entered for it besides: it would report never again, and its last word is to free that too.
    """
    if not held:
        return UnitStanding.OUTSIDE
    unit, message = register.unit(heard.unit_id), heard.message
    accepted = unit.standing is UnitStanding.LEAVING and unit.epoch == heard.epoch
    leaves = isinstance(message, LeavingClaim) or (accepted and isinstance(message, Claim))
    in_portals = register.plan.portals.issuperset(message.section_ids or ())
    return UnitStanding.LEAVING if leaves and in_portals else UnitStanding.REPORTED


def counted_out(unit: RegisteredUnit, heard: Heard[SignOn] | Heard[Claim]) -> bool:
    """Whether it says that it still leaves by its portal after the boundary has counted it out in the same boot."""
    by_contact = unit.counted_out or (unit.standing is UnitStanding.OUTSIDE and not unit.by)
    return by_contact and unit.epoch == heard.epoch and isinstance(heard.message, LeavingClaim)


def has_left(register: Register, heard: Heard[SignOn] | Heard[Claim]) -> bool:
    """Whether a unit that claimed its portal against another, as one that has signed off, says in that boot that it
    holds nothing: whatever persons have entered for it besides, its train has left.
    """
    unit = register.unit(heard.unit_id)
    return unit.standing is UnitStanding.DISPUTED and unit.leaves and heard.epoch == unit.epoch


def says_gone(register: Register, heard: Heard[Claim]) -> Step:
    """A unit that leaves holds nothing: in the boot that signed off, or once the boundary has counted it out, its train
    has left. Booted since, and counted by nothing, it may have forgotten: shown once, and two persons must say so too.
    """
    unit_id, unit = heard.unit_id, register.unit(heard.unit_id)
    if heard.epoch == unit.epoch or unit.counted_out:
        return left_line(register, unit_id)
    if unit.unproven:
        return register, ()
    shown = Contradicted(unit_id=unit_id, section_ids=register.held_by(unit_id), why=FORGOTTEN_OR_GONE)
    return register.with_unit(unit_id, replace(unit, unproven=True)), (Show(shown),)


def left_before(register: Register, section_ids: tuple[str, ...]) -> int:
    """How many trains have left by these portals: the correlation of a query that is asked since the last of them."""
    return sum(register.left_through.get(section_id, 0) for section_id in section_ids)


def may_have_crossed(register: Register, heard: Heard[Claim]) -> bool:
    """Whether a claim of a portal may have been made by the train that has left it since, whoever's that was: unless it
    answers a query that was asked after the last one had.
    """
    left = left_before(register, heard.message.section_ids or ())
    return left > 0 and heard.correlation != left


def sign_off_again(register: Register, heard: Heard[SignOff]) -> Step:
    """Accepted again; nothing changes."""
    return register, (Send(heard.unit_id, SignOffAccepted(), heard.correlation),)


def _refuse_sign_off(register: Register, heard: Heard[SignOff], reason: RefusalReason) -> Step:
    return register, (
        show_refusal(heard.unit_id, reason),
        Send(heard.unit_id, SignOffRefused(reason), heard.correlation),
    )


def sign_off_not_signed_on(register: Register, heard: Heard[SignOff]) -> Step:
    """Refused: the unit must sign on first."""
    return _refuse_sign_off(register, heard, RefusalReason.NOT_SIGNED_ON)


def asked_later(before: Register, after: Register, now_s: float) -> Register:
    """A train that has just been let go has its time to leave before its unit is asked."""
    if before.units is after.units or before.units_asked():
        return after
    newly = after.units_asked()
    if not newly or any(after.unit(unit_id).standing is not UnitStanding.LEAVING for unit_id in newly):
        return after
    return replace(after, ask_at_s=max(after.ask_at_s, now_s + after.plan.ask_interval_s))
