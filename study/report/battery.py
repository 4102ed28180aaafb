"""The report on batteries: each set's day and each charge; nothing where no set runs on one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from study.report.data import Run
from study.report.tabular import Kind, Table, table_of


def battery_tables(run: Run, facts: Mapping[str, Any]) -> tuple[Table, ...]:
    """A row a set, from the summary, and a row a charge."""
    sets: Mapping[str, Mapping[str, Any]] = facts.get("battery") or {}
    if not sets or run.tables.battery.is_empty():
        return ()
    rows: list[dict[str, Any]] = [
        {
            "unit": unit,
            **figures,
            "soc_first": 100.0 * figures["soc_first"],
            "soc_last": 100.0 * figures["soc_last"],
            "soc_lowest": 100.0 * figures["soc_lowest"],
        }
        for unit, figures in sets.items()
    ]
    kwh = (Kind.NUMBER, 1)
    return (
        table_of(
            "battery_sets",
            rows,
            {
                "unit": (Kind.TEXT, 0),
                "soc_first": (Kind.NUMBER, 1),
                "soc_lowest": (Kind.NUMBER, 1),
                "lowest_at_s": (Kind.CLOCK, 0),
                "lowest_train": (Kind.TRAIN, 0),
                "margin_kwh": (Kind.SIGNED, 1),
                "soc_last": (Kind.NUMBER, 1),
                "given_kwh": kwh,
                "taken_kwh": kwh,
                "lost_kwh": kwh,
                "supplied_kwh": kwh,
                "missing_kwh": kwh,
                "unbalanced_percent": (Kind.NUMBER, 4),
            },
        ),
        table_of(
            "charges",
            [
                {**row, "station": row["station"] or None, "charged_min": row["minutes"]}
                for row in run.tables.charges.iter_rows(named=True)
            ],
            {
                "unit": (Kind.TEXT, 0),
                "train": (Kind.TRAIN, 0),
                "station": (Kind.PLACE, 0),
                "from_s": (Kind.CLOCK, 0),
                "to_s": (Kind.CLOCK, 0),
                "charged_min": (Kind.NUMBER, 1),
                "minutes_suffice": (Kind.NUMBER, 1),
                "gained_kwh": (Kind.SIGNED, 1),
                "next_way_kwh": kwh,
                "margin_kwh": (Kind.SIGNED, 1),
            },
        ),
    )
