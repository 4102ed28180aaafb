"""What happened, in order, one JSON object a line; two runs are the same when their journals are, to the byte."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from hashlib import blake2b
from typing import Any, Final

import msgspec

Entry = Mapping[str, Any]
_ENCODER: Final = msgspec.json.Encoder()


class Journal:
    """Entries are flat: `t` (simulated s), `who`, `what`, then data. Watchers see each entry as it is written."""

    def __init__(self) -> None:
        self.entries: list[Entry] = []
        self._lines: list[bytes] = []
        self._hash = blake2b(digest_size=16)
        self._watchers: list[Callable[[Entry], None]] = []

    def watch(self, watcher: Callable[[Entry], None]) -> None:
        """Show every further entry to `watcher`."""
        self._watchers.append(watcher)

    def write(self, t_s: float, who: str, what: str, **data: object) -> None:
        """Write an entry."""
        entry = {"t": t_s, "who": who, "what": what, **data}
        line = _ENCODER.encode(entry)
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
