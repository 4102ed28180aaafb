"""Driving as the table `driving` of a run, and back: what a report, a comparison or an experiment reads is one table."""

from __future__ import annotations

from dataclasses import asdict, fields
from typing import Any

import polars as pl

from onboard.driving.laws.table import LAW_NAMES
from simulation.result import RunResult
from simulation.setup import Setup
from study.measures.driving import DrivenHop, Stock, driven, driven_hops
from study.run.tables import make_table


def driving_table(
    result: RunResult, setup: Setup, margins: pl.DataFrame, stops: pl.DataFrame
) -> pl.DataFrame:
    """The table `driving`, one row a hop, from the run and its tables of margins and stops."""
    stocks = {
        stock_id: Stock(setup.laws.get(stock_id, LAW_NAMES[0]), kind.regenerated_to)
        for stock_id, kind in setup.trains.items()
    }
    left = margins.select("train", "from_station", "to_station", "left_s").iter_rows()
    late_s = {(train, a, b): None if left_s is None else -left_s for train, a, b, left_s in left}
    errors = stops.select("train", "station", "stop_error_m").iter_rows()
    error_m = {(train, station): error for train, station, error in errors}
    hops = [asdict(hop) for hop in driven_hops(result.energy, stocks, late_s, error_m)]
    return make_table("driving", {f.name: [hop[f.name] for hop in hops] for f in fields(DrivenHop)})


def read_hops(table: pl.DataFrame) -> tuple[DrivenHop, ...]:
    """The hops of that table, in its order."""
    return tuple(DrivenHop(**row) for row in table.iter_rows(named=True))


def driving_summary(table: pl.DataFrame) -> dict[str, Any] | None:
    """For summary.json: all hops together, and by law where there are several; None of a run without any hop."""
    hops = read_hops(table)
    whole = driven(hops)
    if whole is None:
        return None
    laws = sorted({hop.law for hop in hops})
    by_law = {law: driven([hop for hop in hops if hop.law == law]) for law in laws}
    told = {law: asdict(part) for law, part in by_law.items() if part is not None}
    return {**asdict(whole), "by_law": told}
