"""A telegram as the block manager hears it, and the answers that several of its handlers give."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

import msgspec

from radio.messages import ClaimQuery, RefusalReason
from wayside.actions import Send, Show
from wayside.reentry import Step
from wayside.register import Register
from wayside.said import Refused

M = TypeVar("M")


class Heard(msgspec.Struct, Generic[M], frozen=True):
    """A telegram passed the envelope's checks. `fresh`: its sender has heard this boot of the manager."""

    unit_id: str
    epoch: int
    fresh: bool
    correlation: int
    message: M


def challenge(register: Register, heard: Heard[Any]) -> Step:
    """Ask: a claim may date from before this boot, but not the answer to this."""
    return register, (Send(heard.unit_id, ClaimQuery(), heard.correlation),)


def show_refusal(
    unit_id: str, reason: RefusalReason, section_id: str | None = None, holder: str | None = None
) -> Show:
    """A refusal for the journal, and what stands against it."""
    sections = () if section_id is None else (section_id,)
    return Show(Refused(unit_id=unit_id, section_ids=sections, other_id=holder or "", why=reason.name))
