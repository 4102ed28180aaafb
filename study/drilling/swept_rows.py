"""The rows of a sweep: `sweep.csv`, written run by run, so that a sweep that is stopped loses nothing of it.

While a sweep runs its rows grow in a folder beside the one asked for, under a name that says that it is incomplete;
the whole sweep takes its place. Rows are taken up again for the same inputs alone, whichever code ran them: each says.
"""

from __future__ import annotations

import csv
from collections.abc import Generator, Iterable, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from network.errors import InputError
from simulation.setup import STEPS_PER_S
from study.drilling.forks import CopyDied, Key
from study.drilling.outcome_class import OutcomeKind, SweptRun, swept_run_of_death
from study.record.directory import INCOMPLETE, check_out

CSV_FILE: Final = "sweep.csv"
COLUMNS: Final = ("variation", "instant_s", "kind", "class", "late_s", "digest", "inputs", "code")
DIGITS: Final = 8  # of a digest in a row


@dataclass(frozen=True, slots=True)
class MadeOf:
    """What the runs of a sweep are made of, faults apart, and the code that runs them: digests."""

    inputs: str = ""
    code: str = ""

    def shortened(self) -> MadeOf:
        """As rows have it."""
        return MadeOf(self.inputs[:DIGITS], self.code[:DIGITS])


@dataclass(frozen=True, slots=True)
class SweptRow:
    """A run of a sweep, and what it was made of."""

    run: SweptRun
    made_of: MadeOf


class SweptRows:
    """The rows of a sweep that is under way: those `taken_up`, and those that are added.

    `folder` None: they are not kept.
    """

    def __init__(self, folder: Path | None, made_of: MadeOf, taken_up: Mapping[Key, SweptRow]) -> None:
        self._file = None if folder is None else folder / CSV_FILE
        self._made_of = made_of.shortened()
        self.taken_up: Final = dict(taken_up)
        self.rows: Final = dict(taken_up)
        if self._file is not None:
            write_rows(self._file, taken_up)

    def made_of(self, key: Key) -> MadeOf:
        """What a run was made of."""
        return self.rows[key].made_of if key in self.rows else self._made_of

    @property
    def of_other_code(self) -> int:
        """How many of those taken up another code ran."""
        return sum(row.made_of.code != self._made_of.code for row in self.taken_up.values())

    def take(self, key: Key, found: SweptRun | CopyDied) -> None:
        """A run has ended."""
        run = swept_run_of_death(found) if isinstance(found, CopyDied) else found
        self.rows[key] = SweptRow(run, self._made_of)
        if self._file is not None:
            with self._file.open("a", encoding="utf-8", newline="") as stream:
                csv.writer(stream).writerow(_cells(key, self.rows[key]))


@contextmanager
def growing_rows(out: Path | None, made_of: MadeOf, *, resume: bool) -> Generator[SweptRows]:
    """Rows of a sweep whose directory will be `out`; they are in its place, or still there, when the context ends."""
    if out is None:
        yield SweptRows(None, made_of, {})
        return
    aside = out.with_name(out.name + INCOMPLETE)
    check_out(aside, {CSV_FILE}.__contains__, "rows of a sweep")
    try:
        aside.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        expected = f"a directory that can be written ({error.strerror})"
        raise InputError("command line", "--out", out, expected) from error
    there = [row for folder in (out, aside) for row in read_rows(folder / CSV_FILE)] if resume else []
    inputs = made_of.shortened().inputs
    rows = SweptRows(aside, made_of, {key: row for key, row in there if row.made_of.inputs == inputs})
    in_place = False
    try:
        yield rows
        in_place = True
    finally:
        if in_place or not rows.rows:
            (aside / CSV_FILE).unlink()
            aside.rmdir()


def write_rows(file: Path, rows: Mapping[Key, SweptRow]) -> None:
    """All rows of a sweep."""
    with file.open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(COLUMNS)
        table.writerows(_cells(key, row) for key, row in rows.items())


def read_rows(file: Path) -> Iterable[tuple[Key, SweptRow]]:
    """The rows that a file has, if there is one; a last row that was not written to its end is none."""
    if not file.is_file():
        return []
    with file.open(encoding="utf-8", newline="") as stream:
        lines = list(csv.reader(stream))
    whole = len(COLUMNS)
    return [_row(cells) for cells in lines[1:] if len(cells) == whole and len(cells[-1]) == DIGITS]


def _cells(key: Key, row: SweptRow) -> tuple[object, ...]:
    (variation, step), run, made_of = key, row.run, row.made_of
    instant_s = step / STEPS_PER_S
    outcome = run.kind.name.lower(), run.label, run.late_s, run.digest
    return variation, instant_s, *outcome, made_of.inputs, made_of.code


def _row(cells: list[str]) -> tuple[Key, SweptRow]:
    variation, instant_s, kind, label, late_s, digest, inputs, code = cells
    run = SweptRun(OutcomeKind[kind.upper()], label, float(late_s), digest)
    return (variation, round(float(instant_s) * STEPS_PER_S)), SweptRow(run, MadeOf(inputs, code))
