"""Plants each mistake of `defects.toml` in a copy of the tree and says which test noticed it.

python -m tests.planted [WORDS ...]: those whose name has all the words, or all. Exit code 1 if one went unnoticed.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tests.planted.defects import ROOT, Planted, planted

NOTICED = 1  # pytest's exit code where a test has failed; others say that none was run


def copied(to: Path) -> Path:
    """The tree without what is made in it."""
    made = shutil.ignore_patterns(".git", ".venv", "__pycache__", "runs", ".*_cache")
    return Path(shutil.copytree(ROOT, to / "tree", ignore=made))


@contextmanager
def with_planted(defect: Planted, tree: Path) -> Generator[None]:
    """The tree with it."""
    file = tree / defect.file
    sound = file.read_text("utf-8")
    file.write_text(defect.planted_in(sound), "utf-8")
    try:
        yield
    finally:
        file.write_text(sound, "utf-8")


def noticed_by(defect: Planted, tree: Path) -> str:
    """The first test that fails with it; empty where none does."""
    environment = os.environ | ({"NUMBA_DISABLE_JIT": "1"} if defect.interpreted else {})
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-x",
        "-p",
        "no:cacheprovider",
        "-rfE",
        "--tb=no",
        *defect.tests,
    ]
    with with_planted(defect, tree):
        ended = subprocess.run(
            command, cwd=tree, env=environment, capture_output=True, text=True, check=False
        )
    if ended.returncode != NOTICED:
        return ""
    told = (
        line.split(" ", 1)[1] for line in ended.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))
    )
    return next(told, "a test").split(" - ")[0]


def unnoticed_of(chosen: Sequence[Planted]) -> list[str]:
    """Plant these, print a line each, and name those that no test noticed."""
    unnoticed = list[str]()
    with tempfile.TemporaryDirectory() as folder:
        tree = copied(Path(folder))
        for defect in chosen:
            by = noticed_by(defect, tree)
            unnoticed += [] if by else [defect.what]
            sys.stdout.write(f"{defect.kind:8} {defect.what}: {by or 'NOT NOTICED'}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{len(chosen) - len(unnoticed)} of {len(chosen)} noticed\n")
    return unnoticed


def main(words: list[str]) -> int:
    """Plant those whose name has all the words."""
    chosen = [defect for defect in planted() if all(word in defect.what for word in words)]
    return int(bool(unnoticed_of(chosen)))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
