"""The files that an arranged day is written to: its timetable, and a scenario that runs it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from exchange.timetable_writer import timetable_toml
from network.errors import COMMAND_LINE, InputError
from plan.arranging.arrange import ArrangedDay
from study.making.place import checked_new, write_new
from study.making.timetable import write_scenario


def checked_files(out: Path | None, scenario: Path | None) -> None:
    """InputError where these cannot be written."""
    if out is None:
        if scenario is not None:
            raise InputError(COMMAND_LINE, "--out", None, "the timetable file that the scenario is to run")
        return
    checked_new(out)
    if scenario is not None:
        checked_new(scenario, "--scenario")
        if scenario.resolve() == out.resolve():
            raise InputError(
                COMMAND_LINE, "--scenario", str(scenario), "another file than that of the timetable"
            )


def write_day(
    day: ArrangedDay, line_name: str, train_name: str, out: Path | None, scenario: Path | None
) -> Iterator[Path]:
    """Write what is asked for, whole or not at all. Raises InputError."""
    checked_files(out, scenario)
    if out is None:
        return
    head = day.file.timetable.model_copy(update={"id": out.stem})
    write_new(out, timetable_toml(day.file.model_copy(update={"timetable": head})))
    yield out
    if scenario is not None:
        write_scenario(scenario, line_name, out, train_name)
        yield scenario
