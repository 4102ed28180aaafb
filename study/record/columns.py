"""Columns that many tables have: what names a row, and figures of one unit."""

from __future__ import annotations

import math
from typing import Annotated, Final, TypeAlias

import polars as pl

from network.model import Direction
from study.record.figure import Adds, Figure, Kind, ShownIn
from study.wording.catalogue import phrase

UNIT: Final = Figure(phrase("unit"), seen=ShownIn.REPORT, kind=Kind.TEXT)
TRAIN: Final = Figure(phrase("train"), seen=ShownIn.REPORT | ShownIn.ROWS_NAMED, kind=Kind.TRAIN)
STATION: Final = Figure(phrase("station"), seen=ShownIn.REPORT, kind=Kind.PLACE)
FROM: Final = Figure(phrase("from", "place"), seen=ShownIn.REPORT | ShownIn.ROWS_NAMED, kind=Kind.PLACE)
TO: Final = Figure(phrase("to", "place"), seen=ShownIn.REPORT | ShownIn.ROWS_NAMED, kind=Kind.PLACE)
TRAINS: Final = Figure(phrase("trains", "count"))
_CROSSING: Final = Figure(phrase("crossing"), seen=ShownIn.REPORT | ShownIn.ROWS_NAMED, kind=Kind.TEXT)
_HOUR: Final = Figure(phrase("hour"), seen=ShownIn.REPORT | ShownIn.ROWS_NAMED)

Unit: TypeAlias = Annotated[str, UNIT]
Train: TypeAlias = Annotated[str, TRAIN]
Station: TypeAlias = Annotated[str, STATION]
From: TypeAlias = Annotated[str, FROM, "station, or portal's section"]
To: TypeAlias = Annotated[str, TO, "station, or portal's section"]
Crossing: TypeAlias = Annotated[str, _CROSSING]
Hour: TypeAlias = Annotated[int, _HOUR, "from midnight"]
Way: TypeAlias = Annotated[Direction, pl.Int8]
Revenue: TypeAlias = Annotated[bool, Figure(phrase("passengers"), kind=Kind.WORD), "carries passengers"]


def seconds(
    name: str,
    digits: int = 0,
    kind: Kind = Kind.NUMBER,
    seen: ShownIn = ShownIn.REPORT,
    context: str = "",
) -> Figure:
    """A time, s; like all names here by its English, with the context that it has in the catalogue."""
    return Figure(phrase(name, context), "s", digits, seen=seen, kind=kind)


def clock(name: str, digits: int = 0, seen: ShownIn = ShownIn.REPORT, context: str = "") -> Figure:
    """A time of the day."""
    return Figure(phrase(name, context), "", digits, seen=seen, kind=Kind.CLOCK)


def kwh(
    name: str,
    seen: ShownIn = ShownIn.REPORT,
    digits: int = 2,
    kind: Kind = Kind.NUMBER,
    context: str = "",
) -> Figure:
    """An energy, which adds up."""
    return Figure(phrase(name, context), "kWh", digits, Adds.SUM, seen=seen, kind=kind)


def said_in_both(name: str, seen: ShownIn = ShownIn.REPORT, context: str = "") -> Figure:
    """A text in both languages."""
    return Figure(phrase(name, context), seen=seen, kind=Kind.SAID)


def tenth(value: float | None) -> float | None:
    """To a tenth; None for what is none, or has no end."""
    return None if value is None or not math.isfinite(value) else round(value, 1)
