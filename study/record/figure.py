"""A figure of a table, defined once, at the field of its row.

From the field come the column of the Parquet file, the headings of report, comparison, CSV and pictures in two
languages, digits, how several rows make one, and what docs/tables.md says of it. A field with a default may be absent
from directories written before it was added.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from enum import Enum, Flag, auto
from functools import cache
from typing import Any, Final, TypeVar, get_args, get_type_hints

import polars as pl

from study.wording.catalogue import phrase, phrase_or_name
from study.wording.phrase import Phrase

Row = TypeVar("Row")


class Kind(Enum):
    """What a column holds, so that a page knows how to write and to sort it."""

    TEXT = "text"
    SAID = "said"  # a text in English and in Japanese
    TRAIN = "train"  # a number: leads to the train on the graph
    PLACE = "place"  # id of a station, or of a portal's section
    CLOCK = "clock"  # s since midnight
    WORD = "word"  # a key of the page's words
    CALL = "call"  # network.timetable.CallKind
    NUMBER = "number"
    SIGNED = "signed"


class Adds(Enum):
    """How a figure of several rows comes of each; weighed ones over the field that the figure names."""

    NOT_AT_ALL = auto()
    SUM = auto()
    MEAN = auto()
    LARGEST = auto()
    SMALLEST = auto()
    WEIGHED_MEAN = auto()
    WEIGHED_ROOT_MEAN_SQUARE = auto()


class ShownIn(Flag):
    """Where a figure is shown besides the table itself."""

    NOWHERE = 0
    REPORT = auto()
    SUMS = auto()  # in the report's tables of several rows together
    PARTS = auto()  # in those that say what a figure is made of
    TOTALS_COMPARED = auto()  # of all rows together
    ROWS_NAMED = auto()  # names what is compared row by row
    ROWS_COMPARED = auto()  # row by row, in the files of a comparison
    ROWS_LISTED = auto()  # row by row, on the page of a comparison too
    LISTED_BY = auto()  # those that differ most in this one first; else in the first one


@dataclass(frozen=True, slots=True)
class Figure:
    """Name in two languages, unit, digits, how it adds up, over which field it is weighed, where and how it is seen."""

    name: Phrase
    unit: str = ""
    digits: int = 0
    adds: Adds = Adds.NOT_AT_ALL
    over: str = ""
    seen: ShownIn = ShownIn.NOWHERE
    kind: Kind = Kind.NUMBER

    @property
    def heading(self) -> Phrase:
        """Name and unit, as columns are headed."""
        return (
            phrase("{what}, {unit}").fill(what=self.name, unit=phrase_or_name(self.unit))
            if self.unit
            else self.name
        )


_TYPES: Final[Mapping[object, type[pl.DataType]]] = {
    str: pl.String,
    bool: pl.Boolean,
    int: pl.Int64,
    float: pl.Float64,
}


@cache
def figures_of(row: type) -> Mapping[str, Figure]:
    """The figures of a row's type by field, in order: what its fields are annotated with."""
    return {name: said for name, notes in _notes(row).items() for said in notes if isinstance(said, Figure)}


@cache
def meanings_of(row: type) -> Mapping[str, str]:
    """What the fields of a row's type mean, as far as their names do not say it: the texts beside them."""
    return {name: said for name, notes in _notes(row).items() for said in notes if isinstance(said, str)}


def _notes(row: type) -> Mapping[str, tuple[object, ...]]:
    hints = get_type_hints(row, include_extras=True)
    return {f.name: getattr(hints[f.name], "__metadata__", ()) for f in fields(row)}


def seen_in(row: type, where: ShownIn) -> Mapping[str, Figure]:
    """Those of them that are shown there, or at one of several places."""
    return {name: said for name, said in figures_of(row).items() if where & said.seen}


@cache
def _types(row: type) -> Mapping[str, Any]:
    """The type of each field; of one that may be None the other."""
    hints = get_type_hints(row)
    return {f.name: (get_args(hints[f.name]) or (hints[f.name],))[0] for f in fields(row)}


@cache
def schema_of(row: type) -> Mapping[str, type[pl.DataType]]:
    """Columns of the table of such rows; words are stored as texts."""
    stored = {name: _TYPES[_words(kind) or kind] for name, kind in _types(row).items()}
    return stored | {
        name: said for name, notes in _notes(row).items() for said in notes if isinstance(said, type)
    }


def _words(kind: type) -> type | None:
    """As what the words of an Enum are stored; None for another type."""
    return (int if issubclass(kind, int) else str) if issubclass(kind, Enum) else None


def added_to(row: type) -> dict[str, object]:
    """Columns that older directories may lack, and what stands for them."""
    return {f.name: f.default for f in fields(row) if f.default is not MISSING}


def columns_of(row: type, rows: Sequence[object]) -> dict[str, list[Any]]:
    """Rows as columns."""
    found = {f.name: [getattr(each, f.name) for each in rows] for f in fields(row)}
    return found | {name: [word.value for word in found[name]] for name in _of_words(row)}


def rows_in(row: type[Row], table: pl.DataFrame) -> tuple[Row, ...]:
    """The rows of a table, in its order."""
    of: type = row
    words = _of_words(of)
    return tuple(
        row(**values | {name: kind(values[name]) for name, kind in words.items()})
        for values in table.select(list(_types(of))).iter_rows(named=True)
    )


@cache
def _of_words(row: type) -> Mapping[str, type[Enum]]:
    """The fields that hold a word of an Enum, with that."""
    return {name: kind for name, kind in _types(row).items() if issubclass(kind, Enum)}


def summed_figures(rows: Sequence[object]) -> dict[str, float | None]:
    """The figures of several rows of one type, by field, as far as they add up; None where no row has it."""
    row: type = type(rows[0])
    of = figures_of(row)
    return {name: _added(rows, name, said) for name, said in of.items() if said.adds is not Adds.NOT_AT_ALL}


def _added(rows: Sequence[object], name: str, said: Figure) -> float | None:
    known = [row for row in rows if getattr(row, name) is not None]
    values: list[float] = [getattr(row, name) for row in known]
    if not values:
        return None
    match said.adds:
        case Adds.SUM:
            return sum(values)
        case Adds.MEAN:
            return sum(values) / len(values)
        case Adds.LARGEST:
            return max(values)
        case Adds.SMALLEST:
            return min(values)
        case _:
            weights: list[float] = [getattr(row, said.over) for row in known]
            return _weighed(values, weights, 2 if said.adds is Adds.WEIGHED_ROOT_MEAN_SQUARE else 1)


def _weighed(values: Sequence[float], weights: Sequence[float], power: int) -> float:
    whole = sum(weights)
    if whole <= 0.0:
        return 0.0
    summed: float = sum(value**power * weight for value, weight in zip(values, weights, strict=True))
    return float((summed / whole) ** (1.0 / power))
