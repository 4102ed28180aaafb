"""The report on driving: hop by hop what the trains took, how often notches changed, how they coasted and arrived."""

from __future__ import annotations

from typing import Any, Final

from study.measures.driving import DrivenHop, driven
from study.report.data import Run
from study.report.tabular import Kind, Table, table_of
from study.run.driving import read_hops

COLUMNS: Final = {
    "from_station": (Kind.PLACE, 0),
    "to_station": (Kind.PLACE, 0),
    "law": (Kind.TEXT, 0),
    "trains": (Kind.NUMBER, 0),
    "running_kwh": (Kind.NUMBER, 2),
    "traction_kwh": (Kind.NUMBER, 2),
    "regenerated_kwh": (Kind.NUMBER, 2),
    "power_changes": (Kind.NUMBER, 1),
    "brake_changes": (Kind.NUMBER, 1),
    "jerk_max_mps3": (Kind.NUMBER, 2),
    "jerk_rms_mps3": (Kind.NUMBER, 3),
    "coasting_way_percent": (Kind.NUMBER, 0),
    "cruising_way_percent": (Kind.NUMBER, 0),
    "braking_way_percent": (Kind.NUMBER, 0),
    "early_s": (Kind.SIGNED, 1),
}
_EACH: Final = ("running_kwh", "traction_kwh", "regenerated_kwh")


def driving_tables(run: Run) -> tuple[Table, ...]:
    """Means over the trains of each hop and law, in order along the line; none for a run without any hop."""
    together: dict[tuple[str, str, str], list[DrivenHop]] = {}
    for hop in read_hops(run.tables.driving):
        together.setdefault((hop.from_station, hop.to_station, hop.law), []).append(hop)
    if not together:
        return ()
    order = {station.id: station.position_m for station in run.stations}

    def place(hops: list[DrivenHop]) -> tuple[int, float]:
        direction = int(run.directions[hops[0].train])
        return -direction, direction * order.get(hops[0].from_station, -direction * float("inf"))

    rows = [_row(hops) for hops in sorted(together.values(), key=place)]
    return (table_of("driving", rows, COLUMNS),)


def _row(hops: list[DrivenHop]) -> dict[str, Any]:
    """One row: energy of the mean train, the rest as `study.measures.driving.driven` has it."""
    first, whole = hops[0], driven(hops)
    figures = {name: getattr(whole, name) for name in COLUMNS if hasattr(whole, name)}
    return {
        **figures,
        **{name: figures[name] / len(hops) for name in _EACH},
        "from_station": first.from_station,
        "to_station": first.to_station,
        "law": first.law,
        "trains": len(hops),
    }
