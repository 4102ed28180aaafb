"""A run that has just ended, compared with one that was kept: for its report and its directory."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from network.model import Line
from study.compare.comparison import Comparisons, compare
from study.compare.files import json_text
from study.compare.parts import parts_against
from study.compare.side import ComparedRun, check_same_line, of_read, of_run
from study.record.directory import COMPARE_FILE
from study.record.read_back import read_run
from study.report.beside import Beside
from study.runner.run import FinishedRun, RunExtras


@dataclass(frozen=True, slots=True)
class RunAgainst:
    """What was found, and what it adds to the run directory."""

    found: Comparisons
    more: RunExtras


def base_of(directory: Path, line: Line) -> ComparedRun:
    """The run to be compared with, read before the other one begins: that may take its place.

    Raises InputError for a directory that is none of a run, or is of another line.
    """
    read = read_run(directory)
    check_same_line(line, read.line, directory)
    return of_read(read, directory.resolve().name)


def changes_from_base(run: FinishedRun, base: ComparedRun, over_s: float) -> RunAgainst:
    """What changed from the run that was kept to the one that has just ended."""
    label = run.scenario.id
    found = compare((base, of_run(run, label if label != base.label else f"{label} (now)")), over_s)
    times = found.pairs[0].times
    moved = frozenset({one.train for one in times.moved} | {one.train for one in times.once})
    beside = Beside(base.label, base.run, moved, frozenset(times.only_base))
    parts = parts_against(found, graphs=False)
    return RunAgainst(found, RunExtras(parts, {COMPARE_FILE: json_text(found)}, beside))
