"""A day of which more is to stay than its figures: run as `branchline run` runs it, and put into `runs/`."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import Final

from network.errors import InputError
from study.outcome import Outcome, outcome_of
from study.record.directory import JOURNAL_FILE, REPORT_FILE, replacing_folder
from study.runner.crash import exception_line
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute, write_run
from study.sweep.day import ProcessCache, record_of
from study.sweep.records import DayOutcome, DayRecord, DaySpec
from study.sweep.store import RUNS, day_name

REPORT: Final = "report"
JOURNAL: Final = "journal"
TRAJECTORY: Final = "trajectory"
_FILES: Final = {REPORT: REPORT_FILE, JOURNAL: JOURNAL_FILE, TRAJECTORY: f"{TRAJECTORY}.parquet"}


def kept_day(spec: DaySpec, index: int, out: Path, keep: tuple[str, ...], warm: ProcessCache) -> DayRecord:
    """Run a day and keep of it what is asked for, below `out`. A bug ends in a record of a crashed day."""
    try:
        run = execute(warm.scenario(spec), PartyLink.SIMULATED, carrier=CarrierKind(spec.carrier))
    except Exception as error:
        if outcome_of(error) is not Outcome.BUG:
            raise
        why = f"{exception_line(error)}; again: {warm.replay_of(spec)}"
        return DayRecord(spec, index, DayOutcome.CRASHED, why, None)
    _keep(run, _folder(spec, index, out), keep)
    setup = run.scenario.setup
    return record_of(spec, index, run.result, replace(setup, day=setup.tuning.days))


def is_kept(record: DayRecord, out: Path, keep: Collection[str]) -> bool:
    """Whether what is asked for lies below `out`; of a day that crashed there is nothing."""
    folder = _folder(record.spec, record.index, out)
    return record.outcome is DayOutcome.CRASHED or all((folder / _FILES[what]).exists() for what in keep)


def _folder(spec: DaySpec, index: int, out: Path) -> Path:
    return out / RUNS / day_name(spec, index).removesuffix(".json")


def _keep(run: FinishedRun, out: Path, keep: tuple[str, ...]) -> None:
    """Write the whole run directory, or single files of it. What lay there is of a try before."""
    try:
        if REPORT in keep:
            write_run(run, out)
            return
        with replacing_folder(out) as folder:
            folder.mkdir()
            if JOURNAL in keep:
                (folder / JOURNAL_FILE).write_bytes(run.result.journal.to_bytes())
            if TRAJECTORY in keep:
                run.tables.trajectory.write_parquet(folder / _FILES[TRAJECTORY])
    except InputError as error:
        raise OSError(str(error)) from error
