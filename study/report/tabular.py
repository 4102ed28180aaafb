"""Tables of the page as columns of values, each of a figure: the page sets them in either language and sorts them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from study.record.figure import Figure, Kind
from study.wording.phrase import Phrase


@dataclass(frozen=True, slots=True)
class Column:
    """One column: its name among the page's columns, what it shows, and its values."""

    label: str
    figure: Figure
    values: Sequence[Any]

    def as_dict(self) -> dict[str, Any]:
        """For the page; a number is rounded to its digits, what is not finite is left out."""
        values = list(self.values)
        if self.figure.kind in _NUMBERS:
            values = [_rounded(value, self.figure.digits) for value in values]
        return {**headed_column(self.label, self.figure), "values": values}


_NUMBERS: Final = (Kind.NUMBER, Kind.SIGNED, Kind.CLOCK)


def headed_column(label: str, figure: Figure) -> dict[str, Any]:
    """A column without values, for the page: heading in both languages, kind, digits."""
    return {
        "label": label,
        "heading": figure.heading.both,
        "kind": figure.kind.value,
        "digits": figure.digits,
    }


def _rounded(value: float | None, digits: int) -> float | int | None:
    if value is None or not math.isfinite(value):
        return None
    rounded = round(value, digits) + 0.0  # nothing has no sign
    return int(rounded) if digits == 0 else rounded


@dataclass(frozen=True, slots=True)
class Table:
    """A table: its name in the page and its files, what stands above it, and sentences under it."""

    id: str
    title: Phrase
    columns: tuple[Column, ...]
    notes: tuple[Phrase, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """For the page."""
        return {
            "id": self.id,
            "title": self.title.both,
            "columns": [column.as_dict() for column in self.columns],
            "notes": [note.both for note in self.notes],
        }


def table_of(
    table_id: str,
    title: Phrase,
    rows: Sequence[Mapping[str, Any]],
    figures: Mapping[str, Figure],
    notes: tuple[Phrase, ...] = (),
) -> Table:
    """A table from rows: of each row the values named in `figures`, which head them."""
    columns = tuple(Column(key, figure, [row[key] for row in rows]) for key, figure in figures.items())
    return Table(table_id, title, columns, notes)
