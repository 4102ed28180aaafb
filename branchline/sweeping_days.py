"""`branchline sweep`: thousands of days of a scenario over a grid and random draws."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from branchline.ending import end, judged, print_json
from branchline.options import Json
from branchline.progress import progress_of_days, tell
from network.errors import InputError
from study.outcome import CutShortError

if TYPE_CHECKING:
    from study.sweep.go import SweepProgress
    from study.sweep.plan import SweepPlan


def sweep(
    file: Annotated[str, typer.Argument(help="A shipped sweep, or a sweep file (.toml): docs/sweeps.md.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Directory; default sweeps/<id>. Days that it has are not run again."),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", min=1, help="Processes on this machine; default one per processor."),
    ] = None,
    carrier: Annotated[
        str | None,
        typer.Option(
            "--carrier", help="sumo, or plain with every tenth day again on sumo; default as in the file."
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler", help="A Dask scheduler, tcp://host:port, instead of processes on this machine."
        ),
    ] = None,
    days: Annotated[
        int | None, typer.Option("--days", help="Days of each point; default as in the file.")
    ] = None,
    recycle: Annotated[
        int, typer.Option("--recycle", min=1, help="Days after which a process is replaced.")
    ] = 200,
    anyway: Annotated[
        bool, typer.Option("--anyway", help="Go on even if days were run by another version of the code.")
    ] = False,
    check: Annotated[bool, typer.Option("--check", help="Read everything, run and write nothing.")] = False,
    as_json: Json = False,
) -> None:
    """Run the missing days of a sweep and write its report.

    Exit code 1: a day crashed, broke a rule, or was another day on SUMO.
    """
    from study.drilling.forks import jobs_of
    from study.sweep.cluster import ClusterPump
    from study.sweep.go import begun, go
    from study.sweep.local import GivenUpError, LocalPump
    from study.sweep.plan import load_plan
    from study.sweep.report import write_sweep_report
    from study.sweep.store import opened
    from study.sweep.table import summary_of

    if carrier not in {None, "sumo", "plain"}:
        raise InputError("command line", "--carrier", carrier, "sumo or plain")
    if scheduler is not None and jobs is not None:
        raise InputError("command line", "--jobs", jobs, "no --scheduler, whose workers run the days")
    plan = load_plan(file, days, carrier)
    if check:
        _print_plan(plan, as_json)
        return
    directory = (out or Path("sweeps") / plan.table.id).resolve()
    with opened(plan, directory) as store:
        state = begun(plan, store, anyway=anyway)
        for refused in state.refused:
            tell(f"does not count: days/{refused.name}: {refused.why}")
        pump = (
            LocalPump(jobs_of(jobs), recycle)
            if scheduler is None
            else ClusterPump(scheduler, directory, store.token)
        )
        try:
            with nullcontext() if state.done else progress_of_days(plan.table.id) as show:
                go(state, store, pump, None if show is None else partial(_show, show))
        except GivenUpError as error:
            raise CutShortError(str(error), str(directory)) from error
        tell("writing the report")
        page = write_sweep_report(state, directory)
    good = not state.failures
    if as_json:
        print_json(summary_of(state, directory), judged(good))
    else:
        _print_sweep(state, page)
    for text in state.failures:
        tell(f"broken: {text}")
    end(judged(good))


def _show(show: Callable[[int, int, str], None], state: SweepProgress) -> None:
    """One more day is there."""
    show(state.there, state.total, state.found_text())


def _print_plan(plan: SweepPlan, as_json: bool) -> None:
    """What would be run."""
    if as_json:
        points = [{"point": p.number, "label": p.label, "inputs": p.inputs} for p in plan.points]
        figures: dict[str, Any] = {"sweep": plan.table.id, "days_of_each": plan.days, "points": points}
        print_json(figures, judged(True))
        return
    lines = [f"{plan.table.name}: {len(plan.points)} points, {plan.days} days of each"]
    lines += [f"  {point.number:4}  {point.label}" for point in plan.points]
    sys.stdout.write("\n".join(lines) + "\n")


def _print_sweep(state: SweepProgress, page: Path) -> None:
    """A line a point, and where the report is."""
    from rich.console import Console
    from rich.table import Table

    from study.sweep.figures import FIGURES
    from study.sweep.records import DayOutcome
    from study.sweep.table import point_rows

    watched = state.plan.table.watch
    table = Table(title=state.plan.table.name, title_justify="left")
    for name in ("point", "days", *(FIGURES[name].label for name in watched), "not good"):
        table.add_column(name)
    for row in point_rows(state):
        means = [row.figures[name].mean for name in watched]
        bad = [
            f"{count} {outcome.name.lower()}"
            for outcome, count in row.counts.items()
            if count and outcome is not DayOutcome.GOOD
        ]
        table.add_row(row.point.label, str(row.days), *(mean.text for mean in means), ", ".join(bad))
    Console().print(table)
    sys.stdout.write(f"report: {page}\n")
