"""Durable state of a party: what a power cut must not lose. Written aside, synced, renamed; checked when read.

People commission a party (使用開始): an act of theirs, which `commission` writes down. A store without it is
blank: lost, or never used. From the store alone nobody can tell which, so no party starts from one.
"""

from __future__ import annotations

import os
from hashlib import blake2b
from pathlib import Path
from typing import Final, Protocol, TypeVar

import msgspec

from network.errors import InputError

T = TypeVar("T")
_DIGEST_BYTES = 16
_LENGTH_BYTES = 4
BOOTS_BITS: Final = 16  # a party boots less often than 2^16 times before it is commissioned again


class Durable(msgspec.Struct, frozen=True):
    """Boot epoch of the party, how often people have commissioned it, and what its role keeps, as the role's own bytes.

    Epoch 0: never started; `commissioned` 0: the store is blank. `vital`: without it the party must not start.
    `spare`: it may be lost, and the role knows what that means; None: lost. Both are empty in a party that never ran.
    """

    epoch: int = 0
    vital: bytes = b""
    spare: bytes | None = b""
    commissioned: int = 0


class NotCommissioned(InputError):  # noqa: N818 - names what happened
    """A party has power, but its store is blank: people must commission it."""

    def __init__(self, called: str) -> None:
        super().__init__(called, "durable", None, "a durable state: it is lost, so people must commission it")


class _StoreHead(msgspec.Struct, frozen=True, array_like=True):
    """What a party cannot start without."""

    epoch: int
    vital: bytes
    commissioned: int


class PartyStore(Protocol):
    """Where a party keeps its durable state."""

    def load(self) -> Durable:
        """What was saved last; nothing of a blank store. Raises InputError if it is damaged."""
        ...

    def save(self, durable: Durable) -> None:
        """Keep it: when this returns, a power cut no longer loses it."""
        ...


def commission(store: PartyStore, number: int = 1, vital: bytes = b"") -> None:
    """People put a party into service, for the `number`th time by their own record, with a `vital` of theirs.

    Its epochs then begin beyond all that it can have had, so peers take it for a new boot, and it drops whatever they
    said to an earlier one. What it kept besides is lost from the second time on.
    """
    spare = b"" if number == 1 else None
    store.save(Durable((number - 1) << BOOTS_BITS, vital, spare, number))


def commissioned(store: PartyStore, called: str) -> PartyStore:
    """The store. Raises NotCommissioned if it is blank."""
    if store.load().commissioned == 0:
        raise NotCommissioned(called)
    return store


def raise_epoch(store: PartyStore) -> Durable:
    """A boot: the next epoch is kept before anything is said under it. Returns what was kept besides."""
    before = store.load()
    durable = msgspec.structs.replace(before, epoch=before.epoch + 1)
    store.save(durable)
    return durable


class MemoryStore:
    """Outlives a killed party in the same process."""

    def __init__(self) -> None:
        self._durable = Durable()

    def load(self) -> Durable:
        """What was saved last."""
        return self._durable

    def save(self, durable: Durable) -> None:
        """Keep it."""
        self._durable = durable


class FileStore:
    """A file of two parts, each behind its digest. A damaged head is refused: starting from zero would repeat
    epochs and tokens. A damaged `spare` is a lost one.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def load(self) -> Durable:
        """What was saved last; a missing file is a blank store."""
        try:
            data = self._path.read_bytes()
        except FileNotFoundError:
            return Durable()
        split = _LENGTH_BYTES + int.from_bytes(data[:_LENGTH_BYTES])
        head = _unsealed(data[_LENGTH_BYTES:split], _StoreHead)
        if head is None:
            raise InputError(str(self._path), "", None, "an undamaged durable state of a party")
        return Durable(head.epoch, head.vital, _unsealed(data[split:], bytes), head.commissioned)

    def save(self, durable: Durable) -> None:
        """Write aside, sync, rename, sync the directory."""
        head = _sealed(_StoreHead(durable.epoch, durable.vital, durable.commissioned))
        spare = b"" if durable.spare is None else _sealed(durable.spare)
        aside = self._path.with_suffix(".new")
        with aside.open("wb") as file:
            file.write(len(head).to_bytes(_LENGTH_BYTES) + head + spare)
            file.flush()
            os.fsync(file.fileno())
        aside.replace(self._path)
        directory = os.open(self._path.parent, os.O_RDONLY)
        try:
            os.fsync(directory)
        finally:
            os.close(directory)


def _sealed(value: object) -> bytes:
    body = msgspec.msgpack.encode(value)
    return blake2b(body, digest_size=_DIGEST_BYTES).digest() + body


def _unsealed(data: bytes, kind: type[T]) -> T | None:
    """The value behind its digest; None if it is damaged."""
    digest, body = data[:_DIGEST_BYTES], data[_DIGEST_BYTES:]
    if blake2b(body, digest_size=_DIGEST_BYTES).digest() != digest:
        return None
    try:
        return msgspec.msgpack.decode(body, type=kind)
    except msgspec.MsgspecError:
        return None
