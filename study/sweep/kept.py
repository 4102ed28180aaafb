"""A day of which more is to stay than its figures: run as `branchline run` runs it, and put into `runs/`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from network.errors import InputError
from study.outcome import Outcome, outcome_of
from study.run.crash import named
from study.run.directory import JOURNAL_FILE, replaced
from study.run.run import CarrierKind, Link, Run, execute, write_run
from study.sweep.day import Warm, record_of
from study.sweep.records import DayOutcome, DayRecord
from study.sweep.store import RUNS, day_name

if TYPE_CHECKING:
    from study.sweep.worker import Task

REPORT: Final = "report"
JOURNAL: Final = "journal"
TRAJECTORY: Final = "trajectory"


def kept_day(task: Task, warm: Warm) -> DayRecord:
    """Run a day and keep of it what is asked for. A bug ends in a record of a crashed day."""
    spec = task.spec
    try:
        run = execute(warm.scenario(spec), Link.SIMULATED, carrier=CarrierKind(spec.carrier))
    except Exception as error:
        if outcome_of(error) is not Outcome.BUG:
            raise
        why = f"{named(error)}; again: {warm.replay_of(spec)}"
        return DayRecord(spec, task.index, DayOutcome.CRASHED, why, None)
    _keep(run, Path(task.out) / RUNS / day_name(spec, task.index).removesuffix(".json"), task.keep)
    setup = run.scenario.setup
    return record_of(spec, task.index, run.result, replace(setup, day=setup.tuning.days))


def _keep(run: Run, out: Path, keep: tuple[str, ...]) -> None:
    """Write the whole run directory, or single files of it. What lay there is of a try before."""
    try:
        if REPORT in keep:
            write_run(run, out)
            return
        with replaced(out) as folder:
            folder.mkdir()
            if JOURNAL in keep:
                (folder / JOURNAL_FILE).write_bytes(run.result.journal.to_bytes())
            if TRAJECTORY in keep:
                run.tables.trajectory.write_parquet(folder / f"{TRAJECTORY}.parquet")
    except InputError as error:
        raise OSError(str(error)) from error
