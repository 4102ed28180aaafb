"""One of the runs that are compared, read back from its directory or just finished."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from network.errors import InputError
from network.model import Line
from scenario.inputs import Inputs
from study.record.directory import labels_of
from study.record.read_back import RunRead, read_run
from study.report.data import ReportedRun as Course

if TYPE_CHECKING:
    from study.runner.run import FinishedRun


@dataclass(frozen=True, slots=True)
class ComparedRun:
    """A run by the name under which it is compared; `run` has line, timetable and tables."""

    label: str
    name: str
    inputs: Inputs
    summary: Mapping[str, Any]
    run: Course
    directory: Path | None = None
    broken: tuple[str, ...] = field(default=())


def read_sides(directories: Sequence[Path]) -> tuple[ComparedRun, ...]:
    """The runs of some directories. InputError for a directory that is none of a run, or is of another line."""
    reads = [read_run(directory) for directory in directories]
    for read in reads[1:]:
        check_same_line(reads[0].line, read.line, read.directory)
    return tuple(of_read(read, label) for read, label in zip(reads, labels_of(directories), strict=True))


def of_read(read: RunRead, label: str) -> ComparedRun:
    """A run that was read back."""
    course = Course(read.line, read.timetable, read.tables)
    return ComparedRun(
        label, read.name, read.inputs, read.summary, course, read.directory, _broken(read.summary)
    )


def of_run(run: FinishedRun, label: str) -> ComparedRun:
    """A run that has just come to its end."""
    setup, scenario = run.scenario.setup, run.scenario
    course = Course(setup.line, setup.timetable, run.tables)
    return ComparedRun(label, scenario.name, scenario.inputs, run.summary, course, None, _broken(run.summary))


def check_same_line(base: Line, other: Line, directory: Path) -> None:
    """Two runs are of one line: it has the same id, or at least the same stations. InputError otherwise."""
    mine, others = set(base.stations), set(other.stations)
    if (base.id == other.id and mine & others) or mine == others:
        return
    expected = f"runs of one line: this one is of {other.name}, the one compared with of {base.name}"
    raise InputError(str(directory), "line", other.id, expected)


def _broken(summary: Mapping[str, Any]) -> tuple[str, ...]:
    """What made the run a failure, in sentences."""
    return tuple(str(text) for text in summary.get("broken", ()))
