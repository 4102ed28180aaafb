"""Invariant: while the line is being restored nothing that a person enters is in force, and it is defined again
only when a person has accepted the picture, nothing in it contradicts, and for every unit that may be on the
line its own word counts or two different persons have said the same.

Re-entry of the block state after the manager lost it (閉そく状況を再現する手動入力, section 4.4 (2) of Sugiyama et
al. 2017; its laboriousness is the open problem of section 5, a wrong entry that of section 4.4 (4)). Pure
functions on the register; persons' inputs themselves are in `wayside.acts`.

| what vouches for a unit                         | on the ledger, or heard | silent, not on the ledger     |
|-------------------------------------------------|-------------------------|-------------------------------|
| its own fresh claim, nobody else claims the same| yes                     | (then it is not silent)       |
| two persons: it left by this portal             | yes                     | yes                           |
| two persons: it stands in a station, and holds  | yes                     | yes                           |
| two persons: it holds open line                 | if heard                | no                            |
| one person: it is outside                       | if not on the ledger    | yes                           |
| one person: it holds sections                   | no                      | no                            |
| nobody entered anything for it                  | no                      | yes: nothing was ever granted |

A unit that says it is outside although it was on the line when the manager stopped may have forgotten: it counts as
outside, and as a silent one in what must be swept, unless a person also says by which portal it left.

A unit's word outranks an entry: what it claims beyond the entry is added, what was entered beyond its claim is
added too when the line is defined, and its next report frees it. An entry that gives one unit what another
claims blocks until a person corrects it. Where a silent unit counts by persons' word alone, every section that no
unit speaks for is locked but for trains on sight until one has run through it (4.4 (4): all trains in stations
first), so that two persons who agree on the same wrong word lead to a train that stops before another.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Final

import msgspec
from msgspec.structs import replace

from wayside.actions import Action, Show
from wayside.config import ReentryMode
from wayside.register import AT_ONCE_S, Reentry, ReentryStage, Register, RegisteredUnit, UnitStanding
from wayside.said import ConfirmedByHand, Contradicted, Outside, PictureChanged, Swept, ToBeSwept

Step = tuple[Register, tuple[Action, ...]]

TELLS_OF_MORE = True  # off: a unit is not told what persons have entered for it beyond its claim


class PictureClash(Enum):
    """What does not fit together in the picture."""

    CLAIMED_TWICE = "two units claim it"
    ENTERED_FOR_ANOTHER = "entered for one unit, claimed by another"
    PERSONS_DIFFER = "two persons entered it differently"
    ENTERED_BUT_OUTSIDE = "entered for a unit that says it is outside"
    ENTERED_FREE = "entered as free, claimed: added"
    NOT_CLAIMED = "entered, but its unit does not claim it: added"


BLOCKING: Final = frozenset(
    {
        PictureClash.CLAIMED_TWICE,
        PictureClash.ENTERED_FOR_ANOTHER,
        PictureClash.PERSONS_DIFFER,
        PictureClash.ENTERED_BUT_OUTSIDE,
    }
)


@dataclass(frozen=True, slots=True)
class Contradiction:
    """`unit_id` holds or claims the section, or is entered for it; `other_id` stands against it, if anyone."""

    clash: PictureClash
    section_id: str
    unit_id: str
    other_id: str = ""

    @property
    def blocks(self) -> bool:
        """Whether a person must correct it; the others are only shown."""
        return self.clash in BLOCKING


class Missing(msgspec.Struct, frozen=True):
    """Why the line is not defined: units nobody vouches for, sections not entered, what contradicts."""

    unit_ids: tuple[str, ...]
    section_ids: tuple[str, ...]
    contradictions: tuple[Contradiction, ...]

    def __bool__(self) -> bool:
        """Whether anything is missing."""
        return bool(self.unit_ids or self.section_ids or self.contradictions)

    def __str__(self) -> str:
        """In one line, for the person."""
        words = [f"unit {unit_id}" for unit_id in self.unit_ids]
        words += [f"section {section_id}" for section_id in self.section_ids]
        words += [f"{found.section_id}: {found.clash.value}" for found in self.contradictions]
        return ", ".join(words)


def entered_for(register: Register, unit_id: str) -> frozenset[str]:
    """Sections that anyone entered for the unit."""
    return frozenset(section for section, by in register.reentry.entries.items() if unit_id in by.values())


def words_for(register: Register, unit_id: str) -> Mapping[str, frozenset[str]]:
    """All that the unit holds, in the word of each person who has said it completely.

    Complete is a confirmation of the unit, or an entry for every section of the line.
    """
    entries, complete = register.reentry.entries, register.reentry.complete
    people = {person for by in entries.values() for person in by} | {person for person, _ in complete}
    words: dict[str, frozenset[str]] = {}
    for person in sorted(people):
        of_person = {section: by[person] for section, by in entries.items() if person in by}
        if (person, unit_id) in complete or len(of_person) == len(register.plan.order):
            words[person] = frozenset(section for section, unit in of_person.items() if unit == unit_id)
    return words


def agreed(register: Register, unit_id: str) -> frozenset[str] | None:
    """What two different persons say the unit holds, and nobody says more; None: no such agreement."""
    entered = entered_for(register, unit_id)
    same = [person for person, word in words_for(register, unit_id).items() if word == entered]
    places = {register.reentry.left_by.get((person, unit_id), "") for person in same}
    placed = entered or unit_id not in register.ledger or (len(places) == 1 and "" not in places)
    return entered if len(same) > 1 and placed else None


def in_station(register: Register, section_ids: Iterable[str]) -> bool:
    """Whether a train that holds these stands in a station, or in a portal."""
    return register.plan.open_line.isdisjoint(section_ids)


def to_be_swept(register: Register, section_ids: Iterable[str]) -> Step:
    """Persons say that a silent unit is not in these: locked but for trains on sight. Into a portal a driver sees."""
    locked = frozenset(section_ids) - register.plan.portals - register.unswept
    if not locked:
        return register, ()
    in_order = tuple(sorted(locked, key=register.plan.order.__getitem__))
    return replace(register, unswept=register.unswept | locked), (Show(ToBeSwept(section_ids=in_order)),)


def vouched(register: Register, unit_id: str) -> bool:
    """Whether it is known well enough what the unit holds (see the table above)."""
    standing = register.unit(unit_id).standing
    if standing is not UnitStanding.UNKNOWN:
        return standing is not UnitStanding.DISPUTED
    heard = unit_id in register.reentry.heard_s  # it is not silent: it does not know, and runs on sight
    if (held := agreed(register, unit_id)) is not None and (heard or in_station(register, held)):
        return True
    if unit_id in register.ledger or entered_for(register, unit_id):
        return False
    return unit_id not in register.reentry.heard_s or bool(words_for(register, unit_id))


def entered_for_another(
    register: Register, unit_id: str, section_ids: Iterable[str]
) -> tuple[str, str] | None:
    """The first of the sections that a person entered for another unit, and that unit."""
    for section_id in section_ids:
        for entered in sorted(filter(None, register.reentry.entries.get(section_id, {}).values())):
            if entered != unit_id:
                return section_id, entered
    return None


def contradictions(register: Register) -> tuple[Contradiction, ...]:
    """Everything that does not fit, in the order of the line; empty once the line is defined."""
    if not register.restoring:
        return ()
    found: list[Contradiction] = []
    for section_id in register.plan.order:
        found += _contradictions_at(register, section_id)
    for unit_id in register.plan.unit_ids:
        for section_id in register.unit(unit_id).claim or ():
            holder = register.holders.get(section_id, unit_id)
            if holder != unit_id:
                found.append(Contradiction(PictureClash.CLAIMED_TWICE, section_id, unit_id, holder))
    return tuple(found)


def _contradictions_at(register: Register, section_id: str) -> list[Contradiction]:
    entered = set(register.reentry.entries.get(section_id, {}).values())
    units, holder = sorted(filter(None, entered)), register.holders.get(section_id)
    found: list[Contradiction] = []
    if len(entered) > 1:
        found.append(Contradiction(PictureClash.PERSONS_DIFFER, section_id, *units[:2]))
    for unit_id in units:
        standing = register.unit(unit_id).standing
        if holder not in (None, unit_id):
            found.append(Contradiction(PictureClash.ENTERED_FOR_ANOTHER, section_id, holder or "", unit_id))
        elif standing is UnitStanding.OUTSIDE:
            found.append(Contradiction(PictureClash.ENTERED_BUT_OUTSIDE, section_id, unit_id))
        elif standing is UnitStanding.REPORTED and holder is None:
            found.append(Contradiction(PictureClash.NOT_CLAIMED, section_id, unit_id))
    if holder is not None and None in entered:
        found.append(Contradiction(PictureClash.ENTERED_FREE, section_id, holder))
    return found


def shown_contradiction(found: Contradiction) -> Show:
    """The contradiction as the operator and the journal get it."""
    return Show(
        Contradicted(
            unit_id=found.unit_id,
            section_ids=(found.section_id,),
            other_id=found.other_id,
            why=found.clash.value,
        )
    )


def shown_against(register: Register, unit_id: str) -> tuple[Action, ...]:
    """What was entered otherwise than the unit claims, for the journal."""
    return tuple(shown_contradiction(found) for found in contradictions(register) if found.unit_id == unit_id)


def missing(register: Register) -> Missing:
    """What stands between the register and a defined line, apart from the person's acceptance."""
    if not register.restoring:
        return Missing(register.undefined_because_of(), (), ())
    plan, entries = register.plan, register.reentry.entries
    by_hand = plan.reentry is ReentryMode.BY_HAND
    return Missing(
        tuple(unit_id for unit_id in plan.unit_ids if not vouched(register, unit_id)),
        tuple(section_id for section_id in plan.order if by_hand and not entries.get(section_id)),
        tuple(found for found in contradictions(register) if found.blocks),
    )


