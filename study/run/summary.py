"""The figures of a run that fit on one screen, computed from its tables."""

from __future__ import annotations

from typing import Any, Final, cast

import polars as pl

from network.timetable import Timetable
from study.run.tables import RunTables

TELEGRAM_COUNTS: Final = ("sent", "delivered", "lost", "dropped")


def summarise(tables: RunTables, timetable: Timetable) -> dict[str, Any]:
    """Figures of a run for `summary.json`; None where there is nothing to compute one from.

    - trains_planned, trains_arrived: revenue trains of the timetable, and those at their last call.
    - late_s_max: most seconds after plan of any arrival or departure, 0 when none was late.
    - early_departure_s_max: most seconds any train left before plan, 0 when none did.
    - stops and stop_error_m_mean, _sigma (of the sample, n - 1), _max_abs: over stops with a known error.
    - energy_kwh {traction, regenerated, auxiliary}; telegrams {sent, delivered, lost, dropped}.
    """
    stops = tables.stops
    error_m = stops["stop_error_m"].drop_nulls()
    energy, telegrams = tables.energy, tables.telegrams
    return {
        "trains_planned": sum(train.revenue for train in timetable.trains.values()),
        "trains_arrived": len(arrived_trains(stops, timetable)),
        "late_s_max": _most_s(
            stops["arrival_s"] - stops["planned_arrival_s"],
            stops["departure_s"] - stops["planned_departure_s"],
        ),
        "early_departure_s_max": _most_s(stops["planned_departure_s"] - stops["departure_s"]),
        "stops": len(error_m),
        "stop_error_m_mean": _number(error_m.mean()),
        "stop_error_m_sigma": _number(error_m.std()) if len(error_m) > 1 else None,
        "stop_error_m_max_abs": _number(error_m.abs().max()),
        "energy_kwh": {
            name: float(energy[f"{name}_kwh"].sum()) for name in ("traction", "regenerated", "auxiliary")
        },
        "telegrams": {name: int(telegrams[name].sum()) for name in TELEGRAM_COUNTS},
    }


def arrived_trains(stops: pl.DataFrame, timetable: Timetable) -> set[str]:
    """Numbers of the revenue trains that arrived at their last planned call."""
    last_calls = {
        (number, train.calls[-1].station_id) for number, train in timetable.trains.items() if train.revenue
    }
    reached = stops.filter(pl.col("arrival_s").is_not_null()).select("train", "station").iter_rows()
    return {number for number, station in reached if (number, station) in last_calls}


def _most_s(*differences: pl.Series) -> float:
    """Greatest of several differences in s, at least 0; a stop without plan or fact does not count."""
    values = (_number(difference.max()) for difference in differences)
    return max([0.0, *(value for value in values if value is not None)])


def _number(value: object) -> float | None:
    return None if value is None else float(cast(float, value))
