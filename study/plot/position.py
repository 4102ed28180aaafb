"""Where a train believed to be: error and bounds over distance, with what its sensors said (位置検知)."""

from __future__ import annotations

from typing import Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from network.model import Direction
from study.measures.localisation import FIX_KINDS, FOUND, HALF_M, LOST, lost_between
from study.plot.choice import ChosenRun
from study.report.curve import alignment_of, in_km, mark_stations
from study.report.style import DIRECTION_COLOUR, INK, PALE, RED, REGENERATED, RULE, WIDTH_IN, dots

BAND: Final = "#c9d6e4"
UNKNOWN: Final = "#f3d9d6"
MARKS: Final = {  # kind of event: marker, colour, its words
    "fix": ("^", REGENERATED, "fixes again, or by the driver's eye"),
    "fix refused": ("x", RED, "fix refused"),
    "fix missed": ("v", PALE, "fix missed"),
    "foreign track": ("s", "#8c6d1f", "foreign track: not what the map has"),
    FOUND: ("o", REGENERATED, "position found"),
    LOST: ("X", RED, "position lost"),
}


def position_table(run: ChosenRun) -> pl.DataFrame:
    """The trajectory with the half-width of the bounds, of the train chosen."""
    columns = ("t_s", "unit", "train", "kilometrage_m", "piece", "speed_mps", "estimate_error_m")
    return run.shown(run.tables.trajectory).select(*columns, "bound_ahead_m", "bound_behind_m", HALF_M)


def draw_position(run: ChosenRun) -> Figure | None:
    """Error in its bounds over distance, in two scales: the whole, and about the largest error. None: no run."""
    train = run.choice.train
    found = next((key for key in run.courses if key[1] == train), None)
    if found is None:
        return None
    unit, direction = found[0], run.directions[found[1]]
    course = run.courses[found]
    alignment = alignment_of(run.line, course)
    pieces = [p.id for p in run.line.pieces.values() if p.alignment_id == alignment.id]
    course = course.filter(pl.col("piece").is_in(pieces))
    at_m = course["kilometrage_m"].to_numpy()
    margin_m = max(0.01 * (at_m.max() - at_m.min()), 1.0)
    low_m, high_m = float(at_m.min()) - margin_m, float(at_m.max()) + margin_m
    figure = Figure(figsize=(WIDTH_IN, 5.6), layout="constrained")
    whole, near = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.0, 1.0]})
    whole.set_xlim(*((low_m, high_m) if direction is Direction.DOWN else (high_m, low_m)))
    error_m = course["estimate_error_m"].to_numpy()
    least_m = error_m - course["bound_behind_m"].to_numpy()
    most_m = error_m + course["bound_ahead_m"].to_numpy()
    known = _known(run, unit, course)
    largest_m = max(1.5 * float(np.abs(error_m[known]).max(initial=0.0)), 1.0)
    widest_m = max(float(np.abs(np.concatenate([least_m[known], most_m[known]])).max(initial=1.0)), 1.0)
    for axes, reach_m in ((whole, 1.1 * widest_m), (near, min(largest_m, 1.1 * widest_m))):
        axes.fill_between(
            at_m, least_m, most_m, where=list(known), color=BAND, lw=0, label="within its bounds"
        )
        if not known.all():
            words = "position unknown, on sight"
            axes.fill_between(at_m, -reach_m, reach_m, where=list(~known), color=UNKNOWN, lw=0, label=words)
        shown_m = np.where(known, error_m, np.nan)
        axes.plot(at_m, shown_m, color=DIRECTION_COLOUR[direction], lw=1.2, label="believed less true")
        axes.axhline(0.0, color=INK, lw=0.5)
        axes.set_ylim(-reach_m, reach_m)
        axes.set_ylabel("m, ahead of the truth")
        axes.grid(axis="y")
    _mark_events(run, whole, unit, course)
    mark_stations(run, (whole, near), low_m, high_m)
    handles, labels = whole.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    near.xaxis.set_major_locator(MaxNLocator(24, steps=[1, 2, 5, 10]))
    near.xaxis.set_major_formatter(FuncFormatter(in_km))
    near.set_xlabel("kilometrage, km")
    near.spines[:].set_color(RULE)
    return figure


def _known(run: ChosenRun, unit: str, course: pl.DataFrame) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    time_s = course["t_s"].to_numpy()
    known = np.ones(time_s.size, dtype=bool)
    for from_s, to_s in lost_between(run.tables.events, unit):
        known &= ~((time_s >= from_s) & (time_s <= to_s))
    return known


def _mark_events(run: ChosenRun, axes: Axes, unit: str, course: pl.DataFrame) -> None:
    """What the unit said of its sensors, where it was when it said so."""
    time_s, at_m = course["t_s"].to_numpy(), course["kilometrage_m"].to_numpy()
    own = run.tables.events.filter(
        pl.col("source") == unit, pl.col("t_s").is_between(float(time_s[0]), float(time_s[-1]))
    )
    kinds = (*FIX_KINDS, FOUND, LOST)
    low_m, high_m = axes.get_ylim()
    for row, kind in enumerate(kinds):
        times = own.filter(pl.col("kind") == kind)["t_s"].to_numpy()
        if times.size == 0:
            continue
        marker, colour, words = MARKS[kind]
        height_m = low_m + (0.05 + 0.05 * row) * (high_m - low_m)
        where_m = np.interp(times, time_s, at_m)
        dots(axes, where_m, np.full(times.size, height_m), marker, 4.5, colour, label=words)
