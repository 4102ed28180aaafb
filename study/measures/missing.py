"""Planned times of a day with how late they came; what never came counts as late as when the run ends whatever happens.

The table of stops has a row only where a train has been, or is on its way to: a train that never ran would be in no
share and no mean. What the dispatcher cancelled has rows, as late as the scenario states. So lateness is compared, and
shown as figures, from here.
"""

from __future__ import annotations

import math

import polars as pl

from network.timetable import Timetable
from simulation.setup import latest_end_s


def missing_calls(stops: pl.DataFrame, timetable: Timetable, end_s: float = math.inf) -> pl.DataFrame:
    """Rows of the table of stops for calls planned until `end_s` that have none, by set in the order of its trains."""
    there = set(stops.select("train", "station").rows())
    rows = [
        {
            "unit": diagram.stock_id,
            "train": number,
            "revenue": train.revenue,
            "station": call.station_id,
            "track": call.track,
            "kind": call.kind.value,
            "planned_arrival_s": None if call.arrival_s is None else float(call.arrival_s),
            "planned_departure_s": None if call.departure_s is None else float(call.departure_s),
            "cancelled": False,
        }
        for diagram in timetable.diagrams
        for number in diagram.train_numbers
        if (train := timetable.trains.get(number)) is not None
        for call in train.due_calls
        if (number, call.station_id) not in there and call.first_s <= end_s
    ]
    return pl.DataFrame(rows, schema=stops.schema)


def planned_times(
    stops: pl.DataFrame, timetable: Timetable, end_s: float | None = None, *, revenue_only: bool = False
) -> pl.DataFrame:
    """Every planned arrival and departure: train, station, kind, what, planned_s, late_s and whether it came.

    `stops` is the table of a run; `end_s`: when that ends whatever happens, s; None: by the usual limit, or when the
    last time came. What was planned for later than that is not missing. `revenue_only`: of what never came, that of
    trains with passengers alone.
    """
    calls = pl.concat([stops, missing_calls(stops, timetable)])
    times = pl.concat(
        calls.filter(pl.col(f"planned_{what}_s").is_not_null()).select(
            "train",
            "station",
            "kind",
            pl.lit(what).alias("what"),
            pl.col(f"planned_{what}_s").alias("planned_s"),
            pl.col(f"late_{what}_s").alias("late_s"),
            (pl.col(f"late_{what}_s").is_not_null() & ~pl.col("cancelled")).alias("came"),
            (pl.col("revenue") | (not revenue_only)).alias("counts"),
        )
        for what in ("arrival", "departure")
    )
    never_due = {
        (number, call.station_id, what)
        for number, train in timetable.trains.items()
        for what, call, due_s in (
            ("arrival", train.calls[0], train.due_calls[0].arrival_s),
            ("departure", train.calls[-1], train.due_calls[-1].departure_s),
        )
        if due_s is None
    }
    asked = [key not in never_due for key in times.select("train", "station", "what").rows()]
    times = times.filter(pl.Series(asked, dtype=pl.Boolean))
    if end_s is None:
        latest_s = times.select((pl.col("planned_s") + pl.col("late_s")).max()).item()
        end_s = max(latest_end_s(timetable) if timetable.trains else 0.0, latest_s or 0.0)
    # what is cancelled has its stated lateness
    due = times.filter(pl.col("came") | (pl.col("counts") & (pl.col("planned_s") <= end_s)))
    return due.drop("counts").with_columns(pl.col("late_s").fill_null(end_s - pl.col("planned_s")))
