"""Figures of the LiDAR's reproductions: errors of speed, points before and after correction, spacing by speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import Figure

from onboard.localisation.lidar_points import CYCLE_S, KEPT_S, moved
from onboard.localisation.marker_patterns import COLUMN_M, COLUMNS, ROWS
from simulation.sensors.lidar_scan import laid
from study.papers.marker_passages import KMH, USES, Passage
from study.report.style import INK, PALE, RED, RULE, drawing

if TYPE_CHECKING:
    from study.papers.mochizuki_patterns import Spaced
    from study.papers.mochizuki_speed import Found

BINS_KMH: Final = np.arange(0.0, 4.01, 0.1)
SHOWN_AT_M: Final = 5.5
BLUE: Final = "#2a6f9e"


def draw_speed(found: Sequence[Found]) -> Figure:
    """A panel a passage: how errors are distributed between 20 and 5 m (figure 6), and the speed of one run."""
    figure = Figure(figsize=(11.0, 5.6), layout="constrained")
    axes = figure.subplots(2, len(found))
    for column, each in enumerate(found):
        top, below = axes[0][column], axes[1][column]
        seen = each.shown
        within = np.flatnonzero(seen.mean_m > 0.0)
        shown = slice(int(within[0]), int(within[-1]) + 1)
        ways = np.where(seen.mean_m[shown] > 0.0, seen.mean_m[shown], np.nan)
        top.plot(ways, seen.speed_mps[shown] * KMH, color=BLUE, lw=1.2, label="LiDAR")
        top.plot(ways, seen.true_mps[shown] * KMH, color=INK, lw=0.9, label="train")
        top.axvline(30.0 - each.case.settles_m, color=RED, lw=0.9, ls="--", label="settled, paper")
        top.axvline(30.0 - each.middle_m, color=BLUE, lw=0.9, ls="--", label="settled, ours")
        top.set_xlim(31.0, 4.0)
        top.set_title(each.case.name, fontsize=9)
        top.set_xlabel("distance, m")
        below.hist(np.clip(each.errors_kmh, 0.0, 4.0), bins=list(BINS_KMH), density=True, color=BLUE)
        for limit in (2.0, 3.0):
            below.axvline(limit, color=RED, lw=0.8, ls=":")
        below.set_xlabel("error from 20 to 5 m, km/h")
    axes[0][0].set_ylabel("speed, km/h")
    axes[1][0].set_ylabel("density")
    axes[0][0].legend(loc="lower right", fontsize=7)
    return figure


def draw_patterns(passages: Sequence[Passage]) -> Figure:
    """Points as taken and as moved (figures 7 and 8), with the cells of the grid and the markers as they lie."""
    figure = Figure(figsize=(9.0, 3.0 * len(passages)), layout="constrained")
    axes = figure.subplots(len(passages), 3, squeeze=False)
    for line, each in enumerate(passages):
        kmh = each.motion.speed_mps * KMH
        for column, name in enumerate(("not corrected", "as the paper", "every point's own time")):
            _draw_points(axes[line][column], each, name)
            axes[line][column].set_title(f"{kmh:.1f} km/h, {name}", fontsize=9)
        axes[line][0].set_ylabel("left of the middle, m")
    for each in axes[-1]:
        each.set_xlabel("ahead of the first row, m")
    return figure


def _draw_points(axes, passage: Passage, name: str) -> None:  # type: ignore[no-untyped-def]  # noqa: ANN001
    use, points = USES[name], passage.points
    seen = passage.seen(use)
    half_m = 0.5 * (ROWS - 1) * passage.spacing_m
    ways = passage.motion.from_m - np.cumsum(passage.speeds_mps) * CYCLE_S
    cycle = int(np.argmin(np.abs(ways + half_m - SHOWN_AT_M)))
    now_s = float(passage.times_s[cycle])
    times = use.stamped(points.time_s)
    kept = (times <= now_s + 1e-9) & (times > now_s - KEPT_S)
    first, end = int(np.flatnonzero(kept)[0]), int(np.flatnonzero(kept)[-1]) + 1
    speed_mps = float(seen.speed_mps[cycle]) if use.used.corrected else 0.0
    at_m = moved(points.x_m, times, first, end, now_s, speed_mps) - float(ways[cycle])
    for row in range(ROWS + 1):
        axes.axvline((row - 0.5) * passage.spacing_m, color=RULE, lw=0.6)
    for column in range(COLUMNS + 1):
        axes.axhline((column - 0.5 * COLUMNS) * COLUMN_M, color=RULE, lw=0.6)
    places = laid(passage.pattern, passage.spacing_m)
    axes.plot(places[:, 0], places[:, 1], "s", ms=13, mfc="none", color=PALE)
    axes.plot(at_m, points.y_m[first:end], ".", ms=3, color=BLUE)
    axes.set_xlim(-0.6, 1.6)
    axes.set_ylim(-0.6, 0.6)


def draw_spacing(found: Mapping[str, Sequence[Spaced]]) -> Figure:
    """The least spacing for each speed."""
    figure = Figure(figsize=(7.5, 4.2), layout="constrained")
    axes = figure.subplots()
    top = max((each.shares[-1][0] for many in found.values() for each in many), default=1.0)
    for colour, (name, many) in zip((INK, BLUE), found.items(), strict=True):
        met = [(each.speed_kmh, each.least_m) for each in many if each.least_m is not None]
        none = [each for each in many if each.least_m is None]
        label = "points with the time of their frame (0.02 s)" if name == "as the paper" else name
        axes.plot([kmh for kmh, _ in met], [least_m for _, least_m in met], "o-", color=colour, label=label)
        axes.plot([e.speed_kmh for e in none], [top for _ in none], "x", color=colour, ms=9)
    axes.axhline(0.25, color=RED, lw=0.8, ls=":")
    axes.set_xlabel("speed, km/h")
    axes.set_ylabel("spacing of rows for 99 %, m (x: none tried is enough)")
    axes.set_ylim(0.0, top * 1.1)
    axes.grid(visible=True)
    axes.legend(loc="upper left")
    return figure


def _write(figure: Figure, folder: Path, name: str) -> tuple[Path, ...]:
    folder.mkdir(parents=True, exist_ok=True)
    paths = tuple(folder / f"{name}.{kind}" for kind in ("svg", "png"))
    figure.savefig(paths[0], metadata={"Date": None, "Creator": None})
    figure.savefig(paths[1], dpi=130, metadata={"Software": None})
    return paths


def write_speed(found: Sequence[Found], folder: Path) -> tuple[Path, ...]:
    """Errors of speed as SVG and PNG below `folder`; the files written. So do the other two."""
    with drawing():
        return _write(draw_speed(found), folder, "lidar_speed")


def write_patterns(passages: Sequence[Passage], folder: Path) -> tuple[Path, ...]:
    """Points of passages."""
    with drawing():
        return _write(draw_patterns(passages), folder, "lidar_points")


def write_spacing(found: Mapping[str, Sequence[Spaced]], folder: Path) -> tuple[Path, ...]:
    """Spacing by speed."""
    with drawing():
        return _write(draw_spacing(found), folder, "lidar_spacing")
