"""What every line of the journal has in common, and the life of a telegram, which every party tells in the same way.

Invariant: a telegram takes effect at its receiver at most once for each boot of its sender, so whoever lets one
in says which one it was (`TookEffect`). Sent, lost on the way, dropped by the receiver, took effect: nothing else
becomes of a telegram, whether manager, terminal or unit receives it. Pure data, without any rule.
"""

from __future__ import annotations

from enum import Enum
from typing import Generic, TypeVar

import msgspec

Word = TypeVar("Word", str, str | None)
Number = TypeVar("Number", int, int | None)


def key_of(field: str) -> str:
    """Key of a field in a line of the journal: an id goes by the word for the thing (`unit_id`: `unit`)."""
    if field.endswith("_ids"):
        return field.removesuffix("_ids") + "s"
    return field.removesuffix("_id")


class Noted(
    msgspec.Struct, frozen=True, kw_only=True, tag_field="what", tag="", rename=key_of, omit_defaults=True
):
    """One line of the journal but for its time and author; its tag is its `what`. A default is left out."""


class LostWhere(Enum):
    """Where a telegram was lost."""

    AIR = "the air"
    NO_COVERAGE = "no coverage"
    CABLE = "the cable"  # cut between the centre and one of the two
    RECEIVER_OFF = "receiver off"


class TelegramNoted(Noted, Generic[Word, Number], frozen=True, kw_only=True):
    """What every note of a telegram says of it; a telegram that cannot be read has None for its header's terms."""

    source: Word
    receiver: str
    epoch: Number
    sequence: Number
    kind: Word
    correlation: Number


class Sent(TelegramNoted[str | None, int | None], frozen=True, kw_only=True, tag="sent"):
    """A telegram went into the air; `arrives_s` has a time for each copy on its way, none when it is lost.

    None: the sender made what cannot be read.
    """

    source: str
    size_bytes: int
    arrives_s: tuple[float, ...]


class Lost(TelegramNoted[str | None, int | None], frozen=True, kw_only=True, tag="lost"):
    """A telegram did not reach its receiver. What was damaged on its way cannot be read: None."""

    where: LostWhere


class TelegramDropped(
    TelegramNoted[str | None, int | None], frozen=True, kw_only=True, tag="telegram_dropped"
):
    """A receiver's checks refused a telegram. None: not to be read, or not proven to be true."""

    why: str


class TookEffect(TelegramNoted[str, int], frozen=True, kw_only=True, tag="took_effect"):
    """A telegram passed its receiver's checks and was acted on."""
