"""The line as the person sees it during re-entry: claims, silences, entries and contradictions side by side.

A pure view of the register (誤入力を防ぐインタフェース, the proposal of section 4.4 (4) of Sugiyama et al. 2017).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from wayside import reentry
from wayside.reentry import Contradiction, Missing
from wayside.register import ReentryStage, Register, UnitStanding


@dataclass(frozen=True, slots=True)
class UnitView:
    """A unit. `claim`: its own word, None if it has not said. `words`: all it holds, as persons say, by person.

    `silent_since_s`: when it was last heard in this boot, or the manager's start; None once it has said what it
    holds. `vouched`: nothing more is needed about it.
    """

    unit_id: str
    standing: UnitStanding
    claim: tuple[str, ...] | None
    sections: tuple[str, ...]
    words: tuple[tuple[str, tuple[str, ...]], ...]
    on_ledger: bool
    silent_since_s: float | None
    vouched: bool


@dataclass(frozen=True, slots=True)
class SectionView:
    """A section. `defined`: whether no holder means free. `entered`: unit by person, None for free."""

    section_id: str
    holder: str | None
    defined: bool
    entered: tuple[tuple[str, str | None], ...]


@dataclass(frozen=True, slots=True)
class Picture:
    """All of it. `inputs`: by person; times in s, `defined_s` None while the line is not defined again."""

    stage: ReentryStage
    units: tuple[UnitView, ...]
    sections: tuple[SectionView, ...]
    contradictions: tuple[Contradiction, ...]
    missing: Missing
    inputs: tuple[tuple[str, int], ...]
    accepted_by: str
    started_s: float | None
    defined_s: float | None

    @property
    def complete(self) -> bool:
        """Whether nothing is missing and nothing contradicts."""
        return not self.missing


def picture(register: Register) -> Picture:
    """What the person sees now."""
    return Picture(
        reentry.stage(register),
        tuple(_unit(register, unit_id) for unit_id in register.plan.unit_ids),
        tuple(_section(register, section_id) for section_id in register.plan.order),
        reentry.contradictions(register),
        reentry.missing(register),
        _sorted(register.reentry.inputs),
        register.reentry.accepted_by,
        register.started_s,
        register.reentry.defined_s,
    )


def _unit(register: Register, unit_id: str) -> UnitView:
    unit, held = register.unit(unit_id), register.held_by(unit_id)
    says = {
        UnitStanding.REPORTED: held,
        UnitStanding.LEAVING: held,
        UnitStanding.OUTSIDE: (),
        UnitStanding.DISPUTED: unit.claim,
    }
    words = reentry.words_for(register, unit_id).items()
    heard_s = register.reentry.heard_s.get(unit_id, register.started_s)
    return UnitView(
        unit_id,
        unit.standing,
        says.get(unit.standing),
        held,
        tuple((person, tuple(sorted(word, key=register.plan.order.__getitem__))) for person, word in words),
        unit_id in register.ledger,
        heard_s if unit.standing in (UnitStanding.UNKNOWN, UnitStanding.BY_HAND) else None,
        reentry.vouched(register, unit_id),
    )


def _section(register: Register, section_id: str) -> SectionView:
    entered = register.reentry.entries.get(section_id, {})
    return SectionView(
        section_id,
        register.holders.get(section_id),
        register.defined or section_id in register.holders,
        tuple(sorted(entered.items())),
    )


def _sorted(counts: Mapping[str, int]) -> tuple[tuple[str, int], ...]:
    return tuple(sorted(counts.items()))
