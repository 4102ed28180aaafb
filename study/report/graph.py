"""The train graph (列車ダイヤ): time across, stations down at true distances, plan thin and truth thick."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import NDArray

from network.model import Station
from network.timetable import TimetableTrain
from study.record.marks import Mark
from study.report import style
from study.report.data import ReportedRun
from study.report.drill import draw_strip, falls_in_panel, mark_graph, mark_legend, strip_height_in
from study.report.labels import Box, Number, laid_out, place_numbers
from study.report.pictures import TRAIN_GRAPH, WAYS

Floats = NDArray[np.float64]

_PANEL_IN: Final = 3.7
_TURN_S_MAX: Final = 3 * 3600  # a set that stands longer than this is stabled, not turning round
_NUMBER_ROOM_SHARE: Final = 0.008  # a run seen for less of the panel than this carries no number
_NUMBER_PT: Final = 6.5
_CROSSING_GAP_MIN: Final = 0.025  # least distance of the names of level crossings, likewise
_LABEL_GAP_MIN: Final = 0.055  # least distance of station labels, share of the panel's height


def draw_train_graph(run: ReportedRun, marks: Sequence[Mark] = ()) -> tuple[Figure, dict[str, str]]:
    """The train graph in panels of at most 6.5 h, and a tip for the line of each train (see `svg_of`).

    The marks of a drill stand on the panels, and in a strip of rows under each.
    """
    bands, grid = style.time_bands(*run.window_s)
    shown = [[mark for mark in marks if falls_in_panel(mark, band)] for band in bands]
    heights_in = [h for part in shown for h in (_PANEL_IN, strip_height_in(part)) if h]
    figure = Figure(figsize=(style.WIDTH_IN, sum(heights_in) + 0.2), layout="constrained")
    panels = iter(figure.subplots(len(heights_in), 1, squeeze=False, height_ratios=heights_in)[:, 0])
    tips: dict[str, str] = {}
    graphs: list[Axes] = []
    for index, (band, part) in enumerate(zip(bands, shown, strict=True)):
        axes = next(panels)
        graphs.append(axes)
        draw_frame(axes, run, band, grid)
        mark_graph(axes, part, band, run.courses)
        if part:
            draw_strip(next(panels), part, band, grid)
        for train in run.timetable.trains.values():
            _draw_plan(axes, run, train, band)
        for (unit, number), course in run.courses.items():
            gid = f"run-{index}-{len(tips)}"
            if _draw_run(axes, run, number, course, band, gid):
                tips[gid] = f"{number}, unit {unit}"
        _draw_turns(axes, run, band)
    mark_legend(graphs[0], marks)
    laid_out(figure)  # numbers are placed on the screen
    for axes, band in zip(graphs, bands, strict=True):
        write_numbers(axes, numbers_of(run, band))
    return figure, tips


def draw_frame(axes: Axes, run: ReportedRun, band: style.TimeBand, grid: style.TimeGrid) -> None:
    """Axes with a line for every station; DOWN trains run downwards, as the Japanese graph is drawn."""
    style.draw_clock_axis(axes, band, grid)
    low_m, high_m = run.extent_m
    margin_m = max(0.03 * (high_m - low_m), 20.0)
    axes.set_ylim(high_m + margin_m, low_m - margin_m)
    for station in run.stations:
        axes.axhline(station.position_m, color=style.PALE, lw=0.4 if station.is_halt else 0.9, zorder=0.6)
    _draw_crossings(axes, run, _CROSSING_GAP_MIN * (high_m - low_m))
    labels_m = style.spread(
        [station.position_m for station in run.stations], _LABEL_GAP_MIN * (high_m - low_m)
    )
    axes.set_yticks([])
    for station, label_m in zip(run.stations, labels_m, strict=True):
        style.beside(
            axes,
            f"{station_label(station)}  {station.position_m / 1000:.1f} km",
            (0.0, label_m),
            (-4, 0),
            7.5,
            xycoords=("axes fraction", "data"),
            color="#666666" if station.is_halt else style.INK,
        )
    axes.spines[:].set_color(style.RULE)


def _draw_crossings(axes: Axes, run: ReportedRun, room_m: float) -> None:
    """A thin line at each level crossing, with its name where that has `room_m`."""
    layer, named_m = TRAIN_GRAPH.layers["crossing"], -np.inf
    for crossing in sorted(run.line.crossings.values(), key=lambda crossing: crossing.position_m):
        at_m = crossing.position_m
        axes.axhline(at_m, **layer.line(), zorder=0.6)
        if at_m - named_m >= room_m:
            where = ("axes fraction", "data")
            style.beside(axes, crossing.name, (1.0, at_m), (-2, 0), 5.0, xycoords=where, color=layer.colour)
            named_m = at_m


def station_label(station: Station, between: str = " ") -> str:
    """Romanised name, with the Japanese one where a font has it."""
    other = station.name_ja if station.name_ja != station.name else ""
    japanese = f"{between}{other}" if other and style.can_write_japanese() else ""
    return f"{station.name}{japanese}"


def _draw_plan(axes: Axes, run: ReportedRun, train: TimetableTrain, band: style.TimeBand) -> None:
    if not band.meets(train.calls[0].first_s, train.calls[-1].last_s):
        return
    t_s, at_m = _planned_course(run, train)
    line = TRAIN_GRAPH.layers[f"plan_{WAYS[train.direction]}"].line()
    if not train.revenue:
        line["ls"] = TRAIN_GRAPH.layers["empty"].line()["ls"]
    axes.plot(t_s, at_m, **line, zorder=3.5)


def _draw_run(
    axes: Axes, run: ReportedRun, number: str, course: pl.DataFrame, band: style.TimeBand, gid: str
) -> bool:
    """Draw what of the run falls in the panel; whether there was anything."""
    t_s, at_m = course["t_s"].to_numpy(), course["kilometrage_m"].to_numpy()
    if not band.meets(t_s[0], t_s[-1]):
        return False
    layer = TRAIN_GRAPH.layers[f"run_{WAYS[run.directions[number]]}"]
    axes.plot(t_s, at_m, **layer.line(), zorder=3, gid=gid)
    braked = course["intervention"].to_numpy() != 0
    began = np.flatnonzero(braked & ~np.concatenate(([False], braked[:-1])))
    style.dots(axes, t_s[began], at_m[began], "x", 5, style.RED, mew=1.2, zorder=4)
    return True


def _draw_turns(axes: Axes, run: ReportedRun, band: style.TimeBand) -> None:
    """Thin dotted links from a unit's train to its next one at the same place (折返し)."""
    last: dict[str, tuple[float, float]] = {}
    for (unit, _), course in run.courses.items():
        begins_s, begins_m = float(course["t_s"][0]), float(course["kilometrage_m"][0])
        ended_s, ended_m = last.get(unit, (-np.inf, np.inf))
        turns = 0 <= begins_s - ended_s < _TURN_S_MAX and abs(begins_m - ended_m) < 500
        if turns and band.meets(ended_s, begins_s):
            line = TRAIN_GRAPH.layers["turn"].line()
            axes.plot([ended_s, begins_s], [ended_m, begins_m], **line, zorder=2)
        last[unit] = float(course["t_s"][-1]), float(course["kilometrage_m"][-1])


