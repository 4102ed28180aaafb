"""The report on driving: hop by hop what the trains took, how often notches changed, how they coasted and arrived."""

from __future__ import annotations

from typing import Any, Final

from study.measures.driving import driving_sums, margins_by_law
from study.record.columns import FROM, TO, TRAINS
from study.record.driving import EARLY, LAW, DrivenHop
from study.record.figure import Adds, Figure, ShownIn, rows_in, seen_in
from study.record.tables import RunTables
from study.report.data import ReportedRun
from study.report.tabular import Table, table_of
from study.wording.catalogue import phrase

FIGURES: Final[dict[str, Figure]] = {**seen_in(DrivenHop, ShownIn.SUMS), "early_s": EARLY}
COLUMNS: Final = {"from_station": FROM, "to_station": TO, "law": LAW, "trains": TRAINS, **FIGURES}


def driving_tables(run: ReportedRun) -> tuple[Table, ...]:
    """Means over the trains of each hop and law, in order along the line; none for a run without any hop."""
    together: dict[tuple[str, str, str], list[DrivenHop]] = {}
    for hop in rows_in(DrivenHop, run.tables.driving):
        together.setdefault((hop.from_station, hop.to_station, hop.law), []).append(hop)
    if not together:
        return ()

    def place(hops: list[DrivenHop]) -> tuple[int, object]:
        direction = run.directions[hops[0].train]
        return -int(direction), run.along(direction, (hops[0].from_station, hops[0].to_station))

    rows = [_row(run.tables, hops) for hops in sorted(together.values(), key=place)]
    return (
        table_of(
            "driving",
            phrase("Driving by hop, means over the trains; energy is traction less what came back"),
            rows,
            COLUMNS,
        ),
    )


def _row(tables: RunTables, hops: list[DrivenHop]) -> dict[str, Any]:
    """One row: energy of the mean train, the rest as `study.measures.driving.driving_sums` has it."""
    first = hops[0]
    margins = margins_by_law(tables.margins, tables.driving, first.law).filter(
        from_station=first.from_station, to_station=first.to_station
    )
    whole = driving_sums(hops, margins["left_s"]) or {}
    return {
        **{
            name: whole[name] / len(hops) if figure.adds is Adds.SUM else whole[name]
            for name, figure in FIGURES.items()
        },
        "from_station": first.from_station,
        "to_station": first.to_station,
        "law": first.law,
        "trains": len(hops),
    }
