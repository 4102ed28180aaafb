"""Energy by hour of the day (時間帯別電力量): what the simulation booked, cut at whole hours."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from simulation.result import DRAWN, EnergyPhase, EnergyRecord
from study.collect.energy import StockMake
from study.collect.energy_parts import drawn_kwh
from study.record.energy import HourOfEnergy
from study.record.tables import make_table

HOUR_S: Final = 3600.0
Joules = NDArray[np.float64]


def energy_hours_of(records: Iterable[EnergyRecord], fleet: Mapping[str, StockMake]) -> pl.DataFrame:
    """The table `energy_hours`: one row an hour, stock and phase that took or gave anything.

    A record that reaches over a whole hour is shared out by time: it is a run between two stops, or a stand, so what is
    put into the wrong hour is at most a part of one leg. The sum over all hours is that of the records.
    """
    sums: dict[tuple[float, str, EnergyPhase], Joules] = defaultdict(lambda: np.zeros(len(DRAWN)))
    for record in records:
        joules = np.array([record.counted_j[name] for name in DRAWN])
        for hour_s, share in shares(record.begin_s, record.end_s):
            sums[hour_s, record.stock_id, record.phase] += share * joules
    return make_table(
        "energy_hours",
        [
            HourOfEnergy(
                hour_s=hour_s,
                unit=unit,
                phase=phase,
                **drawn_kwh(
                    dict(zip(DRAWN, sums[hour_s, unit, phase].tolist(), strict=True)),
                    fleet[unit].regenerated_to,
                ),
            )
            for hour_s, unit, phase in sorted(key for key, joules in sums.items() if joules.any())
        ],
    )


def shares(begin_s: float, end_s: float) -> tuple[tuple[float, float], ...]:
    """(beginning of the hour, share of the time in it) of each hour that a stretch of time meets; they sum to 1."""
    first_s = begin_s // HOUR_S * HOUR_S
    if end_s <= begin_s:
        return ((first_s, 1.0),)
    hours_s = np.arange(first_s, end_s, HOUR_S)
    inside_s = np.minimum(hours_s + HOUR_S, end_s) - np.maximum(hours_s, begin_s)
    return tuple(zip(hours_s.tolist(), (inside_s / (end_s - begin_s)).tolist(), strict=True))
