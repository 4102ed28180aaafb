"""Punctuality by station (定時性): arrivals and departures against the plan, and how fine that plan is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import polars as pl

from network.model import Line
from network.timetable import CallKind

ON_TIME_S: Final = 60.0  # less late than that counts as on time, as Japanese operators count
ALL_STATIONS: Final = ""
PUNCTUALITY: Final[Mapping[str, type[pl.DataType] | pl.DataType]] = {
    "station": pl.String,  # ALL_STATIONS: the whole line
    "what": pl.String,  # "arrival" or "departure"
    "planned": pl.Int64,  # times that were planned
    "came": pl.Int64,  # of these, those that came; the others are in all that follows: see `study.measures.missing`
    "on_time_share": pl.Float64,  # less than ON_TIME_S late, of what was planned: what did not come is not on time
    "mean_s": pl.Float64,
    "sigma_s": pl.Float64,  # of the sample, n - 1; null for fewer than two
    "p95_s": pl.Float64,  # nearest rank
    "worst_s": pl.Float64,
    "worst_train": pl.String,
    "whole_minutes": pl.Boolean,  # every planned time here is one: lateness below a minute says little
}


def punctuality(times: pl.DataFrame, line: Line) -> pl.DataFrame:
    """PUNCTUALITY: one row a station (along the line, then all) and what; only what has planned times.

    Lateness in s, below 0 is early. Passings are left out, and trains that carry no passengers count. `times` are of
    `study.measures.missing.planned_times`.
    """
    times = times.filter(pl.col("kind") != CallKind.PASS.value)
    whole = times.with_columns(pl.lit(ALL_STATIONS).alias("station"))
    at_m = {station.id: station.position_m for station in line.stations.values()}
    rows = pl.concat([times, whole]).group_by("station", "what", maintain_order=True).agg(*_figures())
    order = pl.col("station").replace_strict(at_m, default=None)
    return rows.sort(order, "what", nulls_last=True, maintain_order=True).select(
        pl.col(name).cast(dtype) for name, dtype in PUNCTUALITY.items()
    )


def _figures() -> tuple[pl.Expr, ...]:
    late_s, came = pl.col("late_s"), pl.col("came")
    return (
        pl.len().alias("planned"),
        came.sum().alias("came"),
        (((late_s < ON_TIME_S) & came).sum() / pl.len()).alias("on_time_share"),
        late_s.mean().alias("mean_s"),
        late_s.std().alias("sigma_s"),
        late_s.sort().get((pl.len() * 0.95).ceil().cast(pl.Int64) - 1).alias("p95_s"),
        late_s.max().alias("worst_s"),
        pl.col("train").sort_by(late_s, descending=True).first().alias("worst_train"),
        (pl.col("planned_s") % 60.0 == 0.0).all().alias("whole_minutes"),
    )
