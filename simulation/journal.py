"""What happened, in order, one JSON object a line; two runs are the same when their journals are, to the byte."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path
from typing import Final, overload

import msgspec

from network.errors import InputError
from simulation.events import Event, EventType, JournalEntry

_ENCODER: Final = msgspec.json.Encoder()
_EVENT: Final[msgspec.json.Decoder[Event]] = msgspec.json.Decoder(Event)
SPILL_BYTES: Final = 1 << 15


class _LineHead(msgspec.Struct, frozen=True):
    """The beginning of a line."""

    t: float
    who: str


_HEAD: Final = msgspec.json.Decoder(_LineHead)


class Journal:
    """Lines are flat: `t` (simulated s), `who`, `what`, then data. Watchers see each entry as it is written.

    With a `file` it grows there, in whole lines, and only its end is in memory. With `kept` only events of those types
    stay, as entries: watchers and digest still have all of them, and there are no lines to write.
    """

    def __init__(self, file: Path | None = None, *, kept: tuple[EventType, ...] | None = None) -> None:
        self._entries: list[JournalEntry] = []  # without a file: all of them
        self._lines: list[bytes] = []  # those not in the file
        self._kept = kept
        self._waiting_bytes = 0
        self._file = file
        self._hash = blake2b(digest_size=16)
        self._watchers: list[Callable[[JournalEntry], None]] = []
        if file is not None:
            file.write_bytes(b"")

    @property
    def file(self) -> Path | None:
        """Where it grows."""
        return self._file

    @property
    def entries(self) -> Sequence[JournalEntry]:
        """What was written, in order; read again each time where it is in a file."""
        return self._entries if self._file is None else _Spilled(self._file, self._lines)

    def watch(self, watcher: Callable[[JournalEntry], None]) -> None:
        """Show every further entry to `watcher`."""
        self._watchers.append(watcher)

    def write(self, t_s: float, who: str, event: Event) -> None:
        """Write an entry. OSError where its file takes no more."""
        entry = JournalEntry(t_s, who, event)
        line = encode_entry(entry)
        self._hash.update(line)
        self._hash.update(b"\n")
        if self._kept is not None:
            if isinstance(event, self._kept):
                self._entries.append(entry)
        elif self._file is None:
            self._lines.append(line)
            self._entries.append(entry)
        else:
            self._lines.append(line)
            self._waiting_bytes += len(line)
            if self._waiting_bytes >= SPILL_BYTES:
                self.spill()
        for watcher in self._watchers:
            watcher(entry)

    def spill(self) -> None:
        """Put into the file what waits for it. OSError where that takes no more: it then ends with a whole line."""
        if self._file is None:
            return
        data = _joined(self._lines)
        with self._file.open("ab", buffering=0) as stream:
            begin = stream.tell()
            done = 0
            try:
                while done < len(data):
                    done += stream.write(data[done:])
            except OSError as error:
                whole = data.rfind(b"\n", 0, done) + 1
                stream.truncate(begin + whole)
                del self._lines[: data.count(b"\n", 0, whole)]
                raise OSError(error.errno, error.strerror, str(self._file)) from error
        self._lines.clear()
        self._waiting_bytes = 0

    def moved(self, file: Path) -> None:
        """Its file is whole, and has another name."""
        self._file = file

    def add_to_digest(self, data: bytes) -> None:
        """Let something that is not an entry count for sameness too (the trajectories)."""
        self._hash.update(data)

    def digest(self) -> str:
        """blake2b of all that was written, 32 hex digits."""
        return self._hash.hexdigest()

    def to_bytes(self) -> bytes:
        """The journal file."""
        return (b"" if self._file is None else self._file.read_bytes()) + _joined(self._lines)


class _Spilled(Sequence[JournalEntry]):
    """Entries of a file, and of the lines that are still to come into it."""

    def __init__(self, file: Path, waiting: Sequence[bytes]) -> None:
        self._file = file
        self._waiting = waiting

    def __iter__(self) -> Iterator[JournalEntry]:
        with self._file.open("rb") as stream:
            for line in stream:
                yield decode_entry(line)
        for line in self._waiting:
            yield decode_entry(line)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    @overload
    def __getitem__(self, index: int) -> JournalEntry: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[JournalEntry]: ...

    def __getitem__(self, index: int | slice) -> JournalEntry | Sequence[JournalEntry]:
        return list(self)[index]


def _joined(lines: Sequence[bytes]) -> bytes:
    return b"\n".join([*lines, b""])


def encode_entry(entry: JournalEntry) -> bytes:
    """The line of an entry, without its end."""
    head = _ENCODER.encode(_LineHead(entry.t_s, entry.who))
    return head[:-1] + b"," + _ENCODER.encode(entry.event)[1:]


def decode_entry(line: bytes) -> JournalEntry:
    """The entry of a line. Raises msgspec.DecodeError for one that no run can have written."""
    head = _HEAD.decode(line)
    return JournalEntry(head.t, head.who, _EVENT.decode(line))


def read_journal(path: Path) -> list[JournalEntry]:
    """The entries of a journal file, in order. InputError naming the line that is none."""
    try:
        lines = path.read_bytes().splitlines()
    except OSError as error:
        raise InputError(str(path), "", None, "a journal that can be read") from error
    entries: list[JournalEntry] = []
    for number, line in enumerate(lines, 1):
        try:
            entries.append(decode_entry(line))
        except (msgspec.MsgspecError, UnicodeDecodeError) as error:
            shown = line[:80].decode(errors="replace")
            raise InputError(str(path), f"line {number}", shown, f"a line of a journal: {error}") from error
    return entries


def last_time_s(path: Path) -> float | None:
    """Simulated time of the last entry of a journal file, s; None where there is none."""
    last = None
    with suppress(OSError), path.open("rb") as stream:
        for line in stream:
            last = line
    return None if last is None else decode_entry(last).t_s
