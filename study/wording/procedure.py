"""Substitute working in words, of the tables of `simulation.procedure`: who, which step, what is said, what waits."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from simulation.faults.script import Act
from simulation.procedure import PROCEDURES, WITHIN_STATION, ProcedureRow
from study.wording.catalogue import phrase, phrase_or_name
from study.wording.phrase import NOTHING, Phrase

_SAYS: Final = MappingProxyType(
    {row.step.value: row.says for rows in (*PROCEDURES.values(), WITHIN_STATION) for row in rows}
)


def step_name(step: object) -> Phrase:
    """What people call a step."""
    return phrase_or_name(str(step), "working step")


def role_name(role: object) -> Phrase:
    """Who acts, or is spoken to."""
    return phrase_or_name(str(role), "role")


def says_text(step: str, block: str, train: str) -> Phrase:
    """What is said as a step is done; the step itself where there is none of this name."""
    words = _SAYS.get(step)
    return step_name(step) if words is None else phrase(words, "procedure").fill(block=block, train=train)


def waits_text(row: ProcedureRow) -> Phrase:
    """What of the world a step waits for."""
    return phrase(row.waits, "procedure") if row.waits else NOTHING


def act_step(act: Act) -> Phrase:
    """The step that an act of a script does or leaves out, with where and for which train; empty for other acts."""
    if not act.step:
        return NOTHING
    where = " ".join(filter(None, (act.block, act.train)))
    return Phrase(f"{act.step} {where}", f"{step_name(act.step).in_('ja')} {where}")
