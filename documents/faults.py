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
`target` and a `start` (a time, or words for an event); `after_s` and `duration_s` are optional. Without a duration a
fault lasts until a person ends it, unless it is over at once. The other keys are those of its kind.

Faults of the same quantity and target may overlap. They are applied to the base value one after the other, in the
order in which they began; when one ends, the others stay in force.
"""

AT_TELEGRAMS: Final = """\
## Just before and just after every telegram

What a party knows changes with telegrams only. The critical moment between a request and its answer may be shorter
than a second, so `branchline drill FILE --at telegrams` adds single faults one step before and one step after each
telegram that they may concern: a party's own, a link's as they are sent, those of the terminal of points (decision
167). Staff react. A run is bad if a rule is broken, a train never arrives, or a train waits for nothing. FILE may be a
folder of shipped drills; printed is one line for each class of outcome, and `--out` has a drill for each bad one:

    branchline drill rtri --at telegrams --faults power --sample 100 --out grid
    branchline drill karasuyama --at telegrams --faults links --sample 100 --from 06:30 --to 07:30

`--faults` is `power` of each party, `links` (each cut one way) or `all` kinds. `--sample` limits the runs of each
drill to an even sample over faults and instants, chosen by the seed; without it all are run. A drill without faults or
acts (01) is swept for an hour from its first telegram on, others from a minute before each fault or act begins or is
over until five minutes after that.
Rules that the drill itself breaks, as it expects, are listed separately."""


def document() -> str:
    """The whole text."""
    return "\n".join([HEAD, *_table(), "", *_families(), "", AT_TELEGRAMS, ""])


def _table() -> Iterator[str]:
    yield "| kind | target | what happens | keys | changes |"
    yield "|---|---|---|---|---|"
    for kind in KINDS:
        keys = "; ".join(_key(name, info) for name, info in kind.model_fields.items() if name != "target")
        yield f"| `{kind.kind}` | {kind.aims_at} | {in_one_line(kind.__doc__)} | {keys or '–'} | {kind.changes} |"


def _key(name: str, info: FieldInfo) -> str:
    quantity = next((item.text() for item in info.metadata if isinstance(item, Quantity)), "a name")
    default = "" if info.default is PydanticUndefined else f", {info.default} if not given"
    return f"`{name}`: {info.description}, {quantity}{default}"


def _families() -> Iterator[str]:
    """What the modules say of their quantities, once each."""
    for family in dict.fromkeys(kind.__module__ for kind in KINDS):
        yield f"- {in_one_line(sys.modules[family].__doc__)}"


def in_one_line(text: str | None) -> str:
    """A text without its line breaks."""
    return " ".join((text or "").split())


if __name__ == "__main__":
    write_page(document, FILE)
