"""A drill in the report: its faults, acts and expectations beside the train graph, numbered, and in tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, TypeAlias

import polars as pl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from study.record.marks import Mark, MarkKind
from study.report.style import (
    INK,
    PALE,
    RED,
    RULE,
    TimeBand,
    TimeGrid,
    centred,
    dots,
    draw_clock_axis,
    spread,
)

Courses: TypeAlias = Mapping[tuple[str, str], pl.DataFrame]  # by unit and train, as `Run.courses`
NO_COURSES: Final[Courses] = {}
PLACE: Final = "fault-place"
PLACE_ALPHA: Final = 0.3
ROW_IN: Final = 0.17
MET: Final = "#2e7d4f"
_TEXT_MAX: Final = 46
_TAG_GAP_SHARE: Final = 0.02  # least distance of the numbers on the graph, share of the panel's width


def shows(mark: Mark, band: TimeBand) -> bool:
    """Whether any of a mark falls in the panel."""
    if band.meets(mark.from_s, mark.to_s):
        return True
    at_s = mark.from_s if mark.at_s is None else mark.at_s
    return band.from_s <= at_s <= band.to_s


def strip_height_in(marks: Sequence[Mark]) -> float:
    """Height of the strip for these marks."""
    return ROW_IN * len(marks)


def mark_graph(axes: Axes, marks: Sequence[Mark], band: TimeBand, courses: Courses = NO_COURSES) -> None:
    """On a panel of the train graph: faults as pale bands with their places, acts as lines, numbers at the top."""
    shown = sorted((m for m in marks if m.kind is not MarkKind.EXPECTATION), key=lambda m: m.from_s)
    for mark in shown:
        if mark.kind is MarkKind.FAULT:
            axes.axvspan(mark.from_s, mark.to_s, color=RED, alpha=0.07, lw=0, zorder=0.4)
            axes.axvline(mark.from_s, color=RED, lw=0.7, alpha=0.7, zorder=0.55)
            _mark_place(axes, mark, courses)
        else:
            axes.axvline(mark.from_s, color=INK, lw=0.8, ls=(0, (2, 2)), zorder=0.55)
    width_s = band.to_s - band.from_s
    margin_s = _TAG_GAP_SHARE / 2 * width_s
    places = [min(max(mark.from_s, band.from_s + margin_s), band.to_s - margin_s) for mark in shown]
    for mark, at_s in zip(shown, spread(places, _TAG_GAP_SHARE * width_s), strict=True):
        centred(
            axes,
            at_s,
            0.99,
            mark.label,
            7,
            transform=axes.get_xaxis_transform(),
            va="top",
            color=RED if mark.kind is MarkKind.FAULT else INK,
            zorder=6,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6},
        )


def _mark_place(axes: Axes, mark: Mark, courses: Courses) -> None:
    """Where a fault is while it lasts: a stretch of line as a box, a train as a broad band along its run."""
    for low_m, high_m in mark.where.stretches_m:
        box = Rectangle((mark.from_s, low_m), mark.to_s - mark.from_s, high_m - low_m, alpha=PLACE_ALPHA)
        box.set(facecolor=RED, edgecolor="none", zorder=0.5, gid=PLACE)
        axes.add_patch(box)
    for (unit, _), course in courses.items():
        if unit in mark.where.units:
            ran = course.filter(pl.col("t_s").is_between(mark.from_s, mark.to_s))
            t_s, at_m = ran["t_s"].to_numpy(), ran["kilometrage_m"].to_numpy()
            axes.plot(t_s, at_m, color=RED, alpha=PLACE_ALPHA, lw=7.0, zorder=2.5, gid=PLACE)


def mark_legend(axes: Axes, marks: Sequence[Mark]) -> None:
    """What the bands, boxes and lines of a drill mean; nothing without marks."""
    faults = [mark for mark in marks if mark.kind is MarkKind.FAULT]
    signs: list[Artist] = []
    if faults:
        signs.append(Patch(color=RED, alpha=0.07, label="while a fault lasts"))
    if any(mark.where.stretches_m for mark in faults):
        signs.append(Patch(color=RED, alpha=PLACE_ALPHA, label="its stretch of the line"))
    if any(mark.where.units for mark in faults):
        signs.append(Line2D([], [], color=RED, alpha=PLACE_ALPHA, lw=7.0, label="the train that has it"))
    if any(mark.kind is MarkKind.ACT for mark in marks):
        signs.append(Line2D([], [], color=INK, lw=0.8, ls=(0, (2, 2)), label="a person acts"))
    if signs:
        axes.legend(handles=signs, loc="lower left", bbox_to_anchor=(0.0, 1.06), ncols=4, borderaxespad=0.0)


def draw_strip(axes: Axes, marks: Sequence[Mark], band: TimeBand, grid: TimeGrid) -> None:
    """Under a panel: a row a fault, act or expectation, on the panel's clock."""
    draw_clock_axis(axes, band, grid)
    axes.tick_params(axis="x", labeltop=False, labelbottom=False)
    axes.set_ylim(len(marks) - 0.5, -0.5)
    axes.set_yticks(range(len(marks)), [f"{m.label}  {shortened(m.text)}" for m in marks], fontsize=7)
    axes.tick_params(axis="y", length=0)
    for row, (mark, label) in enumerate(zip(marks, axes.get_yticklabels(), strict=True)):
        axes.axhline(row + 0.5, color=RULE, lw=0.4, zorder=0.4)
        if mark.kind is MarkKind.EXPECTATION:
            label.set_color(INK if mark.passed else RED)
            _draw_expectation(axes, row, mark, band)
        elif mark.kind is MarkKind.FAULT and mark.to_s > mark.from_s:
            axes.barh(row, mark.to_s - mark.from_s, left=mark.from_s, height=0.5, color=RED, alpha=0.55, lw=0)
        else:
            colour = RED if mark.kind is MarkKind.FAULT else INK
            dots(axes, [mark.from_s], [row], "D", 4, colour, mew=0, clip_on=False)
    axes.spines[:].set_color(RULE)


def _draw_expectation(axes: Axes, row: int, mark: Mark, band: TimeBand) -> None:
    """The stretch judged, pale, and a dot where it was met or a cross where it was not."""
    from_s, to_s = max(mark.from_s, band.from_s), min(mark.to_s, band.to_s)
    if to_s > from_s:
        axes.barh(row, to_s - from_s, left=from_s, height=0.22, color=PALE, alpha=0.45, lw=0)
    at_s = mark.to_s if mark.at_s is None else mark.at_s
    if band.from_s <= at_s <= band.to_s:
        style, colour = ("o", MET) if mark.passed else ("X", RED)
        size = 4.5 if mark.passed else 6
        dots(axes, [at_s], [row], style, size, colour, mew=0, clip_on=False, zorder=4)


def shortened(text: str) -> str:
    """At most so many characters that stations' names beside the graph keep their room."""
    return text if len(text) <= _TEXT_MAX else text[: _TEXT_MAX - 1].rstrip() + "…"
