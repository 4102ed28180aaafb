"""What the protocol machines ask their host to do."""

from __future__ import annotations

from dataclasses import dataclass

from radio.messages import AnyMessage
from wayside.said import Note, Output


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
