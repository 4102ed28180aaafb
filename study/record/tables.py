"""The tables of one run: what the simulation hands over, as polars frames, and their Parquet files.

Times are simulated seconds since midnight of the operating day, positions are kilometrage in m, speeds m/s,
energy kWh at the wire. A null is a time that was not planned or did not come; floats hold no other gaps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, get_type_hints

import polars as pl

from network.errors import InputError
from study.record.battery import BatteryMoment, ChargeTaken
from study.record.calls import CallAsRun, TracePoint
from study.record.crossings import CrossingHour, CrossingPassage
from study.record.driving import DrivenHop
from study.record.energy import HourOfEnergy, LayoverEnergy, LegEnergy, TrainEnergy
from study.record.figure import added_to, columns_of, schema_of
from study.record.journal_rows import ComparedFigure, EventInWords, TelegramsOfWay
from study.record.margins import HopMargin
from study.record.road import RoadHour
from study.record.sections import SectionHeld, SliceOfBlocking
from study.record.wait import Wait


@dataclass(frozen=True, slots=True)
class RunTables:
    """The frames of a run, each with the type of its rows, and of exactly its schema.

    Raises ValueError naming table and column if not.
    """

    trajectory: Annotated[pl.DataFrame, TracePoint]
    stops: Annotated[pl.DataFrame, CallAsRun]
    blocks: Annotated[pl.DataFrame, SectionHeld]
    blocking: Annotated[pl.DataFrame, SliceOfBlocking]
    telegrams: Annotated[pl.DataFrame, TelegramsOfWay]
    energy: Annotated[pl.DataFrame, TrainEnergy]
    energy_legs: Annotated[pl.DataFrame, LegEnergy]
    energy_hours: Annotated[pl.DataFrame, HourOfEnergy]
    layovers: Annotated[pl.DataFrame, LayoverEnergy]
    margins: Annotated[pl.DataFrame, HopMargin]
    driving: Annotated[pl.DataFrame, DrivenHop]
    comparisons: Annotated[pl.DataFrame, ComparedFigure]
    waits: Annotated[pl.DataFrame, Wait]
    battery: Annotated[pl.DataFrame, BatteryMoment]
    charges: Annotated[pl.DataFrame, ChargeTaken]
    road: Annotated[pl.DataFrame, RoadHour]
    crossings: Annotated[pl.DataFrame, CrossingHour]
    warnings: Annotated[pl.DataFrame, CrossingPassage]
    events: Annotated[pl.DataFrame, EventInWords]

    def __post_init__(self) -> None:
        for name, row in ROWS.items():
            problem = _difference(getattr(self, name), row)
            if problem:
                raise ValueError(f"table {name}: {problem}")

    @staticmethod
    def with_tables(**frames: pl.DataFrame) -> RunTables:
        """Some tables, and the others empty."""
        return RunTables(**{name: frames[name] if name in frames else make_table(name) for name in ROWS})

    def write(self, directory: Path) -> None:
        """Write one Parquet file a table; all are written aside before the first takes its name."""
        directory.mkdir(parents=True, exist_ok=True)
        aside = {name: directory / f".{name}.parquet.part" for name in ROWS}
        for name, path in aside.items():
            written = BytesIO()  # an error of the disk then is one of ours, and no library's
            getattr(self, name).write_parquet(written, compression="zstd")
            path.write_bytes(written.getbuffer())
        for name, path in aside.items():
            path.replace(_file(directory, name))

    @staticmethod
    def read(directory: Path) -> RunTables:
        """What `write` wrote, in this version or another: each table is read when it is first asked for.

        InputError then for one that is missing, unreadable or lacks a column; what there is besides is left out.
        """
        found = object.__new__(_TablesRead)
        object.__setattr__(found, "directory", directory)
        return found


class _TablesRead(RunTables):
    """The tables of a directory, as they are asked for."""

    __slots__ = ("directory",)
    directory: Path

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> pl.DataFrame:
            if name not in ROWS:
                raise AttributeError(name)
            object.__setattr__(self, name, _read(self.directory, name))
            return getattr(self, name)


ROWS: Final[dict[str, type]] = {
    name: hint.__metadata__[0] for name, hint in get_type_hints(RunTables, include_extras=True).items()
}


def make_table(name: str, rows: Sequence[object] | Mapping[str, Any] = ()) -> pl.DataFrame:
    """The table `name` from its rows, or from columns (sequences or arrays of one length).

    Raises ValueError when the columns are not exactly those of the schema, TypeError for values that do not fit it.
    """
    schema = schema_of(ROWS[name])
    columns = rows if isinstance(rows, Mapping) else columns_of(ROWS[name], rows)
    if set(columns) != set(schema):
        raise ValueError(f"table {name}: columns {sorted(set(columns) ^ set(schema))} missing or unknown")
    return pl.DataFrame({column: columns[column] for column in schema}, schema=schema)


# Tables that directories written before them lack: empty, as no crossing was recorded then.
_ADDED: Final = ("road", "crossings", "warnings")
_OF_BEFORE: Final = (
    "which this command needs and a run of an earlier version does not have: run the scenario again"
)


def _file(directory: Path, name: str) -> Path:
    return directory / f"{name}.parquet"


def _read(directory: Path, name: str) -> pl.DataFrame:
    path, row = _file(directory, name), ROWS[name]
    if not path.exists():
        if name in _ADDED:
            return make_table(name)
        raise InputError(str(path), "", None, f"this table, {_OF_BEFORE}")
    try:
        frame = pl.read_parquet(path)
    except (OSError, pl.exceptions.PolarsError) as error:
        raise InputError(str(path), "", None, f"the {name} table of a run, in Parquet") from error
    schema = schema_of(row)
    added = {name: value for name, value in added_to(row).items() if name not in frame.columns}
    frame = frame.with_columns(**{name: pl.lit(value, schema[name]) for name, value in added.items()})
    missing = sorted(set(schema) - set(frame.columns))
    if missing:
        raise InputError(str(path), "", None, f"the {name} table of a run with {missing}, {_OF_BEFORE}")
    known = frame.select(list(schema))
    problem = _difference(known, row)
    if problem:
        raise InputError(str(path), "", None, f"the {name} table of a run; {problem}")
    return known


def _difference(frame: pl.DataFrame, row: type) -> str:
    """What tells the frame from the table of such rows, in words; empty when nothing does."""
    schema, held = schema_of(row), frame.schema
    if list(held) != list(schema):
        odd = sorted(set(held) ^ set(schema))
        return f"columns {odd} missing or unknown" if odd else f"columns are not in the order {list(schema)}"
    for column, dtype in schema.items():
        if held[column] != dtype:
            return f"column {column} holds {held[column]}, not {dtype.__name__}"
    return ""
