"""The figures of a run that fit on one screen, computed from its tables."""

from __future__ import annotations

import math
from typing import Any, Final, cast

import polars as pl

from network.timetable import CallKind, Timetable
from simulation.result import DRAWN, numbers_due
from simulation.tolerance import OFF_MARK_M
from study.measures.driving import driving_summary
from study.measures.missing import planned_times
from study.record.energy import PARTS
from study.record.figure import ShownIn, seen_in
from study.record.journal_rows import TelegramsOfWay
from study.record.tables import RunTables

NEVER_CAME: Final = "missing arrival"
TELEGRAM_COUNTS: Final = tuple(seen_in(TelegramsOfWay, ShownIn.TOTALS_COMPARED))
NAMED: Final = ("train", "from_station", "to_station", "planned_s", "least_s", "margin_s", "margin_percent")


def summarise(tables: RunTables, timetable: Timetable, end_s: float | None = None) -> dict[str, Any]:
    """Figures of a run for `summary.json`; None where there is nothing to compute one from.

    - trains_planned, trains_arrived: revenue trains of the timetable that should have ended by `end_s` (s; None: all),
      and those of them at their last call.
    - trains_cancelled, trains_shortened: those of them that the dispatcher left out whole, or in part.
    - late_s_max: most seconds after plan of any arrival or departure, 0 when none was late; late_at is where. What
      never came of a train with passengers is as late as `study.measures.missing` has it; None when trains were planned
      and none arrived.
    - late_passing_s_max: seconds after plan of the latest passing, negative when all were early; late_passing_at is
      where. None when no train passed anything at a time planned.
    - early_departure_s_max: most seconds any train left before plan, 0 when none did; early_at is where. None when
      none left.
    - stops and stop_error_m_mean, _sigma (of the sample, n - 1), _max_abs: over stops with a known error.
    - stops_off: how many of them were more than OFF_MARK_M off; stop_off_at the worst of these {train, station,
      error_m}, None where there is none.
    - energy_kwh {traction, regenerated, auxiliary} of trains and layovers; energy: `energy_summary`.
    - margins: `smallest`; driving: `study.measures.driving.driving_summary`.
    - comparisons: rows of that table.
    - telegrams {sent, delivered, lost, dropped}.
    """
    stops = tables.stops
    error_m = stops["stop_error_m"].drop_nulls()
    telegrams = tables.telegrams
    trains = trains_counted(stops, timetable, end_s)
    late, early, passed = worst_late(stops, timetable, end_s), worst_early(stops), worst_passing(stops)
    none_left = stops["departure_s"].is_null().all()
    none_came = trains["trains_planned"] > 0 and trains["trains_arrived"] == 0
    return {
        **trains,
        "late_s_max": None if none_came else 0.0 if late is None else late["late_s"],
        "late_at": None if none_came else late,
        "late_passing_s_max": None if passed is None else passed["late_s"],
        "late_passing_at": passed,
        "early_departure_s_max": None if none_left else 0.0 if early is None else -early["late_s"],
        "early_at": early,
        "stops": len(error_m),
        "stop_error_m_mean": _number(error_m.mean()),
        "stop_error_m_sigma": _number(error_m.std()) if len(error_m) > 1 else None,
        "stop_error_m_max_abs": _number(error_m.abs().max()),
        "stops_off": int((error_m.abs() > OFF_MARK_M).sum()),
        "stop_off_at": worst_off(stops),
        "energy_kwh": {
            name: float(tables.energy[f"{name}_kwh"].sum()) + float(tables.layovers[f"{name}_kwh"].sum())
            for name in DRAWN
        },
        "energy": energy_summary(tables),
        "margins": smallest(tables.margins),
        "driving": driving_summary(tables.driving, tables.margins),
        "comparisons": tables.comparisons.to_dicts(),
        "telegrams": {name: int(telegrams[name].sum()) for name in TELEGRAM_COUNTS},
    }


def energy_summary(tables: RunTables) -> dict[str, Any]:
    """The day's energy, kWh: of trains running, of trains standing, of layovers and of all, and per km.

    `regenerated_to` says which receiver took how much; per km are trains alone (`trains`) and with layovers (`all`).
    `parts` says where the net energy of all went beside the auxiliaries; `rejected` of it is in friction or losses, and
    what they leave open is the residual.
    """
    energy, layovers = tables.energy, tables.layovers
    standing = float(energy["standing_kwh"].sum())
    trains = {name: float(energy[f"{name}_kwh"].sum()) for name in (*DRAWN, "net")}
    stays = {name: float(layovers[f"{name}_kwh"].sum()) for name in (*DRAWN, "net")}
    train_km = float(energy["distance_km"].sum())
    car_km = float((energy["distance_km"] * energy["cars"]).sum())
    whole = trains["net"] + stays["net"]
    returned = energy.group_by("regenerated_to").agg(pl.col("regenerated_kwh").sum()).sort("regenerated_to")
    return {
        "regenerated_to": dict(returned.iter_rows()),
        "running": {**trains, "auxiliary": trains["auxiliary"] - standing, "net": trains["net"] - standing},
        "standing": {"traction": 0.0, "regenerated": 0.0, "auxiliary": standing, "net": standing},
        "layovers": stays,
        "parts": {
            name.removesuffix("_kwh"): float(energy[name].sum()) + float(layovers[name].sum())
            for name in PARTS
        },
        "all": {name: trains[name] + stays[name] for name in trains},
        "train_km": train_km,
        "car_km": car_km,
        "net_kwh_per_train_km": _per({"trains": trains["net"], "all": whole}, train_km),
        "net_kwh_per_car_km": _per({"trains": trains["net"], "all": whole}, car_km),
    }


