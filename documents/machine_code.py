"""Compiled code for any processor, for a wheel: what shipped days, every driving law and their sensors need.

    NUMBA_CPU_NAME=generic NUMBA_CACHE_DIR=FOLDER python -m documents.machine_code [SCENARIO ...]

compiles into FOLDER/machine_code, by running what is asked for, or all of `DAYS`.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from onboard.driving.laws.table import LAW_NAMES
from scenario.law_choice import driven_by
from scenario.part_of_day import part_of_day
from scenario.scenario import Scenario, load_scenario
from study.evaluate.release import confirmed_by_eye
from study.feasibility.check import feasibility
from study.record.directory import reserved
from study.runner.run import CarrierKind, PartyLink, execute, fill_run

SHORT: Final = "karasuyama_round_trip"  # with every law
DAYS: Final = (  # by what sensors, batteries and carriers compute; the first hours of each have all of it
    ("karasuyama_weekday", "06:30"),
    ("karasuyama_position", "07:30"),
    ("karasuyama_stressed", "06:30"),
    ("karasuyama_battery", "07:00"),
    ("karasuyama_late", "06:30"),
    ("rtri_test_line", None),
)


def days(names: Sequence[str]) -> Iterator[Scenario]:
    """Parts of days that between them call all that they need; those of `names` alone, if there are any."""
    for name, until in DAYS:
        if not names or name in names:
            yield part_of_day(load_scenario(name), None, until)
    if not names:
        short = load_scenario(SHORT)
        yield from (replace(short, setup=driven_by(short.setup, law)) for law in LAW_NAMES)


def main(names: Sequence[str]) -> None:
    """Run them with checks, tables and reports."""
    for day in days(names):
        feasibility(day.setup)
        confirmed_by_eye(day.setup)
        plain = execute(day, PartyLink.SIMULATED, carrier=CarrierKind.PLAIN)
        with tempfile.TemporaryDirectory() as folder, reserved(Path(folder) / "run") as place:
            fill_run(execute(day, PartyLink.SIMULATED, journal=place.journal), place)
        sys.stdout.write(f"{day.id}: {plain.summary['trains_arrived']} trains\n")


if __name__ == "__main__":
    main(sys.argv[1:])
