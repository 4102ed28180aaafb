"""Two train graphs in one picture: the new run in colour where it moved, the other thin beneath it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from itertools import chain
from typing import Final

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from network.model import Direction
from study.compare.comparison import RunComparison
from study.compare.meets import MeetFate
from study.compare.side import ComparedRun
from study.report.data import ReportedRun
from study.report.graph import draw_frame, numbers_of, write_numbers
from study.report.labels import Number, laid_out
from study.report.pictures import TRAIN_GRAPH, WAYS, Layer
from study.report.style import INK, PALE, RED, WIDTH_IN, TimeBand, time_bands
from study.wording.phrase import NOTHING

BASE: Final = TRAIN_GRAPH.layers["beside"]
GONE: Final = TRAIN_GRAPH.layers["gone"]
UNMOVED: Final = Layer(NOTHING, "#a9b4bf", width_pt=1.0)
ADDED: Final = Layer(NOTHING, "#2e7d4f", opacity=0.75, width_pt=2.2)
_MOVED: Final[Mapping[int, Layer]] = {
    direction: TRAIN_GRAPH.layers[f"run_{way}"] for direction, way in WAYS.items()
}
_PANEL_IN: Final = 3.7


def draw_both(base: ComparedRun, new: ComparedRun, found: RunComparison) -> Figure:
    """Both runs in panels of at most 6.5 h. Trains that did not move are pale; meets that did are circled.

    The base run is the thin dashed line, the new one the thick line; a train of one run only is red (gone) or
    green (new).
    """
    old, late = base.run, new.run
    windows = [run.window_s for run in (old, late)]
    bands, grid = time_bands(min(w[0] for w in windows), max(w[1] for w in windows))
    figure = Figure(figsize=(WIDTH_IN, _PANEL_IN * len(bands) + 0.5), layout="constrained")
    graphs = figure.subplots(len(bands), 1, squeeze=False)[:, 0]
    moved = {moved.train for moved in found.times.moved} | {once.train for once in found.times.once}
    for axes, band in zip(graphs, bands, strict=True):
        draw_frame(axes, late, band, grid)
        _draw_base(axes, old, band, moved, found.times.only_base)
        _draw_new(axes, late, band, moved, found.times.only_new)
        _draw_meets(axes, found, band)
    _legend(figure, base.label, new.label)
    laid_out(figure)  # numbers are placed on the screen
    for axes, band in zip(graphs, bands, strict=True):
        write_numbers(axes, _numbers(old, late, band, moved, found))
    return figure


def _draw_base(
    axes: Axes, run: ReportedRun, band: TimeBand, moved: Collection[str], gone: Collection[str]
) -> None:
    for (_, number), course in run.courses.items():
        if number in gone:
            _draw(axes, course, band, GONE, 4.0)
        elif number in moved:
            _draw(axes, course, band, BASE, 4.0)


def _draw_new(
    axes: Axes, run: ReportedRun, band: TimeBand, moved: Collection[str], added: Collection[str]
) -> None:
    for (_, number), course in run.courses.items():
        if number in added:
            _draw(axes, course, band, ADDED, 3.2)
        elif number in moved:
            _draw(axes, course, band, _MOVED[run.directions[number]], 3.0)
        else:
            _draw(axes, course, band, UNMOVED, 2.5)


def _draw(axes: Axes, course: pl.DataFrame, band: TimeBand, layer: Layer, zorder: float) -> None:
    t_s, at_m = course["t_s"].to_numpy(), course["kilometrage_m"].to_numpy()
    if band.meets(float(t_s[0]), float(t_s[-1])):
        axes.plot(t_s, at_m, **layer.line(), zorder=zorder)


def _draw_meets(axes: Axes, found: RunComparison, band: TimeBand) -> None:
    """A ring where a meet is in the new run, an open square where one was and is no more."""
    for change in found.meets:
        meet = change.old if change.fate is MeetFate.GONE else change.new
        if meet is not None and band.from_s <= meet.time_s <= band.to_s:
            mark = "s" if change.fate is MeetFate.GONE else "o"
            axes.plot(
                [meet.time_s], [meet.position_m], marker=mark, ms=8, mfc="none", mec=RED, mew=1.1, zorder=4.5
            )


def _legend(figure: Figure, base: str, new: str) -> None:
    """What the lines are, above all panels."""

    def mark(shape: str) -> Line2D:
        return Line2D([], [], ls="", marker=shape, ms=7, mfc="none", mec=RED, mew=1.1)

    entries = [
        (Line2D([], [], **BASE.line()), f"{_short(base)}, trains that moved"),
        (Line2D([], [], **_MOVED[Direction.DOWN].line()), f"{_short(new)}, down"),
        (Line2D([], [], **_MOVED[Direction.UP].line()), "up"),
        (Line2D([], [], **UNMOVED.line()), "not moved"),
        (Line2D([], [], **GONE.line()), f"only in {_short(base)}"),
        (Line2D([], [], **ADDED.line()), f"only in {_short(new)}"),
        (mark("o"), "meet moved or new"),
        (mark("s"), "meet gone"),
    ]
    figure.legend(
        [handle for handle, _ in entries],
        [text for _, text in entries],
        loc="outside upper left",
        ncols=len(entries) // 2,
        labelcolor=INK,
        edgecolor=PALE,
    )


def _short(label: str, most: int = 40) -> str:
    return label if len(label) <= most else f"…{label[1 - most :]}"


def _numbers(
    old: ReportedRun, new: ReportedRun, band: TimeBand, moved: Collection[str], found: RunComparison
) -> list[Number]:
    """Numbers of the new run's trains, and of those that are gone; first of all those that moved or came."""
    gone = [n for n in numbers_of(old, band) if n.text in found.times.only_base]
    mine = numbers_of(new, band)
    first = {*moved, *found.times.only_new}
    ordered = chain((n for n in mine if n.text in first), gone, (n for n in mine if n.text not in first))
    colours = dict.fromkeys(found.times.only_base, GONE.colour) | dict.fromkeys(
        found.times.only_new, ADDED.colour
    )
    return [
        Number(n.text, colours.get(n.text, n.colour if n.text in moved else PALE), n.t_s, n.at_m)
        for n in ordered
    ]
