"""Waits as the table `waits` of a run, and back: what a plot or a report reads is what was found."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, fields, replace

import polars as pl

from study.measures.wait import Asked, Cause, Wait
from study.run.tables import make_table


def waits_table(waits: Iterable[Wait]) -> pl.DataFrame:
    """The table `waits`, one row a wait, in their order."""
    rows = [asdict(wait) for wait in waits]
    return make_table("waits", {field.name: [row[field.name] for row in rows] for field in fields(Wait)})


def read_waits(table: pl.DataFrame) -> tuple[Wait, ...]:
    """The waits of that table, in its order."""
    return tuple(
        replace(Wait(**row), cause=Cause(row["cause"]), asked=Asked(row["asked"]))
        for row in table.select(field.name for field in fields(Wait)).iter_rows(named=True)
    )


def wait_at(waits: Iterable[Wait], unit: str, t_s: float) -> Wait | None:
    """What a stock waits for at a moment, s; None before the run begins and from its end on."""
    return next((w for w in waits if w.unit == unit and w.from_s <= t_s < w.to_s), None)
