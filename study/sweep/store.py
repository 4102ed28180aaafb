"""The directory of a sweep, which is the truth about it: a file a day, whole or not there, whoever has written it.

    sweep.json            what is swept, by which code, and a token by which workers know the directory
    lock                  held by the client at work
    days/<key>-<index>.json   a day: its record, then the digest of that line
    runs/<key>-<index>/   what is kept of a day, where anything is
    replays/*.toml        scenario files of days worth looking at

A day is written aside, brought to the disk and renamed, and so is its name. What is torn, or not what its name says, is
named and run again.
"""

from __future__ import annotations

import errno
import fcntl
import os
import re
import secrets
import tempfile
from collections.abc import Collection, Generator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import blake2b
from importlib.metadata import version
from pathlib import Path
from platform import python_version
from typing import Any, Final

import msgspec

from network.errors import InputError
from study.sweep.digest import code_digest
from study.sweep.plan import SweepPlan
from study.sweep.records import HASH_BYTES, DayRecord, DaySpec

FORMAT: Final = 1
HEADER_FILE: Final = "sweep.json"
LOCK_FILE: Final = "lock"
DAYS: Final = "days"
RUNS: Final = "runs"
_DAY: Final = re.compile(r"[0-9a-f]{32}-[0-9]{6}\.json")
_WITH: Final = ("numpy", "numba", "libsumo")
_NO_LOCKS: Final = frozenset({errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP})


class PointSaid(msgspec.Struct, frozen=True):
    """A point of the grid in the header."""

    label: str
    said: dict[str, Any]
    inputs: str


class Header(msgspec.Struct, frozen=True):
    """`sweep.json`. `code`: digest of the code of the client; each day says which code ran it."""

    format: int
    sweep: str
    token: str
    branchline: str
    code: str
    made_with: dict[str, str]
    scenario: str
    file: dict[str, Any]
    points: tuple[PointSaid, ...]


class UnusableFile(msgspec.Struct, frozen=True):
    """A file of `days/` that does not count, and why."""

    name: str
    why: str


class FiledDays(msgspec.Struct, frozen=True):
    """What there is of a plan's days, by the names of their files; `others` are days of other points or seeds."""

    records: dict[str, DayRecord]
    refused: tuple[UnusableFile, ...]
    others: int


def day_name(spec: DaySpec, index: int) -> str:
    """The name of a day's file."""
    return f"{spec.key}-{index:06d}.json"


class NotSharedError(Exception):
    """A process does not see the sweep that it is to run days of as the client does: directory, code or files."""

    NEEDED: Final = "the client's directory must be under the same path on every machine"
    SAME_CODE: Final = "the same version of branchline, Python and libraries must be on every machine"


class SweepDirectory:
    """The directory of a sweep that is open: see the module."""

    def __init__(self, out: Path, token: str) -> None:
        self.out: Final = out
        self.token: Final = token

    def days_found(self, wanted: Collection[str]) -> FiledDays:
        """Every day that there is, of those wanted by name."""
        records: dict[str, DayRecord] = {}
        refused: list[UnusableFile] = []
        others = 0
        for name in sorted(entry.name for entry in os.scandir(self.out / DAYS)):
            if name.startswith("."):
                continue
            if _DAY.fullmatch(name) is None:
                refused.append(UnusableFile(name, "no name of a day"))
            elif name not in wanted:
                others += 1
            else:
                read = _read(self.out / DAYS / name)
                if isinstance(read, DayRecord):
                    records[name] = read
                else:
                    refused.append(UnusableFile(name, read))
        return FiledDays(records, tuple(refused), others)


