"""The margin (余裕時分) of every hop: as planned over the least running time, and what was left of it as run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl

from study.measures.running_times import PlannedLeg
from study.record.margins import HopMargin
from study.record.tables import make_table


def margins_of(legs: Sequence[PlannedLeg], stops: pl.DataFrame, end_s: float = -math.inf) -> pl.DataFrame:
    """The table margins from what was planned and the table of stops; the run ends at `end_s` whatever happens."""
    # Where a train is ended, what does not come has a row of its own.
    came, cut = (
        {(row["train"], row["station"]): row for row in rows.iter_rows(named=True)}
        for rows in (stops.filter(~pl.col("cancelled")), stops.filter("cancelled"))
    )
    return make_table("margins", [_margin(leg, came, cut, end_s) for leg in legs])


def _margin(
    leg: PlannedLeg,
    came: Mapping[tuple[str, str], Mapping[str, Any]],
    cut: Mapping[tuple[str, str], Mapping[str, Any]],
    end_s: float,
) -> HopMargin:
    left_s = came.get((leg.number, leg.from_id), {}).get("departure_s")
    arrived_s = came.get((leg.number, leg.to_id), {}).get("arrival_s")
    stated_s = cut.get((leg.number, leg.to_id), {}).get("late_arrival_s")
    never_s = end_s if stated_s is None else leg.due_s + stated_s
    missing = arrived_s is None and (stated_s is not None or leg.due_s <= end_s)
    margin_s = leg.planned_s - leg.least_s
    return HopMargin(
        leg.stock_id,
        leg.number,
        leg.revenue,
        leg.from_id,
        leg.to_id,
        leg.planned_s,
        leg.least_s,
        leg.attainable_s,
        margin_s,
        margin_percent=100.0 * margin_s / leg.least_s if 0.0 < leg.least_s < float("inf") else None,
        run_s=_less(arrived_s, left_s),
        left_s=_less(leg.due_s, never_s if missing else arrived_s),
    )


def _less(to_s: float | None, from_s: float | None) -> float | None:
    return None if to_s is None or from_s is None else round(to_s - from_s, 1)
