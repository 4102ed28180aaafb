"""The set of `stop_set` drawn: distance to the mark across, speed upwards, and stops from just outside that miss."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from study.papers.stop_set import BEYOND_M, SPEED_LEAST_MPS, WINDOW_M, Floats, StopSet
from study.report.style import INK, PALE, RED, RULE, drawing

KMH_PER_MPS: Final = 3.6
HELD: Final = "#9cc3e0"
NAME: Final = "stop_window"


def draw_set(found: StopSet, missed: tuple[Floats, Floats]) -> Figure:
    """The set, what no law can hold, and stops that `missed` the window (distances m, speeds m/s)."""
    speeds = np.linspace(SPEED_LEAST_MPS, found.top_mps, 600)
    # just under the top: the cell above it is out
    nearest = found.distance_m(found.least_share(np.minimum(speeds, found.top_mps - 1e-6)), speeds)
    begin = found.distance_m(np.ones(speeds.size), speeds)
    every: Floats = np.linspace(float(found.speeds_mps[0]), float(found.speeds_mps[-1]), 600)
    outer = found.distance_m(np.zeros(every.size), every)
    figure = Figure(figsize=(9.0, 5.2), layout="constrained")
    axes = figure.subplots()
    axes.fill_betweenx(
        every * KMH_PER_MPS, 0.0, outer, color=RULE, lw=0, label="no law can: even the full brake overruns"
    )
    axes.fill_betweenx(
        speeds * KMH_PER_MPS,
        nearest,
        begin + BEYOND_M,
        color=HELD,
        lw=0,
        label=f"every brake stops in the window (from up to {BEYOND_M:.0f} m before braking)",
    )
    axes.plot(
        begin,
        speeds * KMH_PER_MPS,
        color=INK,
        lw=0.9,
        ls="--",
        label="where the law begins to brake, at the earliest",
    )
    axes.plot(
        missed[0],
        missed[1] * KMH_PER_MPS,
        ".",
        color=RED,
        ms=2.5,
        label="stops from just outside that missed it",
    )
    axes.axhline(found.top_mps * KMH_PER_MPS, color=PALE, lw=0.6)
    axes.annotate(
        f"{found.top_mps * KMH_PER_MPS:.0f} km/h",
        (2.0, found.top_mps * KMH_PER_MPS),
        va="bottom",
        fontsize=7.5,
        color=INK,
    )
    axes.set_xlim(0.0, float(begin.max()) + BEYOND_M)
    axes.set_ylim(0.0, float(every[-1]) * KMH_PER_MPS)
    axes.set_xlabel("distance to the mark, m")
    axes.set_ylabel("speed, km/h")
    axes.grid(visible=True)
    axes.set_title(
        f"Starts from which every brake of the stated range stops within {WINDOW_M:g} m of the mark"
    )
    axes.legend(loc="lower right")
    return figure


def write_set(found: StopSet, missed: tuple[Floats, Floats], folder: Path) -> tuple[Path, ...]:
    """Write the figure as SVG and PNG below `folder`, which is made; the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    with drawing():
        figure = draw_set(found, missed)
        paths = tuple(folder / f"{NAME}.{kind}" for kind in ("svg", "png"))
        figure.savefig(paths[0], metadata={"Date": None, "Creator": None})
        figure.savefig(paths[1], dpi=130, metadata={"Software": None})
    return paths
