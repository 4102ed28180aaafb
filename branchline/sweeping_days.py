"""`branchline sweep`: thousands of days of a scenario over a grid and random draws."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from branchline.ending import end, judged, print_json
from branchline.options import Json
from branchline.progress import progress_of_days, tell
from network.errors import InputError

if TYPE_CHECKING:
    from study.sweep.go import State
    from study.sweep.plan import Plan


def sweep(
    file: Annotated[str, typer.Argument(help="A sweep file (.toml); docs/sweeps.md says how to write one.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Directory; default sweeps/<id>. What is there is not run again."),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option("--jobs", min=1, help="Processes of this machine; default one a processor.")
    ] = None,
    carrier: Annotated[
        str | None,
        typer.Option(
            "--carrier", help="sumo, or plain, with every tenth day again on sumo; default as the file says."
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler", help="A Dask scheduler, tcp://host:port, in place of processes of this machine."
        ),
    ] = None,
    days: Annotated[
        int | None, typer.Option("--days", help="Days of each point; default as the file says.")
    ] = None,
    recycle: Annotated[
        int, typer.Option("--recycle", min=1, help="Days after which a process of this machine is replaced.")
    ] = 200,
    anyway: Annotated[
        bool, typer.Option("--anyway", help="Also go on where days were run by other code than this.")
    ] = False,
    check: Annotated[bool, typer.Option("--check", help="Read everything, run and write nothing.")] = False,
    as_json: Json = False,
) -> None:
    """Run the days of a sweep that are missing and write its report; exit code 1 if SUMO carries a day otherwise, a day
    crashes, or a rule is broken.
    """
    from study.run.forks import jobs_of
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
        stopped: GivenUpError | None = None
        try:
            with nullcontext() if state.done else progress_of_days(plan.table.id) as show:
                go(state, store, pump, None if show is None else lambda state: show(state.progress()))
        except GivenUpError as error:
            stopped = error
        if stopped is not None:
            raise given_up(stopped, state, directory)
        tell("writing the report")
        page = write_sweep_report(state, directory)
    good = not state.failures
    summary = summary_of(state, directory)
    if as_json:
        print_json(summary, judged(good))
    else:
        _print_sweep(state, page)
    for text in state.failures:
        tell(f"broken: {text}")
    end(judged(good))
