"""The plot of `position-compare`: a row a sensor set, the error inside its band over the way, faults where they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.papers.position_sets import HIDDEN_M, SETS, TROUBLES, TUNNEL_M, Ran
from study.report.style import INK, PALE, RED, RULE, WIDTH_IN, drawing

NAME: Final = "position_compare"
BAND: Final = "#cfe2f1"
ROW_IN: Final = 1.45
FAULT: Final = "#fbe3c8"
LINEAR_M: Final = 1.0  # the scale is linear within so much of 0, and logarithmic beyond
LIMIT_M: Final = 1_000.0  # a train whose bounds are wider knows nothing
TICKS_M: Final = (-100.0, -10.0, -1.0, 0.0, 1.0, 10.0, 100.0)
PER_LINE: Final = 9


def numbers() -> Mapping[str, int]:
    """The number that stands for a fault in the plot."""
    return {trouble.name: number for number, trouble in enumerate((t for t in TROUBLES if t.held), start=1)}


def draw_comparison(runs: Sequence[Ran]) -> Figure:
    """Left what nothing disturbs, right everything that may fail, in turn; all of the same scale."""
    sets = [carried for carried in SETS if any(ran.carried is carried for ran in runs)]
    figure = Figure(figsize=(WIDTH_IN, 1.2 + ROW_IN * len(sets)), layout="constrained")
    grid = figure.subplots(len(sets), 2, sharex=True, sharey=True, squeeze=False)
    for carried, (left, right) in zip(sets, grid, strict=True):
        plain = next(ran for ran in runs if ran.carried is carried and not ran.troubles)
        troubled = next((ran for ran in runs if ran.carried is carried and len(ran.troubles) > 1), plain)
        for axes, ran in ((left, plain), (right, troubled)):
            _draw_run(axes, ran)
        left.set_ylabel(carried.name, rotation=0, ha="right", va="center", fontsize=8.5)
    grid[0][0].set_title("nothing fails")
    grid[0][1].set_title("faults, one after the other")
    for axes in grid[-1]:
        axes.set_xlabel("way from Karasuyama, km")
    handles, labels = grid[0][0].get_legend_handles_labels()
    words = [f"{number} {name}" for name, number in numbers().items()]
    lines = ["   ".join(words[first : first + PER_LINE]) for first in range(0, len(words), PER_LINE)]
    figure.legend(handles, labels, loc="outside upper right", ncols=4)
    figure.suptitle(
        "Error of the estimated position, and the bounds that must hold it, m (linear to 1 m, then by powers of ten)",
        x=0.01,
        ha="left",
        fontsize=9.5,
        color=INK,
    )
    figure.supxlabel(
        "\n".join(["faults, in force where the right side is shaded:", *lines]), fontsize=8.0, color=INK
    )
    return figure


def _draw_run(axes: Axes, ran: Ran) -> None:
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
            (trouble.from_m / 1e3, -LIMIT_M),
            fontsize=7.0,
            color=INK,
            xytext=(1.0, 2.0),
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
    axes.set_yscale("symlog", linthresh=LINEAR_M, linscale=0.8)
    axes.set_ylim(-LIMIT_M, LIMIT_M)
    axes.set_yticks(TICKS_M, [f"{tick:g}" for tick in TICKS_M])
    axes.minorticks_off()
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
