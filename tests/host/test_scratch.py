"""Folders of a process: gone with it, and where it was killed swept by the next one; never that of one that lives."""

import fcntl
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import pytest

import host.scratch
from host.scratch import LOCK_FILE, scratch, sweep

PREFIX: Final = "tried-"
OWNER: Final = """
import os, sys
from pathlib import Path
from host.scratch import scratch
with scratch("tried-", Path(sys.argv[1])) as folder:
    (folder / "much").write_text("data")
    if sys.argv[2:] and os.fork():
        os._exit(0)  # as a sweep that is killed while its copies run on
    print(folder, flush=True)
    sys.stdin.read()
"""


@contextmanager
def owner(base: Path, *words: str) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """Another process that owns a folder."""
    with subprocess.Popen(
        [sys.executable, "-c", OWNER, str(base), *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        yield process, Path(process.stdout.readline().strip())


def test_it_goes_with_its_context(tmp_path: Path) -> None:
    with scratch(PREFIX, tmp_path) as folder:
        assert folder.parent == tmp_path and folder.name.startswith(PREFIX)
        assert folder.stat().st_mode & 0o777 == 0o700
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_process_left_goes_at_the_next_start(tmp_path: Path) -> None:
    with owner(tmp_path) as (process, folder):
        process.kill()
        process.wait()
        assert (folder / "much").exists()
        with scratch(PREFIX, tmp_path) as mine:
            assert list(tmp_path.iterdir()) == [mine]


def test_that_of_a_process_that_lives_stays(tmp_path: Path) -> None:
    """Stopped, too; and that of a forked copy whose parent is gone, though it was the parent who made it."""
    with owner(tmp_path) as (process, folder), owner(tmp_path, "fork") as (_, other):
        process.send_signal(signal.SIGSTOP)
        sweep(tmp_path, PREFIX)
        assert (folder / "much").exists() and (other / "much").exists()
        process.send_signal(signal.SIGCONT)


def test_one_of_this_process_stays(tmp_path: Path) -> None:
    with scratch(PREFIX, tmp_path) as one, scratch(PREFIX, tmp_path) as other:
        sweep(tmp_path, PREFIX)
        assert one.exists() and other.exists()


def strange_folder(base: Path) -> Path:
    """Of somebody else who likes the same name: what a bug left, for one."""
    folder = base / f"{PREFIX}crash-1"
    folder.mkdir()
    (folder / "crash.txt").write_text("why")
    return folder / "crash.txt"


def linked_folder(base: Path) -> Path:
    """A link to a folder that looks like a leftover."""
    (base / "mine").mkdir()
    (base / "mine" / LOCK_FILE).write_text("")
    (base / f"{PREFIX}link").symlink_to(base / "mine")
    return base / "mine" / LOCK_FILE


def linked_lock(base: Path) -> Path:
    """A lock file that is a link."""
    (base / "lock").write_text("")
    folder = base / f"{PREFIX}x"
    folder.mkdir()
    (folder / LOCK_FILE).symlink_to(base / "lock")
    return folder


def file_of_that_name(base: Path) -> Path:
    (base / f"{PREFIX}file").write_text("")
    return base / f"{PREFIX}file"


def other_prefix(base: Path) -> Path:
    (base / "other-x").mkdir()
    (base / "other-x" / LOCK_FILE).write_text("")
    return base / "other-x"


@pytest.mark.parametrize(
    "made", [strange_folder, linked_folder, linked_lock, file_of_that_name, other_prefix]
)
def test_what_is_not_surely_a_leftover_stays(tmp_path: Path, made: Callable[[Path], Path]) -> None:
    kept = made(tmp_path)
    sweep(tmp_path, PREFIX)
    assert kept.exists()


def test_that_of_another_user_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / f"{PREFIX}x"
    folder.mkdir()
    (folder / LOCK_FILE).write_text("")
    mine = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: mine + 1)
    sweep(tmp_path, PREFIX)
    assert folder.exists()
    monkeypatch.setattr(os, "getuid", lambda: mine)
    sweep(tmp_path, PREFIX)
    assert not folder.exists()


def test_it_has_its_lock_before_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """So that no sweep at that very moment takes a folder that is being made for a leftover."""
    flock = fcntl.flock

    def swept_meanwhile(lock: int, how: int) -> None:
        monkeypatch.setattr(host.scratch.fcntl, "flock", flock)
        sweep(tmp_path, PREFIX)
        flock(lock, how)

    monkeypatch.setattr(host.scratch.fcntl, "flock", swept_meanwhile)
    with scratch(PREFIX, tmp_path) as folder:
        assert (folder / LOCK_FILE).exists()


def test_where_nothing_can_be_locked_nothing_is_swept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(_lock: int, _how: int) -> None:
        raise OSError("no locks here")

    monkeypatch.setattr(host.scratch.fcntl, "flock", none)
    with scratch(PREFIX, tmp_path) as folder:
        assert list(folder.iterdir()) == []
        sweep(tmp_path, PREFIX)
        assert folder.exists()
    assert list(tmp_path.iterdir()) == []


def test_what_must_not_be_lost_is_taken_out_first(tmp_path: Path) -> None:
    folder = tmp_path / f"{PREFIX}x"
    folder.mkdir()
    (folder / LOCK_FILE).write_text("")
    (folder / "old").write_text("dear")
    sweep(tmp_path, PREFIX, lambda left: (left / "old").rename(tmp_path / "old") and None)
    assert [path.name for path in tmp_path.iterdir()] == ["old"]


def test_if_that_fails_the_folder_stays(tmp_path: Path) -> None:
    folder = tmp_path / f"{PREFIX}x"
    folder.mkdir()
    (folder / LOCK_FILE).write_text("")

    def fails(_left: Path) -> None:
        raise OSError("full")

    sweep(tmp_path, PREFIX, fails)
    assert folder.exists()
