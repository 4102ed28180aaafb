"""Durable state of a device: what a power cut must not lose. Written aside, synced, renamed; checked when
read.
"""

from __future__ import annotations

import os
from hashlib import blake2b
from pathlib import Path
from typing import Protocol, TypeVar

import msgspec

from network.errors import InputError
from wayside.point_terminal import Memory

T = TypeVar("T")
_DIGEST_BYTES = 16
_LENGTH_BYTES = 4


class Durable(msgspec.Struct, frozen=True):
    """Boot epoch of the device (0: never started), the memory of a terminal, the ledger of a block manager.

    `ledger`: the units that are on the line; None: lost, so any may be.
    """

    epoch: int = 0
    memory: Memory = Memory()
    ledger: tuple[str, ...] | None = ()


class _Head(msgspec.Struct, frozen=True, array_like=True):
    """What a device cannot start without."""

    epoch: int
    memory: Memory


class Store(Protocol):
    """Where a device keeps its durable state."""

    def load(self) -> Durable:
        """What was saved last; a device that never ran has epoch 0. Raises InputError if it is damaged."""
        ...

    def save(self, durable: Durable) -> None:
        """Keep it: when this returns, a power cut no longer loses it."""
        ...


class MemoryStore:
    """Outlives a killed device in the same process."""

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
    epochs and tokens. A damaged ledger is a lost one.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def load(self) -> Durable:
        """What was saved last; a missing file is a device that never ran."""
        try:
            data = self._path.read_bytes()
        except FileNotFoundError:
            return Durable()
        split = _LENGTH_BYTES + int.from_bytes(data[:_LENGTH_BYTES])
        head = _unsealed(data[_LENGTH_BYTES:split], _Head)
        if head is None:
            raise InputError(str(self._path), "", None, "an undamaged durable state of a device")
        return Durable(head.epoch, head.memory, _unsealed(data[split:], tuple[str, ...]))

    def save(self, durable: Durable) -> None:
        """Write aside, sync, rename, sync the directory."""
        head = _sealed(_Head(durable.epoch, durable.memory))
        ledger = b"" if durable.ledger is None else _sealed(durable.ledger)
        aside = self._path.with_suffix(".new")
        with aside.open("wb") as file:
            file.write(len(head).to_bytes(_LENGTH_BYTES) + head + ledger)
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
