"""The setup of a run that was read back, as far as its plan, its running times and its blocking times rest on it."""

from __future__ import annotations

from scenario.battery_choice import heated_trains
from scenario.scenario import run_tables
from simulation.setup import Setup
from study.record.read_back import RunRead


def setup_of(read: RunRead) -> Setup:
    """Line, timetable, trains and the tables; no faults, and units believe what is so."""
    settings, tables = read.settings, read.settings.tables
    return Setup(
        read.name,
        read.line,
        read.timetable,
        heated_trains(dict(read.trains), tables.battery),
        seed=settings.seed,
        load=settings.trains,
        **run_tables(tables, read.timetable),
    )
