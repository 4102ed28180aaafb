"""What is generated, held against what is committed: `python -m documents.generated` ends with 1 where they differ.

Everything that takes seconds. What the runs in docs/interlocking.md show takes minutes: `make test` compares it.
"""

from __future__ import annotations

import difflib
import sys
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Final

from documents import (
    busy_line,
    desk_protocol,
    faults,
    files,
    interlocking,
    journal,
    losses,
    reproductions,
    safety,
    second_loop,
    sensors,
    substitute,
    tables,
)

ROOT: Final = Path(__file__).resolve().parent.parent
SHOWN_LINES: Final = 8
SHOWN_COLUMNS: Final = 100


def _interlocking() -> str:
    """The page with its runs as they are committed: invariants, tables, diagrams and hazards are made anew."""
    return interlocking.document(interlocking.runs_in((ROOT / interlocking.FILE).read_text("utf-8")))


PAGES: Final[tuple[tuple[Path, Callable[[], str]], ...]] = (
    (interlocking.FILE, _interlocking),
    (desk_protocol.FILE, desk_protocol.document),
    (faults.FILE, faults.document),
    (journal.FILE, journal.document),
    (losses.FILE, losses.document),
    (reproductions.FILE, reproductions.document),
    (safety.FILE, safety.document),
    (sensors.FILE, sensors.document),
    (substitute.FILE, substitute.document),
    (tables.FILE, tables.document),
)


def generated() -> Iterator[tuple[Path, str]]:
    """Every generated file, as a path below the root, with the text that belongs in it."""
    for path, text in {**busy_line.files(), **second_loop.files(), **dict(files.pages())}.items():
        yield path.relative_to(ROOT), text
    for file, document in PAGES:
        yield (ROOT / file).relative_to(ROOT), document()


def differences(committed: str, made: str) -> list[str]:
    """The first lines in which two texts differ, with - and +."""
    lines = difflib.unified_diff(committed.splitlines(), made.splitlines(), lineterm="", n=0)
    changed = (line for line in islice(lines, 2, None) if not line.startswith("@@"))
    return [line[:SHOWN_COLUMNS] for line in islice(changed, SHOWN_LINES)]


def main(root: Path = ROOT) -> int:
    """Print every file with its verdict; 1 where one is not what is generated."""
    stale = False
    for path, text in generated():
        file = root / path
        found = differences(file.read_text("utf-8") if file.exists() else "", text)
        sys.stdout.write(
            f"{'STALE ' if found else 'holds '}  {path}: what is generated is what is committed\n"
        )
        sys.stdout.writelines(f"          {line}\n" for line in found)
        stale = stale or bool(found)
    if stale:
        sys.stdout.write("`make docs` writes them.\n")
    return int(stale)


if __name__ == "__main__":
    sys.exit(main())
