"""Who does, says and hears something: devices, persons, the world. Ids of units and terminals are names."""

from __future__ import annotations

from typing import Final

from study.wording.catalogue import phrase_or_name
from study.wording.phrase import Phrase

ANY_PARTY: Final = "any party"


def party(name: str) -> Phrase:
    """What people call a party; its id where that is its name."""
    return phrase_or_name(ANY_PARTY if name == "*" else name, "party")
