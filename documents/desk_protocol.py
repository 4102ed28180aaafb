"""Writes docs/desk-protocol.json: `python -m documents.desk_protocol [FILE]`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

from console.protocol import schema
from documents.page import write_page

FILE: Final = Path("docs/desk-protocol.json")


def document() -> str:
    """The whole file."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    write_page(document, FILE)
