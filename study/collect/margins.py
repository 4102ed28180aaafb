"""The margin (余裕時分) of every hop: as planned over the least running time, and what was left of it as run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl

from study.measures.running_times import PlannedLeg
from study.record.margins import HopMargin
from study.record.tables import make_table


def margins_of(legs: Sequence[PlannedLeg], stops: pl.DataFrame) -> pl.DataFrame:
    """The table margins from what was planned and the table of stops; times that did not come are null."""
    # Where a train is ended, what does not come has a row of its own.
    ran = stops.filter(~pl.col("cancelled"))
    came = {(row["train"], row["station"]): row for row in ran.iter_rows(named=True)}
    return make_table("margins", [_margin(leg, came) for leg in legs])


def _margin(leg: PlannedLeg, came: Mapping[tuple[str, str], Mapping[str, Any]]) -> HopMargin:
    left_s = came.get((leg.number, leg.from_id), {}).get("departure_s")
    arrived_s = came.get((leg.number, leg.to_id), {}).get("arrival_s")
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
        margin_percent=_percent(margin_s, leg.least_s),
        run_s=_less(arrived_s, left_s),
        left_s=_less(leg.due_s, arrived_s),
    )


def _less(to_s: float | None, from_s: float | None) -> float | None:
    return None if to_s is None or from_s is None else round(to_s - from_s, 1)


def _percent(part: float, whole: float) -> float | None:
    return 100.0 * part / whole if 0.0 < whole < float("inf") else None