def missing_for_acceptance(register: Register) -> Missing:
    """What must be settled before a person may accept: by hand, the units may yet speak afterwards."""
    lacking = missing(register)
    return replace(lacking, unit_ids=()) if register.plan.reentry is ReentryMode.BY_HAND else lacking


def stage(register: Register) -> ReentryStage:
    """How far the re-entry has come."""
    if not register.restoring:
        return ReentryStage.DEFINED
    if register.reentry.accepted_by:
        return ReentryStage.ACCEPTED
    return ReentryStage.INCOMPLETE if missing_for_acceptance(register) else ReentryStage.COMPLETE


def settle(register: Register, now_s: float) -> Step:
    """What follows from any event: the ledger, an acceptance that no longer holds, the line defined."""
    actions: tuple[Action, ...] = ()
    if register.restoring:
        if missing_for_acceptance(register):
            register = replace(register, reentry=replace(register.reentry, accepted_by=""))
        if register.reentry.accepted_by and not missing(register):
            register, actions = _define(register, now_s)
        if (now := stage(register)) is not register.reentry.stage:
            register = replace(register, reentry=replace(register.reentry, stage=now))
            changed = PictureChanged(stage=now.value, inputs=register.inputs)
            actions = (*actions, Show(changed))
    elif register.reentry.complete:
        register = _forget_words_of_speakers(register)
    ledger = frozenset(filter(lambda unit_id: _on_line(register, unit_id), register.plan.unit_ids))
    return (register if ledger == register.ledger else replace(register, ledger=ledger)), actions


