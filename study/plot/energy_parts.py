"""Where the energy of each leg went (区間別の電力量内訳)."""

from __future__ import annotations

from typing import Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from network.model import Direction
from study.plot.choice import ChosenRun
from study.record.energy import LegEnergy
from study.record.figure import figures_of
from study.report.style import AUXILIARY, INK, PALE, REGENERATED, RULE, TRACTION, WIDTH_IN, dots

_COLOURS: Final = {
    "resistance_kwh": TRACTION,
    "curve_kwh": "#86a9cf",
    "gradient_kwh": "#8c6d1f",
    "friction_kwh": "#b3261e",
    "traction_loss_kwh": "#a0568a",
    "regeneration_loss_kwh": REGENERATED,
    "auxiliary_kwh": AUXILIARY,
}


def draw_energy_parts(run: ChosenRun) -> Figure | None:
    """The parts of each leg's net energy, the mean of its trains, stacked; a panel a direction, the net as a dot."""
    panels: list[tuple[Direction, list[dict[str, float | str]]]] = []
    for direction, ends, own in run.legs_by_direction(run.chosen_rows(run.tables.energy_legs)):
        means = own.group_by("from_station", "to_station").agg(pl.col("net_kwh", *_COLOURS).mean())
        rows_of = {(row["from_station"], row["to_station"]): row for row in means.to_dicts()}
        panels.append((direction, [rows_of[leg] for leg in ends]))
    if not panels:
        return None
    figure = Figure(figsize=(WIDTH_IN, 3.6 * len(panels)), layout="constrained")
    rows = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
    for axes, (direction, stacks) in zip(rows, panels, strict=True):
        _draw_stack(axes, run, direction, stacks)
    rows[0].legend(loc="lower right", ncols=8, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    return figure


def _draw_stack(
    axes: Axes, run: ChosenRun, direction: Direction, means: list[dict[str, float | str]]
) -> None:
    at = np.arange(len(means))
    above, below = np.zeros(len(means)), np.zeros(len(means))
    for name, colour in _COLOURS.items():
        kwh = np.array([float(row[name]) for row in means])
        bottom = np.where(kwh >= 0.0, above, below)
        axes.bar(at, kwh, 0.7, bottom=bottom, color=colour, label=figures_of(LegEnergy)[name].name.en)
        above, below = above + np.maximum(kwh, 0.0), below + np.minimum(kwh, 0.0)
    net = [float(row["net_kwh"]) for row in means]
    dots(axes, at, net, "o", 4, INK, label="net")
    names = [f"{run.name(str(row['from_station']))}\n{run.name(str(row['to_station']))}" for row in means]
    many = len(means) > 12
    axes.set_xticks(at, names)
    axes.tick_params(axis="x", length=0, labelsize=6.5, labelrotation=60 if many else 0)
    axes.set_xlim(-0.7, max(len(means), 5) - 0.3)
    axes.axhline(0, color=PALE, lw=0.6)
    axes.set_title(direction.name.lower(), pad=4)
    axes.set_ylabel("per train, kWh")
    axes.margins(y=0.1)
    axes.grid(axis="y")
    axes.spines[:].set_color(RULE)
