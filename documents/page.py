"""How generated pages are written."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from pathlib import Path


def write_page(document: Callable[[], str], place: Path) -> None:
    """Write the page to the file that the command line names, or to its place in the tree; whole or not at all."""
    write_pages([(Path(sys.argv[1]) if len(sys.argv) > 1 else place, document())])


def write_pages(pages: Iterable[tuple[Path, str]]) -> None:
    """Write each text to its file; whole or not at all."""
    for file, text in pages:
        file.parent.mkdir(exist_ok=True)
        aside = file.with_suffix(".new")
        aside.write_text(text, encoding="utf-8")
        aside.replace(file)
