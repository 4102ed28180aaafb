"""Planned times of a day with how late they came; what never came counts as late as when the run ends whatever happens.

The table of stops has a row only where a train has been, or is on its way to: a train that never ran would be in no
share and no mean. What the dispatcher cancelled has rows, as late as the scenario states. So lateness is compared, and
shown as figures, from here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import polars as pl

from network.timetable import Call, CallKind, Timetable
from simulation.setup import latest_end_s

_TIMES: Final = {
    "train": pl.String,
    "station": pl.String,
    "kind": pl.String,
    "what": pl.String,  # "arrival" or "departure"
    "planned_s": pl.Float64,
    "late_s": pl.Float64,
    "came": pl.Boolean,
}


def planned_times(
    stops: pl.DataFrame, timetable: Timetable, end_s: float | None = None, *, revenue_only: bool = False
) -> pl.DataFrame:
    """Every planned arrival and departure: train, station, kind, what, planned_s, late_s and whether it came.

    `stops` is the table of a run; `end_s`: when that ends whatever happens, s; None: by the usual limit, or when the
    last time came. What was planned for later than that is not missing. `revenue_only`: of what never came, that of
    trains with passengers alone.
    """
    whats = ("arrival", "departure")
    came = pl.concat(
        stops.filter(pl.col(f"planned_{what}_s").is_not_null()).select(
            "train",
            "station",
            "kind",
            pl.lit(what).alias("what"),
            pl.col(f"planned_{what}_s").alias("planned_s"),
            pl.col(f"late_{what}_s").alias("late_s"),
            (pl.col(f"late_{what}_s").is_not_null() & ~pl.col("cancelled")).alias("came"),
        )
        for what in whats
    )
    there = {
        (train, station, what) for train, station, what in came.select("train", "station", "what").rows()
    }
    trains = [train for train in timetable.trains.values() if train.revenue or not revenue_only]
    missing = [
        (train.number, call.station_id, call.kind.value, what, planned_s, None, False)
        for train in trains
        for index, call in enumerate(train.calls)
        for what, planned_s in _planned(call, first=index == 0)
        if (train.number, call.station_id, what) not in there
    ]
    times = pl.concat([came, pl.DataFrame(missing, schema=_TIMES, orient="row")])
    if end_s is None:
        latest_s = times.select((pl.col("planned_s") + pl.col("late_s")).max()).item()
        end_s = max(latest_end_s(timetable) if timetable.trains else 0.0, latest_s or 0.0)
    due = times.filter(
        pl.col("came") | (pl.col("planned_s") <= end_s)
    )  # what is cancelled has its stated lateness
    return due.with_columns(pl.col("late_s").fill_null(end_s - pl.col("planned_s")))


def _planned(call: Call, *, first: bool) -> Iterator[tuple[str, float]]:
    if not first and call.arrival_s is not None and call.kind is not CallKind.PASS:
        yield "arrival", float(call.arrival_s)
    if call.departure_s is not None:
        yield "departure", float(call.departure_s)
