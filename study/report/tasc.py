"""The report's figures on stopping at the mark: the last 400 m of every stop, and what one stop taught its train."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import zip_longest
from typing import TYPE_CHECKING, Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from onboard.driving.tuning import (
    DEAD_TIMES,
    OFFSET_STEP_MPS2,
    OFFSET_ZERO,
    OFFSETS,
    REACH_X,
    REACH_Y,
    SIX_POINTS,
    STEP_S,
    StopDecelerations,
    approximate,
    misfit,
    search,
    waves,
    window,
)
from study.record.shown import LearnedTrain
from study.report.data import ReportedRun
from study.report.style import INK, PALE, RED, TRACTION, WIDTH_IN

if TYPE_CHECKING:  # the page of a run draws these itself
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

KMH_PER_MPS: Final = 3.6
KMHPS_PER_MPS2: Final = 3.6
LAST_M: Final = 400.0
APPROACH_S: Final = 120.0
UNITS_IN_A_ROW: Final = 4
TARGET_COLOUR: Final = "#d55e00"


def draw_approaches(run: ReportedRun) -> Figure | None:
    """Target and actual speed over the last 400 m before the mark, every stop of every unit. None: no stops."""
    from matplotlib.figure import Figure

    stops = run.tables.stops.filter(pl.col("stop_error_m").is_not_null() & pl.col("arrival_s").is_not_null())
    units = sorted(stops["unit"].unique())
    if not units:
        return None
    rows = math.ceil(len(units) / UNITS_IN_A_ROW)
    columns = math.ceil(len(units) / rows)
    figure = Figure(figsize=(WIDTH_IN, 3.0 * rows + 0.4), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes, unit in zip_longest(panels.flat, units):
        if unit is None:
            axes.set_axis_off()
            continue
        ours = stops.filter(pl.col("unit") == unit)
        drawn = 0
        for distance_m, speed_mps, target_mps in _approaches(run, ours):
            axes.plot(distance_m, speed_mps * KMH_PER_MPS, color=TRACTION, lw=0.7, alpha=0.5)
            axes.plot(distance_m, target_mps * KMH_PER_MPS, color=TARGET_COLOUR, lw=0.6, ls="--", alpha=0.5)
            drawn += 1
        axes.set_title(
            f"{unit}, {len(ours)} stop{'' if len(ours) == 1 else 's'}"
            + ("" if drawn == len(ours) else f", {drawn} drawn")
        )
        axes.grid()
    for axes in panels[-1]:
        axes.set_xlabel("before the mark, m")
    for axes in panels[:, 0]:
        axes.set_ylabel("speed, km/h")
    first = panels[0, 0]
    first.set_xlim(LAST_M, -10.0)
    first.set_ylim(bottom=0.0)
    first.plot([], [], color=TRACTION, lw=1.2, label="actual")
    first.plot([], [], color=TARGET_COLOUR, lw=1.2, ls="--", label="target")
    first.legend(loc="lower left")
    return figure


def _approaches(run: ReportedRun, stops: pl.DataFrame) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Distance before the mark (m), speed and target speed (m/s) of each stop's last 400 m."""
    for row in stops.iter_rows(named=True):
        course = run.courses.get((row["unit"], row["train"]))
        if course is None:
            continue
        arrival_s = row["arrival_s"]
        near = course.filter(pl.col("t_s").is_between(arrival_s - APPROACH_S, arrival_s))
        if near.is_empty():
            continue
        at_m = near["kilometrage_m"].to_numpy()
        distance_m = (at_m[-1] - at_m) * int(run.directions[row["train"]]) - row["stop_error_m"]
        moved = np.flatnonzero(near["speed_mps"].to_numpy() <= 0.0)
        first = int(moved[-2]) if moved.size > 1 else 0  # a stop shortly before is not part of this one
        shown = (distance_m <= LAST_M) & (np.arange(at_m.size) >= first)
        target_mps = near["target_mps"].to_numpy()
        yield distance_m[shown], near["speed_mps"].to_numpy()[shown], target_mps[shown]


def response_surface(stop: StopDecelerations) -> Floats | None:
    """J, (m/s^2)^2, at every dead time (column) and offset (row) of the grid; None for a stop without a window."""
    span = window(stop)
    if span is None:
        return None
    smooth = waves(stop)
    return np.array(
        [
            [misfit(*smooth, *span, x, (y - OFFSET_ZERO) * OFFSET_STEP_MPS2) for x in range(DEAD_TIMES)]
            for y in range(OFFSETS)
        ]
    )


