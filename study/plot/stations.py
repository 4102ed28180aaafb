"""Pictures of a station's papers: track occupation (番線), station timetable (駅時刻表), punctuality (定時性)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from network.model import Direction, Station
from study.measures.missing import planned_times
from study.measures.punctuality import ALL_STATIONS, punctuality
from study.measures.station_papers import station_timetable, track_occupation
from study.plot.choice import ChosenRun
from study.report.style import (
    DIRECTION_COLOUR,
    INK,
    PALE,
    RED,
    RULE,
    WIDTH_IN,
    TimeBand,
    beside,
    centred,
    dots,
    draw_clock_axis,
    time_bands,
    unit_colours,
)
from study.wording.catalogue import phrase

ROW_IN: Final = 0.2
TALL_ROW_IN: Final = 0.85  # of one station alone: its train numbers stand upright in it
LABEL_PT: Final = 6.0
AXES_SHARE: Final = 0.86  # of the width, beside the names of the tracks
CELL_IN: Final = 0.42
LEAST_COLUMNS: Final = 6
LINE_MAX: Final = 14  # characters of a name beside which another stands
NOBODY: Final = "no train has come or left"
WHOLE_MINUTES: Final = "The plan is in whole minutes: less than one minute says little."


def occupation_table(run: ChosenRun) -> pl.DataFrame:
    """Track occupation of the choice, with the names of stations."""
    rows = track_occupation(run.tables.stops, run.line, run.timetable, run.tables.waits)
    if run.choice.train is not None:
        rows = rows.filter((pl.col("train") == run.choice.train) | (pl.col("next_train") == run.choice.train))
    if run.choice.station is not None:
        rows = rows.filter(pl.col("station") == run.choice.station)
    return run.rows_in_window(rows, "planned_from_s", "planned_to_s", "from_s", "to_s")


def draw_occupation(run: ChosenRun) -> Figure | None:
    """A row a track: planned as outlines, as run filled in the colour of the stock, with numbers. None: no row."""
    table = occupation_table(run)
    rows = [
        (station, track.name)
        for station in run.stations
        if run.choice.station in (None, station.id)
        for track in station.tracks
    ]
    if table.is_empty() or not rows:
        return None
    alone = run.choice.station is not None
    row_in = TALL_ROW_IN if alone else ROW_IN
    bands, grid = time_bands(*run.window_s)
    units = sorted(table["unit"].unique())
    colours = unit_colours(list(run.units))
    figure = Figure(figsize=(WIDTH_IN, len(bands) * (row_in * len(rows) + 0.55) + 0.75), layout="constrained")
    for axes, band in zip(figure.subplots(len(bands), 1, squeeze=False)[:, 0], bands, strict=True):
        draw_clock_axis(axes, band, grid)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_yticks(range(len(rows)), [_track_name(run, *row) for row in rows], fontsize=6.5)
        axes.tick_params(axis="y", length=0)
        axes.spines[:].set_color(RULE)
        for row in range(len(rows)):
            axes.axhline(row + 0.5, color=RULE, lw=0.4, zorder=0.4)
        places = {(station.id, track): row for row, (station, track) in enumerate(rows)}
        _draw_stays(axes, table, places, colours, band, numbers=alone)
    legend = [Patch(color=colours[unit], lw=0, label=unit) for unit in units[:12]]
    legend += [Patch(fc="none", ec=INK, lw=0.6, label="planned"), Patch(color=PALE, lw=0, label="as run")]
    figure.legend(handles=legend, loc="outside upper right", ncols=14, handlelength=1.2)
    return figure


def _track_name(run: ChosenRun, station: Station, track: str) -> str:
    name = run.name(station.id)
    return phrase("{name}, track {track}").fill(name=name, track=track).in_(run.choice.language)


def _draw_stays(
    axes: Axes,
    table: pl.DataFrame,
    places: dict[tuple[str, str], int],
    colours: dict[str, str],
    band: TimeBand,
    *,
    numbers: bool,
) -> None:
    """The stays that fall in a panel. A number stands where it hides no other."""
    last_in: dict[int, float] = {}
    span_s, width_in = band.to_s - band.from_s, WIDTH_IN * AXES_SHARE
    least_s = span_s / (width_in * 72.0) * 1.5  # a passing or a short stop is still to be seen
    for stay in table.iter_rows(named=True):
        row = places.get((stay["station"], stay["track"]))
        times_s = [
            stay[k] for k in ("from_s", "to_s", "planned_from_s", "planned_to_s") if stay[k] is not None
        ]
        if row is None or not times_s or not band.meets(min(times_s), max(times_s) + 1.0):
            continue
        centre_s = 0.0
        for kind, height in (("planned_", 0.84), ("", 0.5)):
            begin_s, end_s = stay[f"{kind}from_s"], stay[f"{kind}to_s"]
            known = [s for s in (begin_s, end_s) if s is not None]
            if not known:
                continue
            low_s, high_s = max(known[0], band.from_s), min(max(known[-1], known[0] + least_s), band.to_s)
            if high_s <= low_s:
                continue
            colour = colours[stay["unit"]]
            style: dict[str, Any] = (
                {"fc": "none", "ec": INK, "lw": 0.5} if kind else {"color": colour, "alpha": 0.75, "lw": 0}
            )
            axes.barh(row, high_s - low_s, left=low_s, height=height, zorder=3 if kind else 2, **style)
            centre_s = (low_s + high_s) / 2
        edge_s = LABEL_PT / 72.0 * span_s / width_in
        if numbers and band.from_s + edge_s < centre_s < band.to_s - edge_s:
            _number(axes, stay, row, centre_s, last_in, span_s / width_in)


def _number(
    axes: Axes, stay: dict[str, Any], row: int, centre_s: float, last_in: dict[int, float], s_per_in: float
) -> None:
    if centre_s / s_per_in - last_in.get(row, -9.0) < LABEL_PT / 72.0 * 1.25:
        return
    last_in[row] = centre_s / s_per_in
    train, following = stay["train"], stay["next_train"]
    centred(
        axes,
        centre_s,
        row,
        train if train == following else f"{train} → {following}",
        LABEL_PT,
        rotation=90,
        color=INK,
        zorder=5,
        bbox={"fc": "white", "ec": "none", "alpha": 0.7, "pad": 0.4},
        clip_on=True,
    )


def timetable_table(run: ChosenRun) -> pl.DataFrame:
    """Station timetable of the choice."""
    end_s = run.read.summary.get("latest_end_s") or math.inf
    rows = run.chosen_rows(station_timetable(run.tables.stops, run.line, run.timetable, end_s))
    return run.rows_in_window(rows, "planned_departure_s", "planned_arrival_s", "departure_s", "arrival_s")


def draw_timetable(run: ChosenRun) -> Figure | None:
    """The timetable of one station, a panel a direction: a row an hour, in it minutes, train, where to and lateness."""
    table = timetable_table(run)
    panels = [
        (direction, _by_hour(table.filter(pl.col("direction") == direction.name.lower())))
        for direction in Direction
    ]
    panels = [(direction, hours) for direction, hours in panels if hours]
    if not panels:
        return None
    most = max(LEAST_COLUMNS, *(len(calls) for _, hours in panels for calls in hours.values()))
    longest = max(len(hours) for _, hours in panels)
    size_in = (len(panels) * (CELL_IN * (most + 1) + 0.2), CELL_IN * longest + 0.75)
    figure = Figure(figsize=size_in, layout="constrained")
    for axes, (direction, hours) in zip(
        figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True
    ):
        _draw_hours(axes, run, direction, hours, (most, longest))
    return figure


def _by_hour(table: pl.DataFrame) -> dict[int, list[dict[str, Any]]]:
    """Calls by the hour of their planned departure, or arrival where they end."""
    hours: dict[int, list[dict[str, Any]]] = {}
    for row in table.iter_rows(named=True):
        due_s = (
            row["planned_departure_s"] if row["planned_departure_s"] is not None else row["planned_arrival_s"]
        )
        if due_s is not None:
            hours.setdefault(int(due_s // 3600), []).append(row | {"due_s": due_s})
    return {hour: hours.get(hour, []) for hour in range(min(hours), max(hours) + 1)} if hours else {}


def _draw_hours(
    axes: Axes,
    run: ChosenRun,
    direction: Direction,
    hours: dict[int, list[dict[str, Any]]],
    room: tuple[int, int],
) -> None:
    axes.set_xlim(-0.9, room[0])
    axes.set_ylim(room[1] - 0.5, -0.5)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.set_title(direction.name.lower(), color=DIRECTION_COLOUR[direction], pad=4)
    axes.spines[:].set_color(RULE)
    axes.axvline(-0.05, color=PALE, lw=0.6)
    for row, (hour, calls) in enumerate(hours.items()):
        axes.axhline(row + 0.5, color=RULE, lw=0.5)
        axes.text(-0.4, row, str(hour), ha="center", va="center", fontsize=10.5)
        for column, call in enumerate(calls):
            _draw_call(axes, run, column + 0.5, row, call)


def _draw_call(axes: Axes, run: ChosenRun, x: float, y: float, call: dict[str, Any]) -> None:
    minute, second = int(call["due_s"] // 60 % 60), int(call["due_s"] % 60)
    ends = call["planned_departure_s"] is None
    goes = phrase("arr.").in_(run.choice.language) if ends else _short(run.name(call["destination"]))
    if call["kind"] == "pass":
        goes = "レ"  # as Japanese timetables mark a train that runs through
    axes.text(x, y - 0.32, goes, ha="center", va="center", fontsize=5.0, color=PALE)
    text = f"{minute:02d}" + (f"·{second:02d}" if second else "")
    axes.text(x, y + 0.0, text, ha="center", va="center", fontsize=9.5 if not second else 7.5)
    came_s = call["arrival_s"] if ends else call["departure_s"]
    late_s = None if came_s is None else came_s - call["due_s"]
    number = call["train"] if call["revenue"] else f"({call['train']})"
    axes.text(x, y + 0.33, number, ha="center", va="center", fontsize=4.8, color=PALE)
    if late_s is None:
        axes.text(x + 0.33, y, "–", ha="center", va="center", fontsize=5.5, color=RED)
    elif abs(late_s) >= 60.0:
        minutes = f"{late_s / 60.0:+.0f}".replace("-", "−")
        axes.text(x + 0.34, y - 0.12, minutes, ha="center", va="center", fontsize=5.0, color=RED)


def _short(name: str) -> str:
    return name if len(name) <= 9 else f"{name[:8]}."


def punctuality_table(run: ChosenRun) -> pl.DataFrame:
    """Punctuality by station, of the choice."""
    end_s = run.read.summary.get("latest_end_s")
    times = run.rows_in_window(planned_times(run.tables.stops, run.timetable, end_s), "planned_s")
    if run.choice.train is not None:
        times = times.filter(pl.col("train") == run.choice.train)
    found = punctuality(times, run.line)
    return found if run.choice.station is None else found.filter(pl.col("station") == run.choice.station)


def draw_punctuality(run: ChosenRun) -> Figure | None:
    """Share on time by station, and lateness: mean, sigma, 95th percentile and worst with its train. None: no times."""
    table = punctuality_table(run)
    stations = [s.id for s in run.stations if s.id in set(table["station"])]
    if (table["station"] == ALL_STATIONS).any():
        stations.append(ALL_STATIONS)
    if not stations:
        return None
    figure = Figure(figsize=(WIDTH_IN, 5.8), layout="constrained")
    share, late = figure.subplots(2, 1, sharex=True, height_ratios=[1.0, 1.5])
    for what, aside, colour in (("arrival", -0.2, "#3b6ea5"), ("departure", 0.2, "#b4531a")):
        rows = {row["station"]: row for row in table.filter(pl.col("what") == what).to_dicts()}
        at = np.array([i for i, s in enumerate(stations) if s in rows]) + aside
        own = [rows[s] for s in stations if s in rows]
        if own:
            _draw_share(share, at, own, what, colour)
            _draw_lateness(late, at, own, colour)
    everywhere = phrase("all stations").in_(run.choice.language)
    labels = [everywhere if s == ALL_STATIONS else _in_lines(run.name(s)) for s in stations]
    late.set_xticks(range(len(stations)), labels, fontsize=7 if len(labels) < 16 else 6)
    if len(labels) > 16:
        late.tick_params(axis="x", labelrotation=60)
    late.tick_params(axis="x", length=0)
    late.set_xlim(-0.7, max(len(stations), 4) - 0.3)
    share.set_ylabel("share on time (less than 1 min late), %")
    late.set_ylabel("lateness, s")
    for axes in (share, late):
        axes.grid(axis="y")
        axes.spines[:].set_color(RULE)
    share.set_ylim(0.0, 112.0)
    share.legend(loc="lower right", ncols=2, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    legend: dict[str, Any] = {}
    for handle, label in zip(*late.get_legend_handles_labels(), strict=True):
        legend.setdefault(label, handle)  # arrivals come first
    if legend:
        late.legend(
            legend.values(), legend, loc="lower right", ncols=6, bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2
        )
    else:
        late.text(0.5, 0.5, NOBODY, transform=late.transAxes, fontsize=8, color=PALE, ha="center")
    if table["whole_minutes"].all():
        late.text(0.0, 1.02, WHOLE_MINUTES, transform=late.transAxes, fontsize=6.5, color=PALE, va="bottom")
    return figure


def _draw_share(axes: Axes, at: Any, rows: Sequence[dict[str, Any]], what: str, colour: str) -> None:  # noqa: ANN401 - positions
    values = [100.0 * row["on_time_share"] for row in rows]
    axes.bar(at, values, 0.38, color=colour, alpha=0.8, label=what)
    for x, value in zip(at, values, strict=True):
        axes.annotate(
            f"{value:.0f}", (x, value), xytext=(0, 1.5), textcoords="offset points", ha="center", fontsize=6
        )


def _draw_lateness(axes: Axes, at: Any, rows: Sequence[dict[str, Any]], colour: str) -> None:  # noqa: ANN401 - positions
    known = [(x, row) for x, row in zip(at, rows, strict=True) if row["mean_s"] is not None]
    if not known:
        return
    x = [x for x, _ in known]
    mean_s = [row["mean_s"] for _, row in known]
    sigma_s = [row["sigma_s"] or 0.0 for _, row in known]
    axes.errorbar(
        x,
        mean_s,
        sigma_s,
        fmt="o",
        ms=4,
        lw=1.2,
        capsize=2.5,
        color=colour,
        label="mean ± σ",
    )
    p95_s, worst_s = [row["p95_s"] for _, row in known], [row["worst_s"] for _, row in known]
    dots(axes, x, p95_s, "_", 11, colour, mew=1.6, label="95th percentile")
    dots(axes, x, worst_s, "x", 4.5, RED, label="worst")
    for at_x, row in known:
        beside(
            axes,
            row["worst_train"],
            (at_x, row["worst_s"]),
            (0, 4),
            5.0,
            rotation=90 if len(rows) > 10 else 0,
            color=RED,
        )
    axes.axhline(0.0, color=PALE, lw=0.6)
    axes.margins(y=0.18)


def _in_lines(name: str) -> str:
    lines = name.replace(" ", "\n").replace("-", "-\n", 1).split("\n") if len(name) > 9 else [name]
    return "\n".join(line if len(line) <= LINE_MAX else f"{line[: LINE_MAX - 1]}." for line in lines)
