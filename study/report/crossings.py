"""The report on level crossings: closed minutes, warnings before the front, and the road where one was carried."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from study.record.crossings import CrossingHour, CrossingPassage
from study.record.figure import Figure, ShownIn, figures_of, rows_in, seen_in, summed_figures
from study.record.road import RoadHour
from study.report.data import ReportedRun
from study.report.tabular import Table, table_of
from study.wording.catalogue import phrase

# The road's closed time is shown in minutes.
_CLOSED: Final = {"closed_min": replace(figures_of(CrossingHour)["closed_s"], unit="min")}
# Of a crossing over the day: who began to move within the approach, and how long it warned for all others.
_STANDS: Final = {
    "from_stand": Figure(phrase("from a stand within the approach")),
    "warned_s_running": Figure(phrase("mean warning of the others"), "s", 1),
}
_NAME: Final = {"crossing": figures_of(CrossingHour)["crossing"]}
_WHEN: Final = {**_NAME, "hour": figures_of(CrossingHour)["hour"]}


def crossing_tables_shown(run: ReportedRun) -> tuple[Table, ...]:
    """By crossing, by crossing and hour, and every passage, along the line; nothing on a line without any."""
    hours = rows_in(CrossingHour, run.tables.crossings)
    if not hours:
        return ()
    vehicles = {(it.crossing, it.hour): it for it in rows_in(RoadHour, run.tables.road)}
    figures = {**_CLOSED, **_shown(CrossingHour), **(_shown(RoadHour) if vehicles else {})}
    known = run.line.crossings
    crossings = sorted({it.crossing for it in hours}, key=lambda name: (known[name].position_m, name))
    fronts: dict[str, list[CrossingPassage]] = {crossing: [] for crossing in crossings}
    for front in rows_in(CrossingPassage, run.tables.warnings):
        fronts[front.crossing].append(front)
    by_crossing: list[dict[str, Any]] = []
    by_hour: list[dict[str, Any]] = []
    for crossing in crossings:
        own = [it for it in hours if it.crossing == crossing]
        name, met = known[crossing].name, [it for it in vehicles.values() if it.crossing == crossing]
        by_crossing.append({"crossing": name, **_row(own, met, figures), **_stands(fronts[crossing])})
        for it in own:
            here = [vehicles[crossing, it.hour]] if (crossing, it.hour) in vehicles else []
            by_hour.append({"crossing": name, "hour": it.hour, **_row([it], here, figures)})
    passages = [
        {**row, "crossing": known[row["crossing"]].name, "from_stand": "yes" if row["from_stand"] else "no"}
        for row in run.tables.warnings.to_dicts()
    ]
    return (
        table_of("crossings", phrase("Level crossings"), by_crossing, {**_NAME, **figures, **_STANDS}),
        table_of("crossing_hours", phrase("Level crossings by hour"), by_hour, {**_WHEN, **figures}),
        table_of("warnings", phrase("Every warning"), passages, seen_in(CrossingPassage, ShownIn.REPORT)),
    )


def _shown(row: type) -> dict[str, Figure]:
    """The figures of such rows but what names them, and the closed time, which is shown in minutes."""
    return {
        name: said
        for name, said in seen_in(row, ShownIn.REPORT).items()
        if name not in _WHEN and name != "closed_s"
    }


def _stands(fronts: Sequence[CrossingPassage]) -> dict[str, float | None]:
    others_s = [front.warned_s for front in fronts if not front.from_stand]
    return {
        "from_stand": len(fronts) - len(others_s),
        "warned_s_running": sum(others_s) / len(others_s) if others_s else None,
    }


def _row(
    hours: Sequence[CrossingHour], vehicles: Sequence[RoadHour], figures: dict[str, Figure]
) -> dict[str, Any]:
    """The figures of some hours of one crossing together; none of a road where no vehicle came."""
    whole = summed_figures(hours) | (summed_figures(vehicles) if vehicles else {})
    whole["closed_min"] = (whole["closed_s"] or 0.0) / 60.0
    return {name: whole.get(name) for name in figures}
