"""What each event of the journal is called, in few words; the English ones are the journal's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from simulation.events import EVENTS, EventType, word_of
from study.wording.catalogue import phrase_or_name
from study.wording.phrase import Phrase

EVENT_NAMES: Final[Mapping[EventType, Phrase]] = {
    event: phrase_or_name(word_of(event).replace("_", " "), "event") for event in EVENTS.values()
}
