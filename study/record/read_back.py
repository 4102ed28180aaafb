"""A run directory read back: inputs, summary and tables of a finished run, without the files that it was made from."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import polars as pl

from network.errors import InputError
from network.files.json_input import read_json
from network.files.line_file import line_of_tables
from network.files.text_input import existing_file
from network.files.timetable_schema import TimetableFile
from network.files.toml_input import validate
from network.model import Line
from network.raw import is_table
from network.timetable import Timetable, timetable_of
from onboard.driving.tuning import Learned
from scenario.fleet_file import read_learned
from scenario.inputs import Inputs, read_inputs
from scenario.scenario_file import ScenarioFile
from study.record.directory import (
    CRASH_FILE,
    FORMAT,
    FORMAT_KEY,
    INCOMPLETE_FILE,
    INPUTS_FILE,
    LEARNED_FILE,
    SHOWN_FILE,
    SUMMARY_FILE,
    TABLE_FILES,
    digests_of_tables,
)
from study.record.shown import Shown, read_shown
from study.record.tables import RunTables
from vehicle.train_file import TrainType, train_of

A_RUN: Final = "the directory of a finished run"
_TEXTS: Final = ("scenario", "digest", "motion_digest", "link", "carrier", "ended_because")


@dataclass(frozen=True, slots=True)
class RunRead:
    """A run as its directory has it. `trains` gives the kind of train of each stock id.

    `settings` are the scenario's own tables after all patches, with the seed that was used; `learned` is what the
    trains had learned at the end, by stock id, and `shown` what only the report shows.
    """

    directory: Path
    line: Line
    timetable: Timetable
    trains: Mapping[str, TrainType]
    settings: ScenarioFile
    inputs: Inputs
    summary: Mapping[str, Any]
    tables: RunTables
    learned: Mapping[str, Learned]
    shown: Shown

    @property
    def name(self) -> str:
        """What people call the scenario."""
        return self.settings.name


def read_run(directory: Path) -> RunRead:
    """Read the directory of a finished run.

    Raises InputError for one that is none, of a run that was cut short, of another version, mixed or damaged.
    """
    _check_finished(directory)
    file = str(directory / INPUTS_FILE)
    inputs = read_inputs(directory / INPUTS_FILE)
    line, timetable, trains, settings = parsed_inputs(inputs, file)
    summary = _summary(directory, settings)
    shown = read_shown(directory / SHOWN_FILE)
    _check_tables(directory, shown)
    tables = RunTables.read(directory)
    _check_names(directory, tables, line, inputs)
    learned = read_learned(directory / LEARNED_FILE) if existing_file(directory / LEARNED_FILE) else {}
    return RunRead(directory, line, timetable, trains, settings, inputs, summary, tables, learned, shown)


def parsed_inputs(inputs: Inputs, file: str) -> tuple[Line, Timetable, dict[str, TrainType], ScenarioFile]:
    """Line, timetable, kind of train by stock id and settings of a run; `file` names its inputs in InputErrors."""
    kinds: dict[str, TrainType] = {}
    with _table_of(file, "line"):
        line = line_of_tables(inputs.line, file)
    with _table_of(file, "timetable"):
        timetable = timetable_of(validate(inputs.timetable, file, TimetableFile), file, line)
    with _table_of(file, "scenario"):
        settings = validate(inputs.scenario, file, ScenarioFile)
    for name, data in inputs.trains.items():
        with _table_of(file, f"trains.{name}"):
            kinds[name] = train_of(data, file, has_run=True)
    for diagram in timetable.diagrams:
        if diagram.stock_id not in inputs.stock:
            raise InputError(
                file, f"stock.{diagram.stock_id}", None, "the train of this set, which is missing"
            )
    return line, timetable, {stock_id: kinds[name] for stock_id, name in inputs.stock.items()}, settings


def _check_finished(directory: Path) -> None:
    """InputError, which says what the directory is, if it is not that of a finished run."""
    place = str(directory)
    try:
        names = {path.name for path in directory.iterdir()}
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise InputError(place, "", None, f"{A_RUN} ({why})") from error
    for name, why in ((INCOMPLETE_FILE, "this one was cut short"), (CRASH_FILE, "a bug has ended this one")):
        # only the report is missing
        if name in names and not (name == INCOMPLETE_FILE and SHOWN_FILE in names):
            raise InputError(place, "", None, f"{A_RUN}; {why}, see {name}")
    if SUMMARY_FILE not in names:
        raise InputError(place, "", None, f"{A_RUN}; it has no {SUMMARY_FILE}")
    if INPUTS_FILE not in names:
        expected = f"{A_RUN}; it has no {INPUTS_FILE}: it is of an older version, run the scenario again"
        raise InputError(place, "", None, expected)
    data = read_json(directory / SUMMARY_FILE, object)
    number = data.get(FORMAT_KEY, 0) if is_table(data) else 0  # runs of before it was counted have none
    if isinstance(number, int) and number > FORMAT:
        expected = (
            f"at most {FORMAT}, the format of run directories that this version knows: a later one wrote it"
        )
        raise InputError(str(directory / SUMMARY_FILE), FORMAT_KEY, number, expected)


@contextmanager
def _table_of(file: str, table: str) -> Generator[None]:
    """One table of the inputs; an error in it names the key with its table."""
    try:
        yield
    except InputError as error:
        key = f"{table}.{error.key}" if error.key else table
        raise InputError(file, key, error.value, error.expected) from error


def _check_names(directory: Path, tables: RunTables, line: Line, inputs: Inputs) -> None:
    """Everything that the tables name is there, or InputError: they are of this run."""
    known: tuple[tuple[str, pl.Series, Collection[str]], ...] = (
        ("stops.station", tables.stops["station"], line.stations),
        ("stops.unit", tables.stops["unit"], inputs.stock),
        ("trajectory.piece", tables.trajectory["piece"], line.pieces),
        ("trajectory.unit", tables.trajectory["unit"], inputs.stock),
        ("blocks.section", tables.blocks["section"], line.sections),
        ("energy.unit", tables.energy["unit"], inputs.stock),
    )
    for name, column, names in known:
        table, _, key = name.partition(".")
        strange = sorted(str(value) for value in column.unique() if value not in names)
        if strange:
            expected = f"a name of this run, as {INPUTS_FILE} has them: the file is of another run"
            raise InputError(str(directory / f"{table}.parquet"), key, strange[0], expected)


def _summary(directory: Path, settings: ScenarioFile) -> Mapping[str, Any]:
    """The summary; InputError where it is not that of this run."""
    path = directory / SUMMARY_FILE
    file, data = str(path), read_json(path, object)
    if not is_table(data):
        raise InputError(file, "", None, "the summary of a run")
    for key in _TEXTS:
        if not isinstance(data.get(key), str):
            raise InputError(file, key, data.get(key), "a text")
    if data["scenario"] != settings.id:
        raise InputError(file, "scenario", data["scenario"], f"{settings.id}, as {INPUTS_FILE} has it")
    return data


def _check_tables(directory: Path, shown: Shown) -> None:
    """The tables are those that the run has written, or InputError; the decoder has not seen them yet."""
    try:
        found = digests_of_tables(directory)
    except OSError as error:
        raise InputError(str(error.filename), "", None, f"a table of a run ({error.strerror})") from error
    for name in sorted(found.keys() | shown.tables.keys() & TABLE_FILES):
        if name not in found:
            raise InputError(str(directory / name), "", None, "a table of a run (no such file)")
        if shown.tables.get(name) != found[name]:
            expected = f"the table that this run has written, by its digest in {SHOWN_FILE}"
            raise InputError(str(directory / name), "", None, expected)
