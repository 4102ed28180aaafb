"""The plot of `position-compare`: a row a sensor set, the error inside its band over the way, faults where they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.papers.position_sets import HIDDEN_M, SETS, TROUBLES, TUNNEL_M, Ran
from study.report.style import INK, PALE, RED, RULE, WIDTH_IN, drawing

NAME: Final = "position_compare"
BAND: Final = "#cfe2f1"
ROW_IN: Final = 1.45
FAULT: Final = "#fbe3c8"
HEADROOM: Final = 1.35
SHARE_SHOWN: Final = 96.0  # percentile of the half width that a row shows; what is wider goes off its top
LEAST_M: Final = 5.0


def numbers() -> Mapping[str, int]:
    """The number that stands for a fault in the plot."""
    return {trouble.name: number for number, trouble in enumerate((t for t in TROUBLES if t.held), start=1)}


def draw_comparison(runs: Sequence[Ran]) -> Figure:
    """Left what nothing disturbs, right everything that may fail, in turn; both of the same scale in a row."""
    sets = [carried for carried in SETS if any(ran.carried is carried for ran in runs)]
    figure = Figure(figsize=(WIDTH_IN, 1.2 + ROW_IN * len(sets)), layout="constrained")
    grid = figure.subplots(len(sets), 2, sharex=True, sharey="row", squeeze=False)
    for carried, (left, right) in zip(sets, grid, strict=True):
        plain = next(ran for ran in runs if ran.carried is carried and not ran.troubles)
        troubled = next((ran for ran in runs if ran.carried is carried and len(ran.troubles) > 1), plain)
        limit_m = max(LEAST_M, *(_limit_m(ran) for ran in (plain, troubled)))
        for axes, ran in ((left, plain), (right, troubled)):
            _draw_run(axes, ran, limit_m)
        left.set_ylabel(carried.name, rotation=0, ha="right", va="center", fontsize=8.5)
    grid[0][0].set_title("nothing fails")
    grid[0][1].set_title("faults, one after the other")
    for axes in grid[-1]:
        axes.set_xlabel("way from Karasuyama, km")
    handles, labels = grid[0][0].get_legend_handles_labels()
    words = "   ".join(f"{number} {name}" for name, number in numbers().items())
    figure.legend(handles, labels, loc="outside upper right", ncols=4)
    figure.suptitle(
        "Error of the estimated position, and the bounds that must hold it, m (scales differ from row to row)",
        x=0.01,
        ha="left",
        fontsize=9.5,
        color=INK,
    )
    figure.supxlabel(f"faults, in force where the right side is shaded: {words}", fontsize=7.5, color=INK)
    return figure


def _limit_m(ran: Ran) -> float:
    trace = ran.result.trace
    widest_m = np.maximum(trace["bound_ahead_m"], trace["bound_behind_m"])
    moves = trace["speed_mps"] > 0.0
    return float(np.percentile(widest_m[moves], SHARE_SHOWN)) * HEADROOM


def _draw_run(axes: Axes, ran: Ran, limit_m: float) -> None:
    trace = ran.result.trace
    km = trace["position_m"] / 1e3
    axes.axvspan(TUNNEL_M[0] / 1e3, TUNNEL_M[1] / 1e3, ymin=0.95, color=PALE, lw=0, label="tunnel")
    for number, (from_m, to_m) in enumerate(HIDDEN_M):
        label = "part of the sky hidden" if number == 0 else None
        axes.axvspan(from_m / 1e3, to_m / 1e3, ymin=0.95, color=RULE, lw=0, label=label)
    for trouble in ran.troubles:
        axes.axvspan(trouble.from_m / 1e3, max(trouble.to_m, trouble.from_m + 60.0) / 1e3, color=FAULT, lw=0)
        axes.annotate(
            str(numbers()[trouble.name]),
            (trouble.from_m / 1e3, -0.93 * limit_m),
            fontsize=7.0,
            color=INK,
            xytext=(1.0, 0.0),
            textcoords="offset points",
        )
    axes.fill_between(
        km,
        -trace["bound_ahead_m"],
        trace["bound_behind_m"],
        color=BAND,
        lw=0,
        label="bounds: the error lies in here",
    )
    axes.plot(km, trace["estimate_error_m"], color=RED, lw=0.9, label="error")
    axes.axhline(0.0, color=PALE, lw=0.4)
    axes.set_ylim(-limit_m, limit_m)
    axes.set_xlim(0.0, 21.4)
    axes.grid(visible=True, axis="y")


def write_comparison(runs: Sequence[Ran], folder: Path) -> tuple[Path, ...]:
    """Write the figure as SVG and PNG below `folder`, which is made; the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    with drawing():
        figure = draw_comparison(runs)
        files = tuple(folder / f"{NAME}.{ending}" for ending in ("svg", "png"))
        figure.savefig(files[0], metadata={"Date": None, "Creator": None})
        figure.savefig(files[1], dpi=130, metadata={"Software": None})
    return files
