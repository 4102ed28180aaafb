"""Invariant: one person's word never frees what a unit may hold. It is taken at once only where it adds or takes
back, or says that a unit is outside which the ledger does not have on the line; else a second, different person
must say the same, and where the unit stands: in a station, or by which portal it left. What it may have held is then
locked but for trains on sight. Against a unit that speaks for itself no word counts, nor while it answers.

What persons enter at the block manager, as a pure machine: `act(register, event, now_s) -> (register,
actions)`. `UNIT_ACTS` and `LINE_ACTS` are the whole table; what is refused changes nothing but the count of
inputs, and a first word that waits for the second.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from math import inf
from types import MappingProxyType
from typing import Any, Final

from msgspec.structs import replace

from radio.envelope import CLOCK_SKEW_MAX_S
from radio.messages import AnyMessage, Claim, SignOn
from wayside import barring, reentry
from wayside.actions import Show
from wayside.barring import person_key
from wayside.reentry import Step
from wayside.register import AT_ONCE_S, Register, RegisteredUnit, UnitStanding
from wayside.said import (
    AcceptPicture,
    Barred,
    BarUnit,
    ConfirmedByHand,
    ConfirmHolding,
    ConfirmOutside,
    Contradicted,
    EnterSection,
    Freed,
    Outside,
    Refused,
    TakeBack,
    TakenBack,
    Unbarred,
    UnbarUnit,
    WordTaken,
)

Act = ConfirmOutside | ConfirmHolding | EnterSection | AcceptPicture | TakeBack | BarUnit | UnbarUnit
ASKED_IN_VAIN: Final = 3  # assumed: so often a unit that reported must have been silent, at `ask_interval_s`


class LineState(Enum):
    """Whether the block state of the line is in force."""

    RUNNING = "running"  # since the first start, or since the line was defined again
    RESTORING = "restoring"


def act(register: Register, event: Act, now_s: float) -> Step:
    """The register after a person's input. Never raises for what a person enters."""
    phase = LineState.RESTORING if register.restoring else LineState.RUNNING
    person = person_key(event.person)
    if register.restoring:
        inputs = {**register.reentry.inputs, person: register.reentry.inputs.get(person, 0) + 1}
        register = replace(register, reentry=replace(register.reentry, inputs=inputs))
    started_s = now_s if register.started_s is None else register.started_s
    if not person:
        return register, (_refused(event, "no name"),)
    unit_id = None if isinstance(event, AcceptPicture) else event.unit_id
    if unit_id is not None and unit_id not in register.plan.unit_ids:
        return register, (_refused(event, "not on the fleet list"),)
    if isinstance(event, BarUnit | UnbarUnit):
        return _bar(register, event, now_s)
    # A grant of the boot before, or to a unit that was then barred, may still be on the air, so what a person sees
    # now may yet grow.
    last_s = max(
        started_s if register.epoch > 1 else -inf, -inf if register.barred_s is None else register.barred_s
    )
    if now_s <= last_s + register.plan.telegram_age_max_s + CLOCK_SKEW_MAX_S:
        return register, (_refused(event, "too early"),)
    if isinstance(event, EnterSection | AcceptPicture):
        return LINE_ACTS[phase, type(event)](register, event)
    return UNIT_ACTS[phase, register.unit(event.unit_id).standing, type(event)](register, event)


def spoke(register: Register, unit_id: str, epoch: int, message: AnyMessage) -> Step:
    """A unit is heard of which a person has said something after it had reported: no word counts, unless it does not
    know itself, or says that it holds nothing and may enter nowhere; that does not count either, but of the boot that
    has signed off.
    """
    unit = register.unit(unit_id)
    left = unit.standing is UnitStanding.LEAVING and epoch == unit.epoch
    claimed = message.section_ids if isinstance(message, SignOn | Claim) else ("",)
    outside = claimed is not None and (not claimed or register.asks_to_enter(unit_id, claimed))
    if claimed is None or (outside and not left):
        return register, ()
    return speaks(register, unit_id)


def speaks(register: Register, unit_id: str) -> Step:
    """What persons have said of a unit that had reported counts no more."""
    if unit_id not in register.doubted:
        return register, ()
    register = reentry.without_words(register.without_doubt(unit_id), unit_id)
    return register, (Show(Refused(unit_id=unit_id, why=SPEAKS)),)