def _on_line(register: Register, unit_id: str) -> bool:
    unit = register.unit(unit_id)
    # Until the line is defined, and swept, the word of one that was on it does not take it off.
    if unit.standing is UnitStanding.UNKNOWN or (unit.unproven and register.restoring):
        return unit_id in register.ledger
    return unit.standing is not UnitStanding.OUTSIDE


def _define(register: Register, now_s: float) -> Step:
    """Entries come into force: for silent units all that two persons agree on, for others as additions."""
    actions: list[Action] = []
    silent = [
        u
        for u in register.ledger
        if register.unit(u).standing is UnitStanding.UNKNOWN or _forgot(register, u)
    ]
    for unit_id in register.plan.unit_ids:
        unit, entered = register.unit(unit_id), entered_for(register, unit_id)
        said_by = ", ".join(words_for(register, unit_id)) or register.reentry.accepted_by
        if unit.standing is UnitStanding.UNKNOWN and not entered:
            register = register.with_unit(
                unit_id,
                RegisteredUnit(UnitStanding.OUTSIDE, unit.epoch, by=said_by, silent=unit_id in silent),
            )
            actions.append(Show(Outside(unit_id=unit_id, by=said_by)))
            continue
        before = register.held_by(unit_id)
        if entered <= frozenset(before):
            continue
        if unit.standing is UnitStanding.UNKNOWN:
            register, token = register.next_token()
            unit = RegisteredUnit(UnitStanding.BY_HAND, unit.epoch, token, by=said_by, silent=True)
        else:  # it is asked, so that it hears of that, and gives back what it does not hold
            unit = replace(unit, silent=TELLS_OF_MORE)
        register = register.with_held(unit_id, (*before, *entered.difference(before)))
        register = register.with_unit(unit_id, unit)
        held = register.held_by(unit_id)
        confirmed = ConfirmedByHand(unit_id=unit_id, section_ids=held, token=unit.token, by=said_by)
        actions.append(Show(confirmed))
    if silent:
        spoken_for = {s for s, holder in register.holders.items() if holder not in silent}
        register, locked = to_be_swept(register, set(register.plan.order) - spoken_for)
        actions += locked
    past = register.reentry
    done = Reentry(accepted_by=past.accepted_by, inputs=past.inputs, stage=past.stage, defined_s=now_s)
    return replace(register, restoring=False, reentry=done), tuple(actions)