def _per(kwh: dict[str, float], km: float) -> dict[str, float | None]:
    return {name: value / km if km > 0.0 else None for name, value in kwh.items()}


def worst_off(stops: pl.DataFrame) -> dict[str, Any] | None:
    """The stop that was farthest off its mark {train, station, error_m}. None: none was more than OFF_MARK_M off."""
    off = stops.filter(pl.col("stop_error_m").abs() > OFF_MARK_M)
    worst = off.sort(pl.col("stop_error_m").abs(), descending=True, maintain_order=True).head(1)
    found = worst.select("train", "station", error_m="stop_error_m").to_dicts()
    return found[0] if found else None


def trains_counted(stops: pl.DataFrame, timetable: Timetable, end_s: float | None) -> dict[str, int]:
    """The first four figures of `summarise`."""
    due = set(numbers_due(timetable, math.inf if end_s is None else end_s)[0])
    cancelled, shortened = cut_trains(stops)
    return {
        "trains_planned": len(due),
        "trains_arrived": len(due & arrived_trains(stops, timetable)),
        "trains_cancelled": len(due & cancelled),
        "trains_shortened": len(due & shortened),
    }


def arrived_trains(stops: pl.DataFrame, timetable: Timetable) -> set[str]:
    """Numbers of the revenue trains that came to their last planned call: a train that calls but once departs there."""
    last_calls = {
        (number, train.calls[-1].station_id) for number, train in timetable.trains.items() if train.revenue
    }
    came = pl.any_horizontal(pl.col("arrival_s", "departure_s").is_not_null())
    reached = stops.filter(came).select("train", "station").iter_rows()
    return {number for number, station in reached if (number, station) in last_calls}


def cut_trains(stops: pl.DataFrame) -> tuple[set[str], set[str]]:
    """Numbers of the trains that the dispatcher left out whole, and of those of which some calls came."""
    cut = set(stops.filter("cancelled")["train"])
    ran = set(stops.filter(~pl.col("cancelled"))["train"])
    return cut - ran, cut & ran


def worst_late(
    stops: pl.DataFrame, timetable: Timetable, end_s: float | None = None
) -> dict[str, Any] | None:
    """The latest arrival or departure of all, if after plan: train, station, what it was, late_s. None: none was."""
    times = planned_times(stops, timetable, end_s, revenue_only=True)
    arrival = pl.col("what") == "arrival"
    never = times.filter(~pl.col("came") & arrival).with_columns(pl.lit(NEVER_CAME).alias("what"))
    late = pl.concat([_lateness(stops), never.select("train", "station", "what", "late_s")])
    late = late.filter(pl.col("late_s") > 0.0).sort("late_s", descending=True, maintain_order=True)
    return None if late.is_empty() else late.row(0, named=True)


def worst_passing(stops: pl.DataFrame) -> dict[str, Any] | None:
    """The latest passing by the plan: train, station, late_s. None: no train passed at a time planned."""
    came = pl.col("late_departure_s").is_not_null()
    late = (
        stops.filter(came, pl.col("kind") == CallKind.PASS.value, ~pl.col("cancelled"))
        .select("train", "station", pl.col("late_departure_s").alias("late_s"))
        .sort("late_s", descending=True, maintain_order=True)
    )
    return None if late.is_empty() else late.row(0, named=True)


def worst_early(stops: pl.DataFrame) -> dict[str, Any] | None:
    """The earliest departure of all, if before plan, as `worst_late` has it. None: none was."""
    left = pl.col("what") == "departure"
    early = _lateness(stops).filter(left, pl.col("late_s") < 0.0).sort("late_s", maintain_order=True)
    return None if early.is_empty() else early.row(0, named=True)


def _lateness(stops: pl.DataFrame) -> pl.DataFrame:
    """Every arrival and departure that had a plan and came; what the table of delays shows. Passings are neither."""
    calls = stops.filter(pl.col("kind") != CallKind.PASS.value, ~pl.col("cancelled"))
    parts = [
        calls.select("train", "station", pl.lit(what).alias("what"), pl.col(f"late_{what}_s").alias("late_s"))
        for what in ("arrival", "departure")
    ]
    return pl.concat(parts).filter(pl.col("late_s").is_not_null())


def _number(value: object) -> float | None:
    return None if value is None else float(cast(float, value))


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
