"""The report on margins (余裕時分): what the timetable leaves over the least running time, hop by hop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import polars as pl

from study.report.data import Run
from study.report.energy import place_name
from study.report.parts import Fact, Grid, Part, signed


def margin_fact(run: Run, facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """The smallest margins in one line, red where the plan cannot be kept; nothing where no hop has times."""
    margins = facts["margins"]
    if not margins:
        return ()
    least = margins["smallest_margin_s"]
    text = _named(run, least)
    tightest = margins.get("smallest_margin_percent", least)
    if _hop(tightest) != _hop(least):
        text += f"; in percent {_named(run, tightest)}"
    return (Fact("Smallest margin", text, least["margin_s"] < 0.0),)


def _hop(row: Mapping[str, Any]) -> tuple[str, str, str]:
    return row["train"], row["from_station"], row["to_station"]


def _named(run: Run, row: Mapping[str, Any]) -> str:
    percent = row["margin_percent"]
    share = "" if percent is None else f" ({signed(percent, 0, '%')})"
    ends = f"{place_name(run, row['from_station'])} – {place_name(run, row['to_station'])}"
    return f"{signed(row['margin_s'], 0, 's')}{share}, {row['train']} {ends}"


def margin_part(run: Run) -> tuple[Part, ...]:
    """Margins by hop and direction; nothing where no hop has times."""
    margins = run.tables.margins
    if margins.is_empty():
        return ()
    negative = margins.filter(pl.col("margin_s") < 0.0)
    notes = [
        f"{row['train']} {place_name(run, row['from_station'])} – {place_name(run, row['to_station'])}:"
        f" {row['planned_s']:.0f} s planned, at least {row['least_s']:.0f} s needed"
        for row in negative.iter_rows(named=True)
    ]
    return (
        Part(
            "Margins",
            "Planned: from the departure to the latest arrival that keeps the planned arrival, and the least dwell"
            " before the next departure. Least: full power and the planned braking, at the limits of the line, with"
            " the mean load and no reaction times; attainable: as far below the limits as trains are driven. Margin:"
            " planned less least, in percent of the least. Left: what was left on arrival as run; automatic driving"
            " spends a margin on a lower speed, so little is left by intent.",
            grids=(_grid(run),),
            notes=(
                f"The plan cannot be kept on {len(notes)} hop{'s' if len(notes) > 1 else ''}: "
                + "; ".join(notes)
                + ".",
            )
            if notes
            else (),
        ),
    )


def _grid(run: Run) -> Grid:
    """A row a hop, DOWN before UP, along the line; with the train of the smallest margin."""
    order = {station.id: station.position_m for station in run.stations}
    rows: list[tuple[tuple[int, float], tuple[str, ...]]] = []
    for (from_id, to_id), hop in run.tables.margins.group_by(
        "from_station", "to_station", maintain_order=True
    ):
        least = hop.sort("margin_s", maintain_order=True).row(0, named=True)
        direction = run.directions[least["train"]]
        percent, run_s, left_s = (
            least["margin_percent"],
            hop["run_s"].drop_nulls(),
            hop["left_s"].drop_nulls(),
        )
        cells = (
            f"{place_name(run, str(from_id))} – {place_name(run, str(to_id))}",
            str(len(hop)),
            _between(hop["planned_s"]),
            f"{least['least_s']:.0f}",
            f"{least['attainable_s']:.0f}",
            signed(least["margin_s"]),
            "–" if percent is None else signed(percent, 0, "%"),
            least["train"],
            _between(run_s),
            "–" if left_s.is_empty() else signed(float(str(left_s.min()))),
        )
        rows.append(((-int(direction), direction * order[str(from_id)]), cells))
    header = (
        *(
            "hop",
            "trains",
            "planned, s",
            "least, s",
            "attainable, s",
            "smallest margin, s",
            "in percent",
            "of train",
        ),
        *("run, s", "least left, s"),
    )
    return Grid(header, tuple(cells for _, cells in sorted(rows, key=lambda row: row[0])), numbers_from=1)


def _between(values: pl.Series) -> str:
    """Least and greatest, or the one that there is."""
    if values.is_empty():
        return "–"
    low, high = (f"{float(str(value)):.0f}" for value in (values.min(), values.max()))
    return low if low == high else f"{low} – {high}"
