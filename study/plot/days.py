"""Pictures of a day by stock: why each waited (待ちの理由), and which trains it ran (運用)."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Final

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from study.measures.duties import SetDuty, duties_of
from study.measures.wait_text import text_of
from study.plot.choice import ChosenRun
from study.plot.words import plot_word
from study.record.as_run import trains_as_run
from study.record.figure import rows_in
from study.record.wait import NO_WAIT, Cause, Wait
from study.report.duty_graph import draw_duties as draw_duty_graph
from study.report.duty_graph import duty_rows
from study.report.style import (
    DIRECTION_COLOUR,
    RULE,
    WIDTH_IN,
    TimeBand,
    draw_clock_axis,
    time_bands,
)
from study.wording.catalogue import phrase

ROW_IN: Final = 0.34
NUMBER_PT: Final = 6.0
AXES_IN: Final = 12.0
# Ordinary stays are pale, what holds a train up stands out.
CAUSE_COLOURS: Final[Mapping[Cause, str]] = {
    Cause.DEPARTURE_TIME: "#d5dde5",
    Cause.DWELL: "#a9bccd",
    Cause.TURN_BACK: "#b9b4d6",
    Cause.NEXT_TRAIN: "#cfcbe4",
    Cause.NUMBER: "#9c8fc0",
    Cause.ENTRY: "#86c5b8",
    Cause.SIGN_OFF: "#b7d3a8",
    Cause.LEAVING: "#6f9a8d",
    Cause.STARTING: "#7f9db9",
    Cause.STABLED: "#ececec",
    Cause.STOP_LIMIT: "#f3c98b",
    Cause.ROUTE_HELD: "#d55e00",
    Cause.REFUSED: "#8c1d18",
    Cause.ANSWER: "#e6a700",
    Cause.COVERAGE: "#8c6d1f",
    Cause.SET_BACK: "#c48a9a",
    Cause.POINTS_MOVE: "#56b4e9",
    Cause.POINTS_REFUSED: "#0b5a8a",
    Cause.POINTS_PROOF: "#2f8fc4",
    Cause.POINTS_BY_EYE: "#173f5f",
    Cause.LEVEL_CROSSING: "#f06fa0",
    Cause.VEHICLE: "#a0568a",
    Cause.UNABLE: "#cc79a7",
    Cause.EMERGENCY: "#b3261e",
    Cause.CONTRADICTION: "#5c0f0b",
    Cause.ON_SIGHT: "#009e73",
    Cause.UNIT_OFF: "#222222",
    Cause.BY_HAND: "#6b5b95",
    Cause.UNIT_FROZEN: "#4b4b4b",
    Cause.ARRIVAL_BY_EYE: "#7fbf9f",
    Cause.QUEUE: "#e8b7a0",
    Cause.PORTAL: "#e08b6d",
    Cause.LATE: "#f2d9cc",
    Cause.NOT_ITS_TURN: "#f0845a",
    Cause.NO_WAY_ON: "#a63c06",
    Cause.OVERLAP: "#e377c2",
}


def waits_table(run: ChosenRun) -> pl.DataFrame:
    """The table of waits of the choice, with the sentence of each in the language chosen; running is left out."""
    rows = run.rows_in_window(run.chosen_rows(run.tables.waits), "from_s", "to_s").filter(
        pl.col("cause") != Cause.RUNS.value
    )
    if run.choice.station is not None:
        rows = rows.filter(pl.col("place") == run.choice.station)
    language = run.choice.language
    sentences = [text_of(wait, run.names).in_(language) for wait in rows_in(Wait, rows)]
    return rows.with_columns(pl.Series("sentence", sentences, dtype=pl.String))


def draw_waits(run: ChosenRun) -> Figure | None:
    """A row a stock, coloured by what it waited for; blank where it ran or was off the line. None: no row."""
    table = waits_table(run).filter(~pl.col("cause").is_in([cause.value for cause in NO_WAIT]))
    units = sorted(table["unit"].unique())
    if not units:
        return None
    bands, grid = time_bands(*run.window_s)
    figure = Figure(figsize=(WIDTH_IN, len(bands) * (ROW_IN * len(units) + 0.6) + 0.9), layout="constrained")
    least_s = (bands[0].to_s - bands[0].from_s) / (AXES_IN * 72.0) * 0.8
    for axes, band in zip(figure.subplots(len(bands), 1, squeeze=False)[:, 0], bands, strict=True):
        draw_clock_axis(axes, band, grid)
        _rows(axes, units)
        for wait in table.iter_rows(named=True):
            if band.meets(wait["from_s"], wait["to_s"]):
                low_s = max(wait["from_s"], band.from_s)
                high_s = min(max(wait["to_s"], wait["from_s"] + least_s), band.to_s)
                colour = CAUSE_COLOURS[Cause(wait["cause"])]
                axes.barh(
                    units.index(wait["unit"]), high_s - low_s, left=low_s, height=0.62, color=colour, lw=0
                )
        _numbers(axes, run, units, band)
    shown = [cause for cause in CAUSE_COLOURS if (table["cause"] == cause.value).any()]
    legend = [
        Patch(color=CAUSE_COLOURS[c], lw=0, label=phrase(c.value, "cause").in_(run.choice.language))
        for c in shown
    ]
    figure.legend(handles=legend, loc="outside lower left", ncols=9, handlelength=1.2)
    return figure


def _rows(axes: Axes, units: list[str]) -> None:
    axes.set_ylim(len(units) - 0.4, -0.6)
    axes.set_yticks(range(len(units)), units, fontsize=7)
    axes.tick_params(axis="y", length=0)
    axes.spines[:].set_color(RULE)
    for row in range(len(units)):
        axes.axhline(row + 0.5, color=RULE, lw=0.4, zorder=0.4)


def _numbers(axes: Axes, run: ChosenRun, units: list[str], band: TimeBand) -> None:
    """Train numbers above the part of the row in which the stock was that train, where they have room."""
    s_per_in = (band.to_s - band.from_s) / AXES_IN
    for (unit, train), course in run.courses.items():
        begin_s, end_s = float(course["t_s"][0]), float(course["t_s"][-1])
        if unit not in units or not band.meets(begin_s, end_s):
            continue
        low_s, high_s = max(begin_s, band.from_s), min(end_s, band.to_s)
        if (high_s - low_s) / s_per_in > len(train) * NUMBER_PT / 72.0 * 0.62:
            axes.text(
                (low_s + high_s) / 2, units.index(unit) - 0.34, train, ha="center", va="bottom", fontsize=NUMBER_PT,
                color=DIRECTION_COLOUR[run.directions[train]],
            )  # fmt: skip


def _duties(run: ChosenRun) -> tuple[SetDuty, ...]:
    return duties_of(run.line, run.timetable, trains_as_run(run.timetable, run.tables.stops))


def duties_table(run: ChosenRun) -> pl.DataFrame:
    """One row a train of each set as it ran, with what the set did before it."""
    return pl.DataFrame(duty_rows(_duties(run)), infer_schema_length=None)


def draw_duties(run: ChosenRun) -> Figure | None:
    """The duty graph of the day as it was, in the language chosen."""
    return draw_duty_graph(run.named_line, _duties(run), partial(plot_word, language=run.choice.language))