def _forgot(register: Register, unit_id: str) -> bool:
    """Whether it says that it is outside, was on the line, and no person says by which portal it left."""
    unit, left_by = register.unit(unit_id), register.reentry.left_by
    seen = any(place for (_, of_unit), place in left_by.items() if of_unit == unit_id)
    return unit.standing is UnitStanding.OUTSIDE and unit.unproven and not seen


def said_outside(register: Register, unit_id: str) -> Step:
    """A unit says that it is not on the line. If it is, as far as is known, that is shown, and what it may be in is
    to be swept: at once, or while the line is restored when it is known who speaks for which sections.
    """
    if not cannot_be_outside(register, unit_id):
        return register, ()
    why = "it may have been on the line, and says that it is outside"
    shown_ = Show(Contradicted(unit_id=unit_id, section_ids=register.held_by(unit_id), why=why))
    if register.restoring or register.held_by(unit_id):
        return register, (shown_,)
    register, locked = to_be_swept(register, set(register.plan.order).difference(register.holders))
    return register, (shown_, *locked)


def known(register: Register, unit_id: str) -> bool:
    """Whether the register has what the unit holds, be it that persons have entered it."""
    return register.unit(unit_id).standing in (
        UnitStanding.BY_HAND,
        UnitStanding.REPORTED,
        UnitStanding.LEAVING,
    )


def cannot_be_outside(register: Register, unit_id: str) -> bool:
    """Whether a unit that says it is outside is on the line, by what is known, and not only before a portal."""
    unknown = register.unit(unit_id).standing is UnitStanding.UNKNOWN and unit_id in register.ledger
    return unknown or not register.plan.portals.issuperset(register.held_by(unit_id))


def unheard(register: Register, unit_id: str) -> Register:
    """What a unit has said counts no more: it is unknown, what it claimed against others is contested until persons
    have said where it is, and while the line is restored nothing that it has said is left.
    """
    unit = register.unit(unit_id)
    unknown = RegisteredUnit(
        UnitStanding.UNKNOWN, unit.epoch, unit.token, claim=unit.claim, claim_needed=True
    )
    if not register.restoring:
        return register.with_unit(unit_id, unknown)
    register = replace(register, reentry=replace(register.reentry, accepted_by=""))
    return register.with_held(unit_id, ()).with_unit(unit_id, replace(unknown, claim=None))


