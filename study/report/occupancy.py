"""Section occupancy by time: what the register held for each unit, and what each train truly occupied."""

from __future__ import annotations

from typing import Final

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from study.report.data import ReportedRun, sections_in_order
from study.report.pictures import OCCUPANCY
from study.report.style import RULE, WIDTH_IN, draw_clock_axis, time_bands, unit_colours

_ROW_IN: Final = 0.17


def draw_occupancy(run: ReportedRun) -> Figure:
    """A row a section, in the panels of the train graph: held (保有) pale, truly occupied solid."""
    bands, grid = time_bands(*run.window_s)
    rows = {section.id: row for row, section in enumerate(sections_in_order(run))}
    colours = unit_colours(list(run.units))
    height_in = len(bands) * (_ROW_IN * len(rows) + 0.5) + 0.4
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    for axes, band in zip(figure.subplots(len(bands), 1, squeeze=False)[:, 0], bands, strict=True):
        draw_clock_axis(axes, band, grid)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_yticks(list(rows.values()), list(rows), fontsize=6.5)
        axes.tick_params(axis="y", length=0)
        for row in rows.values():
            axes.axhline(row + 0.5, color=RULE, lw=0.4, zorder=0.4)
        for unit, colour in colours.items():
            _draw_unit(axes, run, unit, colour, rows)
        axes.spines[:].set_color(RULE)
    legend = [Patch(color=colour, lw=0, label=unit) for unit, colour in colours.items()]
    legend += [Patch(**layer.face()) for layer in OCCUPANCY.layers.values()]
    figure.legend(handles=legend, loc="outside upper right", ncols=12, handlelength=1.2)
    return figure


def _draw_unit(axes: Axes, run: ReportedRun, unit: str, colour: str, rows: dict[str, int]) -> None:
    """Bars of one unit that fall in the panel; what is not freed lasts to the end of the run."""
    from_s, to_s = axes.get_xlim()
    ours = run.tables.blocks.filter(pl.col("unit") == unit, pl.col("section").is_in(list(rows)))
    for begin, end, height, alpha in (
        ("granted_s", "released_s", 0.8, OCCUPANCY.layers["held"].opacity),
        ("entered_s", "cleared_s", 0.5, OCCUPANCY.layers["occupied"].opacity),
    ):
        bars = ours.filter(pl.col(begin).is_not_null()).select(
            pl.col("section"),
            pl.col(begin).clip(from_s, to_s).alias("begin_s"),
            pl.col(end).fill_null(run.window_s[1]).clip(from_s, to_s).alias("end_s"),
        )
        bars = bars.filter(pl.col("end_s") > pl.col("begin_s"))
        axes.barh(
            [rows[section] for section in bars["section"]],
            (bars["end_s"] - bars["begin_s"]).to_numpy(),
            left=bars["begin_s"].to_numpy(),
            height=height,
            color=colour,
            alpha=alpha,
            lw=0,
            zorder=2 + alpha,
        )
