"""The margin (余裕時分) of every hop: as planned over the least running time, and what was left of it as run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import polars as pl

from study.measures.running_times import PlannedLeg
from study.run.tables import make_table

NAMED: Final = ("train", "from_station", "to_station", "planned_s", "least_s", "margin_s", "margin_percent")


def margins_of(legs: Sequence[PlannedLeg], stops: pl.DataFrame) -> pl.DataFrame:
    """The table margins from what was planned and the table of stops; times that did not come are null."""
    came = {(row["train"], row["station"]): row for row in stops.iter_rows(named=True)}
    left = [came.get((leg.number, leg.from_id), {}).get("departure_s") for leg in legs]
    arrived = [came.get((leg.number, leg.to_id), {}).get("arrival_s") for leg in legs]
    return make_table(
        "margins",
        {
            "unit": [leg.stock_id for leg in legs],
            "train": [leg.number for leg in legs],
            "revenue": [leg.revenue for leg in legs],
            "from_station": [leg.from_id for leg in legs],
            "to_station": [leg.to_id for leg in legs],
            "planned_s": [leg.planned_s for leg in legs],
            "least_s": [leg.least_s for leg in legs],
            "attainable_s": [leg.attainable_s for leg in legs],
            "margin_s": [leg.planned_s - leg.least_s for leg in legs],
            "margin_percent": [_percent(leg.planned_s - leg.least_s, leg.least_s) for leg in legs],
            "run_s": [_less(to_s, from_s) for to_s, from_s in zip(arrived, left, strict=True)],
            "left_s": [_less(leg.due_s, to_s) for leg, to_s in zip(legs, arrived, strict=True)],
        },
    )


def smallest(margins: pl.DataFrame) -> dict[str, dict[str, Any]] | None:
    """For summary.json: the hop with the smallest margin in s, in percent, and with least left; None: no hop."""
    if margins.is_empty():
        return None
    found = {by: _least(margins, by) for by in ("margin_s", "margin_percent", "left_s")}
    return {f"smallest_{by}": row for by, row in found.items() if row is not None}


def _least(margins: pl.DataFrame, by: str) -> dict[str, Any] | None:
    known = margins.filter(pl.col(by).is_not_null())
    if known.is_empty():
        return None
    row = known.sort(by, "train", maintain_order=True).row(0, named=True)
    names = (*NAMED, "run_s", "left_s") if by == "left_s" else NAMED
    return {name: round(row[name], 1) if isinstance(row[name], float) else row[name] for name in names}


def _less(to_s: float | None, from_s: float | None) -> float | None:
    return None if to_s is None or from_s is None else round(to_s - from_s, 1)


def _percent(part: float, whole: float) -> float | None:
    return 100.0 * part / whole if 0.0 < whole < float("inf") else None
