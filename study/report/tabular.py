"""Tables of the page as columns of values, each of a kind: the page sets them in either language and sorts them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final


class Kind(Enum):
    """What a column holds, so that the page knows how to write and to sort it."""

    TEXT = "text"
    SAID = "said"  # a text in English and in Japanese
    TRAIN = "train"  # a number: leads to the train on the graph
    PLACE = "place"  # id of a station, or of a portal's section
    CLOCK = "clock"  # s since midnight
    WORD = "word"  # a key of the page's words
    CALL = "call"  # network.timetable.CallKind
    NUMBER = "number"
    SIGNED = "signed"
    BAD = "bad"  # text that stands out


@dataclass(frozen=True, slots=True)
class Column:
    """One column: the key of its heading among the page's words, its kind, digits after the point, and its values."""

    label: str
    kind: Kind
    values: Sequence[Any]
    digits: int = 0

    def as_dict(self) -> dict[str, Any]:
        """For the page; a number is rounded to its digits, what is not finite is left out."""
        values = list(self.values)
        if self.kind in _NUMBERS:
            values = [_rounded(value, self.digits) for value in values]
        return {"label": self.label, "kind": self.kind.value, "digits": self.digits, "values": values}


_NUMBERS: Final = (Kind.NUMBER, Kind.SIGNED, Kind.CLOCK)


def _rounded(value: float | None, digits: int) -> float | int | None:
    if value is None or not math.isfinite(value):
        return None
    rounded = round(value, digits)
    return int(rounded) if digits == 0 else rounded


@dataclass(frozen=True, slots=True)
class Table:
    """A table. `id` names it among the page's words; `notes` are sentences under it, English and Japanese."""

    id: str
    columns: tuple[Column, ...]
    notes: tuple[tuple[str, str], ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """For the page."""
        return {
            "id": self.id,
            "columns": [column.as_dict() for column in self.columns],
            "notes": [list(note) for note in self.notes],
        }


def table_of(
    table_id: str,
    rows: Sequence[Mapping[str, Any]],
    columns: Mapping[str, tuple[Kind, int]],
    notes: tuple[tuple[str, str], ...] = (),
) -> Table:
    """A table from rows: of each row the values named in `columns`, which are headings too."""
    made = tuple(
        Column(key, kind, [row[key] for row in rows], digits) for key, (kind, digits) in columns.items()
    )
    return Table(table_id, made, notes)
