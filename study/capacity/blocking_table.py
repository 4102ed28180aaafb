"""Who had which section when: the tables `blocks` and `blocking` of a run, of the same holds, and back.

Picture, judge and figure read what was found.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

import polars as pl

from study.capacity.occupation import COST_OF, Occupation, OccupationPart, Slice
from study.measures.register_holds import SectionHold
from study.record.figure import rows_in
from study.record.sections import SectionHeld, SliceOfBlocking
from study.record.tables import make_table


def blocking_table(occupations: Iterable[Occupation]) -> pl.DataFrame:
    """The table `blocking`, one row a slice, in the order of the occupations."""
    return make_table("blocking", [row for index, one in enumerate(occupations) for row in _rows(index, one)])


def blocks_table(holds: Iterable[SectionHold]) -> pl.DataFrame:
    """The table `blocks`, one row a section and grant, in the order of the grants.

    Where the train was there before it was first seen, it is entered then.
    """
    return make_table("blocks", [_block(one) for one in holds])


def _block(one: SectionHold) -> SectionHeld:
    visit = one.visit
    entered_s, cleared_s = (math.inf, math.inf) if visit is None else (visit.enters_s, visit.rear_s)
    if visit is not None and entered_s == -math.inf:
        entered_s = visit.begin_s
    return SectionHeld(
        one.section_id,
        one.unit,
        one.number,
        one.token,
        one.asked.heard_s,
        _or_none(one.freed_s),
        _or_none(entered_s),
        _or_none(cleared_s),
    )


def _or_none(time_s: float) -> float | None:
    return time_s if math.isfinite(time_s) else None


def _rows(index: int, one: Occupation) -> Iterator[SliceOfBlocking]:
    for piece in one.slices:
        yield SliceOfBlocking(
            index,
            one.section_id,
            one.stock_id,
            one.number,
            one.direction,
            one.route_id,
            piece.part.value,
            COST_OF[piece.part].value,
            piece.begin_s,
            piece.end_s,
            one.enters_s,
            one.leaves_s,
            one.waited_s,
        )


def read_blocking(table: pl.DataFrame) -> tuple[Occupation, ...]:
    """The occupations of that table, in its order."""
    rows = rows_in(SliceOfBlocking, table)
    return tuple(_occupation(list(own)) for _, own in groupby(rows, key=lambda row: row.occupation))


def _occupation(rows: Sequence[SliceOfBlocking]) -> Occupation:
    first = rows[0]
    return Occupation(
        first.section,
        first.unit,
        first.train,
        first.direction,
        tuple(Slice(OccupationPart(row.part), row.from_s, row.to_s) for row in rows),
        first.enters_s,
        first.leaves_s,
        first.route,
        first.waited_s,
    )
