"""The road of a run as its table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import polars as pl

from simulation.carriers.road_totals import HOUR_S, RoadTotal
from study.record.road import RoadHour
from study.record.tables import make_table


def road_table(
    totals: Mapping[tuple[str, int], RoadTotal], quiet: Iterable[tuple[str, int]] = ()
) -> pl.DataFrame:
    """The table road, by crossing and hour, those too that may be quiet; empty where no road was carried."""
    every = {**dict.fromkeys(quiet, RoadTotal()), **totals} if totals else {}
    rows = [
        RoadHour(crossing, hour, it.passages, it.waited_s / HOUR_S, it.waited_s_max, it.queue)
        for (crossing, hour), it in sorted(every.items())
    ]
    return make_table("road", rows)
