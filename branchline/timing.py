"""`branchline running-times`: what each leg needs (基準運転時分), and what the timetable leaves over it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from branchline.ending import print_json
from branchline.options import Json, ScenarioName
from branchline.progress import print_aside

if TYPE_CHECKING:
    from network.model import Line
    from study.measures.standard_times import PlannedRun, StandardTime


def running_times(
    scenario: ScenarioName,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", help="Directory for running_times.csv, margins.csv and the plot as PNG and SVG."
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Show minimum running times (基準運転時分) by leg, train type and direction, and the margins of the timetable."""
    from scenario.scenario import load_scenario
    from study.measures.standard_times import planned_runs, standard_times
    from study.record.directory import asked_folder
    from study.report.running_times import FILES, write_running_times

    setup = load_scenario(scenario).setup
    with asked_folder(out, FILES.__contains__, "running times") as folder:
        print_aside("computing the least running times")
        times = standard_times(setup)
        print_aside(f"comparing {len(setup.timetable.trains)} trains with them")
        runs = planned_runs(setup)
        if folder is not None:
            write_running_times(folder, setup.line, times, runs)
    if out is not None:
        print_aside(f"wrote {', '.join(sorted(FILES))} in {out}")
    if as_json:
        print_json({"legs": [t.as_dict() for t in times], "margins": [r.as_dict() for r in runs]})
    else:
        _print(setup.line, times, runs)


def _print(line: Line, times: tuple[StandardTime, ...], runs: tuple[PlannedRun, ...]) -> None:
    """A block a kind of train and direction, a row a leg; then runs over more than one leg."""
    from itertools import groupby

    from rich.cells import cell_len, set_cell_size

    from study.measures.standard_times import smallest_margins

    def named(leg: StandardTime | PlannedRun) -> str:
        return f"{line.stations[leg.from_id].name} - {line.stations[leg.to_id].name}"

    least = smallest_margins(runs)
    names = [named(time) for time in times] + [named(run) for run in least.values()]
    width = max(map(cell_len, names), default=0)
    heads = ("km", "stop-stop", "laid down", "stop-pass", "pass-stop", "pass-pass", "margin", "of train")
    for (train, direction), legs in groupby(times, key=lambda time: (time.train, time.direction)):
        title = f"{train}, {direction.name.lower()}: minimum running times, s, and the smallest margin of the timetable"
        rows = [f"{'':{width}}" + "".join(f"{head:>11}" for head in heads)]
        for leg in legs:
            times_s = (leg.stop_pass_s, leg.pass_stop_s, leg.pass_pass_s)
            cells = (
                f"{leg.distance_m / 1000.0:.3f}",
                f"{leg.stop_stop_s:.1f}",
                str(leg.rounded_s() or "-"),
                *("-" if time_s is None else f"{time_s:.1f}" for time_s in times_s),
                *_margin(least.pop((train, direction, leg.from_id, leg.to_id), None)),
            )
            rows.append(set_cell_size(named(leg), width) + "".join(f"{cell:>11}" for cell in cells))
        sys.stdout.write("\n".join((title, *rows, "", "")))
    for run in least.values():
        margin, number = _margin(run)
        over = f"{run.train}, {run.direction.name.lower()}, {named(run)}"
        sys.stdout.write(f"{over}: needs {run.least_s:.1f} s; margin {margin} s of {number}\n")


def _margin(run: PlannedRun | None) -> tuple[str, str]:
    return ("-", "-") if run is None else (f"{run.margin_s:+.1f}", run.number)
