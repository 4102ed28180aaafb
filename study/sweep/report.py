"""The report of a sweep: a page that opens offline, its pictures, and tables of points and days."""

from __future__ import annotations

import json
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure as Picture

from network.errors import InputError
from network.model import Line
from scenario.scenario import load_scenario
from study.record.parts import PagePart, TextTable
from study.report.face import FACE, japanese_face
from study.report.style import drawing, svg_of
from study.report.template import rendered
from study.sweep.draw import draw_days, draw_spread, draw_tornado
from study.sweep.figures import FIGURES, DayFigure
from study.sweep.go import SweepProgress
from study.sweep.records import DayOutcome, DayRecord
from study.sweep.statistics import FigureEstimate
from study.sweep.store import write_whole
from study.sweep.table import (
    Effect,
    PointRow,
    days_csv,
    effects,
    point_rows,
    points_csv,
    summary_of,
    value_of,
)
from study.sweep.worth import NotableDay, worth_looking_at, write_replays

PAGE_FILE: Final = "report.html"
POINTS_FILE: Final = "points.csv"
DAYS_FILE: Final = "days.csv"
SUMMARY_FILE: Final = "summary.json"
_DPI: Final = 150
_HOW: Final = (
    "Means with intervals by Student's t over days, corrected for skewness (Hall 1992); quantiles with intervals by"
    " order statistics; shares of days by Wilson. Differences are taken seed by seed, so that what a seed does at both"
    " points drops out."
)


