"""Run directories: what may stand in one, and how one is put in place, whole or not at all."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from network.errors import InputError
from study.run.tables import SCHEMAS

LEARNED_FILE: Final = (
    "learned.json"  # only where trains learn; `[tuning] learned` of another scenario may name it
)
JOURNAL_FILE: Final = "journal.jsonl"
CRASH_FILE: Final = "crash.txt"  # only of a run that a bug has ended
RUN_FILES: Final = frozenset(
    {
        "summary.json",
        LEARNED_FILE,
        JOURNAL_FILE,
        CRASH_FILE,
        "report.html",
        *(f"{name}.parquet" for name in SCHEMAS),
    }
)


def check_out(out: Path, owns: Callable[[str], bool] = RUN_FILES.__contains__, what: str = "a run") -> None:
    """Only a run directory may be replaced: anything else in the way is somebody's work. Raises InputError.

    Another `what` is what has other files of its own, by their names.
    """
    expected = f"a new directory, or one that holds {what} and nothing else"
    try:
        strange = [path.name for path in out.iterdir() if not owns(path.name)]
    except FileNotFoundError:
        return
    except OSError as error:
        raise InputError("command line", "--out", out, f"{expected} ({error.strerror})") from error
    if strange:
        raise InputError("command line", "--out", out, f"{expected}; it holds {min(strange)}")


@contextmanager
def replaced(
    out: Path, owns: Callable[[str], bool] = RUN_FILES.__contains__, what: str = "a run"
) -> Generator[Path]:
    """A path at which a folder is to be made; it takes the place of `out` when the context ends well.

    Raises InputError as `check_out` does, and when the directory cannot be written.
    """
    check_out(out, owns, what)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        aside = Path(tempfile.mkdtemp(prefix=f".{out.name}-", dir=out.parent))
    except OSError as error:
        expected = f"a directory that can be written ({error.strerror})"
        raise InputError("command line", "--out", out, expected) from error
    try:
        yield aside / "new"
        if out.exists():
            out.rename(aside / "old")
        (aside / "new").rename(out)
    except BaseException:
        if (aside / "old").exists() and not out.exists():
            (aside / "old").rename(out)
        raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)
