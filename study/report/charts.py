"""The smaller charts: energy by train, stop errors, delays."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from network.model import Direction
from study.measures.missing import planned_times
from study.report.data import ReportedRun
from study.report.graph import station_label
from study.report.pictures import ENERGY, STOP_ERRORS
from study.report.style import DIGIT_EM, INK, PALE, RED, RULE, WIDTH_IN, beside, dots, text_pt

Floats = NDArray[np.float64]

_BARS_IN_A_ROW: Final = 64
_CELL_PT: Final = 6.5
_PANEL_SHARE: Final = 0.44  # of the width, for the columns of one direction
_NAME_PT: Final = 6.5

# Fixed, so that the delays of two runs compare by eye.
_EARLY_S, _LATE_S = -60.0, 300.0
_DELAY_COLOURS: Final = LinearSegmentedColormap.from_list(
    "delay", [(0.0, "#9cc3e0"), (0.5, "#ffffff"), (0.75, "#f0b49e"), (1.0, "#b3261e")]
)


def draw_energy(run: ReportedRun) -> Figure | None:
    """Energy by train, kWh: traction and auxiliary up, regenerated down, in rows of equal length. None: no rows."""
    order = {train: i for i, train in enumerate(run.trains)}
    rows = sorted(
        run.tables.energy.iter_rows(named=True), key=lambda row: order.get(row["train"], len(order))
    )
    if not rows:
        return None
    bands = math.ceil(len(rows) / _BARS_IN_A_ROW)
    each = math.ceil(len(rows) / bands)
    figure = Figure(figsize=(WIDTH_IN, 0.4 + 2.8 * bands), layout="constrained")
    panels = figure.subplots(bands, 1, squeeze=False, sharey=True)[:, 0]
    for band, axes in enumerate(panels):
        _draw_bars(axes, rows[band * each : (band + 1) * each], each)
    up_kwh = max([1e-3, *(row["traction_kwh"] + row["auxiliary_kwh"] for row in rows)])
    down_kwh = max(row["regenerated_kwh"] for row in rows)
    panels[0].set_ylim(-max(down_kwh * 1.15, 0.05 * up_kwh), up_kwh * 1.22)
    panels[0].legend(loc="lower right", ncols=4, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    return figure


def _draw_bars(axes: Axes, rows: list[dict[str, Any]], room: int) -> None:
    """One row of bars with the net kWh per train-km of each; `room` is how many a full row has."""
    at = np.arange(len(rows))
    traction, auxiliary, standing, regenerated = (
        np.array([row[f"{name}_kwh"] for row in rows])
        for name in ("traction", "auxiliary", "standing", "regenerated")
    )
    width = 0.72
    stack_energy(axes, at, width, (traction, auxiliary - standing, standing, regenerated))
    upright = room > 24
    for i, row in enumerate(rows):
        text = f"{row['net_kwh'] / row['distance_km']:.2f}" if row["distance_km"] > 0 else "–"
        beside(axes, text, (i, traction[i] + auxiliary[i]), (0, 2), 6.5, rotation=90 if upright else 0)  # fmt: skip
    axes.axhline(0, color=PALE, lw=0.6)
    axes.set_xticks(at, [row["train"] if row["revenue"] else f"({row['train']})" for row in rows])
    axes.tick_params(axis="x", length=0, labelrotation=90 if upright else 0, labelsize=7)
    middle, half = (room - 1) / 2, max(room / 2 + 0.3, 5.0)
    axes.set_xlim(middle - half, middle + half)
    axes.set_ylabel(ENERGY.up.en)
    axes.grid(axis="y")
    axes.spines[:].set_color(RULE)


def stack_energy(
    axes: Axes, at: NDArray[np.int64], width: float, parts: tuple[Floats, Floats, Floats, Floats]
) -> None:
    """Bars of what the layers of `ENERGY` say, kWh: all but the last stand on each other, the last one hangs."""
    *above, below = zip(ENERGY.layers.values(), parts, strict=True)
    bottom = np.zeros(len(at))
    for layer, kwh in above:
        axes.bar(at, kwh, width, bottom=bottom, **layer.face())
        bottom = bottom + kwh
    axes.bar(at, -below[1], width, **below[0].face())


def draw_stop_errors(run: ReportedRun, summary: Mapping[str, Any]) -> Figure | None:
    """Histogram of the stop errors (停止誤差, m), and the errors by station. None: no stops."""
    stops = run.tables.stops.filter(pl.col("stop_error_m").is_not_null())
    if not len(stops):
        return None
    errors_m = stops["stop_error_m"].to_numpy()
    figure = Figure(figsize=(WIDTH_IN, 3.0), layout="constrained")
    histogram, strips = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1, 1.6]})
    reach_m = max(float(np.abs(errors_m).max()) * 1.1, 0.05)
    histogram.hist(errors_m, bins=np.linspace(-reach_m, reach_m, 32), color="#8fa9c0", ec="white", lw=0.4)
    mean_m, sigma_m = float(summary["stop_error_m_mean"]), summary["stop_error_m_sigma"]
    histogram.axvline(mean_m, color=INK, lw=1.2, label=f"mean {mean_m:+.3f} m".replace("-", "−"))
    if sigma_m is not None:
        label = f"mean ± σ, σ = {sigma_m:.3f} m"
        histogram.axvspan(mean_m - sigma_m, mean_m + sigma_m, color=PALE, alpha=0.15, lw=0, label=label)
    histogram.set_xlabel(STOP_ERRORS.up.en)
    histogram.set_ylabel("stops")
    histogram.yaxis.get_major_locator().set_params(integer=True)
    histogram.legend(loc="lower left", ncols=2, bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
    _draw_strips(strips, run, stops)
    return figure


def _draw_strips(axes: Axes, run: ReportedRun, stops: pl.DataFrame) -> None:
    """A dot a stop, moved aside by its rank so that equal ones stay apart; a bar at the mean."""
    for column, station in enumerate(run.stations):
        errors_m = stops.filter(pl.col("station") == station.id)["stop_error_m"].to_numpy()
        if not len(errors_m):
            continue
        aside = np.linspace(-0.25, 0.25, len(errors_m)) if len(errors_m) > 1 else np.zeros(1)
        dots(axes, column + aside, errors_m, "o", 2.2, "#5e81a3", mew=0)
        axes.hlines(errors_m.mean(), column - 0.32, column + 0.32, color=INK, lw=1.2)
    axes.axhline(0, color=PALE, lw=0.6)
    labels = [station_label(station).replace(" ", "\n") for station in run.stations]
    axes.set_xticks(range(len(labels)), labels, fontsize=6.5 if len(labels) < 12 else 5.5)
    axes.set_xlim(-0.6, len(labels) - 0.4)
    axes.tick_params(axis="x", length=0)
    axes.set_ylabel(STOP_ERRORS.up.en)
    axes.grid(axis="y")
    axes.spines[:].set_color(RULE)


@dataclass(frozen=True, slots=True)
class CallLateness:
    """Lateness at one call, s: on arrival and on departure; None without a plan, infinite where it did not come."""

    arrival_s: float | None
    departure_s: float | None

    @property
    def worse_s(self) -> float | None:
        """The greater of the two."""
        return max((s for s in (self.arrival_s, self.departure_s) if s is not None), default=None)

    def text(self) -> str:
        """+5/+12: arrival, then departure."""
        if self.worse_s is None:
            return ""
        return f"{_in_words(self.arrival_s)}/{_in_words(self.departure_s)}"


def draw_delays(run: ReportedRun, end_s: float | None = None) -> Figure | None:
    """Lateness in s, a row a train and a column a station: arrival/departure, in the colour of the worse of both.

    `end_s`: what was planned for later, s, is not missing; see `study.measures.missing`.
    """
    groups = [
        (direction, [t for t in run.trains if run.directions[t] == direction]) for direction in Direction
    ]
    groups = [(direction, trains) for direction, trains in groups if trains]
    if not groups:
        return None
    late: dict[tuple[str, str], dict[str, float]] = {}
    times = planned_times(run.tables.stops, run.timetable, end_s)
    for train, station, what, late_s, came in times.select(
        "train", "station", "what", "late_s", "came"
    ).iter_rows():
        found = late.setdefault((train, station), {})
        found[what] = min(found.get(what, math.inf), late_s if came else math.inf)
    cells = {key: CallLateness(found.get("arrival"), found.get("departure")) for key, found in late.items()}
    height_in = 0.75 + 0.19 * max(len(trains) for _, trains in groups)
    figure = Figure(figsize=(WIDTH_IN, max(height_in, 1.6)), layout="constrained")
    panels = figure.subplots(1, 2, squeeze=False)[0]
    for axes, (direction, trains) in zip(panels, groups, strict=False):
        _draw_heat_map(axes, run, direction, trains, cells)
    for axes in panels[len(groups) :]:
        axes.set_axis_off()
    return figure


def _draw_heat_map(
    axes: Axes,
    run: ReportedRun,
    direction: Direction,
    trains: list[str],
    late: Mapping[tuple[str, str], CallLateness],
) -> None:
    stations = list(run.stations) if direction is Direction.DOWN else list(reversed(run.stations))
    never = CallLateness(None, None)
    cells = [[late.get((train, station.id), never) for station in stations] for train in trains]
    values_s = np.array(
        [[np.nan if cell.worse_s is None else min(cell.worse_s, _LATE_S) for cell in row] for row in cells]
    ).reshape(len(trains), len(stations))
    edges_x, edges_y = np.arange(len(stations) + 1) - 0.5, np.arange(len(trains) + 1) - 0.5
    axes.pcolormesh(
        edges_x,
        edges_y,
        np.ma.masked_invalid(values_s),
        cmap=_DELAY_COLOURS,
        norm=TwoSlopeNorm(0.0, _EARLY_S, _LATE_S),
        ec=RULE,
        lw=0.4,
    )
    longest = max([1, *(len(cell.text()) for row in cells for cell in row)])
    column_pt = 72.0 * WIDTH_IN * _PANEL_SHARE / len(stations)
    size_pt = min(_CELL_PT, column_pt / (longest * DIGIT_EM))
    for row, several in enumerate(cells):
        for column, cell in enumerate(several):
            if cell.worse_s is None:
                continue
            too_early = cell.departure_s is not None and cell.departure_s < -0.5
            colour = "white" if cell.worse_s > 0.8 * _LATE_S else RED if too_early else INK
            axes.text(column, row, cell.text(), ha="center", va="center", fontsize=size_pt, color=colour)
    axes.set_ylim(len(trains) - 0.5, -0.5)
    axes.set_yticks(range(len(trains)), trains, fontsize=6.5)
    axes.set_xticks(range(len(stations)), [station.name for station in stations], fontsize=_NAME_PT)
    axes.tick_params(length=0, labeltop=True, labelbottom=False)
    if max(text_pt(station.name, _NAME_PT) for station in stations) > 0.95 * column_pt:
        axes.tick_params(axis="x", labelrotation=25)
        for label in axes.get_xticklabels():
            label.set_horizontalalignment("left")
            label.set_rotation_mode("anchor")
    axes.set_title(f"{direction.name.lower()} trains", pad=4)
    axes.spines[:].set_color(RULE)


def _in_words(value_s: float | None) -> str:
    """+42 in s; from ten minutes on in whole minutes; nothing where there is nothing, – where it did not come."""
    if value_s is None:
        return ""
    if math.isinf(value_s):
        return "–"
    rounded = round(value_s)
    text = f"{rounded / 60:+.0f} min" if abs(rounded) >= 600 else "0" if rounded == 0 else f"{rounded:+d}"
    return text.replace("-", "−")
