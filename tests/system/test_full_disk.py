"""A disk that is full, for real: a limit of the size of files, a device that takes nothing, a small file system."""

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import pytest

from scenario.scenario import load_scenario
from simulation.journal import read_journal
from study.outcome import Outcome
from study.record.tables import ROWS
from study.runner.run import CarrierKind, PartyLink, execute
from tests.nightly import others_nightly

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


def journal_of(scenario: str) -> bytes:
    """That of the day without a limit."""
    run = execute(load_scenario(scenario), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)
    return run.result.journal.to_bytes()


@pytest.mark.parametrize("room_bytes", others_nightly((100_000, 1_000_000, 2_000_000), [2_000_000]))
def test_no_room_is_told_before_a_day_is_simulated(
    command: tuple[str, ...], tmp_path: Path, room_bytes: int
) -> None:
    """Not for a beginning, not for a report, not for the largest table of the end."""
    done = limited(command, tmp_path, room_bytes, "run", DAY, "--json")
    assert done.returncode == Outcome.COULD_NOT_RUN.code
    (told,) = done.stderr.splitlines()  # no hour of the day
    assert told.startswith(f"error: {tmp_path / 'runs'}: File too large")
    assert list(tmp_path.iterdir()) == []


UNHELD: Final = """
import sys
from branchline.cli import main
from study.record.directory import Reserved
Reserved.hold_room = lambda place, size_bytes: None
main()
"""


CUT: Final = "cut short"
FULL: Final = [("turn_back", 300_000, "whole but for its report"), (DAY, 300_000, CUT), (DAY, 1_000_000, CUT)]


@pytest.mark.parametrize("full", others_nightly(FULL, FULL[:1]), ids=lambda full: f"{full[0]}-{full[1]}")
def test_a_disk_that_is_full_costs_no_day(tmp_path: Path, turn_back: str, full: tuple[str, int, str]) -> None:
    """Full in the middle of the day, when tables are written, when the report is: what ran is there, to the byte.

    No room was held, as where others fill the disk faster than one can hold it.
    """
    name, room_bytes, lacks = full
    scenario = turn_back if name == "turn_back" else name
    done = limited((sys.executable, "-c", UNHELD), tmp_path, room_bytes, "run", scenario, "--json")
    journal = journal_of(scenario)
    assert done.returncode == Outcome.COULD_NOT_RUN.code
    (kept,) = (tmp_path / "runs").iterdir()
    last = done.stderr.splitlines()[-1]
    assert last.startswith(f"error: {tmp_path / 'runs'}")
    assert last.endswith(f"File too large; what was run so far is in {kept}")
    assert kept.name == f"{name}-incomplete"
    found = (kept / "journal.jsonl").read_bytes()
    assert journal.startswith(found) and found.endswith(b"\n")
    assert read_journal(kept / "journal.jsonl")
    if len(journal) > room_bytes:
        assert room_bytes - 1000 < len(found) <= room_bytes
        assert "writing the report" not in done.stderr
    else:
        assert found == journal
        assert "writing the report" in done.stderr
    assert lacks in (kept / "incomplete.txt").read_text("utf-8")
    others = {path.name for path in kept.iterdir()} - {"journal.jsonl", "incomplete.txt"}
    tables = {f"{name}.parquet" for name in ROWS}
    assert others in (set(), tables) if lacks == CUT else others > tables  # all tables, or none


@pytest.fixture(params=["700k"])
def small(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Path]:
    """A file system of its own; by default with room for the journal of a day, or nearly."""
    folder = tmp_path / "small"
    folder.mkdir()
    size = f"size={request.param}"
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", size, "tmpfs", str(folder)], capture_output=True, check=False
    )
    if mounted.returncode != 0:
        pytest.skip("only root can mount a file system of its own")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.nightly
@pytest.mark.parametrize("small", ["6m"], indirect=True)
def test_a_disk_that_others_fill_during_the_run_costs_no_report(tmp_path: Path, small: Path) -> None:
    """They fill it to the last byte, and all of them when the run is over; what was held is enough."""
    wrap = """
import sys
from pathlib import Path
from branchline.cli import main
from study.runner import run
execute = run.execute
def filling(*given, **named):
    done = execute(*given, **named)
    with (Path(sys.argv[-1]).parent / "of_others").open("wb", buffering=0) as stream:
        while True:
            try:
                stream.write(bytes(4096))
            except OSError:
                return done
run.execute = filling
main()
"""
    done = subprocess.run(
        [sys.executable, "-c", wrap, "run", "rtri_test_line", "--out", str(small / "run")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (small / "run" / "report.html").read_bytes().rstrip().endswith(b"</html>")
    assert {path.name for path in small.iterdir()} == {"run", "of_others"}


@pytest.mark.nightly
def test_a_small_file_system_keeps_what_fits(tmp_path: Path, small: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", UNHELD, "run", DAY, "--out", str(small / "run")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == Outcome.COULD_NOT_RUN.code
    kept = small / "run-incomplete"
    assert done.stderr.splitlines()[-1].endswith(f"No space left on device; what was run so far is in {kept}")
    found = (kept / "journal.jsonl").read_bytes()
    assert found and journal_of(DAY).startswith(found)
    assert "No space left" in (kept / "incomplete.txt").read_text("utf-8")  # room for which was there before
    assert [path.name for path in small.iterdir()] == [kept.name]
    full = subprocess.run(
        [sys.executable, "-m", "branchline.cli", "run", DAY, "--out", str(small / "other")],
        cwd=tmp_path,
        capture_output=True,
        check=False,
    )
    assert full.returncode == Outcome.COULD_NOT_RUN.code


def test_a_limit_is_an_error_and_no_signal() -> None:
    """What these tests stand on: Python ignores SIGXFSZ, so that a file that may not grow says so."""
    assert signal.getsignal(signal.SIGXFSZ) is signal.SIG_IGN
    assert resource.RLIMIT_FSIZE and os.name == "posix"
