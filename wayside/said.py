"""What wayside devices are told and say besides telegrams: inputs, outputs, and lines of their journal.

Points stand in the simulated world; a terminal drives them by outputs and sees them by inputs, as a real one does by
relays (転てつ機制御出力・表示入力, table 4 of Sugiyama et al. 2017). Persons' words are inputs of the block manager.
"""

from __future__ import annotations

from enum import Enum

import msgspec

from network.model import Position


class ConfirmOutside(msgspec.Struct, frozen=True, array_like=True, tag=1):
    """Operator to manager: `person` has made sure that the unit is off the line."""

    unit_id: str
    person: str


class ConfirmHolding(msgspec.Struct, frozen=True, array_like=True, tag=2):
    """Operator to manager: by-hand entry (手動入力) of all that a silent unit occupies and holds."""

    unit_id: str
    section_ids: tuple[str, ...]
    person: str


class PointsDetected(msgspec.Struct, frozen=True, array_like=True, tag=3):
    """World to terminal: what the detection contacts show, at each change and after a restart. None:
    neither.
    """

    points_id: str
    position: Position | None
    locked: bool


class EnterSection(msgspec.Struct, frozen=True, array_like=True, tag=4):
    """Operator to manager, after its restart: this section belongs to that unit; None: it is free (手動入力)."""

    section_id: str
    unit_id: str | None
    person: str


class AcceptPicture(msgspec.Struct, frozen=True, array_like=True, tag=5):
    """Operator to manager, after its restart: `person` has looked at the whole line as it is shown; it is right."""

    person: str


Input = ConfirmOutside | ConfirmHolding | PointsDetected | EnterSection | AcceptPicture


class StartThrow(msgspec.Struct, frozen=True, array_like=True, tag=1):
    """Terminal to world: unlock, run the motor to this position, lock."""

    points_id: str
    position: Position


class StopThrow(msgspec.Struct, frozen=True, array_like=True, tag=2):
    """Terminal to world: motor off, because position or lock was not proven in time."""

    points_id: str


Output = StartThrow | StopThrow


class NoteKind(Enum):
    """What a device writes in the journal."""

    STARTED = "started"  # token: the boot epoch
    DROPPED = "dropped"  # a telegram; detail: the reason
    GRANTED = "granted"
    REFUSED = "refused"  # detail: the reason; other_id: who holds section_ids[0]
    FREED = "freed"
    CLAIMED = "claimed"  # taken on the unit's own word: sign-on, claim
    OUTSIDE = "outside"
    BY_HAND = "by hand"  # detail: the person
    ENTERED = "entered"  # re-entry: a person's word taken down, not yet in force; detail: the person
    PICTURE = "picture"  # re-entry: what the whole line is now; detail: how complete, after how many inputs
    CONTRADICTION = "contradiction"  # shown to the operator; other_id: the other holder
    COMMANDED = "commanded"  # points: section_ids[0] is the section, detail the points and position
    PROVEN = "proven"
    UNPROVEN = "unproven"


class Note(msgspec.Struct, frozen=True, array_like=True):
    """One line of a device's journal. `device_id` and time are added by who keeps the journal."""

    kind: NoteKind
    unit_id: str = ""
    section_ids: tuple[str, ...] = ()
    token: int = 0
    other_id: str = ""
    detail: str = ""
