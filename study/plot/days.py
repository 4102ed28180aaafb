"""Pictures of a day by stock: why each waited (待ちの理由), and which trains it ran (運用)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from network.model import Direction
from study.measures.wait import Cause
from study.measures.wait_text import text_of
from study.plot.choice import Seen
from study.plot.words import cause_name
from study.report.style import (
    DIRECTION_COLOUR,
    INK,
    PALE,
    RULE,
    WIDTH_IN,
    TimeBand,
    draw_clock_axis,
    time_bands,
)
from study.run.waits_table import read_waits

ROW_IN: Final = 0.34
NUMBER_PT: Final = 6.0
AXES_IN: Final = 12.0
# Ordinary stays are pale, what holds a train up stands out.
CAUSE_COLOURS: Final[Mapping[Cause, str]] = {
    Cause.DEPARTURE_TIME: "#d5dde5",
    Cause.DWELL: "#a9bccd",
    Cause.TURN_BACK: "#b9b4d6",
    Cause.NEXT_TRAIN: "#cfcbe4",
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
    Cause.VEHICLE: "#a0568a",
    Cause.EMERGENCY: "#b3261e",
    Cause.CONTRADICTION: "#5c0f0b",
    Cause.ON_SIGHT: "#009e73",
    Cause.UNIT_OFF: "#222222",
    Cause.UNIT_FROZEN: "#4b4b4b",
    Cause.ARRIVAL_BY_EYE: "#7fbf9f",
    Cause.QUEUE: "#e8b7a0",
    Cause.PORTAL: "#e08b6d",
}


def waits_table(run: Seen) -> pl.DataFrame:
    """The table of waits of the choice, with the sentence of each in the language chosen; running is left out."""
    rows = run.within(run.shown(run.tables.waits), "from_s", "to_s").filter(
        pl.col("cause") != Cause.RUNS.value
    )
    if run.choice.station is not None:
        rows = rows.filter(pl.col("place") == run.choice.station)
    language = run.choice.language
    sentences = [text_of(wait, language, run.names) for wait in read_waits(rows)]
    return rows.with_columns(pl.Series("sentence", sentences, dtype=pl.String))


def draw_waits(run: Seen) -> Figure | None:
    """A row a stock, coloured by what it waited for; blank where it ran or was off the line. None: no row."""
    table = waits_table(run).filter(pl.col("cause").is_in([cause.value for cause in CAUSE_COLOURS]))
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
    legend = [Patch(color=CAUSE_COLOURS[c], lw=0, label=cause_name(c, run.choice.language)) for c in shown]
    figure.legend(handles=legend, loc="outside lower left", ncols=9, handlelength=1.2)
    return figure


def _rows(axes: Axes, units: list[str]) -> None:
    axes.set_ylim(len(units) - 0.4, -0.6)
    axes.set_yticks(range(len(units)), units, fontsize=7)
    axes.tick_params(axis="y", length=0)
    axes.spines[:].set_color(RULE)
    for row in range(len(units)):
        axes.axhline(row + 0.5, color=RULE, lw=0.4, zorder=0.4)


def _numbers(axes: Axes, run: Seen, units: list[str], band: TimeBand) -> None:
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


def duties_table(run: Seen) -> pl.DataFrame:
    """One row a train of each stock, in its order: from, to, planned and as run."""
    stops = run.tables.stops
    ends = {
        (unit, train): (rows.row(0, named=True), rows.row(-1, named=True))
        for (unit, train), rows in stops.group_by("unit", "train", maintain_order=True)
    }
    rows: list[dict[str, object]] = []
    for diagram in run.timetable.diagrams:
        for order, number in enumerate(diagram.train_numbers, 1):
            train = run.timetable.trains[number]
            first, last = ends.get((diagram.stock_id, number), (None, None))
            rows.append(
                {
                    "unit": diagram.stock_id,
                    "order": order,
                    "train": number,
                    "revenue": train.revenue,
                    "direction": train.direction.name.lower(),
                    "from_station": train.calls[0].station_id,
                    "to_station": train.calls[-1].station_id,
                    "planned_from_s": float(train.calls[0].last_s),
                    "planned_to_s": float(train.calls[-1].first_s),
                    "from_s": None if first is None else first["departure_s"],
                    "to_s": None if last is None else last["arrival_s"],
                }
            )
    schema = {
        **dict.fromkeys(("unit", "train", "direction", "from_station", "to_station"), pl.String),
        **dict.fromkeys(("planned_from_s", "planned_to_s", "from_s", "to_s"), pl.Float64),
    }
    return run.within(
        run.shown(pl.DataFrame(rows, schema_overrides=schema)), "planned_from_s", "planned_to_s"
    )


def draw_duties(run: Seen) -> Figure | None:
    """A row a stock: a bar a train as planned, its number in it, the run as a thin line below; places at the ends."""
    table = duties_table(run)
    if table.is_empty():
        return None
    units = list(dict.fromkeys(table["unit"]))
    bands, grid = time_bands(*run.window_s)
    figure = Figure(figsize=(WIDTH_IN, len(bands) * (0.46 * len(units) + 0.6) + 0.6), layout="constrained")
    for axes, band in zip(figure.subplots(len(bands), 1, squeeze=False)[:, 0], bands, strict=True):
        draw_clock_axis(axes, band, grid)
        _rows(axes, units)
        s_per_pt = (band.to_s - band.from_s) / (AXES_IN * 72.0)
        for row in table.iter_rows(named=True):
            _draw_duty(axes, run, row, units.index(row["unit"]), band, s_per_pt)
    legend = [Patch(color=DIRECTION_COLOUR[d], alpha=0.35, lw=0, label=d.name.lower()) for d in Direction]
    legend.append(Patch(color=PALE, lw=0, label="as run"))
    figure.legend(handles=legend, loc="outside upper right", ncols=4, handlelength=1.2)
    return figure


def _draw_duty(
    axes: Axes, run: Seen, row: Mapping[str, object], y: int, band: TimeBand, s_per_pt: float
) -> None:
    low_s, high_s = float(str(row["planned_from_s"])), float(str(row["planned_to_s"]))
    if not band.meets(low_s, high_s):
        return
    train = str(row["train"])
    colour = DIRECTION_COLOUR[run.directions[train]]
    axes.barh(y, high_s - low_s, left=low_s, height=0.42, color=colour, alpha=0.35, lw=0, zorder=2)
    if row["from_s"] is not None and row["to_s"] is not None:
        ran_s = float(str(row["from_s"])), float(str(row["to_s"]))
        axes.hlines(y + 0.3, *ran_s, color=PALE, lw=1.6, zorder=2)
    seen_s = min(high_s, band.to_s) - max(low_s, band.from_s)
    number = train if row["revenue"] else f"({train})"
    middle_s = (max(low_s, band.from_s) + min(high_s, band.to_s)) / 2
    if seen_s / s_per_pt > len(number) * NUMBER_PT * 0.62:
        axes.text(middle_s, y, number, ha="center", va="center", fontsize=NUMBER_PT, color=INK, zorder=4)
    places = [run.name(str(row[key])) for key in ("from_station", "to_station")]
    if seen_s / s_per_pt > sum(map(_width_pt, places)) + 6.0:
        for place, at_s, side in zip(places, (low_s, high_s), ("left", "right"), strict=True):
            if band.from_s <= at_s <= band.to_s:
                axes.text(at_s, y - 0.23, place, ha=side, va="bottom", fontsize=5.0, color=PALE, zorder=4)


def _width_pt(text: str) -> float:
    """About how wide a text of 5 pt is: Japanese characters are twice as wide as others."""
    return sum(5.0 if ord(character) > 0x2E80 else 2.9 for character in text)
