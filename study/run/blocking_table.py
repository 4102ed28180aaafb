"""Who had which section when: the tables `blocks` and `blocking` of a run, of the same holds, and back.

Picture, judge and figure read what was found.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import Any

import polars as pl

from network.model import Direction
from study.capacity.observed import Held
from study.capacity.occupation import COST_OF, Occupation, Part, Slice
from study.run.tables import BLOCKING, BLOCKS, make_table


def blocking_table(occupations: Iterable[Occupation]) -> pl.DataFrame:
    """The table `blocking`, one row a slice, in the order of the occupations."""
    rows = [row for index, one in enumerate(occupations) for row in _rows(index, one)]
    return make_table("blocking", {column: [row[column] for row in rows] for column in BLOCKING})


def blocks_table(held: Iterable[Held]) -> pl.DataFrame:
    """The table `blocks`, one row a section and grant, in the order of the grants.

    Where the train was there before it was first seen, it is entered then.
    """
    rows = [_block(one) for one in held]
    return make_table("blocks", {column: [row[column] for row in rows] for column in BLOCKS})


def _block(one: Held) -> dict[str, Any]:
    visit = one.visit
    entered_s, cleared_s = (math.inf, math.inf) if visit is None else (visit.enters_s, visit.rear_s)
    if visit is not None and entered_s == -math.inf:
        entered_s = visit.begin_s
    return {
        "section": one.section_id,
        "unit": one.unit,
        "train": one.number,
        "token": one.token,
        "granted_s": one.granted_s,
        "released_s": _or_none(one.freed_s),
        "entered_s": _or_none(entered_s),
        "cleared_s": _or_none(cleared_s),
    }


def _or_none(time_s: float) -> float | None:
    return time_s if math.isfinite(time_s) else None


def _rows(index: int, one: Occupation) -> Iterator[dict[str, Any]]:
    for piece in one.slices:
        yield {
            "occupation": index,
            "section": one.section_id,
            "unit": one.stock_id,
            "train": one.number,
            "direction": int(one.direction),
            "route": one.route_id,
            "part": piece.part.value,
            "cost": COST_OF[piece.part].value,
            "from_s": piece.begin_s,
            "to_s": piece.end_s,
            "enters_s": one.enters_s,
            "leaves_s": one.leaves_s,
            "waited_s": one.waited_s,
        }


def read_blocking(table: pl.DataFrame) -> tuple[Occupation, ...]:
    """The occupations of that table, in its order."""
    rows = table.iter_rows(named=True)
    return tuple(_occupation(list(own)) for _, own in groupby(rows, key=lambda row: row["occupation"]))


def _occupation(rows: Sequence[dict[str, Any]]) -> Occupation:
    first = rows[0]
    return Occupation(
        first["section"],
        first["unit"],
        first["train"],
        Direction(first["direction"]),
        tuple(Slice(Part(row["part"]), row["from_s"], row["to_s"]) for row in rows),
        first["enters_s"],
        first["leaves_s"],
        first["route"],
        first["waited_s"],
    )
