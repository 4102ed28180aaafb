"""`branchline sweep`: thousands of days of a scenario over a grid and random draws."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from branchline.ending import end, judged_outcome, print_json
from branchline.options import Json
from branchline.progress import print_aside

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
        int,
        typer.Option("--recycle", min=1, help="Without --scheduler: days after which a process is replaced."),
    ] = 200,
    anyway: Annotated[
        bool, typer.Option("--anyway", help="Go on even if days were run by another version of the code.")
    ] = False,
    check: Annotated[bool, typer.Option("--check", help="Read everything, run and write nothing.")] = False,
    as_json: Json = False,
) -> None:
    """Run the missing days of a sweep and write its report.

    Exit code 1: a day crashed, broke a rule, or went otherwise on SUMO than without.
    """
    from branchline.whole_sweep import SweepAsked, run_sweep
    from study.sweep.plan import load_plan
    from study.sweep.table import summary_of

    asked = SweepAsked(jobs, carrier, scheduler, recycle, anyway)
    plan = load_plan(file, days, carrier)
    if check:
        _print_plan(plan, as_json)
        return
    directory = (out or Path("sweeps") / plan.table.id).resolve()
    state, page = run_sweep(plan, directory, asked, progress=True)
    good = not state.failures
    if as_json:
        print_json(summary_of(state, directory), judged_outcome(good))
    else:
        _print_sweep(state, page)
    for text in state.failures:
        print_aside(f"broken: {text}")
    end(judged_outcome(good))


def _print_plan(plan: SweepPlan, as_json: bool) -> None:
    """What would be run."""
    if as_json:
        points = [{"point": p.number, "label": p.label, "inputs": p.inputs} for p in plan.points]
        figures: dict[str, Any] = {"sweep": plan.table.id, "days_of_each": plan.days, "points": points}
        print_json(figures, judged_outcome(True))
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
