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

AT_TELEGRAMS: Final = """\
## Just before and just after every telegram

What a party knows changes with telegrams alone, so a window between a word and its answer is found on the grid of
telegrams and by luck on one of seconds. `branchline drill FILE --at telegrams` puts single faults beside those of a
drill, a step before and a step after each telegram that they may have to do with is sent or takes effect; staff react,
and a run is bad when a rule is broken, a train never arrives, or something waits for nothing. Whole folders of shipped
drills, one line a class of outcome, and the drills that show what is bad:

    branchline drill rtri --at telegrams --faults power --sample 100 --out grid
    branchline drill karasuyama --at telegrams --faults links --sample 100 --from 06:30 --to 07:30

`--faults` is `power` of each party, `links` (each cut one way) or `all` kinds; `--sample` takes so many runs of each
drill, evenly over faults and instants (the seed says which), and without it all are run. A drill with nothing in it
(01) is swept for an hour from its first telegram on, another from a minute before what it does first until five
minutes after what it does last. What the drill itself breaks, as it expects of itself, is told apart."""


def document() -> str:
    """The whole text."""
    return "\n".join([HEAD, *_table(), "", *_families(), "", AT_TELEGRAMS, ""])


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
