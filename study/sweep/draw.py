"""Pictures of a sweep: how a figure is spread over the days of each point, and what each axis does to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Picture
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from study.report.style import INK, PALE, RED, RULE, UNIT_COLOURS, WIDTH_IN
from study.sweep.figures import DayFigure
from study.sweep.statistics import FigureEstimate
from study.sweep.table import Effect, PointRow

ROW_IN: Final = 0.26
ROWS_MAX: Final = 60  # points that a picture shows; the tables have all
CURVES_MAX: Final = len(UNIT_COLOURS)  # more curves nobody tells apart
BINS: Final = 40
LABEL_MAX: Final = 70
BOX: Final = "#c9d6e2"
BLUE: Final = "#1f4e79"
WORSE: Final = "#d55e00"
BETTER: Final = "#009e73"


def draw_spread(rows: Sequence[PointRow], figure: DayFigure, confidence: float) -> Picture | None:
    """A row a point: quantiles of its days as a box, mean with its interval as a mark. None where no day has it."""
    shown = [row for row in rows if row.figures[figure.name].mean.value is not None][:ROWS_MAX]
    if not shown:
        return None
    picture = Picture(figsize=(WIDTH_IN, ROW_IN * len(shown) + 1.2), layout="constrained")
    axes = picture.subplots()
    for place, row in enumerate(shown):
        _box(axes, place, row, figure)
    axes.set_yticks(range(len(shown)), [_label(row.point.label) for row in shown])
    axes.set_ylim(len(shown) - 0.5, -0.5)
    axes.set_xlabel(figure.label)
    axes.grid(visible=True, axis="x")
    axes.tick_params(axis="y", length=0)
    handles = [
        Patch(facecolor=BOX, label="middle half of the days"),
        Line2D([], [], color=PALE, lw=1.0, label="5 % to 95 % of the days"),
        Line2D([], [], color=INK, lw=1.2, label="median"),
        Line2D([], [], color=RED, marker="D", ms=4, lw=1.6, label=f"mean, {confidence * 100:g} % interval"),
    ]
    picture.legend(handles=handles, loc="outside lower left", ncols=4)
    return picture


def draw_days(
    rows: Sequence[PointRow], values: Sequence[Sequence[float]], figure: DayFigure, confidence: float
) -> Picture | None:
    """Share of days with at most so much, a curve a point; one point alone as a histogram. None: too many, or none."""
    shown = [(row, days) for row, days in zip(rows, values, strict=True) if days]
    if not shown or len(shown) > CURVES_MAX:
        return None
    picture = Picture(figsize=(WIDTH_IN, 3.2), layout="constrained")
    axes = picture.subplots()
    if len(shown) == 1:
        _histogram(axes, *shown[0], figure, confidence)
        picture.legend(loc="outside lower left")
    else:
        for (row, days), colour in zip(shown, UNIT_COLOURS, strict=False):
            ordered = np.sort(np.asarray(days))
            shares = np.arange(1, len(ordered) + 1) / len(ordered)
            axes.step(ordered, shares, where="post", color=colour, lw=1.3, label=_label(row.point.label))
        axes.set_ylabel("share of days with at most so much")
        axes.set_ylim(0.0, 1.02)
        picture.legend(loc="outside right upper")
    axes.set_xlabel(figure.label)
    axes.grid(visible=True)
    return picture


def draw_tornado(found: Sequence[Effect], figure: DayFigure, confidence: float) -> Picture | None:
    """What each place of each axis does, the greatest first; the line across a bar's end is its interval."""
    known = [effect for effect in found if effect.less_first.value is not None]
    if not known:
        return None
    known = sorted(known, key=lambda effect: -abs(effect.less_first.value or 0.0))[:ROWS_MAX]
    picture = Picture(figsize=(WIDTH_IN, ROW_IN * len(known) + 1.2), layout="constrained")
    axes = picture.subplots()
    for place, effect in enumerate(known):
        value = effect.less_first.value or 0.0
        better = (value > 0.0) == figure.more_is_better
        sure = effect.less_first.apart_from_0
        axes.barh(place, value, height=0.62, color=(BETTER if better else WORSE) if sure else RULE)
        _interval(axes, place, effect.less_first, INK, 1.0)
    axes.axvline(0.0, color=INK, lw=0.8)
    axes.set_yticks(range(len(known)), [_label(f"{effect.axis}: {effect.place}") for effect in known])
    axes.set_ylim(len(known) - 0.5, -0.5)
    axes.set_xlabel(f"{figure.label}: less that of the axis's first place, the other axes taken together")
    axes.grid(visible=True, axis="x")
    axes.tick_params(axis="y", length=0)
    handles = [
        Patch(facecolor=WORSE, label="worse"),
        Patch(facecolor=BETTER, label="better"),
        Patch(facecolor=RULE, label="may be chance"),
        Line2D([], [], color=INK, lw=1.0, label=f"{confidence * 100:g} % interval"),
    ]
    picture.legend(handles=handles, loc="outside lower left", ncols=4)
    return picture


def _box(axes: Axes, place: int, row: PointRow, figure: DayFigure) -> None:
    found = row.figures[figure.name]
    low, quarter, middle, three, high = (
        found.quantiles[share].value or 0.0 for share in sorted(found.quantiles)
    )
    axes.plot([low, high], [place, place], color=PALE, lw=1.0, zorder=1)
    axes.barh(place, three - quarter, left=quarter, height=0.56, color=BOX, zorder=2)
    axes.plot([middle, middle], [place - 0.28, place + 0.28], color=INK, lw=1.2, zorder=3)
    _interval(axes, place, found.mean, RED, 1.6)
    axes.plot([found.mean.value or 0.0], [place], "D", color=RED, ms=4, zorder=5)


def _interval(axes: Axes, place: int, found: FigureEstimate, colour: str, width: float) -> None:
    if found.low is not None and found.high is not None:
        axes.plot([found.low, found.high], [place, place], color=colour, lw=width, zorder=4)


def _histogram(
    axes: Axes, row: PointRow, days: Sequence[float], figure: DayFigure, confidence: float
) -> None:
    found = row.figures[figure.name]
    axes.hist(days, bins=min(BINS, max(5, int(len(days) ** 0.5) * 2)), color=BOX, edgecolor="white", lw=0.5)
    if found.mean.low is not None and found.mean.high is not None:
        axes.axvspan(found.mean.low, found.mean.high, color=RED, alpha=0.18, lw=0)
    if found.mean.value is not None:
        label = f"mean, {confidence * 100:g} % interval shaded"
        axes.axvline(found.mean.value, color=RED, lw=1.4, label=label)
    for share in (0.05, 0.5, 0.95):
        value = found.quantiles[share].value
        if value is not None:
            axes.axvline(value, color=BLUE, lw=0.9, ls=(0, (4, 3)))
            axes.annotate(
                f"{share * 100:g} %",
                (value, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(2, -9),
                textcoords="offset points",
                color=BLUE,
            )
    axes.set_ylabel("days")


def _label(text: str) -> str:
    return text if len(text) <= LABEL_MAX else text[: LABEL_MAX - 1] + "…"
