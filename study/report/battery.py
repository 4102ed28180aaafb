"""The report on batteries: each set's day and each charge; nothing where no set runs on one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

from study.record.battery import BatteryMoment, ChargeTaken
from study.record.columns import TRAIN, UNIT
from study.record.figure import Figure, Kind, ShownIn, figures_of, seen_in
from study.report.data import ReportedRun
from study.report.tabular import Table, table_of
from study.wording.catalogue import phrase

_OF_A_SET: Final = {
    "unit": UNIT,
    "soc_first": Figure(phrase("charge at first"), "%", 1),
    "soc_lowest": Figure(phrase("lowest"), "%", 1),
    "lowest_at_s": Figure(phrase("when"), kind=Kind.CLOCK),
    "lowest_train": replace(TRAIN, name=phrase("train then")),
    "margin_kwh": figures_of(ChargeTaken)["margin_kwh"],
    "soc_last": Figure(phrase("at last"), "%", 1),
    **seen_in(BatteryMoment, ShownIn.REPORT),
    "unbalanced_percent": Figure(phrase("unbalanced"), "%", 4),
}


def battery_tables(run: ReportedRun, facts: Mapping[str, Any]) -> tuple[Table, ...]:
    """A row a set, from the summary, and a row a charge."""
    sets: Mapping[str, Mapping[str, Any]] = facts.get("battery") or {}
    if not sets or run.tables.battery.is_empty():
        return ()
    shares = ("soc_first", "soc_last", "soc_lowest")
    rows = [
        {"unit": unit, **figures, **{name: 100.0 * figures[name] for name in shares}}
        for unit, figures in sets.items()
    ]
    charges = [{**row, "station": row["station"] or None} for row in run.tables.charges.iter_rows(named=True)]
    return (
        table_of("battery_sets", phrase("Batteries by set"), rows, _OF_A_SET),
        table_of("charges", phrase("Charges"), charges, seen_in(ChargeTaken, ShownIn.REPORT)),
    )