def write_sweep_report(state: SweepProgress, out: Path) -> Path:
    """Write page, pictures, tables and replays into the sweep's directory; returns the page."""
    rows = point_rows(state)
    worth = worth_looking_at(state, out)
    write_replays(worth, out)
    _write(out / POINTS_FILE, points_csv(rows))
    _write(out / DAYS_FILE, days_csv(state))
    summary = summary_of(state, out)
    _write(out / SUMMARY_FILE, json.dumps(summary, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    with drawing():
        parts: list[PagePart | None] = [
            _headline(state),
            *_figure_parts(state, rows, out),
            _points_part(state, rows),
        ]
        parts += [_worth_part(state, worth), _assumed_part(state)]
        _write(out / PAGE_FILE, _page(state, [part for part in parts if part is not None]))
    return out / PAGE_FILE


def _page(state: SweepProgress, parts: Sequence[PagePart]) -> str:
    table = state.plan.table
    days = f"{state.there} days at {len(state.plan.points)} points of the grid"
    if len(state.plan.points) == 1:
        days = f"{state.there} days"
    page = rendered(
        "sweep.html.j2",
        title=table.name,
        subtitle=f"{table.scenario} · {days} · carried by {state.carriers}",
        parts=parts,
    )
    return page.replace(FACE, japanese_face(page), 1)


def _headline(state: SweepProgress) -> PagePart:
    """What became of the days, and whether the sweep holds."""
    counts = {
        outcome: sum(r.outcome is outcome for p in state.plan.points for r in state.days_counted(p))
        for outcome in DayOutcome
    }
    rows = [(outcome.value, str(count)) for outcome, count in counts.items()]
    again = sum(bool(r.again) for p in state.plan.points for r in state.days_counted(p))
    rows.append(("run again on SUMO", str(again)))
    if state.others:
        rows.append(("days of other points or seeds that lie in the directory", str(state.others)))
    holds = "SUMO carried every day that it ran again alike." if again else ""
    caption = "; ".join(state.failures) or f"Nothing is broken. {holds}".strip()
    return PagePart(
        "What became of the days", caption, grids=(TextTable(("outcome", "days"), tuple(rows), 1),)
    )


def _figure_parts(state: SweepProgress, rows: Sequence[PointRow], out: Path) -> list[PagePart]:
    """A part for each figure watched: spread by point, curves of days, tornado."""
    parts: list[PagePart] = []
    confidence = state.plan.table.confidence
    for name in state.plan.table.watch:
        figure = FIGURES[name]
        found = effects(state, name)
        days = [
            [
                value
                for record in state.days_counted(row.point)
                if (value := value_of(record, name)) is not None
            ]
            for row in rows
        ]
        pictures = {
            "days": draw_days(rows, days, figure, confidence),
            "spread": draw_spread(rows, figure, confidence) if len(rows) > 1 else None,
            "tornado": draw_tornado(found, figure, confidence),
        }
        svgs = [
            _picture(picture, f"{what}_{name}", out)
            for what, picture in pictures.items()
            if picture is not None
        ]
        grids = [_quantiles_grid(rows, figure, confidence)]
        if found:
            grids.append(_effects_grid(found, figure))
        caption = "" if parts else _HOW
        parts.append(
            PagePart(figure.label[:1].upper() + figure.label[1:], caption, tuple(svgs), tuple(grids))
        )
    return parts


def _picture(picture: Picture, name: str, out: Path) -> str:
    """Into the page as SVG, and beside it as PNG."""
    buffer = BytesIO()
    picture.savefig(buffer, format="png", dpi=_DPI, metadata={"Software": None})
    write_whole(out / f"{name}.png", buffer.getvalue())
    return svg_of(picture, name)


def _quantiles_grid(rows: Sequence[PointRow], figure: DayFigure, confidence: float) -> TextTable:
    level = f"{confidence * 100:g} % interval"
    head = (
        *("point", "days", "mean", level, "5 %", "median", "interval", "95 %", "interval"),
        *("less the first point", "interval"),
    )
    cells: list[tuple[str, ...]] = []
    for row in rows:
        found = row.figures[figure.name]
        low, middle, high = (found.quantiles[share] for share in (0.05, 0.5, 0.95))
        less = ("", "") if row is rows[0] else (_text(found.less_first.value), _between(found.less_first))
        cells.append(
            (
                *(row.point.label, str(found.mean.days), _text(found.mean.value), _between(found.mean)),
                *(_text(low.value), _text(middle.value), _between(middle), _text(high.value), _between(high)),
                *less,
            )
        )
    return TextTable(head, tuple(cells), 1)


def _effects_grid(found: Sequence[Effect], figure: DayFigure) -> TextTable:
    head = ("axis", "place", "pairs of days", f"{figure.title} less the first place", "interval")
    cells = tuple(
        (e.axis, e.place, str(e.less_first.days), _text(e.less_first.value), _between(e.less_first))
        for e in found
    )
    return TextTable(head, cells, 2)


def _points_part(state: SweepProgress, rows: Sequence[PointRow]) -> PagePart:
    """Outcomes by point, with the share of days of each."""
    head = ["point", "days", "ended early"]
    for outcome in DayOutcome:
        head += [outcome.value, "share of days"]
    cells: list[tuple[str, ...]] = []
    for row in rows:
        cell = [row.point.label, str(row.days), "yes" if row.stopped_early else ""]
        for outcome in DayOutcome:
            cell += [str(row.counts[outcome]), _between(row.outcomes[outcome], 3)]
        cells.append(tuple(cell))
    stop = state.plan.stop
    caption = "Shares of days as intervals."
    if stop is not None:
        caption += (
            f" A point ends early once the interval of {FIGURES[stop.figure].title} is narrower than"
            f" {stop.narrower_than:g}, looked at after {', '.join(map(str, state.plan.looks))} days; intervals are so"
            " wide that they hold at all these looks together."
        )
    return PagePart("Outcomes by point", caption, grids=(TextTable(tuple(head), tuple(cells), 1),))


def _worth_part(state: SweepProgress, worth: Sequence[NotableDay]) -> PagePart:
    names = _station_names(state)
    first = FIGURES[state.plan.table.watch[0]]
    head = ("why", "point", "seed", first.label, "latest arrival", "what happened", "run it again")
    cells = tuple(
        (
            *(day.why, day.point.label, str(day.record.spec.seed), _text(value_of(day.record, first.name))),
            *(_worst(day.record, names), day.record.why, day.command),
        )
        for day in worth
    )
    caption = "Each command runs the same day again and writes its whole run directory with report.html."
    return PagePart("Days worth looking at", caption, grids=(TextTable(head, cells, 2, 4),))


def _assumed_part(state: SweepProgress) -> PagePart | None:
    rows = tuple((text,) for text in state.plan.table.assumed)
    if not rows:
        return None
    return PagePart("Assumed", "What nobody has published.", grids=(TextTable(("assumption",), rows),))


def _worst(record: DayRecord, names: dict[str, str]) -> str:
    figures = record.figures
    if figures is None or figures.worst_late_s is None:
        return ""
    at = names.get(figures.worst_station, figures.worst_station)
    return f"{figures.worst_late_s:+.0f} s, {figures.worst_train} at {at}"


def _station_names(state: SweepProgress) -> dict[str, str]:
    """What people call each station: in the scenario that is varied, and where that is no longer there, its id."""
    try:
        line: Line = load_scenario(state.plan.scenario).setup.line
    except InputError:
        return {}
    return {station.id: f"{station.name} {station.name_ja}".strip() for station in line.stations.values()}


def _text(value: float | None) -> str:
    if value is None:
        return "–"
    digits = 3 if abs(value) < 2.0 else 1
    return f"{value:,.{digits}f}".replace("-", "−")


def _between(found: FigureEstimate, digits: int | None = None) -> str:
    if found.low is None or found.high is None:
        return "–"
    if digits is None:
        return f"{_text(found.low)} to {_text(found.high)}"
    return f"{found.low:.{digits}f} to {found.high:.{digits}f}"


def _write(path: Path, text: str) -> None:
    write_whole(path, text.encode("utf-8"))
