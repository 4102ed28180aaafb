"""Faults of what a unit says: it is mad, or its key is stolen, and what comes under its name is not so.

Its claims name a section that it does not hold: one unasked as this begins, then each with which it answers. All else
that it does is right: its train runs to the end of what it really holds, and a unit that does not know where its train
is says so. A claim of too little would be a word by which a unit frees what its train stands in: against that no
manager can guard, and it is outside the design.
"""

from __future__ import annotations

from pydantic import Field

from network.files.names import Identifier
from network.files.toml_input import one_of
from simulation.faults.fault import Names, UnitFault


class SpeechFault(UnitFault[tuple[str, ...]]):
    """What a unit claims besides what it holds."""

    changes = "claims"

    def base(self) -> tuple[str, ...]:
        return ()


class FalseClaims(SpeechFault):
    """The unit claims a section that it does not hold."""

    kind = "false_claims"
    section: Identifier = Field(description="which section it claims")

    def wrong_names(self, names: Names) -> dict[str, str]:
        known = self.section in names.sections
        return {} if known else {"section": f"a section: {one_of(names.sections, self.section)}"}

    def over(self, claimed: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(dict.fromkeys((*claimed, self.section)))
