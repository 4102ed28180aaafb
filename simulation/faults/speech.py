"""Faults of what a unit claims: the unit is defective, or its key is stolen.

Its claims name a section that it does not hold: one claim unasked when the fault begins, then each answer. Everything
else is right: the train runs to the end of what it really holds, and a unit that does not know where its train is says
so. A claim of too little would free a section in which the train stands. No block manager can guard against that; it is
outside the design.
"""

from __future__ import annotations

from pydantic import Field

from network.files.names import Identifier
from network.files.toml_input import one_of
from simulation.faults.fault import Names, UnitFault


class SpeechFault(UnitFault[tuple[str, ...]]):
    """What a unit claims besides what it holds."""

    changes = "claims"
    in_order = ()


class FalseClaims(SpeechFault):
    """The unit claims a section that it does not hold."""

    kind = "false_claims"
    section: Identifier = Field(description="which section it claims")

    def wrong_names(self, names: Names) -> dict[str, str]:
        known = self.section in names.sections
        return {} if known else {"section": f"a section: {one_of(names.sections, self.section)}"}

    def applied_to(self, claimed: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*claimed, self.section)))
