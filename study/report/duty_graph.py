"""The duty graph (運用図): a row for each set, a bar for each train, and what the set does between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from network.model import Direction, Line
from study.measures.duties import DutyGap, DutyTrain, GapKind, SetDuty
from study.report.labels import laid_out
from study.report.style import (
    DIRECTION_COLOUR,
    INK,
    PALE,
    RULE,
    WIDTH_IN,
    TimeBand,
    TimeGrid,
    can_write_japanese,
    centred,
    clock,
    draw_clock_axis,
    drawing,
    time_bands,
)

PICTURE: Final = "duties"
FILES: Final = frozenset({f"{PICTURE}.csv", f"{PICTURE}.png", f"{PICTURE}.svg"})
_ROW_IN: Final = 0.62
_FRAME_IN: Final = 0.75  # clock labels above and below a panel
_BAR: Final = (-0.30, 0.0)  # of a row of height 1 about its middle, downwards
_UNDER: Final = (0.13, 0.33)  # where names of places stand under the bars: the first that is free
_OVER: Final = -0.41  # a number that its bar has no room for
_TEXT_PT: Final = 6.0
_GAP_PT: Final = 2.0
_STUB_SHARE: Final = 0.008  # of a panel: what is drawn of the time before the first and after the last train
_KEY: Final = (
    "Duties: trains down blue, up brown, empty ones white inside; place and minutes between them;"
    " ■ stabled, » beyond the line"
)
_KEY_AS_RUN: Final = f"{_KEY}; black: as planned"
Align = Literal["left", "center", "right"]
_COLOUR: Final = {"down": DIRECTION_COLOUR[Direction.DOWN], "up": DIRECTION_COLOUR[Direction.UP]}


@dataclass(slots=True)
class _Row:
    """Texts that stand in one row already, by level: spans on the screen, px."""

    taken: dict[float, list[tuple[float, float]]] = field(
        default_factory=dict[float, list[tuple[float, float]]]
    )

    def free(self, level: float, low: float, high: float) -> bool:
        """Whether nothing stands there."""
        return all(
            high < other_low or low > other_high for other_low, other_high in self.taken.get(level, ())
        )


def draw_duties(line: Line, duties: Sequence[SetDuty], say: Callable[[str], str] = str) -> Figure | None:
    """The graph in panels of some hours; None where no set runs a train.

    A bar is a train in the colour of its direction, white inside where it runs empty; between bars stand the place
    where the set is and for how many minutes. A thin line: it stands; dots: it is beyond a portal. As run, a bar has
    the plan as a line along its top. `say` puts its key and what stands beside a row into a language.
    """
    times = [
        time_s
        for duty in duties
        for train in duty.trains
        for time_s in (train.begins_s, train.ends_s, train.planned_begins_s, train.planned_ends_s)
    ]
    if not times:
        return None
    bands, grid = time_bands(min(times), max(times))
    height_in = len(bands) * (len(duties) * _ROW_IN + _FRAME_IN)
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    panels = figure.subplots(len(bands), 1, squeeze=False)[:, 0]
    for axes, band in zip(panels, bands, strict=True):
        _frame(axes, [say(_sum(duty)) for duty in duties], band, grid)
        for i, duty in enumerate(duties):
            for train in duty.trains:
                _draw_train(axes, i, train)
            for gap in duty.gaps:
                _draw_gap(axes, i, gap, band)
    planned = all(t.late_s is None and not t.cut_short for d in duties for t in d.trains)
    panels[0].set_title(say(_KEY if planned else _KEY_AS_RUN), pad=18)
    laid_out(figure)  # texts are placed on the screen
    for axes, band in zip(panels, bands, strict=True):
        for i, duty in enumerate(duties):
            _write_row(axes, i, duty, line, band)
    return figure


def _frame(axes: Axes, rows: Sequence[str], band: TimeBand, grid: TimeGrid) -> None:
    draw_clock_axis(axes, band, grid)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_yticks(range(len(rows)), rows)
    axes.tick_params(axis="y", length=0, labelsize=7.0)
    for i in range(1, len(rows)):
        axes.axhline(i - 0.5, color=RULE, lw=0.5, zorder=0.6)
    axes.spines[:].set_color(RULE)


def _sum(duty: SetDuty) -> str:
    """What stands beside a row."""
    turn = "" if duty.turn_min_s is None else f", least turn {_minutes(duty.turn_min_s)} min"
    trains = f"{len(duty.trains)} train{'' if len(duty.trains) == 1 else 's'}"
    return f"{duty.stock_id}\n{trains}, {duty.distance_m / 1000:.1f} km\n{duty.on_duty_s / 3600:.1f} h{turn}"


def _minutes(time_s: int) -> str:
    return f"{time_s / 60:.0f}" if time_s % 60 == 0 else f"{time_s / 60:.1f}"


def _draw_train(axes: Axes, row: int, train: DutyTrain) -> None:
    colour = _COLOUR[train.direction]
    top, bottom = _BAR
    axes.add_patch(
        Rectangle(
            (train.begins_s, row + top),
            train.ends_s - train.begins_s,
            bottom - top,
            facecolor=colour if train.revenue else "white",
            edgecolor=colour,
            lw=0.8,
            zorder=3,
        )
    )
    if train.late_s is not None or train.cut_short:
        axes.plot(
            [train.planned_begins_s, train.planned_ends_s], [row + top] * 2, color=INK, lw=1.6, zorder=4
        )


def _draw_gap(axes: Axes, row: int, gap: DutyGap, band: TimeBand) -> None:
    middle = row + sum(_BAR) / 2
    style = ":" if gap.kind == GapKind.OUTSIDE.value else "-"
    if gap.from_s is not None and gap.to_s is not None:
        axes.plot([gap.from_s, gap.to_s], [middle] * 2, color=PALE, lw=1.0, ls=style, zorder=2)
        return
    stub_s = (band.to_s - band.from_s) * _STUB_SHARE
    inside_s = gap.to_s if gap.to_s is not None else gap.from_s or 0
    ends = [inside_s, inside_s + (stub_s if gap.to_s is None else -stub_s)]
    axes.plot(ends, [middle] * 2, color=PALE, lw=1.0, ls=style, zorder=2)


def _write_row(axes: Axes, row: int, duty: SetDuty, line: Line, band: TimeBand) -> None:
    """Numbers in their bars (or over them), then places under the gaps: the longest first, none over another."""
    used = _Row()
    top, bottom = _BAR
    for train in duty.trains:
        low_s, high_s = max(train.begins_s, band.from_s), min(train.ends_s, band.to_s)
        if high_s <= low_s:
            continue
        inside = "white" if train.revenue else _COLOUR[train.direction]
        text = _text(axes, (low_s + high_s) / 2, row + (top + bottom) / 2, train.number, inside)
        low, high = _span(text)
        room = axes.transData.transform([(low_s, 0.0), (high_s, 0.0)])[:, 0]
        if high - low > room[1] - room[0] - _GAP_PT:
            text.set_y(row + _OVER)
            text.set_color(_COLOUR[train.direction])
            _keep_inside(axes, text)
            low, high = _span(text)
            if not used.free(_OVER, low, high):
                text.remove()
                continue
            used.taken.setdefault(_OVER, []).append((low, high))
    gaps = sorted(duty.gaps, key=lambda gap: -(gap.length_s if gap.length_s is not None else 10**9))
    for gap in gaps:
        _write_gap(axes, row, gap, line, band, used)


def _write_gap(axes: Axes, row: int, gap: DutyGap, line: Line, band: TimeBand, used: _Row) -> None:
    """The place under a gap, with how many minutes; on the second level, or not at all, where there is no room."""
    low_s = band.from_s if gap.from_s is None else gap.from_s
    high_s = band.to_s if gap.to_s is None else gap.to_s
    ends = [time_s for time_s in (gap.from_s, gap.to_s) if time_s is not None]
    if not any(band.from_s <= time_s <= band.to_s for time_s in ends):
        return
    place = _place(line, gap)
    if gap.length_s is None:
        before = gap.from_s is None
        text = _text(axes, ends[0], row + _UNDER[0], place, INK, "right" if before else "left")
    else:
        at_s = (max(low_s, band.from_s) + min(high_s, band.to_s)) / 2
        text = _text(axes, at_s, row + _UNDER[0], f"{place} {_minutes(gap.length_s)}", INK)
    _keep_inside(axes, text)
    low, high = _span(text)
    for level in _UNDER:
        if used.free(level, low, high):
            text.set_y(row + level)
            used.taken.setdefault(level, []).append((low, high))
            return
    text.remove()


def _place(line: Line, gap: DutyGap) -> str:
    """Name of a station in Japanese, or romanised; with an arrow for what lies beyond it."""
    station = line.stations[gap.station_id]
    name = station.name_ja if station.name_ja and can_write_japanese() else station.name or station.id
    if gap.kind == GapKind.STABLED.value:
        return f"■ {name}"
    return f"{name} »" if gap.kind == GapKind.OUTSIDE.value else name


def _text(axes: Axes, at_s: float, y: float, text: str, colour: str, align: Align = "center") -> Text:
    return centred(axes, at_s, y, text, _TEXT_PT, color=colour, ha=align, zorder=5, clip_on=False)


def _span(text: Text) -> tuple[float, float]:
    """From where to where a text stands on the screen, px, with a gap round it."""
    extent = text.get_window_extent()
    return extent.x0 - _GAP_PT, extent.x1 + _GAP_PT


def _keep_inside(axes: Axes, text: Text) -> None:
    """Move a text that would stand beyond the panel to its edge."""
    frame, extent = axes.get_window_extent(), text.get_window_extent()
    over = max(frame.x0 + _GAP_PT - extent.x0, 0.0) - max(extent.x1 - frame.x1 + _GAP_PT, 0.0)
    if over:
        x, y = axes.transData.transform((float(text.get_position()[0]), 0.0))
        text.set_x(float(axes.transData.inverted().transform((x + over, y))[0]))


def duty_rows(duties: Sequence[SetDuty]) -> list[dict[str, Any]]:
    """The table: a row for each train, with what its set does before it."""
    rows: list[dict[str, Any]] = []
    for duty in duties:
        before = {gap.before: gap for gap in duty.gaps}
        for i, train in enumerate(duty.trains, start=1):
            gap = before[train.number]
            rows.append(
                {
                    "set": duty.stock_id,
                    "order": i,
                    "train": train.number,
                    "revenue": train.revenue,
                    "from": train.from_id,
                    "departure": clock(train.begins_s, seconds=True),
                    "to": train.to_id,
                    "arrival": clock(train.ends_s, seconds=True),
                    "km": round(train.distance_m / 1000, 3),
                    "before": gap.kind,
                    "before_min": None if gap.length_s is None else round(gap.length_s / 60, 2),
                    "late_s": train.late_s,
                }
            )
    return rows


def write_duties(folder: Path, line: Line, duties: Sequence[SetDuty]) -> None:
    """Make a folder with duties.csv and the graph; OSError when it cannot be written."""
    folder.mkdir()
    pl.DataFrame(duty_rows(duties), infer_schema_length=None).write_csv(folder / f"{PICTURE}.csv")
    with drawing():
        figure = draw_duties(line, duties)
        if figure is not None:
            figure.savefig(folder / f"{PICTURE}.png", dpi=150)
            figure.savefig(folder / f"{PICTURE}.svg", metadata={"Date": None})
