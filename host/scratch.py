"""Folders that live as long as the process that made them. What a killed process left is swept by the next that starts.

A folder's owner holds a lock on a file in it, which ends with the process and its forked copies, however they end; a
number of a process would not do, since another may have it by then. A folder without that file is left alone.
"""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
import tempfile
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

LOCK_FILE: Final = ".branchline-lock"
_UNNAMED: Final = ".branchline-lock.new"


def _nothing(_left: Path) -> None:
    """There is nothing to rescue."""


@contextmanager
def scratch(prefix: str, parent: Path | None = None) -> Generator[Path]:
    """A new folder `prefix`... in `parent` (default: the folder for temporary files); gone when the context ends.

    First, `sweep` removes what killed processes left there under that prefix. Raises OSError.
    """
    base = _temporary() if parent is None else parent
    sweep(base, prefix)
    # mkdtemp makes it for its owner alone, whatever the umask is.
    folder = Path(tempfile.mkdtemp(prefix=prefix, dir=base))
    lock = None
    try:
        lock = _locked(folder)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def _temporary() -> Path:
    try:
        return Path(tempfile.gettempdir())
    except FileNotFoundError as error:  # none of them takes a file
        raise OSError(
            errno.ENOSPC, f"{os.strerror(errno.ENOSPC)} in any folder for temporary files"
        ) from error


def sweep(base: Path, prefix: str, rescue: Callable[[Path], None] = _nothing) -> None:
    """Remove the folders `prefix`... of this user in `base` whose owner is dead for sure.

    `rescue` may first take out of one what must not be lost. What cannot be looked at or removed stays.
    """
    for folder in _named(base, prefix):
        with suppress(OSError), _dead(folder):
            rescue(folder)
            shutil.rmtree(folder)


def _named(base: Path, prefix: str) -> Iterator[Path]:
    with suppress(OSError), os.scandir(base) as entries:
        for entry in entries:
            if entry.name.startswith(prefix) and entry.is_dir(follow_symlinks=False):
                yield Path(entry.path)


@contextmanager
def _dead(folder: Path) -> Generator[None]:
    """While the lock of its dead owner is held. OSError where that lives, or it is not a folder of `scratch`."""
    if folder.lstat().st_uid != os.getuid():
        raise PermissionError
    lock = os.open(folder / LOCK_FILE, os.O_RDWR | os.O_NOFOLLOW)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(lock)


def _locked(folder: Path) -> int | None:
    """The lock file of a new folder, under its name only when it is locked. None where files cannot be locked."""
    unnamed = folder / _UNNAMED
    lock = os.open(unnamed, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(lock)
        unnamed.unlink()
        return None
    unnamed.rename(folder / LOCK_FILE)
    return lock
