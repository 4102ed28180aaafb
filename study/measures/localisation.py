"""How well trains knew where they were: half-width of their bounds, error, when they did not know, fixes by source."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import polars as pl

from study.record.tables import RunTables

LOST: Final = "fault"  # kinds of the table of events that a unit itself writes
FOUND: Final = "position found"
FIX_KINDS: Final = ("fix", "fix refused", "fix missed", "foreign track")
HALF_M: Final = ((pl.col("bound_ahead_m") + pl.col("bound_behind_m")) / 2.0).alias("half_m")


def lost_between(events: pl.DataFrame, unit: str) -> list[tuple[float, float]]:
    """From when to when (s) a unit did not know its position, by its own word; infinite where it never found it."""
    own = events.filter(pl.col("source") == unit, pl.col("kind").is_in([LOST, FOUND])).sort("t_s")
    lost: list[tuple[float, float]] = []
    begun: float | None = None
    for t_s, kind in own.select("t_s", "kind").iter_rows():
        if kind == LOST and begun is None:
            begun = t_s
        elif kind == FOUND and begun is not None:
            lost.append((begun, t_s))
            begun = None
    return [*lost, (begun, np.inf)] if begun is not None else lost


def known_positions(tables: RunTables) -> pl.DataFrame:
    """The rows of the trajectory in which units knew their position, with the half-width of the bounds `half_m`."""
    rows = tables.trajectory.with_columns(HALF_M)
    unknown = pl.lit(value=False)
    for unit in tables.trajectory["unit"].unique().to_list():
        for from_s, to_s in lost_between(tables.events, unit):
            unknown |= (pl.col("unit") == unit) & (pl.col("t_s") >= from_s) & (pl.col("t_s") <= to_s)
    return rows.filter(~unknown)


def localisation_summary(tables: RunTables, fixes: Mapping[str, Mapping[str, int]]) -> dict[str, Any]:
    """Of the run and of each train `half_width_m` (median and 95 %) and `error_m_max`; by unit `lost_s` and fixes.

    Over the seconds in which trains moved and knew where they were. `fixes` are counts by unit and reader.
    """
    known = known_positions(tables)
    trains = {
        train: _figures(rows) for (train,), rows in known.group_by(["train"], maintain_order=True) if train
    }
    units = sorted(tables.trajectory["unit"].unique().to_list())
    end_s = float(tables.trajectory["t_s"].max() or 0.0)  # type: ignore[arg-type]
    return {
        **_figures(known),
        "lost_s": {
            unit: round(
                sum(min(to_s, end_s) - from_s for from_s, to_s in lost_between(tables.events, unit)), 1
            )
            for unit in units
        },
        "trains": trains,
        "fixes": {unit: {name: n for name, n in own.items() if n} for unit, own in fixes.items()},
    }


def _figures(rows: pl.DataFrame) -> dict[str, float | None]:
    if rows.is_empty():
        return {"half_width_m_median": None, "half_width_m_p95": None, "error_m_max": None}
    half_m, error_m = rows["half_m"].to_numpy(), np.abs(rows["estimate_error_m"].to_numpy())
    return {
        "half_width_m_median": round(float(np.median(half_m)), 3),
        "half_width_m_p95": round(float(np.percentile(half_m, 95.0)), 3),
        "error_m_max": round(float(error_m.max()), 3),
    }
