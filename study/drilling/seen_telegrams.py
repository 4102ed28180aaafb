"""The telegrams of a run as the grid of telegrams counts them: as they are sent, and as they take effect.

A telegram that is lost changes nobody but its sender, and when that says the same again and is not heard again, not
even the sender learns anything: such a repeat is marked.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from typing import Final

import msgspec

from radio.noted import Lost, Sent, TelegramNoted, TookEffect
from simulation.events import JournalEntry
from simulation.setup import STEPS_PER_S

Place = tuple[str, float]  # alignment and kilometrage, m
_Key = tuple[str | None, str, int | None, int | None]


class SeenTelegram(msgspec.Struct, frozen=True):
    """A telegram as it is sent, with its train's place, or as it takes effect.

    `is_lost`: it never takes effect. `is_repeat`: its sender has said the same, in vain too, since it last heard or
    reached anybody.
    """

    step: int
    source: str
    receiver: str
    place: Place | None = None
    is_sent: bool = False
    is_lost: bool = False
    is_repeat: bool = False

    @property
    def party(self) -> str:
        """Who says it, or who hears it."""
        return self.source if self.is_sent else self.receiver


class TelegramWatch:
    """Watches the journal of a run. `place_of` is where the radio reaches a train, None for whoever is none."""

    def __init__(self, place_of: Callable[[str], Place | None]) -> None:
        self._place_of: Final = place_of
        self._sent: list[tuple[JournalEntry, Sent | TookEffect, Place | None]] = []
        self._lost: set[_Key] = set()
        self._took_effect: set[_Key] = set()

    def see(self, entry: JournalEntry) -> None:
        """An entry was written."""
        match entry.event:
            case Sent() as sent:
                place = self._place_of(sent.source) or self._place_of(sent.receiver)
                self._sent.append((entry, sent, place))
            case TookEffect() as taken:
                self._sent.append((entry, taken, None))
                self._took_effect.add(_key(taken))
            case Lost() as lost:
                self._lost.add(_key(lost))
            case _:
                pass

    def telegrams(self) -> list[SeenTelegram]:
        """All that were seen, in order."""
        lost = self._lost - self._took_effect
        in_vain: dict[str, set[tuple[str, str | None]]] = defaultdict(set)  # by party: to whom, what
        found: list[SeenTelegram] = []
        for entry, noted, place in self._sent:
            is_sent = isinstance(noted, Sent)
            is_lost = is_sent and _key(noted) in lost
            seen = SeenTelegram(
                round(entry.t_s * STEPS_PER_S), noted.source, noted.receiver, place, is_sent, is_lost
            )
            said = in_vain[seen.party]
            if not is_lost:
                said.clear()
            found.append(msgspec.structs.replace(seen, is_repeat=(noted.receiver, noted.kind) in said))
            if is_lost:
                said.add((noted.receiver, noted.kind))
        return found


def _key(noted: TelegramNoted[str, int] | TelegramNoted[str | None, int | None]) -> _Key:
    return noted.source, noted.receiver, noted.epoch, noted.sequence
