"""Closed minutes of level crossings by hour (踏切の時間帯別遮断時間)."""

from __future__ import annotations

from typing import Final

import numpy as np
import polars as pl
from matplotlib.figure import Figure

from study.collect.energy_hours import HOUR_S
from study.plot.choice import ChosenRun
from study.report.style import INK, RULE, WIDTH_IN, centred

_DARKEST_MIN: Final = 10.0  # or the longest, where that is more
_CELL_PT: Final = 6.5
_DARK_SHARE: Final = 0.5  # of the darkest: from here on figures are white


def crossings_table(run: ChosenRun) -> pl.DataFrame:
    """The rows of the hours chosen."""
    from_s, to_s = run.window_s
    rows = run.tables.crossings
    if run.choice.from_s is None and run.choice.to_s is None:
        return rows
    begins_s = pl.col("hour") * HOUR_S
    return rows.filter((begins_s + HOUR_S > from_s) & (begins_s < to_s))


def draw_crossings(run: ChosenRun) -> Figure | None:
    """A row a crossing, along the line, and a column an hour: minutes closed, the darker the longer. None: no rows."""
    table = crossings_table(run)
    if table.is_empty():
        return None
    known = run.line.crossings
    names = sorted(set(table["crossing"]), key=lambda name: (known[name].position_m, name))
    hours = sorted(set(table["hour"]))
    columns = range(hours[0], hours[-1] + 1)
    closed_min = np.zeros((len(names), len(columns)))
    for crossing, hour, closed_s in table.select("crossing", "hour", "closed_s").iter_rows():
        closed_min[names.index(crossing), hour - columns[0]] = closed_s / 60.0
    figure = Figure(figsize=(WIDTH_IN, 0.9 + 0.22 * len(names)), layout="constrained")
    axes = figure.subplots()
    darkest_min = max(float(closed_min.max()), _DARKEST_MIN)
    axes.imshow(closed_min, cmap="Greys", vmin=0.0, vmax=darkest_min, aspect="auto")
    for (row, column), value in np.ndenumerate(closed_min):
        if value > 0.0:
            colour = INK if value < _DARK_SHARE * darkest_min else "white"
            centred(axes, column, row, f"{value:.1f}", _CELL_PT, color=colour)
    axes.set_yticks(range(len(names)), [known[name].name for name in names])
    axes.set_xticks(range(len(columns)), [str(hour) for hour in columns])
    axes.tick_params(length=0)
    axes.set_xlabel("hour")
    axes.spines[:].set_color(RULE)
    return figure