def _bar(register: Register, event: BarUnit | UnbarUnit, now_s: float) -> Step:
    """Barred, or not any more, when a second person says the same; what it held stays its own."""
    unit_id, before = event.unit_id, register.bars
    bars = barring.bars_after_word(before, unit_id, event.person, bar=isinstance(event, BarUnit))
    register = replace(register, bars=bars)
    if bars.barred == before.barred:
        why = SECOND_PERSON if bars.words != before.words else "it is so already"
        return register, (_refused(event, why),)
    if isinstance(event, BarUnit):
        return replace(_shut_out(register, event), barred_s=now_s), (
            Show(Barred(unit_id=unit_id, by=event.person)),
        )
    return replace(register, ask_at_s=AT_ONCE_S), (Show(Unbarred(unit_id=unit_id, by=event.person)),)


def _shut_out(register: Register, event: BarUnit) -> Register:
    """Its word counts no more: not what it claims against others, and while restoring nothing that it has said.

    What the register gave it, it holds until people say where it is; where it claims more, that stays contested until
    they do, and the line undefined.
    """
    unit_id, unit = event.unit_id, register.unit(event.unit_id)
    register = register.without_doubt(unit_id)
    if register.restoring:
        heard_s = {other: at_s for other, at_s in register.reentry.heard_s.items() if other != unit_id}
        register = replace(register, reentry=replace(register.reentry, heard_s=heard_s))
    if register.restoring or unit.standing is UnitStanding.DISPUTED:
        return reentry.unheard(register, unit_id)
    if unit.standing in (UnitStanding.REPORTED, UnitStanding.LEAVING, UnitStanding.BY_HAND):
        by_hand = RegisteredUnit(
            UnitStanding.BY_HAND, unit.epoch, unit.token, by=event.person, claim_needed=True, silent=True
        )
        return register.with_unit(unit_id, by_hand)
    return register


def _sections(event: ConfirmOutside | ConfirmHolding) -> tuple[str, ...]:
    return event.section_ids if isinstance(event, ConfirmHolding) else ()


def _place(event: ConfirmOutside | ConfirmHolding) -> str:
    return event.place if isinstance(event, ConfirmOutside) else ""


def _freed(register: Register, event: ConfirmHolding) -> tuple[str, ...]:
    """What the unit no longer holds, nor claims, if this is so."""
    return tuple(s for s in _may_be_in(register, event.unit_id) if s not in event.section_ids)


def _given_back(register: Register, event: ConfirmHolding) -> tuple[str, ...]:
    """What of that the register has it hold; else the word says only that it is not where it claims to be."""
    held = register.held_by(event.unit_id)
    return tuple(section_id for section_id in _freed(register, event) if section_id in held)


def _may_be_in(register: Register, unit_id: str) -> tuple[str, ...]:
    """What a unit holds, and what it claims against others."""
    return tuple(dict.fromkeys((*register.held_by(unit_id), *(register.unit(unit_id).claim or ()))))


def _refused(event: Act, why: str, section_ids: tuple[str, ...] = ()) -> Show:
    unit_id = "" if isinstance(event, AcceptPicture) else event.unit_id or ""
    return Show(Refused(unit_id=unit_id, section_ids=section_ids, why=f"{event.person}: {why}"))


def _senseless(register: Register, event: ConfirmOutside | ConfirmHolding) -> Show | None:
    if isinstance(event, ConfirmOutside):
        silent = event.unit_id in register.ledger
        placed = event.place in register.plan.portals or not (event.place or silent)
        return None if placed else _refused(event, "say by which portal it left the line")
    unknown = tuple(section for section in event.section_ids if section not in register.plan.order)
    if unknown:
        return _refused(event, "unknown section", unknown)
    return None if event.section_ids else _refused(event, "an empty entry; confirm the unit as outside")


def _confirm_outside(register: Register, event: ConfirmOutside) -> Step:
    """Outside at once; a unit on the ledger only when a second person says so."""
    unit_id = event.unit_id
    if (senseless := _senseless(register, event)) is not None:
        return register, (senseless,)
    if unit_id in register.ledger:
        register = reentry.with_word(register, person_key(event.person), unit_id, (), event.place)
        if reentry.agreed(register, unit_id) is None:
            return register, (_refused(event, _SECOND_PERSON),)
    return _set_outside(register, event)


