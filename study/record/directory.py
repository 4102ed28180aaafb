"""Run directories: reserved before a run, filled out of sight beside their place, and put there whole or not at all."""

from __future__ import annotations

import errno
import os
import tempfile
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from hashlib import sha256
from pathlib import Path
from typing import Final

from host.scratch import scratch, sweep
from network.clock import clock
from network.errors import InputError
from simulation.journal import last_time_s
from study.outcome import CutShortError, Outcome, outcome_of, text_of
from study.record.tables import ROWS

LEARNED_FILE: Final = (
    "learned.json"  # only where trains learn; `[tuning] learned` of another scenario may name it
)
INPUTS_FILE: Final = "inputs.json"  # `scenario.inputs`
SHOWN_FILE: Final = "shown.json"  # `study.record.shown`
COMPARE_FILE: Final = "compare.json"  # only of a run that was compared with another
SUMMARY_FILE: Final = "summary.json"
JOURNAL_FILE: Final = "journal.jsonl"
REPORT_FILE: Final = "report.html"
CRASH_FILE: Final = "crash.txt"  # only of a run that a bug has ended
INCOMPLETE_FILE: Final = "incomplete.txt"  # only of a run that is under way or was cut short
TABLE_FILES: Final = frozenset(f"{name}.parquet" for name in ROWS)
RUN_FILES: Final = TABLE_FILES | {
    SUMMARY_FILE,
    INPUTS_FILE,
    SHOWN_FILE,
    COMPARE_FILE,
    LEARNED_FILE,
    JOURNAL_FILE,
    CRASH_FILE,
    INCOMPLETE_FILE,
    REPORT_FILE,
}
FORMAT: Final = (
    1  # of a run directory, in its summary; another one where what is there cannot be read any more
)
FORMAT_KEY: Final = "format"
INCOMPLETE: Final = "-incomplete"  # ends the name of the directory of a run that was cut short
ROOM_BYTES: Final = 1 << 18  # where not even so much can be written nothing begins: the shortest takes more
END_ROOM_BYTES: Final = 1_500_000  # what the shortest run writes at its end: a report and small tables
_FULL: Final = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
_UNDER_WAY: Final = "This is no whole run: it is under way, or it was killed.\n"


def digests_of_tables(folder: Path) -> dict[str, str]:
    """SHA-256 of each table's file that is there, by name."""
    there = sorted(name for name in TABLE_FILES if (folder / name).exists())
    return {name: sha256((folder / name).read_bytes()).hexdigest() for name in there}


def write_whole(path: Path, data: bytes) -> None:
    """Write a file aside, then give it its name: it is whole or not there."""
    aside = path.with_name(f".{path.name}.part")
    aside.write_bytes(data)
    aside.replace(path)


def check_out(
    out: Path,
    owns: Callable[[str], bool] = RUN_FILES.__contains__,
    what: str = "a run",
    option: str = "--out",
) -> None:
    """Only a run directory may be replaced: anything else in the way is somebody's work. Raises InputError.

    Another `what` is what has other files of its own, by their names; `option` is what names it on the command line.
    """
    expected = f"a new directory, or one that holds {what} and nothing else"
    try:
        strange = [path.name for path in out.iterdir() if not owns(path.name)]
    except FileNotFoundError:
        return
    except OSError as error:
        raise InputError("command line", option, out, f"{expected} ({error.strerror})") from error
    if strange:
        raise InputError("command line", option, out, f"{expected}; it holds {min(strange)}")


@contextmanager
def replacing_folder(
    out: Path, owns: Callable[[str], bool] = RUN_FILES.__contains__, what: str = "a run"
) -> Generator[Path]:
    """A path at which a folder is to be made; it takes the place of `out` when the context ends well.

    Raises InputError as `check_out` does, and when the directory cannot be written; OSError where there is no room.
    """
    check_out(out, owns, what)
    with made_folder(out.parent, out), _beside(out) as aside:
        yield aside / "new"
        _put(aside, out)


@contextmanager
def asked_folder(
    out: Path | None, owns: Callable[[str], bool] = RUN_FILES.__contains__, what: str = "a run"
) -> Generator[Path | None]:
    """The same where a folder is asked for. What is computed for it belongs in the context: a bad one is told first."""
    with nullcontext() if out is None else replacing_folder(out, owns, what) as folder:
        yield folder


