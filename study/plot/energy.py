"""Energy by leg and by hour (区間別・時間帯別電力量)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from network.model import Direction
from simulation.result import EnergyPhase
from study.collect.energy_hours import HOUR_S
from study.plot.choice import ChosenRun
from study.report.charts import stack_energy
from study.report.pictures import ENERGY
from study.report.style import (
    DIRECTION_COLOUR,
    INK,
    PALE,
    RULE,
    WIDTH_IN,
    dots,
)

_STANDS: Final = (
    EnergyPhase.AT_STOP.value,
    EnergyPhase.HELD.value,
    EnergyPhase.LAYOVER.value,
    EnergyPhase.STABLED.value,
)


def energy_hours_table(run: ChosenRun) -> pl.DataFrame:
    """Energy by hour, stock and phase, of the hours chosen."""
    from_s, to_s = run.window_s
    hours = run.tables.energy_hours
    if run.choice.from_s is None and run.choice.to_s is None:
        return hours
    return hours.filter((pl.col("hour_s") + HOUR_S > from_s) & (pl.col("hour_s") < to_s))


def draw_energy_hours(run: ChosenRun) -> Figure | None:
    """A column an hour: traction, and auxiliaries running and standing, up; regenerated down; net as a dot."""
    table = energy_hours_table(run)
    if table.is_empty():
        return None
    hours_s = np.arange(float(table["hour_s"].min()), float(table["hour_s"].max()) + 1.0, HOUR_S)  # type: ignore[arg-type]

    def by_hour(column: str, rows: pl.DataFrame) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        sums = dict(rows.group_by("hour_s").agg(pl.col(column).sum()).iter_rows())
        return np.array([float(sums.get(hour_s, 0.0)) for hour_s in hours_s])

    stands = pl.col("phase").is_in(_STANDS)
    traction, regenerated = by_hour("traction_kwh", table), by_hour("regenerated_kwh", table)
    moving, standing = (by_hour("auxiliary_kwh", table.filter(which)) for which in (~stands, stands))
    net = by_hour("net_kwh", table)
    figure = Figure(figsize=(WIDTH_IN, 3.8), layout="constrained")
    axes = figure.subplots()
    at = np.arange(len(hours_s))
    stack_energy(axes, at, 0.72, (traction, moving, standing, regenerated))
    dots(axes, at, net, "o", 4, INK, label="net")
    for x, value in zip(at, net, strict=True):
        axes.annotate(
            f"{value:.0f}".replace("-", "−"),
            (x, value),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            fontsize=6.5,
            bbox={"fc": "white", "ec": "none", "alpha": 0.75, "pad": 0.5},
        )
    axes.set_xticks(at, [f"{int(hour_s // HOUR_S)}" for hour_s in hours_s])
    axes.tick_params(axis="x", length=0)
    axes.set_xlabel("hour")
    axes.set_ylabel(ENERGY.up.en)
    axes.set_xlim(-0.8, max(len(at), 6) - 0.2)
    axes.axhline(0, color=PALE, lw=0.6)
    axes.grid(axis="y")
    axes.spines[:].set_color(RULE)
    axes.legend(loc="lower right", ncols=5, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    return figure


def draw_energy_legs(run: ChosenRun) -> Figure | None:
    """Net energy of each leg, a panel a direction: a dot a train, a bar at the mean."""
    return draw_by_direction(run, run.tables.energy_legs, 3.4, _draw_legs)


def draw_by_direction(
    run: ChosenRun, rows: pl.DataFrame, panel_in: float, draw: Callable[..., None], more_in: float = 0.0
) -> Figure | None:
    """A panel a direction, each by `draw` with the legs in it and their rows; None where there is no leg."""
    panels = run.legs_by_direction(run.chosen_rows(rows))
    if not panels:
        return None
    figure = Figure(figsize=(WIDTH_IN, panel_in * len(panels) + more_in), layout="constrained")
    for axes, panel in zip(figure.subplots(len(panels), 1, squeeze=False)[:, 0], panels, strict=True):
        draw(axes, run, *panel)
    return figure


def _draw_legs(
    axes: Axes, run: ChosenRun, direction: Direction, ends: list[tuple[str, str]], legs: pl.DataFrame
) -> None:
    for column, (from_id, to_id) in enumerate(ends):
        values = (
            legs.filter(pl.col("from_station") == from_id, pl.col("to_station") == to_id)["net_kwh"]
            .sort()
            .to_numpy()
        )
        aside = np.linspace(-0.25, 0.25, len(values)) if len(values) > 1 else np.zeros(1)
        mean = float(values.mean())
        axes.bar(column, mean, 0.7, color="#c9d6e4", zorder=1)
        dots(axes, column + aside, values, "o", 2.4, DIRECTION_COLOUR[direction], mew=0)
        axes.annotate(
            f"{mean:.1f}".replace("-", "−"),
            (column, max(0.0, float(values.max()))),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center",
            fontsize=6.5,
        )
    axes.set_xticks(range(len(ends)), [f"{run.name(a)}\n{run.name(b)}" for a, b in ends])
    many = len(ends) > 12
    axes.tick_params(axis="x", length=0, labelsize=6.5, labelrotation=60 if many else 0)
    axes.set_xlim(-0.7, max(len(ends), 5) - 0.3)
    axes.axhline(0, color=PALE, lw=0.6)
    axes.set_title(direction.name.lower(), pad=4)
    axes.set_ylabel("net energy, kWh")
    axes.margins(y=0.15)
    axes.grid(axis="y")
    axes.spines[:].set_color(RULE)
