"""Durable state of a device: what a power cut must not lose. Written aside, synced, renamed; checked when
read.
"""

from __future__ import annotations

import os
from hashlib import blake2b
from pathlib import Path
from typing import Protocol

import msgspec

from network.errors import InputError
from wayside.point_terminal import Memory

_DIGEST_BYTES = 16


class Durable(msgspec.Struct, frozen=True):
    """Boot epoch of the device (0: never started) and the memory of a terminal."""

    epoch: int = 0
    memory: Memory = Memory()


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
    """A file with a digest in front. A damaged one is refused: starting from zero would repeat epochs and
    tokens.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def load(self) -> Durable:
        """What was saved last; a missing file is a device that never ran."""
        try:
            data = self._path.read_bytes()
        except FileNotFoundError:
            return Durable()
        digest, body = data[:_DIGEST_BYTES], data[_DIGEST_BYTES:]
        try:
            if blake2b(body, digest_size=_DIGEST_BYTES).digest() == digest:
                return msgspec.msgpack.decode(body, type=Durable)
        except msgspec.MsgspecError:
            pass
        raise InputError(str(self._path), "", None, "an undamaged durable state of a device")

    def save(self, durable: Durable) -> None:
        """Write aside, sync, rename, sync the directory."""
        body = msgspec.msgpack.encode(durable)
        aside = self._path.with_suffix(".new")
        with aside.open("wb") as file:
            file.write(blake2b(body, digest_size=_DIGEST_BYTES).digest() + body)
            file.flush()
            os.fsync(file.fileno())
        aside.replace(self._path)
        directory = os.open(self._path.parent, os.O_RDONLY)
        try:
            os.fsync(directory)
        finally:
            os.close(directory)
