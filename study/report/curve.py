"""The run curve (運転曲線) of one train: speed over distance, with gradients, curves and notches."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from network.model import Alignment, Direction, Line
from study.report.data import ReportedRun, limits_mps
from study.report.graph import station_label
from study.report.pictures import RUN_CURVE
from study.report.style import INK, PALE, RED, RULE, TRACTION, WIDTH_IN, beside, dots, spread, text_pt

Floats = NDArray[np.float64]

KMH_PER_MPS: Final = 3.6
_CROSSING_SHARE: Final = 0.03  # of the height: where level crossings are marked
_STATION_PT: Final = 7
PANEL_PT: Final = 0.94 * 72 * WIDTH_IN  # the width of the panels, about
_LABEL_WIDTH_SHARE: Final = 0.022  # a gradient or curve narrower than this carries no figure


def in_km(at_m: float, _place: int | None) -> str:
    """A kilometrage as the axis has it, km."""
    return f"{at_m / 1000:g}"


def draw_run_curve(run: ReportedRun, unit: str, train: str) -> Figure:
    """Speed, permitted and target speed over distance; below gradient, curvature and notch. Km and km/h."""
    alignment = alignment_of(run.line, run.courses[unit, train])
    course = run.courses[unit, train].filter(
        pl.col("piece").is_in([p.id for p in run.line.pieces.values() if p.alignment_id == alignment.id])
    )
    direction = run.directions[train]
    figure = Figure(figsize=(WIDTH_IN, 5.6), layout="constrained")
    speed, gradient, curve, notch = figure.subplots(
        4, 1, sharex=True, gridspec_kw={"height_ratios": [5.2, 1.0, 1.0, 1.0]}
    )
    at_m = course["kilometrage_m"].to_numpy()
    stops = run.tables.stops.filter(pl.col("train") == train)["station"]
    called_m = [run.line.stations[station].position_m for station in stops]
    low_m, high_m = min([float(at_m.min()), *called_m]), max([float(at_m.max()), *called_m])
    margin_m = max(0.01 * (high_m - low_m), 1.0)
    low_m, high_m = low_m - margin_m, high_m + margin_m
    # The train always runs from left to right, so the axis of an UP train is turned.
    speed.set_xlim(*((low_m, high_m) if direction is Direction.DOWN else (high_m, low_m)))
    _draw_speeds(speed, run.line, alignment, course, direction)
    draw_gradients(gradient, alignment, direction, high_m - low_m)
    _draw_curves(curve, alignment, direction, high_m - low_m)
    draw_notches(notch, course, (TRACTION, RED), 0.75, 4)
    notch.set_ylabel("notch")
    mark_stations(run, (speed, gradient, curve, notch), low_m, high_m)
    _mark_crossings(speed, run, alignment, (unit, train))
    notch.xaxis.set_major_locator(MaxNLocator(24, steps=[1, 2, 5, 10]))
    notch.xaxis.set_major_formatter(FuncFormatter(in_km))
    notch.set_xlabel("kilometrage, km")
    figure.align_ylabels()
    return figure


def alignment_of(line: Line, course: pl.DataFrame) -> Alignment:
    """The axis of kilometrage on which most of the run lies."""
    samples: dict[str, int] = {}
    for piece, count in course.group_by("piece", maintain_order=True).len().iter_rows():
        alignment_id = line.pieces[piece].alignment_id
        samples[alignment_id] = samples.get(alignment_id, 0) + count
    return line.alignments[max(samples, key=lambda key: samples[key])]


def _draw_speeds(
    axes: Axes, line: Line, alignment: Alignment, course: pl.DataFrame, direction: Direction
) -> None:
    breaks_m, limit_mps = limits_mps(line, alignment, direction)
    limit_kmh = limit_mps * KMH_PER_MPS
    top_kmh = max(float(limit_kmh.max()), float(course["speed_mps"].to_numpy().max()) * KMH_PER_MPS) * 1.08
    at_m = course["kilometrage_m"].to_numpy()
    layers = RUN_CURVE.layers
    axes.step(breaks_m, limit_kmh, where="post", **layers["limit"].line())
    for column, layer in (
        ("permitted_mps", "permitted"),
        ("target_mps", "target"),
        ("speed_mps", direction.name.lower()),
    ):
        values_kmh = course[column].to_numpy() * KMH_PER_MPS
        values_kmh = np.where(np.isfinite(values_kmh), np.minimum(values_kmh, 2 * top_kmh), np.nan)
        axes.plot(at_m, values_kmh, **layers[layer].line())
    braked = course.filter(pl.col("intervention") != 0)
    if len(braked):
        dots(
            axes,
            braked["kilometrage_m"].to_numpy(),
            braked["speed_mps"].to_numpy() * KMH_PER_MPS,
            "x",
            4,
            layers["braked"].colour,
            label=layers["braked"].label.en,
        )
    axes.set_ylim(0, top_kmh)
    axes.set_ylabel(RUN_CURVE.up.en)
    axes.grid(axis="y")
    axes.legend(loc="lower center", ncols=5, bbox_to_anchor=(0.5, 1.09), borderaxespad=0.0)


def _mark_crossings(axes: Axes, run: ReportedRun, alignment: Alignment, course: tuple[str, str]) -> None:
    """A cross at each level crossing, with how long it had warned as the train came, s; contacts, if any, as ticks."""
    unit, train = course
    passed = run.tables.warnings.filter((pl.col("unit") == unit) & (pl.col("train") == train))
    warned_s = dict(passed.select("crossing", "warned_s").iter_rows())
    direction, over = run.directions[train], axes.get_xaxis_transform()
    low_m, high_m = sorted(axes.get_xlim())
    here = [
        crossing
        for crossing in sorted(run.line.crossings.values(), key=lambda one: one.position_m)
        if run.line.pieces[crossing.piece_id].alignment_id == alignment.id
        and low_m < crossing.position_m < high_m
    ]
    for crossing in here:
        axes.plot([crossing.position_m], [_CROSSING_SHARE], "x", color=INK, ms=4, mew=0.8, transform=over)
        contact_m = crossing.starts_m.get(direction)
        if contact_m is not None:
            axes.plot([contact_m], [_CROSSING_SHARE], "|", color=PALE, ms=5, transform=over)
    said = [crossing for crossing in here if crossing.id in warned_s]
    labels_m = spread([crossing.position_m for crossing in said], _LABEL_WIDTH_SHARE * (high_m - low_m))
    for crossing, label_m in zip(said, labels_m, strict=True):
        text = f"{warned_s[crossing.id]:.0f} s"
        beside(
            axes, text, (label_m, _CROSSING_SHARE), (0, 3), 5.5, color=INK, xycoords=("data", "axes fraction")
        )


def draw_gradients(axes: Axes, alignment: Alignment, direction: Direction, span_m: float) -> None:
    """Gradient as the train meets it: positive climbs in its own direction of travel."""
    breaks_m = [g.from_m for g in alignment.gradients] + [g.to_m for g in alignment.gradients[-1:]]
    permille = [g.permille * direction for g in alignment.gradients]
    if permille:
        axes.stairs(permille, breaks_m, fill=True, color="#c9d3dc", lw=0)
        axes.stairs(permille, breaks_m, color=PALE, lw=0.6, baseline=None)
        steepest = max(1.0, *(abs(value) for value in permille))
        axes.set_ylim(-1.9 * steepest, 1.9 * steepest)
    axes.axhline(0, color=PALE, lw=0.5)
    for g, value in zip(alignment.gradients, permille, strict=True):
        if g.to_m - g.from_m > _LABEL_WIDTH_SHARE * span_m and value != 0:
            _figure(axes, (g.from_m + g.to_m) / 2, value, f"{abs(value):.3g}")
    axes.set_ylabel("gradient\n‰")


def _draw_curves(axes: Axes, alignment: Alignment, direction: Direction, span_m: float) -> None:
    """Curvature as the train meets it, right above and left below, with radii in m."""
    sharpest = max((1.0 / abs(c.radius_m) for c in alignment.curves), default=1.0)
    axes.axhline(0, color=PALE, lw=0.5)
    for c in alignment.curves:
        height = direction / c.radius_m / sharpest
        inner_m = min(c.transition_m, (c.to_m - c.from_m) / 2)
        corners_m = [c.from_m, c.from_m + inner_m, c.to_m - inner_m, c.to_m]
        axes.fill(corners_m, [0, height, height, 0], color="#d8cdb8", ec=PALE, lw=0.4)
        if c.to_m - c.from_m > _LABEL_WIDTH_SHARE * span_m:
            _figure(axes, (c.from_m + c.to_m) / 2, height, f"{abs(c.radius_m):.0f}")
    axes.set_ylim(-1.8, 1.8)
    axes.set_yticks([])
    axes.set_ylabel("curve\nradius m")


def _figure(axes: Axes, at_m: float, value: float, text: str) -> None:
    """A small figure beyond the end of a bar."""
    beside(axes, text, (at_m, value), (0, 1.5 if value > 0 else -1.5), 5.5, color=INK, annotation_clip=True)


def draw_notches(
    axes: Axes, course: pl.DataFrame, colours: tuple[str, str], brake_alpha: float, ticks: int
) -> None:
    """Power up, brake down, in a colour each."""
    at_m = course["kilometrage_m"].to_numpy()
    notch = np.nan_to_num(course["notch"].to_numpy())
    axes.fill_between(at_m, np.maximum(notch, 0), step="post", color=colours[0], lw=0)
    axes.fill_between(at_m, np.minimum(notch, 0), step="post", color=colours[1], alpha=brake_alpha, lw=0)
    axes.axhline(0, color=PALE, lw=0.5)
    axes.yaxis.set_major_locator(MaxNLocator(ticks, integer=True))


def mark_stations(run: ReportedRun, panels: tuple[Axes, ...], low_m: float, high_m: float) -> None:
    """A line through all panels at each station in between, with its name above the first."""
    shown = [station for station in run.stations if low_m <= station.position_m <= high_m]
    for axes in panels:
        axes.spines[:].set_color(RULE)
        for station in shown:
            axes.axvline(station.position_m, color=RULE, lw=0.8, zorder=0.5)
    labels = [station_label(station, "\n") for station in shown]
    wide_pt = [max(text_pt(f" {name}", _STATION_PT) for name in label.split("\n")) for label in labels] or [
        0.0
    ]
    m_per_pt = (high_m - low_m) / max(PANEL_PT, math.fsum(wide_pt))  # of more than have room each has less
    within_m = low_m + m_per_pt * wide_pt[0] / 2, high_m - m_per_pt * wide_pt[-1] / 2
    gaps_m = [m_per_pt * (one + other) / 2 for one, other in pairwise(wide_pt)]
    for label, label_m in zip(labels, spread([s.position_m for s in shown], gaps_m, within_m), strict=True):
        beside(panels[0], label, (label_m, 1.0), (0, 2), _STATION_PT, xycoords=("data", "axes fraction"))
