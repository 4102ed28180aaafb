"""Who does, says and hears something: devices, persons, the world. Ids of units and terminals are names.

Those who work a line by substitute working are named by their role and its place.
"""

from __future__ import annotations

from typing import Final

from study.wording.catalogue import phrases_of
from study.wording.forms import phrase_by_form
from study.wording.phrase import Phrase

ANY_PARTY: Final = "any party"


def party(name: str) -> Phrase:
    """What people call a party; its id where that is its name."""
    known = phrases_of("party").get(ANY_PARTY if name == "*" else name)
    return known or phrase_by_form(phrases_of("post").values(), name, Phrase) or Phrase(name)
