"""What a unit reports to hold, and as which train it goes on: what it no longer lists is free.

Invariant: only a report of the unit's present boot under its newest grant frees anything, and nothing that it claims to
hold beyond the register.
"""

from __future__ import annotations

from radio.messages import ClaimQuery, HoldingConfirmed, HoldingReport, NextTrainReport, RefusalReason
from wayside import cutting, reentry
from wayside.actions import Send, Show
from wayside.heard import Heard, show_refusal
from wayside.reentry import Step
from wayside.register import Register
from wayside.said import Contradicted, Freed, Refused


def report(register: Register, heard: Heard[HoldingReport] | Heard[NextTrainReport]) -> Step:
    """Frees what it no longer lists, under the current token and boot; answered with what the register has."""
    message, unit_id = heard.message, heard.unit_id
    unit = register.unit(unit_id)
    held, listed = register.held_by(unit_id), frozenset(message.section_ids)
    contested = register.contested(unit_id)
    confirmed = Send(
        unit_id, HoldingConfirmed(held, unit.token, contested, register.on_sight(held)), heard.correlation
    )
    if heard.epoch != unit.epoch:
        return register, (show_refusal(unit_id, RefusalReason.NOT_SIGNED_ON), confirmed)
    if message.token != unit.token:
        return register, (show_refusal(unit_id, RefusalReason.STALE_TOKEN), confirmed)
    if extra := tuple(section_id for section_id in message.section_ids if section_id not in held):
        # It believes to hold more than the register says: a contradiction, so nothing of it is freed. Its train stops
        # at this answer; what it then claims is added, or disputed.
        holder = register.holders.get(extra[0], "")
        against = Contradicted(unit_id=unit_id, section_ids=extra, token=unit.token, other_id=holder)
        return register, (Show(against), confirmed, Send(unit_id, ClaimQuery()))
    if not listed:
        why = "an empty report; sign off to leave the line"
        refused = Refused(unit_id=unit_id, section_ids=held, token=unit.token, why=why)
        return register, (Show(refused), confirmed)
    register, noted = reentry.swept(register, unit_id, message.swept)
    freed = tuple(section_id for section_id in held if section_id not in listed)
    if not freed:
        return register, (*noted, confirmed)
    kept = tuple(section_id for section_id in held if section_id in listed)
    register = reentry.released(register.with_held(unit_id, kept), unit_id, freed)
    return register, (
        *noted,
        Show(Freed(unit_id=unit_id, section_ids=freed, token=unit.token)),
        Send(
            unit_id,
            HoldingConfirmed(kept, unit.token, register.contested(unit_id), register.on_sight(kept)),
            heard.correlation,
        ),
    )


def next_train(register: Register, heard: Heard[NextTrainReport]) -> Step:
    """A report, and as which train of its day the unit goes on from where it stands."""
    register, actions = report(register, heard)
    register, shows = cutting.reported(register, heard)
    return register, (*shows, *actions)
