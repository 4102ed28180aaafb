"""The missing days of a sweep, run into its directory, as `branchline sweep` and `branchline.sweep` do it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from branchline.progress import print_aside, progress_of_days
from network.errors import COMMAND_LINE, InputError
from study.drilling.forks import jobs_of
from study.outcome import CutShortError
from study.runner.run import carrier_of
from study.sweep.cluster import ClusterPump
from study.sweep.go import SweepProgress, run_missing, sweep_begun
from study.sweep.local import GivenUpError, LocalPump
from study.sweep.plan import SweepPlan
from study.sweep.report import write_sweep_report
from study.sweep.store import opened_sweep

RECYCLE_DAYS = 200  # after which a process is replaced


@dataclass(frozen=True, slots=True)
class SweepAsked:
    """How a sweep is run: by so many processes of this machine, or by a Dask scheduler. InputError where it cannot."""

    jobs: int | None = None
    carrier: str | None = None
    scheduler: str | None = None
    recycle: int = RECYCLE_DAYS
    anyway: bool = False

    def __post_init__(self) -> None:
        if self.carrier is not None:
            carrier_of(self.carrier)
        if self.scheduler is not None and self.jobs is not None:
            expected = "no --scheduler, whose workers run the days"
            raise InputError(COMMAND_LINE, "--jobs", self.jobs, expected)


def run_sweep(
    plan: SweepPlan, directory: Path, asked: SweepAsked, *, progress: bool
) -> tuple[SweepProgress, Path]:
    """Run what is missing and write the report: how far it is, and the page. CutShortError keeps what was run."""
    with opened_sweep(plan, directory) as store:
        state = sweep_begun(plan, store, anyway=asked.anyway)
        for refused in state.refused:
            print_aside(f"does not count: days/{refused.name}: {refused.why}")
        pump = (
            LocalPump(jobs_of(asked.jobs), asked.recycle)
            if asked.scheduler is None
            else ClusterPump(asked.scheduler, directory, store.token)
        )
        quiet = state.done or not progress
        try:
            with nullcontext() if quiet else progress_of_days(plan.table.id) as show:
                run_missing(state, store, pump, None if show is None else partial(_show, show))
        except GivenUpError as error:
            raise CutShortError(str(error), str(directory)) from error
        if progress:
            print_aside("writing the report")
        return state, write_sweep_report(state, directory)


def _show(show: Callable[[int, int, str], None], state: SweepProgress) -> None:
    """One more day is there."""
    show(state.there, state.total, state.found_text())