def numbers_of(run: ReportedRun, band: style.TimeBand) -> list[Number]:
    """Each train's number beside its plan, or its run where it has no plan; none for what is hardly seen here."""
    numbers: list[Number] = []
    for number in run.trains:
        planned = run.timetable.trains.get(number)
        t_s, at_m = _planned_course(run, planned) if planned else _run_course(run, number)
        seen = [
            (max(t0, band.from_s), min(t1, band.to_s), t0, t1, y0, y1)
            for (t0, y0), (t1, y1) in pairwise(zip(t_s, at_m, strict=True))
            if y0 != y1 and band.meets(t0, t1)
        ]
        room_s = max((to_s - from_s for from_s, to_s, *_ in seen), default=0.0)
        if room_s <= _NUMBER_ROOM_SHARE * (band.to_s - band.from_s):
            continue
        corners = [
            (at_s, y0 + (y1 - y0) * (at_s - t0) / (t1 - t0))
            for from_s, to_s, t0, t1, y0, y1 in seen
            for at_s in (from_s, to_s)
        ]
        course = np.array(corners, dtype=np.float64)
        colour = style.DIRECTION_COLOUR[run.directions[number]]
        numbers.append(Number(number, colour, course[:, 0], course[:, 1]))
    return numbers


def write_numbers(axes: Axes, numbers: Sequence[Number]) -> None:
    """Write numbers beside their courses, on no other line of the panel where there is room; it must be laid out."""
    occupied = [
        _screen_box(text) for text in axes.texts if text.get_transform() is axes.get_xaxis_transform()
    ]
    courses = [np.asarray(line.get_xydata()) for line in axes.lines]
    lines = [course for course in courses if len(course) > 2]  # the others are the grid
    place_numbers(axes, numbers, lines, occupied, _NUMBER_PT)


def _screen_box(text: Text) -> Box:
    """Where a level text stands on the screen."""
    extent = text.get_window_extent()
    x, y = (extent.x0 + extent.x1) / 2, (extent.y0 + extent.y1) / 2
    return Box(x, y, extent.width / 2, extent.height / 2, 0.0)


def _planned_course(run: ReportedRun, train: TimetableTrain) -> tuple[Floats, Floats]:
    """Times (s) and kilometrages (m) of a train's calls as planned, two corners a call."""
    t_s = np.array([t for call in train.calls for t in (call.first_s, call.last_s)], dtype=np.float64)
    return t_s, np.repeat([run.line.stations[call.station_id].position_m for call in train.calls], 2)


def _run_course(run: ReportedRun, number: str) -> tuple[Floats, Floats]:
    """The same of a train without a plan, as it ran: its ends and where it stood."""
    course = next(course for (_, train), course in run.courses.items() if train == number)
    t_s, at_m = course["t_s"].to_numpy(), course["kilometrage_m"].to_numpy()
    still = course["speed_mps"].to_numpy() <= 0.0
    still[[0, -1]] = True
    return t_s[still], at_m[still]
