"""Columns that many tables have: what names a row, and figures of one unit."""

from __future__ import annotations

from typing import Annotated, Final, TypeAlias

import polars as pl

from network.model import Direction
from study.record.figure import Adds, Figure, Kind, ShownIn
from study.wording.phrase import Phrase

UNIT: Final = Figure(Phrase("unit", "編成・単位"), seen=ShownIn.REPORT, kind=Kind.TEXT)
TRAIN: Final = Figure(Phrase("train", "列車"), seen=ShownIn.REPORT | ShownIn.ROWS_NAMED, kind=Kind.TRAIN)
STATION: Final = Figure(Phrase("station", "駅"), seen=ShownIn.REPORT, kind=Kind.PLACE)
FROM: Final = Figure(Phrase("from", "駅間（発）"), seen=ShownIn.REPORT | ShownIn.ROWS_NAMED, kind=Kind.PLACE)
TO: Final = Figure(Phrase("to", "駅間（着）"), seen=ShownIn.REPORT | ShownIn.ROWS_NAMED, kind=Kind.PLACE)
TRAINS: Final = Figure(Phrase("trains", "本数"))

Unit: TypeAlias = Annotated[str, UNIT]
Train: TypeAlias = Annotated[str, TRAIN]
Station: TypeAlias = Annotated[str, STATION]
From: TypeAlias = Annotated[str, FROM, "station, or portal's section"]
To: TypeAlias = Annotated[str, TO, "station, or portal's section"]
Way: TypeAlias = Annotated[Direction, pl.Int8]
Revenue: TypeAlias = Annotated[
    bool, Figure(Phrase("passengers", "営業"), kind=Kind.WORD), "carries passengers"
]


def seconds(
    en: str, ja: str, digits: int = 0, kind: Kind = Kind.NUMBER, seen: ShownIn = ShownIn.REPORT
) -> Figure:
    """A time, s."""
    return Figure(Phrase(en, ja), "s", digits, seen=seen, kind=kind)


def clock(en: str, ja: str, digits: int = 0, seen: ShownIn = ShownIn.REPORT) -> Figure:
    """A time of the day."""
    return Figure(Phrase(en, ja), "", digits, seen=seen, kind=Kind.CLOCK)


def kwh(
    en: str, ja: str, seen: ShownIn = ShownIn.REPORT, digits: int = 2, kind: Kind = Kind.NUMBER
) -> Figure:
    """An energy, which adds up."""
    return Figure(Phrase(en, ja), "kWh", digits, Adds.SUM, seen=seen, kind=kind)


def said(en: str, ja: str, seen: ShownIn = ShownIn.REPORT) -> Figure:
    """A text in both languages."""
    return Figure(Phrase(en, ja), seen=seen, kind=Kind.SAID)
