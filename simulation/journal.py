"""What happened, in order, one JSON object a line; two runs are the same when their journals are, to the byte."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import blake2b
from pathlib import Path
from typing import Final

import msgspec

from network.errors import InputError
from simulation.events import Entry, Event

_ENCODER: Final = msgspec.json.Encoder()
_EVENT: Final[msgspec.json.Decoder[Event]] = msgspec.json.Decoder(Event)


class _Head(msgspec.Struct, frozen=True):
    """The beginning of a line."""

    t: float
    who: str


_HEAD: Final = msgspec.json.Decoder(_Head)


class Journal:
    """Lines are flat: `t` (simulated s), `who`, `what`, then data. Watchers see each entry as it is written."""

    def __init__(self) -> None:
        self.entries: list[Entry] = []
        self._lines: list[bytes] = []
        self._hash = blake2b(digest_size=16)
        self._watchers: list[Callable[[Entry], None]] = []

    def watch(self, watcher: Callable[[Entry], None]) -> None:
        """Show every further entry to `watcher`."""
        self._watchers.append(watcher)

    def write(self, t_s: float, who: str, event: Event) -> None:
        """Write an entry."""
        entry = Entry(t_s, who, event)
        line = encode_entry(entry)
        self._hash.update(line)
        self._hash.update(b"\n")
        self._lines.append(line)
        self.entries.append(entry)
        for watcher in self._watchers:
            watcher(entry)

    def add_to_digest(self, data: bytes) -> None:
        """Let something that is not an entry count for sameness too (the trajectories)."""
        self._hash.update(data)

    def digest(self) -> str:
        """blake2b of all that was written, 32 hex digits."""
        return self._hash.hexdigest()

    def to_bytes(self) -> bytes:
        """The journal file."""
        return b"\n".join([*self._lines, b""])


def encode_entry(entry: Entry) -> bytes:
    """The line of an entry, without its end."""
    head = _ENCODER.encode(_Head(entry.t_s, entry.who))
    return head[:-1] + b"," + _ENCODER.encode(entry.event)[1:]


def decode_entry(line: bytes) -> Entry:
    """The entry of a line. Raises msgspec.DecodeError for one that no run can have written."""
    head = _HEAD.decode(line)
    return Entry(head.t, head.who, _EVENT.decode(line))


def read_journal(path: Path) -> list[Entry]:
    """The entries of a journal file, in order. InputError naming the line that is none."""
    try:
        lines = path.read_bytes().splitlines()
    except OSError as error:
        raise InputError(str(path), "", None, "a journal that can be read") from error
    entries: list[Entry] = []
    for number, line in enumerate(lines, 1):
        try:
            entries.append(decode_entry(line))
        except (msgspec.MsgspecError, UnicodeDecodeError) as error:
            shown = line[:80].decode(errors="replace")
            raise InputError(str(path), f"line {number}", shown, f"a line of a journal: {error}") from error
    return entries
