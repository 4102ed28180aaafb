"""What the host needs of a party, whatever it decides: a boot number, and one door that takes and gives bytes.

A party (a wayside device, an on-board unit) is told and says what its role alone understands: `told` and
`said` are the records of a `Codec`, opaque to whoever carries them. Adding a role is a member of `Role`, a
case of `host.boot`, and the module that the case names; transport, time plane and processes stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Final, Generic, Protocol, TypeVar

import msgspec

from network.errors import InputError
from radio.keys import KeyRing

Told = TypeVar("Told", bound=msgspec.Struct)
Said = TypeVar("Said", bound=msgspec.Struct)


class Role(Enum):
    """What a party is; the value is the subcommand of `python -P -m host.serve`."""

    BLOCK_MANAGER = "block-manager"
    POINT_TERMINAL = "point-terminal"
    LEVEL_CROSSING = "level-crossing"
    UNIT = "unit"


_CALLED: Final = {
    Role.BLOCK_MANAGER: "block manager",
    Role.POINT_TERMINAL: "point terminal {}",
    Role.LEVEL_CROSSING: "level crossing {}",
    Role.UNIT: "on-board unit {}",
}


class PartySpec(msgspec.Struct, frozen=True):
    """What is needed to start a party; `config` is the JSON of its role's fixed data (固定データ)."""

    line_id: str
    party_id: str
    role: Role
    config: bytes
    keys: KeyRing
    asks_solver: bool = False  # and waits for it before it answers

    @property
    def called(self) -> str:
        """What a person calls it; a line has one block manager."""
        return _CALLED[self.role].format(self.party_id)


class Advance(msgspec.Struct, frozen=True):
    """What a party did when advanced: telegrams as (destination, bytes), what its role says besides, and when
    it wants to be asked next; None: only when something comes.
    """

    telegrams: tuple[tuple[str, bytes], ...]
    said: bytes
    wake_at_s: float | None


class Party(Protocol):
    """One running party. Making it is a boot: the epoch is raised and saved before anything leaves it."""

    @property
    def epoch(self) -> int:
        """Number of this boot, from 1."""
        ...

    def advance(self, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Act at `now_s` on what it is told, telegrams and timers. Raises InputError for bytes of another role."""
        ...


class Codec(Generic[Told, Said]):
    """What a role is told and says, as bytes; the same codec stands on both sides."""

    def __init__(self, told: type[Told], said: type[Said]) -> None:
        self._told = msgspec.msgpack.Decoder(told)
        self._said = msgspec.msgpack.Decoder(said)
        self._encoder = msgspec.msgpack.Encoder()

    def encode(self, record: Told | Said) -> bytes:
        """Either record as bytes."""
        return self._encoder.encode(record)

    def decode_told(self, data: bytes) -> Told:
        """What a party of this role is told. Raises InputError."""
        return _decoded(self._told, data)

    def decode_said(self, data: bytes) -> Said:
        """What a party of this role said. Raises InputError."""
        return _decoded(self._said, data)


Record = TypeVar("Record", bound=msgspec.Struct)


def _decoded(decoder: msgspec.msgpack.Decoder[Record], data: bytes) -> Record:
    try:
        return decoder.decode(data)
    except msgspec.MsgspecError as error:
        raise InputError("host", "record", f"{len(data)} bytes", f"a record of this role ({error})") from None
