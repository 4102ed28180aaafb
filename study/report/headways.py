"""The pictures of headways: a matrix of trains by trains at each station, and what each headway is made of."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from network.model import Line
from study.capacity.headway import HeadwayCase
from study.capacity.occupation import OccupationCost
from study.report.style import INK, PALE, WIDTH_IN, can_write_japanese, drawing

PICTURES: Final = ("headway_matrix", "headway_parts")
FILES: Final = frozenset(
    {"headways.csv", *(f"{name}.{form}" for name in PICTURES for form in ("png", "svg"))}
)
COLUMNS: Final = (
    *("station", "kind", "kind_ja", "between", "first", "second", "least_s", "section"),
    *("first_train_s", "second_train_s", *(cost.column for cost in OccupationCost)),
    *("of", "pairs", "closest", "closest_s", "buffer_s"),
)
COST_COLOURS: Final = {
    OccupationCost.RADIO: "#0072b2",
    OccupationCost.POINTS: "#d55e00",
    OccupationCost.LOCALISATION: "#009e73",
    OccupationCost.RULE: "#56b4e9",
    OccupationCost.DRIVING: "#c9d6e4",
    OccupationCost.PEOPLE: "#e3c66b",
    OccupationCost.CHARGING: "#a0568a",
}


def kind_name(case: HeadwayCase) -> str:
    """The headway's name, in Japanese too where there is a font for it."""
    kind = case.headway.kind
    return f"{kind.value} {kind.english}" if can_write_japanese() else kind.english


def draw_matrix(line: Line, cases: Sequence[HeadwayCase]) -> Figure | None:
    """A panel a station: rows are first trains, columns second ones, a cell tells each headway between them, s."""
    stations = list(dict.fromkeys(case.station_id for case in cases))
    if not stations:
        return None
    kinds = {
        s: list(dict.fromkeys(k for c in cases if c.station_id == s for k in (c.first, c.second)))
        for s in stations
    }
    heights = [0.9 + 0.62 * len(kinds[s]) for s in stations]
    figure = Figure(figsize=(WIDTH_IN, sum(heights) + 0.3), layout="constrained")
    grid = figure.subplots(len(stations), 1, squeeze=False, height_ratios=heights)[:, 0]
    longest_s = max(1.0, *(case.headway.least_s for case in cases))  # all may be negative
    for axes, station_id in zip(grid, stations, strict=True):
        own = [case for case in cases if case.station_id == station_id]
        _draw_station(axes, kinds[station_id], own, longest_s)
        axes.set_title(f"{line.stations[station_id].name}: least headway, s (columns behind rows)")
    return figure


def _draw_station(axes: Axes, kinds: list[str], cases: Sequence[HeadwayCase], longest_s: float) -> None:
    count = len(kinds)
    shade = np.full((count, count), np.nan)
    texts: dict[tuple[int, int], list[str]] = {}
    for case in cases:
        at = kinds.index(case.first), kinds.index(case.second)
        shade[at] = np.nanmax([shade[at], case.headway.least_s])
        texts.setdefault(at, []).append(f"{kind_name(case)} {case.headway.least_s:.0f}")
    axes.imshow(shade, cmap="YlOrBr", vmin=0.0, vmax=1.4 * longest_s, aspect="auto")
    for (row, column), lines in texts.items():
        axes.text(column, row, "\n".join(lines), ha="center", va="center", fontsize=7.0, color=INK)
    axes.set_xticks(range(count), kinds)
    axes.set_yticks(range(count), kinds)
    axes.tick_params(length=0, labelsize=7.0)
    axes.set_xticks(np.arange(count + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(count + 1) - 0.5, minor=True)
    axes.grid(which="minor", color="white", lw=1.5)
    axes.tick_params(which="minor", length=0)


def draw_parts(line: Line, cases: Sequence[HeadwayCase]) -> Figure | None:
    """A bar a headway: what each cost has of it, s."""
    if not cases:
        return None
    ordered = list(reversed(cases))
    figure = Figure(figsize=(WIDTH_IN, 1.0 + 0.26 * len(cases)), layout="constrained")
    axes = figure.subplots()
    at = np.arange(len(ordered))
    for sign in (1.0, -1.0):
        left = np.zeros(len(ordered))
        for cost, colour in COST_COLOURS.items():
            lengths = np.array([max(sign * case.headway.costs_s[cost], 0.0) * sign for case in ordered])
            axes.barh(at, lengths, 0.7, left, color=colour, label=cost.value if sign > 0.0 else "_")
            left = left + lengths
    for i, case in enumerate(ordered):
        text = f" {case.headway.least_s:.1f} s, {case.headway.section_id}"
        axes.text(max(case.headway.least_s, 0.0), i, text, va="center", fontsize=6.5, color=INK)
    names = [f"{line.stations[c.station_id].name}, {kind_name(c)}: {c.first} / {c.second}" for c in ordered]
    axes.set_yticks(at, names)
    axes.tick_params(axis="y", length=0, labelsize=6.5)
    axes.axvline(0.0, color=PALE, lw=0.6)
    axes.set_ylim(-0.6, len(ordered) - 0.4)
    axes.set_xlim(right=1.18 * max(1.0, *(case.headway.least_s for case in cases)))
    axes.set_xlabel("least headway, s; the section that makes it so")
    axes.grid(axis="x")
    axes.legend(loc="lower right", ncols=6, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    return figure


def headway_table(cases: Sequence[HeadwayCase]) -> pl.DataFrame:
    """A row a headway; without any the names of columns alone."""
    return table_of([case.as_dict() for case in cases])


def table_of(rows: Sequence[dict[str, Any]]) -> pl.DataFrame:
    """Rows of headways; without any the names of columns alone."""
    return pl.DataFrame(rows, infer_schema_length=None) if rows else pl.DataFrame(schema=list(COLUMNS))


def write_headways(folder: Path, line: Line, cases: Sequence[HeadwayCase]) -> None:
    """Make a folder with headways.csv and the pictures; OSError when it cannot be written."""
    folder.mkdir()
    headway_table(cases).write_csv(folder / "headways.csv")
    with drawing():
        for name, figure in zip(PICTURES, (draw_matrix(line, cases), draw_parts(line, cases)), strict=True):
            save(figure, folder, name)


def save(figure: Figure | None, folder: Path, name: str) -> None:
    """A picture as PNG and SVG, if there is one; call within `drawing()`."""
    if figure is not None:
        figure.savefig(folder / f"{name}.png", dpi=150, metadata={"Software": None})
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None, "Creator": None})
