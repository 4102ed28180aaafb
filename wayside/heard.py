"""A telegram as the block manager hears it, and the answers that several of its handlers give."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

import msgspec
from msgspec.structs import replace

from radio.messages import Claim, ClaimQuery, Contested, RefusalReason, SignOn, SignOnRefused
from wayside.actions import Send, Show
from wayside.reentry import Step
from wayside.register import Register, RegisteredUnit, UnitStanding
from wayside.said import Refused

M = TypeVar("M")


class Heard(msgspec.Struct, Generic[M], frozen=True):
    """A telegram passed the envelope's checks. `fresh`: its sender has heard this boot of the manager."""

    unit_id: str
    epoch: int
    fresh: bool
    correlation: int
    message: M


def challenge(register: Register, heard: Heard[Any]) -> Step:
    """Ask: a claim may date from before this boot, but not the answer to this."""
    return register, (Send(heard.unit_id, ClaimQuery(), heard.correlation),)


def is_to_hear(heard: Heard[SignOn] | Heard[Claim], after: RegisteredUnit) -> bool:
    """Whether a unit must hear of the token of its claim from the answer to it, and from nothing else: what it knows of
    points is of another, and counts no more. A unit that has booted knows of none.
    """
    known = heard.message.token
    return (
        after.standing is UnitStanding.REPORTED
        and isinstance(heard.message, Claim)
        and 0 < known < after.token
    )


def has_heard(register: Register, heard: Heard[Any]) -> Register:
    """The register with a unit that has heard that answer, if it speaks under that token: all of its words count."""
    unit = register.unit(heard.unit_id)
    under = getattr(heard.message, "token", 0) == unit.token and unit.standing is UnitStanding.REPORTED
    if not (unit.claim_needed and under):
        return register
    return register.with_unit(heard.unit_id, replace(unit, claim_needed=False))


def show_refusal(
    unit_id: str, reason: RefusalReason, section_id: str | None = None, holder: str | None = None
) -> Show:
    """A refusal for the journal, and what stands against it."""
    sections = () if section_id is None else (section_id,)
    return Show(Refused(unit_id=unit_id, section_ids=sections, other_id=holder or "", why=reason.name))


def tell_contested(register: Register) -> tuple[Send, ...]:
    """To every unit with something contested: it only restricts, and is said again as long as it lasts."""
    if not register.in_dispute:
        return ()
    units = (unit_id for unit_id in register.plan.unit_ids if unit_id not in register.bars.barred)
    contested = {unit_id: register.contested(unit_id) for unit_id in units}
    return tuple(Send(unit_id, Contested(sections)) for unit_id, sections in contested.items() if sections)


def newly_contested(before: Register, after: Register) -> tuple[Send, ...]:
    """What is to be told of it that was not before."""
    if before.units is after.units:
        return ()
    known = tell_contested(before)
    return tuple(send for send in tell_contested(after) if send not in known)


def refuse_claim(
    register: Register,
    heard: Heard[SignOn] | Heard[Claim],
    reason: RefusalReason,
    section_id: str | None = None,
    holder: str | None = None,
) -> Step:
    """What a unit claims, or where it wishes to enter, is refused; the register stays as it is."""
    return register, (
        show_refusal(heard.unit_id, reason, section_id, holder),
        Send(heard.unit_id, SignOnRefused(reason, section_id, holder), heard.correlation),
    )
