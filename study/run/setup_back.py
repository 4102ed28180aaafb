"""The setup of a run that was read back, as far as its plan, its running times and its blocking times rest on it."""

from __future__ import annotations

from simulation.setup import Setup
from study.run.read_back import RunRead
from study.scenario.battery_choice import heated
from study.scenario.scenario import unit_of


def setup_of(read: RunRead) -> Setup:
    """Line, timetable, trains and the tables that theory asks; no faults, no sensors, and units believe what is so."""
    settings = read.settings
    return Setup(
        read.name,
        read.line,
        read.timetable,
        heated(dict(read.trains), settings.battery),
        seed=settings.seed,
        air=settings.air,
        unit=unit_of(settings.unit, read.timetable),
        driving=settings.driving,
        load=settings.trains,
        limits=settings.limits,
        operation=settings.operation,
        battery=settings.battery,
    )
