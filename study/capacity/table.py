"""Blocking times as a table for people: a row an occupation, a column a part, then what each cost has of it, s."""

from __future__ import annotations

import math
from collections.abc import Iterable

import polars as pl

from study.capacity.occupation import Conflict, Occupation, OccupationCost, OccupationPart


def part_column(part: OccupationPart) -> str:
    """The column of a part."""
    return f"{part.value.replace(' ', '_')}_s"


def cost_column(cost: OccupationCost) -> str:
    """The column of a cost."""
    return f"cost_{cost.column}"


def blocking_times(occupations: Iterable[Occupation]) -> pl.DataFrame:
    """One row an occupation, in their order; parts make up `whole_s`, and so do costs. Null: it never comes or goes."""
    rows = [
        {
            "train": one.number,
            "section": one.section_id,
            "unit": one.stock_id,
            "direction": one.direction.name.lower(),
            "route": one.route_id,
            "begin_s": one.begin_s,
            "enters_s": one.enters_s if math.isfinite(one.enters_s) else None,
            "leaves_s": one.leaves_s if math.isfinite(one.leaves_s) else None,
            "end_s": one.end_s,
            "whole_s": one.length_s,
            **{part_column(part): one.of_part(part) for part in OccupationPart},
            **{cost_column(cost): value_s for cost, value_s in one.costs_s().items()},
            "waited_s": one.waited_s,
        }
        for one in occupations
    ]
    texts = dict.fromkeys(("train", "section", "unit", "direction", "route"), pl.String)
    times = ("begin_s", "enters_s", "leaves_s", "end_s", "whole_s")
    figures = [*times, *map(part_column, OccupationPart), *map(cost_column, OccupationCost), "waited_s"]
    return pl.DataFrame(rows, schema=texts | dict.fromkeys(figures, pl.Float64))


def conflict_rows(conflicts: Iterable[Conflict]) -> list[dict[str, object]]:
    """Conflicts as plain data."""
    return [
        {
            "section": one.section_id,
            "train": one.first.number,
            "until_s": one.first.end_s,
            "other": one.second.number,
            "from_s": one.second.begin_s,
            "overlap_s": one.overlap_s,
        }
        for one in conflicts
    ]
