"""The picture of margins (余裕時分): what the plan leaves over the least running time, and what was left as run."""

from __future__ import annotations

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from network.model import Direction
from study.plot.choice import ChosenRun
from study.plot.energy import draw_by_direction
from study.report.style import DIRECTION_COLOUR, PALE, RED, RULE, dots


def draw_margins(run: ChosenRun) -> Figure | None:
    """A panel a direction, a column a hop: the margin of every train as planned, and what was left on its arrival."""
    return draw_by_direction(run, run.tables.margins, 3.2, _draw_hops, 0.2)


def _draw_hops(
    axes: Axes, run: ChosenRun, direction: Direction, hops: list[tuple[str, str]], table: pl.DataFrame
) -> None:
    for column, (from_id, to_id) in enumerate(hops):
        hop = table.filter(pl.col("from_station") == from_id, pl.col("to_station") == to_id)
        for name, aside, colour, label in (
            ("margin_s", -0.18, DIRECTION_COLOUR[direction], "planned"),
            ("left_s", 0.18, PALE, "left on arrival, as run"),
        ):
            values_s = hop[name].drop_nulls().sort().to_numpy()
            if not len(values_s):
                continue
            x = (
                column
                + aside
                + (np.linspace(-0.12, 0.12, len(values_s)) if len(values_s) > 1 else np.zeros(1))
            )
            bad = values_s < 0.0
            shown = "_" if label in axes.get_legend_handles_labels()[1] else label
            dots(axes, x[~bad], values_s[~bad], "o", 2.6, colour, mew=0, label=shown)
            dots(axes, x[bad], values_s[bad], "o", 3.2, RED, mew=0)
    axes.axhline(0, color=PALE, lw=0.7)
    axes.set_xticks(range(len(hops)), [f"{run.name(a)}\n{run.name(b)}" for a, b in hops])
    axes.tick_params(axis="x", length=0, labelsize=6.5, labelrotation=60 if len(hops) > 12 else 0)
    axes.set_xlim(-0.6, max(len(hops), 5) - 0.4)
    axes.set_title(direction.name.lower(), pad=4)
    axes.set_ylabel("margin, s")
    axes.grid(axis="y")
    axes.spines[:].set_color(RULE)
    axes.legend(loc="lower right", ncols=2, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
