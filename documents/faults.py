"""Writes docs/faults.md from the table of faults: `python -m documents.faults [FILE]`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from documents.page import write_page
from network.files.quantity import Quantity
from simulation.faults.table import KINDS

FILE: Final = Path("docs/faults.md")

HEAD: Final = """\
# Faults

Made by `make docs` from `simulation/faults/`; do not edit. Each `[[fault]]` of a scenario or drill has a `kind`, a
`target`, a `start` (a time, or words for an event), and as it likes `after_s` and `duration_s`; without a duration it
lasts, unless it is over at once or a person ends it. The other keys are those of its kind.

Faults that change the same quantity of the same target may overlap: the value in force is what they make of the base,
one after the other in the order in which they began, and one that ends takes only itself away.
"""


def document() -> str:
    """The whole text."""
    return "\n".join([HEAD, *_table(), "", *_families(), ""])


def _table() -> Iterator[str]:
    yield "| kind | target | what happens | keys | changes |"
    yield "|---|---|---|---|---|"
    for kind in KINDS:
        keys = "; ".join(_key(name, info) for name, info in kind.model_fields.items() if name != "target")
        yield f"| `{kind.kind}` | {kind.aims_at} | {_plain(kind.__doc__)} | {keys or '–'} | {kind.changes} |"


def _key(name: str, info: FieldInfo) -> str:
    quantity = next((item.text() for item in info.metadata if isinstance(item, Quantity)), "a name")
    default = "" if info.default is PydanticUndefined else f", {info.default} if not given"
    return f"`{name}`: {info.description}, {quantity}{default}"


def _families() -> Iterator[str]:
    """What the modules say of their quantities, once each."""
    for family in dict.fromkeys(kind.__module__ for kind in KINDS):
        yield f"- {_plain(sys.modules[family].__doc__)}"


def _plain(text: str | None) -> str:
    return " ".join((text or "").split())


if __name__ == "__main__":
    write_page(document, FILE)
