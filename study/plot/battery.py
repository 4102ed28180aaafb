"""State of charge over the day (充電状態), a panel a set: charges shaded, what is kept back, and the lowest point."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MultipleLocator

from study.plot.choice import ChosenRun
from study.report.style import (
    DIRECTION_COLOUR,
    INK,
    PALE,
    RED,
    RULE,
    UNIT_COLOURS,
    WIDTH_IN,
    beside,
    clock,
    dots,
)

PANEL_IN: Final = 1.75
HOUR_S: Final = 3600.0
CHARGED: Final = "#cfe3cf"
OFF_LINE: Final = "#f1f1f1"
NUMBER_PT: Final = 6.0
LABEL_PERCENT: Final = 4.0
RAISED_PERCENT: Final = 32.0  # above the red lines
LABEL_S: Final = 2400.0  # names nearer than this touch
NARROW_S: Final = 720.0  # a name above a charge has no room in less


def battery_table(run: ChosenRun) -> pl.DataFrame:
    """The batteries at every moment written down, of the time chosen."""
    return run.rows_in_window(run.tables.battery, "t_s")


def draw_battery(run: ChosenRun) -> Figure | None:
    """A panel a set: percent of charge over the time of the day. None: no set ran on a battery."""
    table, rows = battery_table(run), run.tables.battery
    if table.is_empty():
        return None
    units = sorted(rows["unit"].unique())
    whole_s = float(rows["t_s"].min()), float(rows["t_s"].max())  # type: ignore[arg-type]
    from_s, to_s = whole_s if run.choice.from_s is None and run.choice.to_s is None else run.window_s
    figure = Figure(figsize=(WIDTH_IN, PANEL_IN * len(units) + 0.8), layout="constrained")
    panels = figure.subplots(len(units), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    bottom: Axes = panels[-1]
    bottom.set_xlim(from_s, max(to_s, from_s + 60.0))
    for i, (axes, unit) in enumerate(zip(panels, units, strict=True)):
        _panel(axes, run, unit, rows.filter(pl.col("unit") == unit), UNIT_COLOURS[i % len(UNIT_COLOURS)])
    bottom.xaxis.set_major_locator(MultipleLocator(HOUR_S if to_s - from_s > 2 * HOUR_S else HOUR_S / 6))
    bottom.xaxis.set_major_formatter(FuncFormatter(_clock))
    bottom.set_xlabel("time")
    figure.legend(
        handles=[
            Line2D([], [], color=INK, lw=1.4, label="state of charge"),
            Line2D([], [], color=RED, lw=0.9, ls=(0, (5, 3)), label="reserve to be kept"),
            Line2D([], [], color=RED, lw=0.9, label="nothing to use below"),
            Patch(color=CHARGED, lw=0, label="charges"),
            Patch(color=OFF_LINE, lw=0, label="off the line"),
        ],
        loc="outside lower left",
        ncols=5,
    )
    return figure


def _clock(time_s: float, _place: int | None) -> str:
    return clock(time_s)


def _panel(axes: Axes, run: ChosenRun, unit: str, rows: pl.DataFrame, colour: str) -> None:
    times_s, soc = rows["t_s"].to_numpy(), 100.0 * rows["soc"].to_numpy()
    for low_s, high_s in _off_line(rows):
        axes.axvspan(low_s, high_s, color=OFF_LINE, lw=0, zorder=0.2)
    _charges(axes, run, unit)
    low, kept = 100.0 * float(rows["soc_low"][0]), 100.0 * float(rows["soc_kept"][0])
    axes.axhline(low, color=RED, lw=0.9)
    axes.axhline(kept, color=RED, lw=0.9, ls=(0, (5, 3)))
    axes.plot(times_s, soc, color=colour, lw=1.4)
    _numbers(axes, run, unit)
    axes.set_ylim(0, 112)
    axes.set_yticks([0, 20, 40, 60, 80, 100])
    axes.set_ylabel(f"{unit}\ncharge, %")
    axes.grid(axis="both")
    axes.tick_params(length=0)
    axes.spines[:].set_color(RULE)
    from_s, to_s = axes.get_xlim()
    shown = (times_s >= from_s) & (times_s <= to_s)
    if not shown.any():
        return
    at = int(np.argmin(np.where(shown, soc, np.inf)))
    lowest = rows.row(at, named=True)
    dots(axes, times_s[at], soc[at], "v", 5, colour)
    # Towards the middle of the panel, so that it stays inside.
    right = times_s[at] > 0.5 * (from_s + to_s)
    beside(
        axes,
        f"{lowest['train']}: {soc[at]:.0f} %, {lowest['above_low_kwh']:.0f} kWh left to use",
        (times_s[at], soc[at]),
        (-6 if right else 6, -1),
        7,
        bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.6},
    )


def _off_line(rows: pl.DataFrame) -> list[tuple[float, float]]:
    """When the set was off the line, between leaving and coming back."""
    events = rows.filter(pl.col("event").is_in(["leaves", "enters"])).select("t_s", "event").rows()
    return [
        (left_s, came_s)
        for (left_s, left), (came_s, came) in pairwise(events)
        if left == "leaves" and came == "enters"
    ]


def _charges(axes: Axes, run: ChosenRun, unit: str) -> None:
    """Each charge, with its station where there is room: higher up, where it would touch the one before."""
    last_s, at_percent = -np.inf, LABEL_PERCENT
    for charge in run.tables.charges.filter(pl.col("unit") == unit).iter_rows(named=True):
        axes.axvspan(charge["from_s"], charge["to_s"], color=CHARGED, lw=0, zorder=0.3)
        if charge["to_s"] - charge["from_s"] < NARROW_S:
            continue
        middle_s = 0.5 * (charge["from_s"] + charge["to_s"])
        place = run.name(charge["station"]) if charge["station"] else "off the line"
        gained = round(charge["gained_kwh"])
        text = f"{place}\n{gained:+d} kWh".replace("-", "−") if gained else place
        touches = middle_s - last_s < LABEL_S and at_percent == LABEL_PERCENT
        last_s, at_percent = middle_s, RAISED_PERCENT if touches else LABEL_PERCENT
        axes.annotate(text, (middle_s, at_percent), ha="center", va="bottom", fontsize=NUMBER_PT, color=PALE)


def _numbers(axes: Axes, run: ChosenRun, unit: str) -> None:
    """Train numbers above the time in which the set was that train."""
    for (of, train), course in run.courses.items():
        if of != unit:
            continue
        middle_s = 0.5 * (float(course["t_s"][0]) + float(course["t_s"][-1]))
        axes.annotate(
            train,
            (middle_s, 105),
            ha="center",
            va="center",
            fontsize=NUMBER_PT,
            color=DIRECTION_COLOUR[run.directions[train]],
        )