class Reserved:
    """The directory of a run that is under way: `folder` is to be filled, `journal` grows in it; then `put`.

    It says that it is incomplete until it is put in its place, `out`.
    """

    def __init__(self, out: Path, aside: Path) -> None:
        self.out = out
        self.folder: Final = aside / "new"
        self.journal: Final = self.folder / JOURNAL_FILE
        self._aside: Final = aside
        self._held: list[Path] = []
        self.folder.mkdir()
        self._say(_UNDER_WAY)

    def hold_room(self, size_bytes: int) -> None:
        """Keep room on the disk for a file, or several, of the run's end, until then: a full disk is found before the
        run. OSError where there is none.
        """
        room = self._aside / f"room-{len(self._held)}"
        try:
            with room.open("wb", buffering=0) as stream:
                self._held.append(room)
                os.posix_fallocate(stream.fileno(), 0, max(size_bytes, 1))  # of nothing: an error
        except OSError as error:
            self.free_room()
            why = f"{error.strerror}; a run writes {size_bytes / 1e6:.1f} MB and more at its end"
            raise OSError(error.errno, why, str(self.out.parent)) from error

    def free_room(self) -> None:
        """The end has come: what was held is there for its files."""
        while self._held:
            self._held.pop().unlink(missing_ok=True)

    def put_in_place(self) -> None:
        """The run is whole: it takes its place."""
        (self.folder / INCOMPLETE_FILE).unlink()
        _put(self._aside, self.out)

    def keep_cut_short(self, why: str) -> Path | None:
        """The run was cut short: journal and whole tables stay, under a name of their own. None if it had not begun.

        Where its report alone could not be written, all else stays, and the report can be made of it.
        """
        self.free_room()
        until_s = last_time_s(self.journal)
        if until_s is None:
            return None
        over = (self.folder / SHOWN_FILE).exists()  # the last file before the report
        whole = RUN_FILES - {REPORT_FILE} if over else TABLE_FILES | {JOURNAL_FILE, INCOMPLETE_FILE}
        for path in self.folder.iterdir():
            if path.name not in whole:
                path.unlink()
        what = (
            "This run is whole but for its report, which `branchline report` makes of this directory."
            if over
            else "This is no whole run: it was cut short."
        )
        self._say(f"{what}\nwhy: {why}\njournal until: {clock(int(until_s))}\n")
        self.name_incomplete()
        _put(self._aside, self.out)
        return self.out

    def name_incomplete(self) -> None:
        """From now on its place is beside the one asked for, under a name that says that it is no whole run."""
        beside = self.out.with_name(self.out.name + INCOMPLETE)
        try:
            check_out(beside)
        except InputError:  # the name is taken by somebody's work
            beside = Path(tempfile.mkdtemp(prefix=f"{beside.name}-", dir=beside.parent))
        self.out = beside

    def _say(self, text: str) -> None:
        """Over what is there, which takes no new room on the disk; blanks to the length of the longest."""
        file = self.folder / INCOMPLETE_FILE
        with suppress(OSError), file.open("r+b" if file.exists() else "wb") as stream:
            stream.write(f"{text.rstrip():<1000.1000}\n".encode())


@contextmanager
def reserved(out: Path) -> Generator[Reserved]:
    """The directory of a run, reserved until the context ends; then it was `put`, or nothing of it is left.

    With it goes room for the end of a short run; who knows that the run is long holds more.

    What cuts the run short and is no bug leaves what was run so far, and becomes a CutShortError that says where.
    Raises InputError as `check_out` does, and when the directory cannot be written; OSError where there is no room.
    """
    check_out(out)
    with made_folder(out.parent, out), _beside(out) as aside:
        place = Reserved(out, aside)
        place.hold_room(END_ROOM_BYTES)
        try:
            yield place
        except Exception as error:
            if isinstance(error, OSError) and error.errno and not error.filename:  # of an open file
                error.filename = str(out)
            if (
                outcome_of(error) is not Outcome.COULD_NOT_RUN
                or (kept := place.keep_cut_short(text_of(error))) is None
            ):
                raise
            raise CutShortError(text_of(error), str(kept)) from error


@contextmanager
def made_folder(folder: Path, out: Path) -> Generator[None]:
    """A folder and those above it, made; new ones go again if nothing came into them. InputError of `out`."""
    above = folder
    new: list[Path] = []
    while not above.exists() and above != above.parent:
        new.append(above)
        above = above.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _unwritable(out, error) from error
    try:
        yield
    finally:
        with suppress(OSError):
            for one in new:
                one.rmdir()


@contextmanager
def _beside(out: Path) -> Generator[Path]:
    """A hidden folder beside `out`, on the same disk, where there is room; what killed runs left there is swept."""
    begun = False
    sweep(out.parent, ".", _rescue)
    try:
        with scratch(f".{out.name}-", out.parent) as aside:
            _try_room(aside)
            begun = True
            yield aside
    except OSError as error:
        if begun or error.errno in _FULL:
            raise
        raise _unwritable(out, error) from error


def _unwritable(out: Path, error: OSError) -> InputError:
    expected = f"a directory that can be written ({error.strerror})"
    return InputError("command line", "--out", out, expected)


def _try_room(folder: Path) -> None:
    """OSError where there is no room for even the shortest run."""
    file = folder / "room"
    try:
        with file.open("wb", buffering=0) as stream:
            left = memoryview(bytes(ROOM_BYTES))
            while left:
                left = left[stream.write(left) :]
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(folder.parent)) from error
    finally:
        file.unlink(missing_ok=True)


def _put(aside: Path, out: Path) -> None:
    """What was filled takes the place of what was there, which comes back if that fails."""
    try:
        if out.exists():
            out.rename(aside / "old")
        (aside / "new").rename(out)
    except BaseException:
        _rescue_to(aside, out)
        raise


def _rescue(left: Path) -> None:
    """Of a process that was killed between two renames: the run before goes back to its place."""
    name, _, _ = left.name.removeprefix(".").rpartition("-")
    _rescue_to(left, left.with_name(name))


def _rescue_to(aside: Path, out: Path) -> None:
    if (aside / "old").exists() and not out.exists():
        (aside / "old").rename(out)


def labels_of(directories: Sequence[Path]) -> tuple[str, ...]:
    """What each directory is called: the end of its path, as short as tells it from the others."""
    paths = [directory.resolve() for directory in directories]
    different = list(dict.fromkeys(paths))
    ends = [path.name or str(path) for path in different]
    for length in range(2, max(len(path.parts) for path in paths) + 1):
        counts = Counter(ends)
        if max(counts.values()) == 1:
            break
        ends = [
            str(Path(*path.parts[-length:])) if counts[end] > 1 else end
            for path, end in zip(different, ends, strict=True)
        ]
    labels, seen = [ends[different.index(path)] for path in paths], Counter[str]()
    for i, label in enumerate(labels):
        seen[label] += 1
        if seen[label] > 1:  # one directory, named again
            labels[i] = f"{label} ({seen[label]})"
    return tuple(labels)
