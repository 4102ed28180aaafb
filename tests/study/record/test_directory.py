"""Run directories: reserved, filled out of sight, put in place whole; what is cut short keeps what there was."""

import errno
import signal
import subprocess
import sys
from pathlib import Path
from typing import Final

import pytest

import study.record.directory
from host.parties import PartyBug, PartyError
from network.errors import InputError
from onboard.notes import Holds
from simulation.journal import Journal, read_journal
from study.outcome import CutShortError, Outcome, StoppedError, outcome_of
from study.record.directory import INCOMPLETE_FILE, JOURNAL_FILE, Reserved, check_out, reserved

NOON_S: Final = 43_200.0


def simulate(place: Reserved, until_s: float = NOON_S) -> Journal:
    """As a run does: its journal grows, and is on disk whenever the run is cut short."""
    journal = Journal(place.journal)
    for token in range(5):
        journal.write(until_s - 4.0 + token, "V1", Holds(section_ids=("3",), token=token))
    journal.spill()
    return journal


def cut_short(out: Path, error: BaseException, *, begun: bool = True) -> None:
    with reserved(out) as place:
        if begun:
            simulate(place)
        (place.folder / "stops.parquet").write_bytes(b"whole")
        (place.folder / ".blocks.parquet.part").write_bytes(b"ha")
        (place.folder / "report.html").write_text("ha")
        raise error


def full() -> OSError:
    return OSError(errno.ENOSPC, "No space left on device", "/x/summary.json")


def test_while_it_is_filled_nothing_has_its_name(tmp_path: Path) -> None:
    out = tmp_path / "a" / "run"
    with reserved(out) as place:
        simulate(place)
        assert not out.exists()
        assert "under way" in (place.folder / INCOMPLETE_FILE).read_text("utf-8")
        place.put_in_place()
    assert [path.name for path in out.iterdir()] == [JOURNAL_FILE]
    assert [path.name for path in tmp_path.rglob("*")] == ["a", "run", JOURNAL_FILE]


@pytest.mark.parametrize(
    "error",
    [StoppedError(signal.SIGTERM), KeyError("a bug"), PartyBug("another"), InputError("f", "", 1, "2")],
)
def test_what_is_no_want_leaves_nothing(tmp_path: Path, error: BaseException) -> None:
    """A signal is a wish; a bug leaves its journal elsewhere. Folders above, made for it, go too."""
    with pytest.raises(type(error)):
        cut_short(tmp_path / "a" / "b" / "run", error)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("error", [full(), PartyError("block manager was killed by SIGKILL"), MemoryError()])
def test_what_was_run_so_far_is_kept_and_named(tmp_path: Path, error: Exception) -> None:
    """The journal and whole tables, under a name that says that it is no whole run; nothing half-written."""
    out = tmp_path / "run"
    out.mkdir()
    (out / "summary.json").write_text("the run before")
    with pytest.raises(CutShortError) as ended:
        cut_short(out, error)
    assert outcome_of(ended.value) is Outcome.COULD_NOT_RUN
    kept = tmp_path / "run-incomplete"
    assert str(ended.value).endswith(f"; what was run so far is in {kept}")
    assert {path.name for path in kept.iterdir()} == {JOURNAL_FILE, "stops.parquet", INCOMPLETE_FILE}
    assert len(read_journal(kept / JOURNAL_FILE)) == 5
    said = (kept / INCOMPLETE_FILE).read_text("utf-8")
    assert "cut short" in said and "journal until: 12:00:00" in said and "under way" not in said
    assert (out / "summary.json").read_text() == "the run before"
    assert {path.name for path in tmp_path.iterdir()} == {"run", "run-incomplete"}


def test_a_second_one_takes_the_place_of_the_first_but_not_of_work(tmp_path: Path) -> None:
    kept = tmp_path / "run-incomplete"
    for _ in range(2):
        with pytest.raises(CutShortError):
            cut_short(tmp_path / "run", full())
        assert [path.name for path in tmp_path.iterdir()] == [kept.name]
    (kept / "notes.txt").write_text("mine")
    with pytest.raises(CutShortError) as ended:
        cut_short(tmp_path / "run", full())
    assert (kept / "notes.txt").read_text() == "mine"
    other = Path(str(ended.value).rpartition(" ")[2])
    assert other.parent == tmp_path and other != kept
    assert len(read_journal(other / JOURNAL_FILE)) == 5


def test_before_it_has_begun_there_is_nothing_to_keep(tmp_path: Path) -> None:
    with pytest.raises(PartyError, match="did not start"):
        cut_short(tmp_path / "run", PartyError("t did not start"), begun=False)
    assert list(tmp_path.iterdir()) == []


def test_what_was_cut_short_may_be_replaced(tmp_path: Path) -> None:
    with pytest.raises(CutShortError):
        cut_short(tmp_path / "run", full())
    check_out(tmp_path / "run-incomplete")


def test_no_room_is_told_before_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study.record.directory, "_try_room", refuse)
    with pytest.raises(OSError, match="No space left") as ended, reserved(tmp_path / "a" / "run"):
        raise AssertionError("it began")
    assert outcome_of(ended.value) is Outcome.COULD_NOT_RUN
    assert list(tmp_path.iterdir()) == []


def refuse(_folder: Path) -> None:
    raise full()


@pytest.mark.parametrize("number", [errno.EACCES, errno.EROFS, errno.EPERM])
def test_a_place_that_cannot_be_written_is_bad_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refused(_folder: Path) -> None:
        raise OSError(number, "no")

    monkeypatch.setattr(study.record.directory, "_try_room", refused)
    with pytest.raises(InputError, match="can be written"), reserved(tmp_path / "run"):
        raise AssertionError("it began")


def test_a_file_where_a_folder_is_wanted_is_bad_input(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match="--out"), reserved(tmp_path / "file" / "run"):
        raise AssertionError("it began")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


KILLED: Final = """
import os, signal, sys
from pathlib import Path
from study.record.directory import reserved
rename, at = Path.rename, sys.argv[2]
def killing(self, target):
    if self.name == at:
        os.kill(os.getpid(), signal.SIGKILL)
    return rename(self, target)
Path.rename = killing
with reserved(Path(sys.argv[1])) as place:
    (place.folder / "summary.json").write_text("the run after")
    place.put_in_place()
"""


@pytest.mark.parametrize("at", ["run", "new"])
def test_killed_at_any_rename_the_run_before_is_there_at_the_next_start(tmp_path: Path, at: str) -> None:
    """Killed before the run of before goes aside, or after that and before the new one takes its place."""
    out = tmp_path / "run"
    out.mkdir()
    (out / "summary.json").write_text("the run before")
    done = subprocess.run([sys.executable, "-c", KILLED, str(out), at], check=False)
    assert done.returncode == -signal.SIGKILL
    assert out.exists() == (at == "run")
    with reserved(tmp_path / "another"):
        assert (out / "summary.json").read_text() == "the run before"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]