def _set_outside(register: Register, event: ConfirmOutside) -> Step:
    unit_id, before = event.unit_id, register.unit(event.unit_id)
    freed, left = register.held_by(unit_id), _may_be_in(register, unit_id)
    silent = unit_id in register.ledger
    unit = RegisteredUnit(
        UnitStanding.OUTSIDE, before.epoch, by=event.person, claim_needed=before.has_spoken, silent=silent
    )
    register = reentry.without_words(register, unit_id).with_held(unit_id, ()).with_unit(unit_id, unit)
    register, swept = reentry.to_be_swept(register, left)
    shows = [Show(Freed(unit_id=unit_id, section_ids=freed, by=event.person))] if freed else []
    return register, (*shows, *swept, Show(Outside(unit_id=unit_id, by=event.person)))


def _confirm_holding(register: Register, event: ConfirmHolding) -> Step:
    """Held by hand at once; what it frees, or ends the claim of, only when a second person says so."""
    unit_id, section_ids = event.unit_id, event.section_ids
    if (senseless := _senseless(register, event)) is not None:
        return register, (senseless,)
    if (conflict := register.other_holder(unit_id, section_ids)) is not None:
        section_id, other_id = conflict
        against = Contradicted(
            unit_id=unit_id, section_ids=(section_id,), other_id=other_id, why=f"entered by {event.person}"
        )
        return register, (Show(against),)
    freed = _freed(register, event)
    given_back = _given_back(register, event)
    if given_back and not reentry.in_station(register, section_ids):
        return register, (_refused(event, IN_STATION, given_back),)
    if freed:
        register = reentry.with_word(register, person_key(event.person), unit_id, section_ids)
        if reentry.agreed(register, unit_id) is None:
            return register, (_refused(event, _SECOND_PERSON, freed),)
    return _set_by_hand(register, event)


def _set_by_hand(register: Register, event: ConfirmHolding) -> Step:
    unit_id, by, before = event.unit_id, event.person, register.unit(event.unit_id)
    left, freed = _freed(register, event), _given_back(register, event)
    register, token = reentry.without_words(register, unit_id).next_token()
    register = register.with_held(unit_id, event.section_ids)
    unit = RegisteredUnit(
        UnitStanding.BY_HAND, before.epoch, token, by=by, claim_needed=before.has_spoken, silent=True
    )
    register = register.with_unit(unit_id, unit)
    register, swept = reentry.to_be_swept(register, left)
    shows = [Show(Freed(unit_id=unit_id, section_ids=freed, token=token, by=by))] if freed else []
    held = register.held_by(unit_id)
    confirmed = ConfirmedByHand(unit_id=unit_id, section_ids=held, token=token, by=by)
    return register, (*shows, *swept, Show(confirmed))


def _doubt_speaker(register: Register, event: ConfirmOutside | ConfirmHolding) -> Step:
    """Recorded, and the unit is asked; it counts if two persons say so and the unit does not answer."""
    unit_id, section_ids = event.unit_id, _sections(event)
    senseless = _senseless(register, event)
    if senseless is None and not reentry.in_station(register, section_ids):
        senseless = _refused(event, IN_STATION)
    if senseless is None and (conflict := register.other_holder(unit_id, section_ids)) is not None:
        senseless = _refused(event, f"section {conflict[0]} is held by {conflict[1]}")
    if senseless is not None:
        return register, (senseless,)
    register = reentry.with_word(register, person_key(event.person), unit_id, section_ids, _place(event))
    if unit_id not in register.doubted:
        register = replace(register, doubted={**register.doubted, unit_id: 0}, ask_at_s=AT_ONCE_S)
    alone = reentry.agreed(register, unit_id) is None
    if alone or register.doubted[unit_id] < ASKED_IN_VAIN:
        return register, (_refused(event, _SECOND_PERSON if alone else _STILL_ASKED),)
    register = register.without_doubt(unit_id)
    if isinstance(event, ConfirmOutside):
        return _set_outside(register, event)
    return _set_by_hand(register, event)


def _take_back(register: Register, event: TakeBack) -> Step:
    """Unknown again, and asked: nothing is granted; trains that hold a section it may be in must stop."""
    unit = register.unit(event.unit_id)
    if not unit.by:
        return register, (_refused(event, "it has said so itself"),)
    unknown = RegisteredUnit(
        UnitStanding.UNKNOWN, unit.epoch, claim_needed=unit.claim_needed, taken_back=True
    )
    register = register.with_unit(event.unit_id, unknown)
    # It may be on the line after all, so one person's word does not suffice the next time.
    register = replace(register, ledger=register.ledger | {event.unit_id}, ask_at_s=AT_ONCE_S)
    return register, (Show(TakenBack(unit_id=event.unit_id, by=event.person)),)


def _nothing_to_take_back(register: Register, event: TakeBack) -> Step:
    """Refused: no person's word counts for it; a first word that waits for a second is forgotten."""
    register = reentry.without_words(register, event.unit_id, person_key(event.person))
    return register, (_refused(event, "no word of a person counts for it"),)


def _take_back_word(register: Register, event: TakeBack) -> Step:
    """What this person has entered for the unit is forgotten."""
    changed = reentry.without_words(register, event.unit_id, person_key(event.person))
    note = Show(TakenBack(unit_id=event.unit_id, by=event.person))
    return _as_changed(register, changed), (note,)


def _refuse_unit_speaks(register: Register, event: ConfirmOutside | ConfirmHolding) -> Step:
    """Refused: the unit reports itself, or claims what another holds."""
    standing = register.unit(event.unit_id).standing.value
    return register, (_refused(event, f"the unit is {standing}"),)


def _take_word(register: Register, event: ConfirmOutside | ConfirmHolding) -> Step:
    """Recorded, not in force; it counts once a second person enters the same, or the unit reports itself."""
    unit_id, section_ids = event.unit_id, _sections(event)
    if (senseless := _senseless(register, event)) is not None:
        return register, (senseless,)
    changed = reentry.with_word(register, person_key(event.person), unit_id, section_ids, _place(event))
    if not section_ids and unit_id in register.ledger and reentry.agreed(changed, unit_id) is None:
        return _as_changed(register, changed), (_refused(event, _SECOND_PERSON),)
    note = Show(WordTaken(unit_id=unit_id, section_ids=section_ids, by=event.person))
    return _as_changed(register, changed), (note, *_new_contradictions(register, changed))


def _take_correction(register: Register, event: ConfirmOutside | ConfirmHolding) -> Step:
    """Refused but for the unit's own word: so a person takes back what they entered wrongly for it."""
    unit = register.unit(event.unit_id)
    own = register.held_by(event.unit_id) if unit.claim is None else unit.claim
    if frozenset(own) != frozenset(_sections(event)):
        return _refuse_unit_speaks(register, event)
    if not own and (senseless := _senseless(register, event)) is not None:
        return register, (senseless,)
    changed = reentry.with_word(register, person_key(event.person), event.unit_id, own, _place(event))
    note = Show(WordTaken(unit_id=event.unit_id, section_ids=own, by=event.person))
    return _as_changed(register, changed), (note, *_new_contradictions(register, changed))


def _enter_section(register: Register, event: EnterSection) -> Step:
    """Recorded, not in force before the picture is accepted."""
    if event.section_id not in register.plan.order:
        return register, (_refused(event, "unknown section", (event.section_id,)),)
    changed = reentry.with_entry(register, person_key(event.person), event.section_id, event.unit_id)
    note = Show(WordTaken(unit_id=event.unit_id or "", section_ids=(event.section_id,), by=event.person))
    return _as_changed(register, changed), (note, *_new_contradictions(register, changed))


def _accept(register: Register, event: AcceptPicture) -> Step:
    """Taken when nothing is missing and nothing contradicts; refused with what is missing."""
    if lacking := reentry.missing_for_acceptance(register):
        return register, (_refused(event, f"not complete: {lacking}"),)
    taken = replace(register.reentry, accepted_by=event.person)
    return replace(register, reentry=taken), ()


def _refuse_running(register: Register, event: EnterSection | AcceptPicture) -> Step:
    """Refused: there is nothing to restore."""
    return register, (_refused(event, "nothing to restore"),)


def _as_changed(before: Register, after: Register) -> Register:
    """An entry that changes what the picture says takes an earlier acceptance back."""
    was, now = (
        {section: set(by.values()) for section, by in register.reentry.entries.items()}
        for register in (before, after)
    )
    return after if was == now else replace(after, reentry=replace(after.reentry, accepted_by=""))


