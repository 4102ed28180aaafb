"""Made-up runs to compare: the made-up weekday, with tables that a test has changed."""

from __future__ import annotations

from dataclasses import fields
from functools import cache

import polars as pl

from study.compare.side import Side
from study.report.data import Run
from study.run.tables import RunTables
from study.scenario.inputs import Inputs
from study.scenario.scenario import load_scenario


@cache
def inputs_of(scenario: str = "karasuyama_weekday") -> Inputs:
    return load_scenario(scenario).inputs


def with_tables(run: Run, **tables: pl.DataFrame) -> Run:
    """The same run with other tables."""
    kept = {field.name: getattr(run.tables, field.name) for field in fields(RunTables)}
    return Run(run.line, run.timetable, RunTables(**{**kept, **tables}))


def side(
    run: Run,
    label: str = "base",
    inputs: Inputs | None = None,
    broken: tuple[str, ...] = (),
    **summary: object,
) -> Side:
    facts = {
        "scenario": "karasuyama_weekday",
        "digest": label,
        "link": "simulated",
        "carrier": "sumo",
        **summary,
    }
    return Side(label, label.title(), inputs or inputs_of(), facts, run, None, broken)
