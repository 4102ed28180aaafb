"""One definition of a record: a class whose annotated fields are its type, its numpy dtype and its documentation.

Structured arrays instead of objects, because a day is some 650,000 steps and the laws of motion are compiled: numba
reads `row.speed_mps` as it stands. numpy's own type of a record does not know the names, so a record is written as a
Protocol; a law that takes it and misspells a field is an error of the type checker. `dtype_of` makes the numpy dtype
of that very class, `fields_of` its documentation:

    class WheelRow(Protocol):
        speed_mps: float
        sliding: Annotated[int, "1: adhesion exceeded in this step"]
        pulses: Annotated[list[int], 16, "of the last steps"]  # a number is the length of an array, of NDArray too
        axle: AxleRow  # a record in a record
        settings: Wheel  # a table of a file in a record: its numbers and switches; `put_settings` fills it

    WHEEL: Final = dtype_of(WheelRow)

A record holds float (f8), int (i8), arrays of them and other records, aligned, in the order written.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Final, TypeVar, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from network.files.toml_input import Record

RowT = TypeVar("RowT")

SCALARS: Final[dict[object, str]] = {float: "f8", int: "i8"}
NUMBERS: Final[dict[object, type]] = {float: float, int: int, bool: int}  # of a table of a file
FLOATS: Final[object] = NDArray[np.float64]
UNITS: Final = {
    "m": "m",
    "s": "s",
    "kg": "kg",
    "n": "N",
    "w": "W",
    "j": "J",
    "c": "C",
    "a": "A",
    "v": "V",
    "ohm": "Ω",
    "rad": "rad",
    "mps": "m/s",
    "mps2": "m/s²",
    "mps3": "m/s³",
    "m2ps5": "m²/s⁵",
    "per_s": "1/s",
    "per_s2": "1/s²",
    "s_per_m": "s/m",
    "n_per_kn": "N/kN",
    "n_per_kmh2": "N/(km/h)²",
    "n_per_kn_kmh": "N/(kN km/h)",
}


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a record as documented; `length` 0: a single value."""

    name: str
    kind: type
    length: int
    unit: str
    meaning: str


def unit_of(name: str) -> str:
    """The unit that ends a field's name, as written in text; empty for numbers and states without one."""
    parts = name.split("_")
    for first in range(1, len(parts)):
        unit = UNITS.get("_".join(parts[first:]))
        if unit is not None:
            return unit
    return ""


@cache
def fields_of(row: type) -> tuple[Field, ...]:
    """The fields of a record in order. TypeError, naming record and field, for what no record can hold."""
    table: type = row
    if issubclass(table, Record):
        return tuple(
            Field(name, NUMBERS[info.annotation], 0, unit_of(name), info.description or "")
            for name, info in table.model_fields.items()
            if info.annotation in NUMBERS
        )
    fields: list[Field] = []
    for name, hint in get_type_hints(row, include_extras=True).items():
        kind, notes = _taken_apart(hint)
        lengths = [note for note in notes if isinstance(note, int)]
        meanings = [note for note in notes if isinstance(note, str)]
        listed = get_origin(kind) is list or kind == FLOATS
        of = float if kind == FLOATS else get_args(kind)[0] if listed else kind
        record = not listed and bool(getattr(of, "__annotations__", None))
        if len(lengths) != int(listed) or not (of in SCALARS or record):
            raise TypeError(f"{row.__name__}.{name}: a record holds no {hint}")
        fields.append(Field(name, of, lengths[0] if listed else 0, unit_of(name), " ".join(meanings)))
    if not fields:
        raise TypeError(f"{row.__name__} has no fields")
    return tuple(fields)


@cache
def dtype_of(row: type) -> np.dtype[np.void]:
    """The aligned numpy dtype of a record."""
    columns: list[Any] = []
    for field in fields_of(row):
        kind = SCALARS.get(field.kind) or dtype_of(field.kind)
        columns.append((field.name, kind, (field.length,)) if field.length else (field.name, kind))
    return np.dtype(columns, align=True)


def put_settings(row: object, settings: Record, table: type[Record] | None = None) -> None:
    """Put the numbers and switches of a table of a file into its record, which has those of `table` where it is given:
    a class that the table derives from.
    """
    for field in fields_of(table or type(settings)):
        setattr(row, field.name, getattr(settings, field.name))


CELLS: Final[dict[object, Any]] = {float: ctypes.c_double, int: ctypes.c_int64}


@cache
def structure_of(row: type) -> type[ctypes.Structure]:
    """The C structure of a record: the same memory as its dtype, both laid out as C does."""
    columns: list[tuple[str, Any]] = []
    for field in fields_of(row):
        kind = CELLS.get(field.kind) or structure_of(field.kind)
        columns.append((field.name, kind * field.length if field.length else kind))
    made = type(f"{row.__name__}Cells", (ctypes.Structure,), {"_fields_": columns})
    if ctypes.sizeof(made) != dtype_of(row).itemsize:
        raise TypeError(f"{row.__name__} is laid out in two ways")
    return made


def cells_of(row: type, record: RowT) -> RowT:
    """The memory of a record with plain Python numbers as attributes, for code that is not compiled.

    Reading a numpy record's attribute takes some twenty times as long. `record` is one element of a structured
    array, which is kept alive.
    """
    address, _ = cast("Any", record).__array_interface__["data"]
    cells: Any = structure_of(row).from_address(address)
    cells.kept_alive = record
    return cast("RowT", cells)


def _taken_apart(hint: object) -> tuple[Any, tuple[object, ...]]:
    if get_origin(hint) is Annotated:
        kind, *notes = get_args(hint)
        return kind, tuple(notes)
    return hint, ()
