"""How each hop of each train was driven: running energy, notches, jerk, coasting, and how it came to its stop.

A hop is a leg of the energy's records: from a place where the train stops to the next. What the kernel counted in every
step (`simulation.ride`) is cut with the energy, so both are of the same run.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Any

import polars as pl

from network.units import J_PER_KWH
from onboard.driving.laws.table import LAW_NAMES
from simulation.result import EnergyPhase, EnergyRecord, RunResult
from simulation.ride import BRAKES, COASTS, CRUISES, Ride
from simulation.ride import joined_rides as rides_together
from simulation.setup import Setup
from study.record.driving import DrivenHop
from study.record.figure import rows_in, summed_figures
from study.record.tables import make_table
from vehicle.train_file import RegenerationReceiver

Ends = tuple[str, str, str]  # train, from, to


@dataclass(frozen=True, slots=True)
class Stock:
    """What the table says of a stock: the law that drives it, and who takes what it gives back."""

    law: str
    regenerated_to: RegenerationReceiver


def driven_hops(
    records: Iterable[EnergyRecord],
    stocks: Mapping[str, Stock],
    late_s: Mapping[Ends, float | None],
    stop_error_m: Mapping[tuple[str, str], float | None],
) -> tuple[DrivenHop, ...]:
    """Every hop that a train moved on, in the order in which they ended."""
    runs: dict[tuple[str, Ends], list[EnergyRecord]] = {}
    for record in records:
        if record.phase is EnergyPhase.RUNNING:
            ends = (record.number, record.from_id, record.to_id)
            runs.setdefault((record.stock_id, ends), []).append(record)
    return tuple(
        _hop(run, stocks[stock_id], late_s.get(ends), stop_error_m.get((ends[0], ends[2])))
        for (stock_id, ends), run in runs.items()
    )


def _hop(
    run: Sequence[EnergyRecord], stock: Stock, late_s: float | None, stop_error_m: float | None
) -> DrivenHop:
    first, ride = run[0], rides_together(record.ride for record in run)
    traction_kwh, regenerated_kwh = (
        sum(record.counted_j[name] for record in run) / J_PER_KWH for name in ("traction", "regenerated")
    )
    back_kwh = 0.0 if stock.regenerated_to is RegenerationReceiver.RESISTORS else regenerated_kwh
    return DrivenHop(
        first.stock_id,
        first.number,
        first.revenue,
        stock.law,
        first.from_id,
        first.to_id,
        first.begin_s,
        sum(record.end_s - record.begin_s for record in run),
        sum(record.distance_m for record in run),
        traction_kwh,
        regenerated_kwh,
        traction_kwh - back_kwh,
        ride.power_changes,
        ride.brake_changes,
        ride.jerk_max_mps3,
        ride.jerk_rms_mps3,
        ride.jolt_mps2,
        **_shares(ride),
        late_s=late_s,
        stop_error_m=stop_error_m,
    )


def _shares(ride: Ride) -> dict[str, float]:
    """Coasting, cruising and braking, each of the time and of the way, percent: the fields of a hop by name."""
    return {
        f"{name}_{of}_percent": 100.0 * part[manner] / whole if whole > 0.0 else 0.0
        for name, manner in (("coasting", COASTS), ("cruising", CRUISES), ("braking", BRAKES))
        for of, part, whole in (("time", ride.time_s, ride.moving_s), ("way", ride.way_m, ride.moved_m))
    }


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
    errors = stops.filter(~pl.col("cancelled")).select("train", "station", "stop_error_m").iter_rows()
    error_m = {(train, station): error for train, station, error in errors}
    return make_table("driving", driven_hops(result.energy, stocks, late_s, error_m))


def driving_sums(hops: Sequence[DrivenHop], left_s: Iterable[float | None] = ()) -> dict[str, Any] | None:
    """Hops together, by figure, with their number, how many were late, and mean earliness; None of none.

    `left_s`: what was left on arrival of each hop that was planned, s: those too on which no train ran.
    """
    if not hops:
        return None
    early_s = [time_s for time_s in left_s if time_s is not None]
    return {
        "hops": len(hops),
        **summed_figures(hops),
        "early_s": fmean(early_s) if early_s else None,
        "late_hops": sum(time_s < 0.0 for time_s in early_s),
    }


def driving_summary(table: pl.DataFrame, margins: pl.DataFrame) -> dict[str, Any] | None:
    """For summary.json: all hops together, and by law where there are several; None of a run without any hop."""
    hops = rows_in(DrivenHop, table)
    whole = driving_sums(hops, margins["left_s"])
    if whole is None:
        return None
    by_law = {
        law: driving_sums(
            [hop for hop in hops if hop.law == law], margins_by_law(margins, table, law)["left_s"]
        )
        for law in sorted({hop.law for hop in hops})
    }
    return {**whole, "by_law": by_law}


def margins_by_law(margins: pl.DataFrame, table: pl.DataFrame, law: str) -> pl.DataFrame:
    """The margins of units that no other law drives: of one that never ran no table says which would have."""
    others = table.filter(pl.col("law") != law)["unit"].unique()
    return margins.filter(~pl.col("unit").is_in(others.implode()))