@contextmanager
def opened_sweep(plan: SweepPlan, out: Path) -> Generator[SweepDirectory]:
    """The directory of a plan, made or found, while no other client has it. InputError for any other directory."""
    before = _header(out, plan.table.id)
    try:
        (out / DAYS).mkdir(parents=True, exist_ok=True)
        lock = os.open(out / LOCK_FILE, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        expected = f"a directory that can be written ({error.strerror})"
        raise InputError("command line", "--out", out, expected) from error
    try:
        _lock(lock, out)
        token = secrets.token_hex(HASH_BYTES) if before is None else before.token
        header = _header_of(plan, token)
        write_whole(out / HEADER_FILE, msgspec.json.format(msgspec.json.encode(header), indent=1) + b"\n")
        for left in (out / DAYS).glob(".*"):
            left.unlink(missing_ok=True)
        yield SweepDirectory(out, token)
    finally:
        os.close(lock)


def write_day(out: Path, record: DayRecord) -> None:
    """Put a day into its place: whole, and on the disk when this returns."""
    line = msgspec.json.encode(record)
    digest = blake2b(line, digest_size=HASH_BYTES).hexdigest().encode()
    write_whole(out / DAYS / day_name(record.spec, record.index), line + b"\n" + digest + b"\n")


def filed_day(out: Path, name: str) -> DayRecord | None:
    """A day that is there and is whole; None otherwise."""
    try:
        found = _read(out / DAYS / name)
    except FileNotFoundError:
        return None
    return None if isinstance(found, str) else found


def write_whole(path: Path, data: bytes) -> None:
    """Write a file aside, bring it to the disk, rename it, and bring its name to the disk."""
    place, aside = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
    try:
        with os.fdopen(place, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        # Private until now: on a shared directory others read it too.
        Path(aside).chmod(0o644)
        Path(aside).replace(path)
    except BaseException:
        with suppress(OSError):
            Path(aside).unlink()
        raise
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def check_shared(out: Path, token: str) -> None:
    """This process sees the very directory that the client has, and runs its code. NotSharedError otherwise."""
    try:
        header = msgspec.json.decode((out / HEADER_FILE).read_bytes(), type=Header)
    except (OSError, msgspec.MsgspecError) as error:
        raise NotSharedError(
            f"{os.uname().nodename} has no sweep in {out}: {NotSharedError.NEEDED}"
        ) from error
    if header.token != token:
        raise NotSharedError(f"{os.uname().nodename} has another sweep in {out}: {NotSharedError.NEEDED}")
    if (header.code, header.made_with) != (code_digest(), made_with()):
        raise NotSharedError(
            f"{os.uname().nodename} runs other code than the client: {NotSharedError.SAME_CODE}"
        )


def _read(path: Path) -> DayRecord | str:
    """A day, or why the file is none."""
    line, _, rest = path.read_bytes().partition(b"\n")
    if rest != blake2b(line, digest_size=HASH_BYTES).hexdigest().encode() + b"\n":
        return "torn: not as it was written"
    try:
        record = msgspec.json.decode(line, type=DayRecord)
    except msgspec.MsgspecError as error:
        return f"of another version: {error}"
    if day_name(record.spec, record.index) != path.name:
        return "another day than its name says"
    return record


def _header(out: Path, sweep: str) -> Header | None:
    """The header that is there; None for a directory that is new or empty. InputError for anything else."""
    expected = f"a new directory, or that of the sweep {sweep}"
    try:
        strange = next(iter(out.iterdir()), None)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError("command line", "--out", out, f"{expected} ({error.strerror})") from error
    if strange is None:
        return None
    try:
        header = msgspec.json.decode((out / HEADER_FILE).read_bytes(), type=Header)
    except (OSError, msgspec.MsgspecError) as error:
        if {path.name for path in out.iterdir()} <= {LOCK_FILE, DAYS} and not any((out / DAYS).glob("*")):
            return None  # a client was killed before it wrote the header
        raise InputError("command line", "--out", out, expected) from error
    if header.sweep != sweep:
        raise InputError("command line", "--out", out, f"{expected}; it is that of the sweep {header.sweep}")
    if header.format != FORMAT:
        raise InputError("command line", "--out", out, f"{expected}, in format {FORMAT} of this version")
    return header


def _header_of(plan: SweepPlan, token: str) -> Header:
    points = tuple(PointSaid(point.label, dict(point.said), point.inputs) for point in plan.points)
    table = plan.table.model_dump(mode="json", by_alias=True)
    return Header(
        FORMAT,
        plan.table.id,
        token,
        version("branchline"),
        code_digest(),
        made_with(),
        plan.scenario,
        table,
        points,
    )


@cache
def made_with() -> dict[str, str]:
    """Versions of Python and of the libraries that compute."""
    return {"python": python_version()} | {name: version(name) for name in _WITH}


def _lock(lock: int, out: Path) -> None:
    """Hold the lock until it is closed. Where the file system has none, a day is still written whole."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        expected = "a directory at which no other client is at work"
        raise InputError("command line", "--out", out, expected) from error
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise
