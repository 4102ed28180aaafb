"""Writes docs/tables.md from the types of rows: `python -m documents.tables [FILE]`."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from documents.interlocking import table
from documents.journal import UNITS
from documents.page import write_page
from study.record.figure import Adds, figures_of, meanings_of, schema_of
from study.record.tables import ROWS

FILE: Final = Path("docs/tables.md")
HEAD: Final = ("column", "type", "unit", "English", "Japanese", "several rows", "meaning")
_UNITS: Final = dict(UNITS) | {"mps3": "m/s³", "kwh": "kWh", "kw": "kW", "km": "km", "percent": "%"}


def document() -> str:
    """The whole document."""
    return "\n\n".join([_INTRO.strip(), *(_section(name, row) for name, row in ROWS.items())]) + "\n"


def _section(name: str, row: type) -> str:
    """A table: what a row is, and its columns."""
    figures, meanings = figures_of(row), meanings_of(row)
    lines: list[tuple[str, ...]] = []
    for column, kind in schema_of(row).items():
        figure = figures.get(column)
        unit = _UNITS.get(column.rpartition("_")[2], "")
        said = ("", "", "") if figure is None else (figure.name.en, figure.name.ja, _added(figure.adds))
        lines.append((f"`{column}`", kind.__name__, unit, *said, meanings.get(column, "")))
    return f"## {name}\n\n{' '.join((row.__doc__ or '').split())}\n\n{table(HEAD, lines)}"


def _added(adds: Adds) -> str:
    return "" if adds is Adds.NOT_AT_ALL else adds.name.lower().replace("_", " ")


_INTRO: Final = """
# The tables of a run

Made by `make docs` from the types of rows in `study/record`; not written by hand.

A run directory has each as a Parquet file of its name. Times are seconds since midnight of the operating day, places
kilometrage, energy is counted at the wire or battery; a null is what was not planned or did not come. `read_run` of
`study.record.read_back` gives the tables as polars frames, each read when it is first asked for (`tables.margins`), and
`rows_in(HopMargin, tables.margins)` of `study.record.figure` gives its rows as their type. What a version has more is
left out in reading, and a column with a default may be absent. The summary's `format` is counted up where what earlier
versions wrote cannot be read any more.
"""


if __name__ == "__main__":
    write_page(document, FILE)
