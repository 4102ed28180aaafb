"""Made-up runs to compare: the made-up weekday, with tables that a test has changed."""

from dataclasses import fields
from functools import cache

import polars as pl

from scenario.inputs import Inputs
from scenario.scenario import load_scenario
from study.compare.side import ComparedRun
from study.record.tables import RunTables
from study.report.data import ReportedRun


@cache
def inputs_of(scenario: str = "karasuyama_weekday") -> Inputs:
    return load_scenario(scenario).inputs


def with_tables(run: ReportedRun, **tables: pl.DataFrame) -> ReportedRun:
    """The same run with other tables."""
    kept = {field.name: getattr(run.tables, field.name) for field in fields(RunTables)}
    return ReportedRun(run.line, run.timetable, RunTables(**{**kept, **tables}))


def side(
    run: ReportedRun,
    label: str = "base",
    inputs: Inputs | None = None,
    broken: tuple[str, ...] = (),
    **summary: object,
) -> ComparedRun:
    facts = {
        "scenario": "karasuyama_weekday",
        "digest": label,
        "link": "simulated",
        "carrier": "sumo",
        **summary,
    }
    return ComparedRun(label, label.title(), inputs or inputs_of(), facts, run, None, broken)
