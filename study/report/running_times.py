"""The picture of minimum running times: along the line, what is needed, and what each train is given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Final

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from network.model import Line
from study.measures.standard_times import PlannedRun, StandardTime
from study.report.style import DIRECTION_COLOUR, INK, PALE, RED, WIDTH_IN, drawing

PICTURE: Final = "running_times"
FILES: Final = frozenset({"running_times.csv", "margins.csv", f"{PICTURE}.png", f"{PICTURE}.svg"})
_NEED: Final = "#c9d6e4"


def draw_running_times(
    line: Line, times: Sequence[StandardTime], runs: Sequence[PlannedRun]
) -> Figure | None:
    """A panel a kind of train and direction: bars are needed from stand to stand, dots planned, red where too short.

    None where the line has no way from end to end. A run over several legs stands at the first of them.
    """
    panels = [(key, list(rows)) for key, rows in groupby(times, key=lambda t: (t.train, t.direction))]
    if not panels:
        return None
    figure = Figure(figsize=(WIDTH_IN, 3.6 * len(panels)), layout="constrained")
    for axes, ((train, direction), legs) in zip(
        figure.subplots(len(panels), 1, squeeze=False)[:, 0], panels, strict=True
    ):
        own = [run for run in runs if run.train == train and run.direction is direction]
        _draw_panel(axes, line, legs, own)
        axes.set_title(
            f"{train}, {direction.name.lower()}: minimum running times and what the timetable plans"
        )
    return figure


def _draw_panel(axes: Axes, line: Line, legs: Sequence[StandardTime], runs: Sequence[PlannedRun]) -> None:
    direction = legs[0].direction
    at = range(len(legs))
    needs_s = [leg.stop_stop_s if math.isfinite(leg.stop_stop_s) else 0.0 for leg in legs]
    axes.bar(at, needs_s, 0.62, color=_NEED, label="needed, from stand to stand")
    passing = False
    for i, leg in enumerate(legs):
        text = f"{leg.stop_stop_s:.0f}" if math.isfinite(leg.stop_stop_s) else "cannot be run"
        axes.annotate(
            text, (i, 0.0), xytext=(0, 2), textcoords="offset points", ha="center", fontsize=6.5, color=INK
        )
        if leg.pass_pass_s is not None and math.isfinite(leg.pass_pass_s):
            axes.plot(
                [i - 0.31, i + 0.31],
                [leg.pass_pass_s] * 2,
                color=PALE,
                lw=1.0,
                label=None if passing else "needed, passing both",
            )
            passing = True
    where = {(leg.from_id, leg.to_id): i for i, leg in enumerate(legs)}
    placed = [(where[run.from_id, run.to_id], run) for run in runs if (run.from_id, run.to_id) in where]
    for short, colour, label in (
        (False, DIRECTION_COLOUR[direction], "planned"),
        (True, RED, "planned, too short"),
    ):
        some = [
            (i, run.planned_s)
            for i, run in placed
            if (run.margin_s < 0.0) is short and math.isfinite(run.planned_s)
        ]
        if some:
            axes.plot(*zip(*some, strict=True), "o", ms=3, color=colour, zorder=3, label=label)
    names = [f"{line.stations[leg.from_id].name}\n{line.stations[leg.to_id].name}" for leg in legs]
    axes.set_xticks(list(at), names)
    axes.tick_params(axis="x", length=0, labelsize=6.5, labelrotation=0 if len(legs) <= 10 else 60)
    axes.set_xlim(-0.6, max(len(legs), 6) - 0.4)
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("running time, s")
    axes.grid(axis="y")
    axes.legend(loc="lower right", ncols=4, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)


def write_running_times(
    folder: Path, line: Line, times: Sequence[StandardTime], runs: Sequence[PlannedRun]
) -> None:
    """Make a folder with running_times.csv, margins.csv and the picture; OSError when it cannot be written."""
    folder.mkdir()
    tables = {"running_times": [t.as_dict() for t in times], "margins": [r.as_dict() for r in runs]}
    for name, rows in tables.items():
        pl.DataFrame(rows, infer_schema_length=None).write_csv(folder / f"{name}.csv")
    with drawing():
        figure = draw_running_times(line, times, runs)
        if figure is not None:
            figure.savefig(folder / f"{PICTURE}.png", dpi=150)
            figure.savefig(folder / f"{PICTURE}.svg", metadata={"Date": None})
