"""The picture of virtual blocks: traffic at one mean speed, and headway, by number of blocks; the paper's beside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.report.headways import save
from study.report.style import INK, PALE, UNIT_COLOURS, WIDTH_IN, drawing

NAME: Final = "virtual_blocks"


@dataclass(frozen=True, slots=True)
class BlocksDrawn:
    """A stretch by number of blocks: gain in traffic (%) and headway (s); `whole_s`: of routes had whole, one block."""

    name: str
    blocks: tuple[int, ...]
    gains_percent: tuple[float, ...]
    following_s: tuple[float, ...]
    whole_s: float


def draw_curves(curves: Sequence[BlocksDrawn]) -> Figure:
    """Left: more trains at today's speed, %. Right: headway of a follower, min. Both over blocks, on a log axis."""
    figure = Figure(figsize=(WIDTH_IN, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    counts = curves[0].blocks
    for curve, colour in zip(curves, UNIT_COLOURS, strict=False):
        left.plot(counts, curve.gains_percent, "o-", ms=4, lw=1.4, color=colour, label=curve.name)
        following = [headway_s / 60.0 for headway_s in curve.following_s]
        right.plot(counts, following, "o-", ms=4, lw=1.4, color=colour, label=f"{curve.name}, down")
        right.plot(
            [counts[0]], [curve.whole_s / 60.0], "x", ms=7, color=colour, label="as units do: route had whole"
        )
    left.axhline(40.0, color=INK, lw=1.0, ls=(0, (4, 3)))
    left.annotate(
        "published, moving blocks: 40 %", (counts[-1], 40.0), xytext=(0, 3), textcoords="offset points",
        ha="right", fontsize=7.5, color=INK,
    )  # fmt: skip
    left.axvline(5.0, color=PALE, lw=0.8, ls=(0, (2, 3)))
    left.annotate(
        "published: five give most", (5.0, 0.0), xytext=(4, 4), textcoords="offset points", fontsize=7.5
    )
    left.set_ylabel("more trains at the mean speed of one block, %")
    right.set_ylabel("headway from departure to departure, min")
    for axes in (left, right):
        _axis(axes, counts)
    left.set_ylim(bottom=0.0)
    right.set_ylim(bottom=0.0)
    left.legend(loc="upper left", fontsize=7.5)
    right.legend(loc="upper right", fontsize=7.5)
    return figure


def _axis(axes: Axes, counts: Sequence[int]) -> None:
    axes.set_xscale("log")
    axes.set_xticks(list(counts), [str(count) for count in counts])
    axes.minorticks_off()
    axes.set_xlabel("virtual blocks of each section between stations")
    axes.grid()


def write_curves(curves: Sequence[BlocksDrawn], folder: Path) -> tuple[Path, ...]:
    """Write the picture as PNG and SVG below a folder; the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    with drawing():
        save(draw_curves(curves), folder, NAME)
    return tuple(folder / f"{NAME}.{form}" for form in ("png", "svg"))
