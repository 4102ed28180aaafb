"""Level crossings (踏切) of a line that is made from a list: `[[crossings]]` of a station list, or rows of a CSV."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from network.files.kinds import TABLES_MAX, about
from network.files.names import Identifier, Title
from network.files.quantities import CrossingWidth, Kilometrage
from network.files.toml_input import Record


class CrossingRow(Record):
    """`[[crossings]]` of a station list, or a row of the CSV."""

    km: Annotated[Kilometrage, about("kilometrage of the middle of the road")]
    id: Annotated[Identifier | None, about("name in other files; left out: X and its number")] = None
    name: Annotated[Title, about("what people call it")] = ""
    kind: Annotated[
        Literal["1", "3", "4"], about("class: with barriers, with a warning alone, without any device")
    ] = "1"
    width_m: Annotated[CrossingWidth, about("extent along the track")] = 6.0


Crossings = Annotated[
    list[CrossingRow], Field(max_length=TABLES_MAX), about("level crossings (踏切), by radio")
]


class CrossingListFile(Record):
    """The rows of a CSV."""

    crossings: Crossings


@dataclass(frozen=True, slots=True)
class ListedCrossings:
    """Rows, and the file that has them."""

    file: str
    rows: tuple[CrossingRow, ...] = ()
