"""The pictures of docs/studies: train graphs one under another, and what headways are longer by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from study.capacity.headway import HeadwayKind
from study.capacity.occupation import OccupationCost
from study.report.data import ReportedRun as Shown
from study.report.graph import draw_frame, numbers_of, write_numbers
from study.report.labels import laid_out
from study.report.style import (
    DIRECTION_COLOUR,
    PLAN_COLOUR,
    RED,
    UNIT_COLOURS,
    WIDTH_IN,
    TimeBand,
    TimeGrid,
    drawing,
)

DPI: Final = 110
SHORT_S: Final = 3600.0  # of less than that, minutes are told apart
FEW_MINUTES_S: Final = 1800.0  # of less than that, every other one is written
_PANEL_IN: Final = 3.4
_BAR: Final = 0.26
_LEAST_S: Final = 0.5  # what is longer by less in every case is left out of the picture


@dataclass(frozen=True, slots=True)
class HeadwayByCase:
    """One kind of headway in several cases, s."""

    station: str
    kind: HeadwayKind
    first: str
    second: str
    least_s: tuple[float, ...]
    costs_s: tuple[Mapping[OccupationCost, float], ...]


def train_graphs(
    file: Path,
    runs: Sequence[tuple[str, Shown]],
    window_s: tuple[float, float],
    shaded_s: tuple[float, float] | None = None,
    marks: Sequence[Mapping[str, tuple[float, float]]] = (),
    meanings: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """As run over the plan (dashed), one panel a run; `shaded_s` is a stretch of the day to be told apart.

    `marks`: for each run, signs at a time (s) and a place (m); `meanings`: what the first panel says of each sign.
    """
    lasts_s = window_s[1] - window_s[0]
    of_day, of_hour = TimeGrid(3600, 1800, 600), TimeGrid(600, 300, 60)
    of_minutes = TimeGrid(120, 60, 60)
    grid = of_minutes if lasts_s < FEW_MINUTES_S else of_hour if lasts_s < SHORT_S else of_day
    band = TimeBand(*window_s)
    with drawing():
        figure = Figure(figsize=(WIDTH_IN, _PANEL_IN * len(runs) + 0.2), layout="constrained")
        panels = figure.subplots(len(runs), 1, squeeze=False)[:, 0]
        shown = [run for _, run in runs]
        for axes, (what, _), run in zip(panels, runs, shown, strict=True):
            draw_frame(axes, run, band, grid)
            axes.set_title(what, pad=16)
            if shaded_s is not None:
                axes.axvspan(*shaded_s, color=RED, alpha=0.07, lw=0, zorder=0.2)
            for train in run.timetable.trains.values():
                t_s = [t for call in train.calls for t in (call.first_s, call.last_s)]
                at_m = np.repeat([run.line.stations[call.station_id].position_m for call in train.calls], 2)
                axes.plot(t_s, at_m, color=PLAN_COLOUR[train.direction], lw=0.6, ls=(0, (5, 3)), alpha=0.7)
            for (_, number), course in run.courses.items():
                axes.plot(
                    course["t_s"],
                    course["kilometrage_m"],
                    color=DIRECTION_COLOUR[run.directions[number]],
                    lw=1.8,
                )
        for axes, signs in zip(panels, marks, strict=False):
            for sign, (at_s, place_m) in signs.items():
                name = {"label": meanings[sign]} if sign in meanings and axes is panels[0] else {}
                axes.plot(at_s, place_m, sign, color=RED, ms=11, mew=1.6, fillstyle="none", **name)
        if meanings:
            panels[0].legend(loc="lower right", labelspacing=0.8, borderpad=0.7)
        laid_out(figure)
        for axes, run in zip(panels, shown, strict=True):
            write_numbers(axes, numbers_of(run, band))
        figure.savefig(file, dpi=DPI, metadata={"Software": None})


def headways(file: Path, pairs: Sequence[HeadwayByCase], names: Sequence[str]) -> None:
    """How much longer headways are in each case than as it is, s."""
    more_s = np.array([[s - pair.least_s[0] for s in pair.least_s[1:]] for pair in pairs])
    chosen: list[int] = np.flatnonzero((np.abs(more_s) >= _LEAST_S).any(axis=1)).tolist()
    with drawing():
        figure = Figure(figsize=(WIDTH_IN * 0.75, 0.42 * len(chosen) + 1.2), layout="constrained")
        axes = figure.subplots()
        rows = np.arange(len(chosen))
        for i, (name, colour) in enumerate(zip(names, UNIT_COLOURS, strict=False)):
            axes.barh(rows + (i - 1) * _BAR, more_s[chosen, i], _BAR, color=colour, label=name)
        axes.set_yticks(rows, [_label(pairs[i]) for i in chosen])
        axes.invert_yaxis()
        axes.set_xlabel("headway longer than as it is, s")
        axes.grid(axis="x")
        axes.legend(loc="lower right")
        figure.savefig(file, dpi=DPI, metadata={"Software": None})


def _label(pair: HeadwayByCase) -> str:
    return f"{pair.station}: {pair.first} / {pair.second}\n{pair.kind.english}, least {pair.least_s[0]:.0f} s"
