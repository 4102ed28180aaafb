"""A disk that is full, for real: a limit of the size of files, a device that takes nothing, a small file system."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest

from simulation.journal import read_journal
from study.outcome import Outcome
from study.run.run import Link, execute
from study.run.tables import SCHEMAS
from study.scenario.scenario import load_scenario

pytestmark = pytest.mark.system

DAY: Final = "karasuyama_weekday"


def limited(
    command: tuple[str, ...], cwd: Path, room_bytes: int, *arguments: str
) -> subprocess.CompletedProcess[str]:
    """Run it where no file can grow beyond `room_bytes`; what is compiled stands in its cache already."""
    return subprocess.run(
        ["prlimit", f"--fsize={room_bytes}", "--", *command, *arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="module")
def journal() -> bytes:
    """That of the day without a limit."""
    return execute(load_scenario(DAY), Link.SIMULATED).result.journal.to_bytes()


def test_no_room_is_told_before_a_day_is_simulated(command: tuple[str, ...], tmp_path: Path) -> None:
    done = limited(command, tmp_path, 100_000, "run", DAY, "--json")
    assert done.returncode == Outcome.COULD_NOT_RUN.code
    assert done.stderr == f"error: {tmp_path / 'runs'}: File too large\n"  # no hour of the day was told
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("room_bytes", [300_000, 1_000_000])
def test_a_disk_that_is_full_costs_no_day(
    command: tuple[str, ...], tmp_path: Path, journal: bytes, room_bytes: int
) -> None:
    """Full in the middle of the day, and when the report is written: what was run so far is there, to the byte."""
    done = limited(command, tmp_path, room_bytes, "run", DAY, "--json")
    assert done.returncode == Outcome.COULD_NOT_RUN.code
    (kept,) = (tmp_path / "runs").iterdir()
    last = done.stderr.splitlines()[-1]
    assert last.startswith(f"error: {tmp_path / 'runs'}")
    assert last.endswith(f"File too large; what was run so far is in {kept}")
    assert kept.name == f"{DAY}-incomplete"
    found = (kept / "journal.jsonl").read_bytes()
    assert journal.startswith(found) and found.endswith(b"\n")
    assert read_journal(kept / "journal.jsonl")
    if len(journal) > room_bytes:
        assert room_bytes - 1000 < len(found) <= room_bytes
        assert "writing the report" not in done.stderr
    else:
        assert found == journal
        assert "writing the report" in done.stderr
    assert "cut short" in (kept / "incomplete.txt").read_text("utf-8")
    others = {path.name for path in kept.iterdir()} - {"journal.jsonl", "incomplete.txt"}
    assert others in (set(), {f"{name}.parquet" for name in SCHEMAS})  # all tables, or none


@pytest.fixture
def small(tmp_path: Path) -> Iterator[Path]:
    """A file system of 700 kB: room for the journal of a day, or nearly."""
    folder = tmp_path / "small"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=700k", "tmpfs", str(folder)], capture_output=True, check=False
    )
    if mounted.returncode != 0:
        pytest.skip("only root can mount a file system of its own")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_a_small_file_system_keeps_what_fits(
    command: tuple[str, ...], tmp_path: Path, small: Path, journal: bytes
) -> None:
    done = subprocess.run(
        [*command, "run", DAY, "--out", str(small / "run")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == Outcome.COULD_NOT_RUN.code
    kept = small / "run-incomplete"
    assert done.stderr.splitlines()[-1].endswith(f"No space left on device; what was run so far is in {kept}")
    found = (kept / "journal.jsonl").read_bytes()
    assert found and journal.startswith(found)
    assert "No space left" in (kept / "incomplete.txt").read_text("utf-8")  # room for which was there before
    assert [path.name for path in small.iterdir()] == [kept.name]
    full = subprocess.run(
        [*command, "run", DAY, "--out", str(small / "other")], cwd=tmp_path, capture_output=True, check=False
    )
    assert full.returncode in (Outcome.COULD_NOT_RUN.code, Outcome.GOOD.code)


def test_a_limit_is_an_error_and_no_signal() -> None:
    """What these tests stand on: Python ignores SIGXFSZ, so that a file that may not grow says so."""
    assert signal.getsignal(signal.SIGXFSZ) is signal.SIG_IGN
    assert resource.RLIMIT_FSIZE and os.name == "posix"
