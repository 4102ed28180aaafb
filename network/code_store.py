"""What is costly to make, on disk, each piece in a file of its own under its name and the key of what it depends on.

A key says what is inside, so a folder may be copied to any place or machine, and any number of versions, branches and
processes may share it. A file that is cut short, damaged or renamed is as good as none.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext, suppress
from hashlib import blake2b
from pathlib import Path
from typing import Final

SUFFIX: Final = ".code"
SEAL_BYTES: Final = 16
KEPT: Final = 12  # pieces of one name, those used last


def kept_folder() -> Path:
    """In numba's own cache folder if one is set, else beside this file, else in the user's cache."""
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(given)
    beside = Path(__file__).parent / "__pycache__"
    users = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "branchline"
    return beside if os.access(beside if beside.exists() else beside.parent, os.W_OK) else users


class CodeStore:
    """A folder that is read and written, and folders that are only read."""

    def __init__(self, folder: Path, others: Iterable[Path] = ()) -> None:
        self.folder = folder
        self._others = tuple(others)

    def made(self, name: str, made_of: object, make: Callable[[], bytes]) -> bytes:
        """The piece of that name and of all that `made_of` says in its repr; made and kept where there is none."""
        key = blake2b(repr(made_of).encode(), digest_size=16).hexdigest()
        found = self.read(name, key)
        if found is None:
            self.write(name, key, found := make())
        return found

    def read(self, name: str, key: str) -> bytes | None:
        """The piece of that name and key; None if there is none, or none that is whole."""
        for folder in (*self._others, self.folder):
            file = folder / _file_name(name, key)
            try:
                found = file.read_bytes()
            except OSError:
                continue
            seal, data = found[:SEAL_BYTES], found[SEAL_BYTES:]
            if seal == _seal(name, key, data):
                if folder is self.folder:
                    with suppress(OSError):  # a folder that is only read
                        os.utime(file)
                return data
        return None

    def write(self, name: str, key: str, data: bytes) -> None:
        """Keep a piece; where nothing can be written it is only not kept."""
        file = self.folder / _file_name(name, key)
        aside = file.with_suffix(f".{os.getpid()}")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            aside.write_bytes(_seal(name, key, data) + data)
            aside.replace(file)
        except OSError:
            return
        self._drop_old(name)

    def alone(self, name: str) -> AbstractContextManager[object]:
        """Make a piece of that name while no other process does; at once where nothing is kept, or nothing locked."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            lock = (self.folder / f"{name}.lock").open("ab")
            fcntl.flock(lock, fcntl.LOCK_EX)
        except OSError:
            return nullcontext()
        return lock

    def _drop_old(self, name: str) -> None:
        """Delete the pieces of a name that were not used for longest."""
        dated: list[tuple[float, Path]] = []
        for file in self.folder.glob(_file_name(name, "?" * 32)):
            with suppress(FileNotFoundError):  # another process has deleted it
                dated.append((file.stat().st_mtime, file))
        for _, file in sorted(dated, reverse=True)[KEPT:]:
            file.unlink(missing_ok=True)


def _file_name(name: str, key: str) -> str:
    return f"{name.replace('<', '').replace('>', '')}-{key}{SUFFIX}"


def _seal(name: str, key: str, data: bytes) -> bytes:
    return blake2b(f"{name} {key} ".encode() + data, digest_size=SEAL_BYTES).digest()