def _new_contradictions(before: Register, after: Register) -> tuple[Show, ...]:
    known = reentry.contradictions(before)
    return tuple(
        reentry.shown_contradiction(found) for found in reentry.contradictions(after) if found not in known
    )


SECOND_PERSON: Final = "a second person must say the same"
_SECOND_PERSON: Final = f"it may be on the line; {SECOND_PERSON}"
SPEAKS: Final = "it speaks for itself: no word counts"
IN_STATION: Final = "a silent unit must stand in a station"  # for what it may hold yet to be freed
_STILL_ASKED: Final = "the unit is still being asked; if it stays silent, say it again with all that it shows"
_Handler = Callable[[Register, Any], Step]

UNIT_ACTS: Final[Mapping[tuple[LineState, UnitStanding, type], _Handler]] = MappingProxyType(
    {
        (LineState.RUNNING, UnitStanding.UNKNOWN, ConfirmOutside): _confirm_outside,
        (LineState.RUNNING, UnitStanding.UNKNOWN, ConfirmHolding): _confirm_holding,
        (LineState.RUNNING, UnitStanding.OUTSIDE, ConfirmOutside): _confirm_outside,
        (LineState.RUNNING, UnitStanding.OUTSIDE, ConfirmHolding): _confirm_holding,
        (LineState.RUNNING, UnitStanding.BY_HAND, ConfirmOutside): _confirm_outside,
        (LineState.RUNNING, UnitStanding.BY_HAND, ConfirmHolding): _confirm_holding,
        (LineState.RUNNING, UnitStanding.REPORTED, ConfirmOutside): _doubt_speaker,
        (LineState.RUNNING, UnitStanding.REPORTED, ConfirmHolding): _doubt_speaker,
        (LineState.RUNNING, UnitStanding.LEAVING, ConfirmOutside): _doubt_speaker,
        (LineState.RUNNING, UnitStanding.LEAVING, ConfirmHolding): _doubt_speaker,
        (LineState.RUNNING, UnitStanding.DISPUTED, ConfirmOutside): _refuse_unit_speaks,
        (LineState.RUNNING, UnitStanding.DISPUTED, ConfirmHolding): _refuse_unit_speaks,
        (LineState.RESTORING, UnitStanding.UNKNOWN, ConfirmOutside): _take_word,
        (LineState.RESTORING, UnitStanding.UNKNOWN, ConfirmHolding): _take_word,
        (LineState.RESTORING, UnitStanding.OUTSIDE, ConfirmOutside): _take_correction,
        (LineState.RESTORING, UnitStanding.OUTSIDE, ConfirmHolding): _take_correction,
        (LineState.RESTORING, UnitStanding.BY_HAND, ConfirmOutside): _take_word,
        (LineState.RESTORING, UnitStanding.BY_HAND, ConfirmHolding): _take_word,
        (LineState.RESTORING, UnitStanding.REPORTED, ConfirmOutside): _take_correction,
        (LineState.RESTORING, UnitStanding.REPORTED, ConfirmHolding): _take_correction,
        (LineState.RESTORING, UnitStanding.LEAVING, ConfirmOutside): _take_correction,
        (LineState.RESTORING, UnitStanding.LEAVING, ConfirmHolding): _take_correction,
        (LineState.RESTORING, UnitStanding.DISPUTED, ConfirmOutside): _take_correction,
        (LineState.RESTORING, UnitStanding.DISPUTED, ConfirmHolding): _take_correction,
        (LineState.RUNNING, UnitStanding.OUTSIDE, TakeBack): _take_back,
        (LineState.RUNNING, UnitStanding.BY_HAND, TakeBack): _take_back,
        **{
            (LineState.RUNNING, standing, TakeBack): _nothing_to_take_back
            for standing in (
                UnitStanding.UNKNOWN,
                UnitStanding.REPORTED,
                UnitStanding.LEAVING,
                UnitStanding.DISPUTED,
            )
        },
        **{(LineState.RESTORING, standing, TakeBack): _take_back_word for standing in UnitStanding},
    }
)

LINE_ACTS: Final[Mapping[tuple[LineState, type], _Handler]] = MappingProxyType(
    {
        (LineState.RUNNING, EnterSection): _refuse_running,
        (LineState.RUNNING, AcceptPicture): _refuse_running,
        (LineState.RESTORING, EnterSection): _enter_section,
        (LineState.RESTORING, AcceptPicture): _accept,
    }
)
