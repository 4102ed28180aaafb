"""The command line of every generated page."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path


def write_page(document: Callable[[], str], place: Path) -> None:
    """Write the page to the file that the command line names, or to its place in the tree; whole or not at all."""
    file = Path(sys.argv[1]) if len(sys.argv) > 1 else place
    aside = file.with_suffix(".new")
    aside.write_text(document(), encoding="utf-8")
    aside.replace(file)
