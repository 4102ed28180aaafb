"""What the protocol machines ask their host to do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from radio.messages import AnyMessage
from wayside.said import Note, NoteKind, Output


@dataclass(frozen=True, slots=True)
class Send:
    """A message to a unit. An answer carries the correlation of what it answers."""

    destination: str
    message: AnyMessage
    correlation: int = 0


@dataclass(frozen=True, slots=True)
class Show:
    """A line in the journal, and before the operator if it is a contradiction."""

    note: Note


@dataclass(frozen=True, slots=True)
class Drive:
    """A relay output to the machine in the world."""

    output: Output


Action = Send | Show | Drive


def show(
    kind: NoteKind,
    unit_id: str = "",
    section_ids: Iterable[str] = (),
    token: int = 0,
    other_id: str = "",
    detail: str = "",
) -> Show:
    """A line of the block manager's journal."""
    return Show(Note(kind, unit_id, tuple(section_ids), token, other_id, detail))
