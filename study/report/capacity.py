"""The pictures of capacity: how full each part of a line is by the way it was cut, and what moves that most."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from study.capacity.equipment import BLOCKS, EquipmentFigures, LeverWorth
from study.capacity.line_capacity import Rate
from study.report.headways import COST_COLOURS, save
from study.report.style import INK, PALE, RED, WIDTH_IN, beside, drawing

PICTURE: Final = "occupation"
TORNADO: Final = "tornado"
FILES: Final = frozenset(
    {
        "occupation.csv",
        "equipment.csv",
        *(f"{n}.{form}" for n in (PICTURE, TORNADO) for form in ("png", "svg")),
    }
)
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
    fullest = max(rate.occupied_share for rates in panels.values() for rate in rates)
    # the axis of all panels, which share it; a label takes a fifth
    grid[-1].set_xlim(0.0, max(130.0, 130.0 * fullest))
    grid[-1].set_xlabel("occupancy time rate, %; the thin line is the limit recommended by UIC 406")
    return figure


def _draw_cut(axes: Axes, rates: Sequence[Rate]) -> None:
    parts = list(dict.fromkeys((rate.part.kind.value, rate.part.name) for rate in rates))
    beside = 0.19 if len({rate.period for rate in rates}) > 1 else 0.0
    for rate in rates:
        at = parts.index((rate.part.kind.value, rate.part.name))
        y = at + (beside if rate.period.peak else -beside)
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
    axes.grid(axis="x")


def draw_tornado(worth: Sequence[LeverWorth]) -> Figure | None:
    """A panel a figure: how far each parameter moves headways and occupancy, from its one end to the other."""
    panels: tuple[tuple[str, Callable[[EquipmentFigures], float]], ...] = (
        ("headway of a follower on the way down, s", lambda one: one.headway_s),
        (f"the same with {BLOCKS} virtual blocks a section, s", lambda one: one.block_headway_s),
        ("from an arrival to the opposing departure, s", lambda one: one.meet_s),
        ("occupancy of the day of the fullest part, %", lambda one: 100.0 * one.occupied_share),
    )
    shown = [panel for panel in panels if any(math.isfinite(panel[1](one.base)) for one in worth)]
    if not shown:
        return None
    rows = math.ceil(len(shown) / 2)
    figure = Figure(figsize=(WIDTH_IN, rows * (1.1 + 0.36 * len(worth))), layout="constrained")
    grid = figure.subplots(rows, 2, squeeze=False).flat
    for axes, (text, of) in zip(grid, shown, strict=False):
        _draw_swings(axes, worth, of)
        axes.set_xlabel(text)
    for axes in list(figure.axes)[len(shown) :]:
        axes.remove()
    colours = dict.fromkeys(one.cost for one in worth)
    handles = [Patch(color=COST_COLOURS[cost], label=cost.value) for cost in colours]
    figure.legend(handles=handles, loc="outside upper right", ncols=6)
    return figure


def _draw_swings(axes: Axes, worth: Sequence[LeverWorth], of: Callable[[EquipmentFigures], float]) -> None:
    """A bar a parameter, the widest on top, about the line of what is."""
    finite = [one for one in worth if math.isfinite(of(one.low_end)) and math.isfinite(of(one.high_end))]
    ordered = sorted(finite, key=lambda one: abs(of(one.high_end) - of(one.low_end)))
    base = of(worth[0].base)
    ends = [end for one in ordered for end in (of(one.low_end), of(one.high_end))]
    room = 0.45 * max(max(ends) - min(ends), 1e-6)
    for at, one in enumerate(ordered):
        low, high = of(one.low_end), of(one.high_end)
        axes.barh(at, high - low, 0.55, low, color=COST_COLOURS[one.cost])
        same = abs(high - low) < 0.05
        words = ((low, ""),) if same else ((low, one.low), (high, one.high))
        for value, word in words:
            leftmost = same or value == min(low, high)
            text = f"{value:.1f}" if same else f"{word}: {value:.1f}"
            beside(axes, text, (value, at), (-4 if leftmost else 4, 0), 6.5, color=INK)
    axes.axvline(base, color=INK, lw=0.8)
    axes.set_yticks(range(len(ordered)), [one.name for one in ordered])
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(min(ends) - room, max(ends) + room)
    axes.set_ylim(-0.6, len(ordered) - 0.4)
    axes.grid(axis="x")


def rates_table(by_cut: Mapping[str, Sequence[Rate]]) -> pl.DataFrame:
    """A row a part of each cut and period."""
    rows = [{"cut": name, **rate.as_dict()} for name, rates in by_cut.items() for rate in rates]
    return pl.DataFrame(rows, infer_schema_length=None)


def write_occupation(
    folder: Path, by_cut: Mapping[str, Sequence[Rate]], worth: Sequence[LeverWorth] | None = None
) -> None:
    """Make a folder with occupation.csv and the picture, equipment.csv and the tornado; OSError when it cannot be."""
    folder.mkdir()
    rates_table(by_cut).write_csv(folder / "occupation.csv")
    if worth is not None:
        table = pl.DataFrame([one.as_dict() for one in worth], infer_schema_length=None)
        table.write_csv(folder / "equipment.csv")
    with drawing():
        save(draw_occupation(by_cut), folder, PICTURE)
        save(None if worth is None else draw_tornado(worth), folder, TORNADO)