def draw_response(tuned: LearnedTrain, unit: str) -> Figure | None:
    """The evaluation function of one stop (評価関数の応答曲面) with its search, and the waves it comes from."""
    from matplotlib.figure import Figure

    surface = response_surface(tuned.stop)
    if surface is None:
        return None
    figure = Figure(figsize=(WIDTH_IN, 4.2), layout="constrained")
    heat, course = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1.15, 1.0]})
    _draw_surface(heat, figure, surface, tuned)
    heat.set_title(f"Evaluation function J of the last stop of {unit}")
    at_s = (np.arange(tuned.stop.designed_mps2.size) - tuned.stop.designed_mps2.size) * STEP_S
    course.plot(at_s, tuned.stop.designed_mps2, color=TARGET_COLOUR, lw=1.1, label="designed, after its lag")
    course.plot(at_s, tuned.stop.actual_mps2, color=PALE, lw=0.5, label="actual, as measured")
    course.plot(at_s, waves(tuned.stop)[1], color=TRACTION, lw=1.1, label="actual, smoothed")
    course.set_title("Designed and actual deceleration, without gradient and resistance")
    course.set_xlabel("before rest, s")
    course.set_ylabel("deceleration, m/s²")
    course.set_ylim(-0.2, 1.2 * max(0.1, float(tuned.stop.designed_mps2.max())))
    course.legend(loc="lower center")
    course.grid()
    return figure


def _draw_surface(axes: Axes, figure: Figure, surface: Floats, tuned: LearnedTrain) -> None:
    """Heat map over dead time (s) and offset (km/h/s), the least J by search and by the six points."""
    from matplotlib.colors import LogNorm

    step_kmhps = OFFSET_STEP_MPS2 * KMHPS_PER_MPS2
    half_s, half_kmhps = STEP_S / 2.0, step_kmhps / 2.0
    reach_kmhps = OFFSET_ZERO * step_kmhps
    extent = (
        -half_s,
        (DEAD_TIMES - 1) * STEP_S + half_s,
        -reach_kmhps - half_kmhps,
        reach_kmhps + half_kmhps,
    )
    least = max(float(surface.min()), 1e-6)
    image = axes.imshow(
        surface,
        origin="lower",
        extent=extent,
        aspect="auto",
        cmap="YlGnBu_r",
        norm=LogNorm(vmin=least, vmax=max(float(surface.max()), 2.0 * least)),
    )
    bar = figure.colorbar(image, ax=axes, label="J, (m/s²)²")
    bar.ax.yaxis.set_major_formatter("{x:g}")
    centre = tuned.learned.centre
    x0 = min(max(centre[0], REACH_X), DEAD_TIMES - 1 - REACH_X)
    y0 = min(max(centre[1], REACH_Y), OFFSETS - 1 - REACH_Y)
    six = np.array([(x0 + dx, y0 + dy - OFFSET_ZERO) for dx, dy in SIX_POINTS])
    axes.plot(
        six[:, 0] * STEP_S, six[:, 1] * step_kmhps, "o", mfc="white", mec=INK, ms=5.5, label="six points"
    )
    for fit, marker, label in (
        (search(tuned.stop), "+", "least of 441 (search)"),
        (approximate(tuned.stop, centre), "x", "least of the quadratic"),
    ):
        if fit is not None:
            place = (fit.dead_time_s, fit.offset_mps2 * KMHPS_PER_MPS2)
            axes.plot(*place, marker, color=RED, ms=10, mew=1.8, label=label, ls="none")
    axes.set_xlabel("dead time, s")
    axes.set_ylabel("deceleration offset, km/h/s")
    axes.legend(loc="upper right", facecolor="white", framealpha=0.8, frameon=True)


def most_telling(tuned: Mapping[str, LearnedTrain]) -> str | None:
    """The train that differs most from its design: the one to show. None where none has learned."""
    away = {
        unit: abs(one.learned.offset_mps2) / OFFSET_STEP_MPS2
        + abs(one.learned.dead_time_s - one.learned.design_dead_time_s) / STEP_S
        for unit, one in sorted(tuned.items())
    }
    return max(away, key=lambda unit: away[unit]) if away else None


def waves_shown(stop: StopDecelerations) -> tuple[Floats, Floats, Floats]:
    """Designed, measured and smoothed deceleration of a stop, m/s^2, a step apart and up to rest."""
    return stop.designed_mps2, stop.actual_mps2, waves(stop)[1]
