"""A sweep of planted days in this process, and the table that is on disk."""

from collections.abc import Generator, Iterator
from pathlib import Path

from study.sweep.go import Show, SweepProgress, run_missing, sweep_begun
from study.sweep.local import Pump
from study.sweep.plan import load_plan
from study.sweep.store import opened_sweep
from study.sweep.table import days_csv
from study.sweep.worker import FiledDay, Task, run_task
from tests.study.sweep.planted import RUNNER


class Here:
    """Days in this process, one after the other, the last one first."""

    def run(self, tasks: Iterator[Task]) -> Generator[FiledDay]:
        for task in reversed(list(tasks)):
            yield run_task(task)


class OneByOne:
    """Days in this process, in their order."""

    def run(self, tasks: Iterator[Task]) -> Generator[FiledDay]:
        for task in tasks:
            yield run_task(task)


def swept(
    file: Path, out: Path, pump: Pump | None = None, days: int | None = None, show: Show | None = None
) -> SweepProgress:
    """Run what is missing."""
    plan = load_plan(str(file), days)
    with opened_sweep(plan, out) as store:
        state = sweep_begun(plan, store, anyway=False)
        run_missing(state, store, pump or Here(), show, runner=RUNNER)
        return state


def table(file: Path, out: Path) -> str:
    """The table of what is on disk, read anew: nothing is run."""
    plan = load_plan(str(file))
    with opened_sweep(plan, out) as store:
        state = sweep_begun(plan, store, anyway=False)
    assert state.done
    return days_csv(state)
