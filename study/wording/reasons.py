"""Why something was refused, stopped or doubted: the journal's own words (`why`) as people say them.

The words are those of enums and constants of who writes them; what stands after a colon is whose or what it is about.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from study.wording.catalogue import phrases_of
from study.wording.forms import phrase_by_form
from study.wording.parties import party
from study.wording.phrase import NOTHING, Names, Phrase, joined_phrases

# What parties note down in fewer words than a person needs.
_SAID_IN_FULL: Final[Mapping[str, str]] = {
    "no power": "it has no power",
    "frozen": "it does nothing (frozen)",
    "cable cut": "the cable to the centre is cut",
    "undefined": "the block manager does not yet know what every unit holds",
    "unknown route": "there is no such route",
    "unknown section": "there is no such section",
    "not connected": "the train does not hold the section before the route",
    "not signed on": "the unit has not signed on since its restart",
    "still holding": "the train holds more than the portal",
    "stale token": "the unit's token is not the newest",
    "claim needed": "a person must say what the train holds",
    "wrong unit": "the unit named is not the sender",
    "unknown points": "the terminal has no such points",
    "wrong section": "the points lie in another section",
    "bad capability": "the terminal cannot verify the grant",
    "old token": "a newer holder has commanded since",
    "locked": "the points are locked in the other position",
    "not detected": "position or lock was not detected in time",
    "locked by hand": "a crew has locked the points by hand",
    "doors not closed": "its doors are not shown as closed",
    "brake not in order": "its brake is not in order",
    "the register has less": "the register has less than the train holds",
    "held": "another unit holds a section asked for",
    "unknown token": "the token was never granted",
    "no way on": "not every train could finish its day",
    "not its turn": "another train goes first",
    "overlap": "another train must stand first",
    "barred": "the unit is barred",
    "unknown track": "the train has no such way",
    "may have entered": "the train may have entered the route",
    "no name": "the word has no name",
    "too early": "too early: a telegram to the unit may still be on the air",
    "claim refused": "its claim was refused",
    "lost": "the proof was lost",
    "not held": "the section is not held",
    "no mission": "no train taken up",
    "brake too weak": "the brake is too weak",
    "target not seen": "no beacon or sign where one was due",
    "sign beyond limit": "the mark lies beyond the stop limit",
    "expected tag was not read": "an expected tag was not read",
    "old epoch": "of an earlier boot",
}


def reason(why: str, names: Names = MappingProxyType({})) -> Phrase:
    """A `why` of the journal, in words; as it is where it has no other. `names` are those of stations by id."""

    def said(part: str) -> Phrase:
        return reason(part.strip(), names)

    word = why.strip().lower().replace("_", " ")
    if not word:
        return NOTHING
    reasons = phrases_of("reason")
    known = reasons.get(_SAID_IN_FULL.get(word, word))
    if known is not None:
        return known
    named = phrase_by_form(reasons.values(), why, said)
    if named is not None:
        return named
    head, colon, rest = why.partition(":")
    if colon:
        of, about = said(head), said(rest)
        return Phrase(f"{of.en} ({about.en})", f"{of.in_('ja')}（{about.in_('ja')}）")
    if "," in why:
        return joined_phrases(map(said, why.split(",")))
    known = names.get(why) or phrases_of("telegram").get(why) or phrases_of("working step").get(why)
    return known or party(why)