def on_line_after_all(register: Register, unit_id: str, epoch: int) -> Step:
    """If a unit counts as outside: it is on the line, and may be anywhere, so it is unknown again, and asked.

    Who holds anything of the line is told to stop, and is asked as well: the answer says what must be swept.
    """
    if register.unit(unit_id).standing is not UnitStanding.OUTSIDE:
        return register, ()
    unit = RegisteredUnit(
        UnitStanding.UNKNOWN, epoch, claim_needed=register.unit(unit_id).claim_needed, taken_back=True
    )
    register, locked = to_be_swept(register.with_unit(unit_id, unit), register.plan.order)
    register = replace(register, ledger=register.ledger | {unit_id}, ask_at_s=AT_ONCE_S)
    why = "it counts as outside, and signs on without knowing what it holds"
    return register, (Show(Contradicted(unit_id=unit_id, why=why)), *locked)


def swept(register: Register, unit_id: str, section_ids: Iterable[str]) -> Step:
    """What the unit held, and its train has run through on sight, is empty but for it."""
    held = register.held_by(unit_id)
    empty = tuple(s for s in register.on_sight(section_ids) if s in held)
    if not empty:
        return register, ()
    left = replace(register, unswept=register.unswept.difference(empty))
    return left, (Show(Swept(unit_id=unit_id, section_ids=empty)),)


def _forget_words_of_speakers(register: Register) -> Register:
    """Of a running line, words are kept only while a first one waits for the second."""
    for unit_id in {unit_id for _, unit_id in register.reentry.complete}:
        unheard = register.unit(unit_id).standing in (UnitStanding.BY_HAND, UnitStanding.UNKNOWN)
        if not (unheard or unit_id in register.doubted):
            register = without_words(register, unit_id)
    return register


def without_words(register: Register, unit_id: str, person: str | None = None) -> Register:
    """The register without what was entered for the unit, by anyone or by one person."""
    entries: dict[str, Mapping[str, str | None]] = {}
    for section_id, by in register.reentry.entries.items():
        kept = {p: unit for p, unit in by.items() if unit != unit_id or person not in (None, p)}
        if kept:
            entries[section_id] = kept
    complete = frozenset(
        (p, unit) for p, unit in register.reentry.complete if unit != unit_id or person not in (None, p)
    )
    left_by = {key: place for key, place in register.reentry.left_by.items() if key in complete}
    return replace(
        register, reentry=replace(register.reentry, entries=entries, complete=complete, left_by=left_by)
    )


def with_entry(register: Register, person: str, section_id: str, unit_id: str | None) -> Register:
    """The register with one section entered by the person; an earlier entry of theirs is corrected."""
    by = {**register.reentry.entries.get(section_id, {}), person: unit_id}
    entries = {**register.reentry.entries, section_id: by}
    return replace(register, reentry=replace(register.reentry, entries=entries))


def with_word(
    register: Register, person: str, unit_id: str, section_ids: Iterable[str], place: str = ""
) -> Register:
    """The register with all that the person says the unit holds; empty: it is outside, and left by `place`."""
    register = without_words(register, unit_id, person)
    for section_id in section_ids:
        register = with_entry(register, person, section_id, unit_id)
    complete = register.reentry.complete | {(person, unit_id)}
    left_by = {**register.reentry.left_by, (person, unit_id): place}
    return replace(register, reentry=replace(register.reentry, complete=complete, left_by=left_by))


def released(register: Register, unit_id: str, section_ids: Iterable[str]) -> Register:
    """The unit itself has given sections back: entries for it there mean free from now on."""
    if not register.restoring:
        return register
    for section_id in section_ids:
        for person, unit in register.reentry.entries.get(section_id, {}).items():
            if unit == unit_id:
                register = with_entry(register, person, section_id, None)
    return register
