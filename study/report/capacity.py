"""The pictures of capacity: how full each part of a line is by the way it was cut, and what moves that most."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from study.capacity.line_capacity import Rate
from study.report.headways import save
from study.report.style import INK, PALE, RED, WIDTH_IN, drawing

PICTURE: Final = "occupation"
FILES: Final = frozenset({"occupation.csv", f"{PICTURE}.png", f"{PICTURE}.svg"})
_FULL, _OVER = "#3b6ea5", RED


def draw_occupation(by_cut: Mapping[str, Sequence[Rate]]) -> Figure | None:
    """A panel a way of cutting, a pair of bars a part: the day and the peak hour, with the limit as a line, %."""
    panels = {name: [rate for rate in rates if rate.trains] for name, rates in by_cut.items()}
    panels = {name: rates for name, rates in panels.items() if rates}
    if not panels:
        return None
    sizes = {name: len({rate.part.name for rate in rates}) for name, rates in panels.items()}
    heights = [0.9 + 0.36 * size for size in sizes.values()]
    figure = Figure(figsize=(WIDTH_IN, sum(heights)), layout="constrained")
    grid = figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights, sharex=True)[:, 0]
    for axes, (name, rates) in zip(grid, panels.items(), strict=True):
        _draw_cut(axes, rates)
        axes.set_title(f"cut: {name}")
    grid[-1].set_xlabel("occupancy time rate, %; the thin line is the limit recommended by UIC 406")
    return figure


def _draw_cut(axes: Axes, rates: Sequence[Rate]) -> None:
    parts = list(dict.fromkeys((rate.part.kind.value, rate.part.name) for rate in rates))
    for rate in rates:
        at = parts.index((rate.part.kind.value, rate.part.name))
        y = at + (0.19 if rate.period.peak else -0.19)
        over = rate.occupied_share > rate.limit_share
        percent = 100.0 * rate.occupied_share
        axes.barh(y, percent, 0.34, color=_OVER if over else _FULL, alpha=1.0 if rate.period.peak else 0.55)
        axes.plot([100.0 * rate.limit_share] * 2, [y - 0.19, y + 0.19], color=INK, lw=1.0)
        text = f" {rate.period.name}: {percent:.0f} %, {rate.trains} trains, {rate.compressed.section_id}"
        axes.text(max(percent, 100.0 * rate.limit_share) + 0.5, y, text, va="center", fontsize=6.5, color=INK)
    axes.set_yticks(range(len(parts)), [f"{name} ({kind})" for kind, name in parts])
    axes.tick_params(axis="y", length=0, labelsize=7.0)
    axes.set_ylim(len(parts) - 0.5, -0.5)
    axes.axvline(100.0, color=PALE, lw=0.6, ls=(0, (4, 3)))
    axes.set_xlim(0.0, max(130.0, 30.0 + max(100.0 * rate.occupied_share for rate in rates)))
    axes.grid(axis="x")


def write_occupation(folder: Path, by_cut: Mapping[str, Sequence[Rate]]) -> None:
    """Make a folder with occupation.csv and the picture; OSError when it cannot be written."""
    folder.mkdir()
    rows = [{"cut": name, **rate.as_dict()} for name, rates in by_cut.items() for rate in rates]
    pl.DataFrame(rows, infer_schema_length=None).write_csv(folder / "occupation.csv")
    with drawing():
        save(draw_occupation(by_cut), folder, PICTURE)
