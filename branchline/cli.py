"""The command `branchline`: every command is a function of a module of its own, listed here in its group.

Heavy imports are inside the commands, so that help is quick. How a command ends: `branchline.ending`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import nullcontext
from copy import copy
from functools import cache, partial
from importlib.metadata import version
from typing import Annotated, Final, cast

import typer
from typer.core import TyperGroup

from branchline.arranging import arrange
from branchline.best import best
from branchline.blocking import blocking
from branchline.certifying import certificates
from branchline.checking import check
from branchline.comparing import compare
from branchline.compressing import capacity
from branchline.describing import schema
from branchline.drilling import drill
from branchline.duties import duties
from branchline.ending import run_command, stop_by_signals
from branchline.exporting import exporters
from branchline.headways import headway
from branchline.importing import importers
from branchline.making import makers
from branchline.measuring import bench
from branchline.partners import with_partners
from branchline.plotting import plot
from branchline.progress import CompilingShown, never_silent
from branchline.reporting import report
from branchline.reproducing import reproduce
from branchline.running import run
from branchline.serving import serve
from branchline.sweeping_days import sweep
from branchline.taking_part import serve_party
from branchline.timing import running_times
from branchline.verifying import verify
from study.outcome import Outcome
from vehicle.compiling import WATCHERS

app = typer.Typer(name="branchline", pretty_exceptions_enable=False)
COMPLETION: Final = "_BRANCHLINE_COMPLETE"  # set by a shell that asks what may follow on its command line
PREPARE, RUN, READ = "Prepare: lines, timetables, trains, scenarios", "Run", "Read a finished run"
ANALYSE, RESEARCH = "Analyse: running times, headways, capacity", "Research"
COMMANDS: Final[tuple[tuple[str, *tuple[Callable[..., None], ...]], ...]] = (
    (PREPARE, arrange, check, schema),
    (RUN, run, drill, sweep, serve, certificates, serve_party),
    (READ, report, compare, plot),
    (ANALYSE, duties, running_times, headway, capacity, blocking),
    (RESEARCH, reproduce, bench),
)
for group, *commands in COMMANDS:
    for command in commands:
        app.command(command.__name__.replace("_", "-"), rich_help_panel=group)(command)
app.add_typer(makers, name="new", rich_help_panel=PREPARE)
app.add_typer(importers, name="import", rich_help_panel=PREPARE)
app.add_typer(exporters, name="export", rich_help_panel=READ)
app.add_typer(verify, name="verify", rich_help_panel=RESEARCH)
app.add_typer(best, name="best", rich_help_panel=ANALYSE)


@cache
def whole_command(name: str = "") -> TyperGroup:
    """All commands, or that of the name alone, put together once a process: all take as long as a short command."""
    asked = copy(app)
    asked.registered_commands = [each for each in app.registered_commands if each.name == name]
    asked.registered_groups = [each for each in app.registered_groups if each.name == name]
    found = asked if asked.registered_commands or asked.registered_groups else app
    return with_partners(cast("TyperGroup", typer.main.get_command(found)))


def main() -> None:
    """Entry point: how a command ends, and one line on stderr wherever a person has to act."""
    stop_by_signals()
    WATCHERS[:] = [CompilingShown()]
    sys.exit(run_command(partial(_run_command, sys.argv[1:])).code)


def _run_command(arguments: list[str]) -> Outcome:
    """Commands end by `typer.Exit` with the code of their outcome, or by coming to their end."""
    command = whole_command(*arguments[:1])
    if os.environ.get(COMPLETION):
        command.main(arguments, "branchline", COMPLETION)  # answers and exits
    try:
        waits = arguments[:1] in (["serve"], ["serve-party"])  # for people
        said = nullcontext() if waits else never_silent(" ".join(arguments[:2]))
        with command.make_context("branchline", arguments) as context, said:
            command.invoke(context)
    except typer.Exit as ending:
        return next(outcome for outcome in Outcome if outcome.code == ending.exit_code)
    return Outcome.GOOD


def _print_version(asked: bool) -> None:
    if asked:
        sys.stdout.write(f"branchline {version('branchline')}\n")
        raise typer.Exit


@app.callback()
def _of_all_commands(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """Simulate the traffic and the interlocking of a single-track branch line."""


if __name__ == "__main__":
    os.environ.setdefault("PYTHONUNBUFFERED", "1")
    main()
