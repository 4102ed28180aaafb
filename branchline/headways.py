"""`branchline headway`: how soon one train can come behind another, at each station, and what that time goes into."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from branchline.ending import print_json
from branchline.options import Json
from branchline.progress import print_aside
from network.errors import InputError

if TYPE_CHECKING:
    from network.model import Line
    from scenario.scenario import Scenario
    from study.capacity.headway import HeadwayCase

Source = Annotated[
    str, typer.Argument(help="A shipped scenario, a scenario file (.toml), or a run directory.")
]
ByTheory = Annotated[
    bool,
    typer.Option("--theory", help="Compute from running times, routes set as late as possible; run nothing."),
]


def headway(
    source: Source,
    station: Annotated[
        str | None, typer.Option("--station", help="Only this station, by id or name.")
    ] = None,
    theory: ByTheory = False,
    drive: Annotated[
        bool,
        typer.Option(
            "--drive",
            help="Run the two trains of each theoretical headway alone: at the headway, and one second closer.",
        ),
    ] = False,
    out: Annotated[
        Path | None, typer.Option("--out", help="Directory for headways.csv and the pictures as PNG and SVG.")
    ] = None,
    as_csv: Annotated[bool, typer.Option("--csv", help="Print the table as CSV on stdout.")] = False,
    as_json: Json = False,
) -> None:
    """Show the least headways (続行, 開通, 追い込み, 着発, 発着) by station and kinds of trains.

    With the section that decides each and what its seconds go into.
    """
    from branchline.questions import headways_of
    from branchline.sources import loaded_source
    from study.record.directory import asked_folder
    from study.report.headways import FILES, headway_table, write_headways

    if as_csv and as_json:
        raise InputError("command line", "--csv", None, "one of --csv and --json")
    if drive and out is not None:
        raise InputError("command line", "--drive", None, "--drive without --out")
    if drive:
        scenario = undisturbed_scenario(source)
        cases = headways_of(scenario, station, theory=True)
        _print_driven(scenario, cases.cases, as_csv=as_csv, as_json=as_json)
        return
    loaded = loaded_source(source)
    with asked_folder(out, FILES.__contains__, "headways") as folder:
        found = headways_of(loaded, station, theory=theory, progress=True)
        shown = found.cases
        if folder is not None:
            write_headways(folder, found.line, shown)
    if out is not None:
        print_aside(f"wrote {', '.join(sorted(p.name for p in out.iterdir()))} in {out}")
    if as_json:
        print_json({"of": "theory" if theory else "run", "headways": [case.as_dict() for case in shown]})
    elif as_csv:
        sys.stdout.write(headway_table(shown).write_csv())
    else:
        _print(found.line, shown)


def undisturbed_scenario(source: str) -> Scenario:
    """A scenario in which nothing is drawn, to be driven."""
    from dataclasses import replace

    from scenario.scenario import load_scenario
    from study.capacity.two_trains import undisturbed_setup

    scenario = load_scenario(source)
    return replace(scenario, setup=undisturbed_setup(scenario.setup))


def _print_driven(scenario: Scenario, cases: tuple[HeadwayCase, ...], *, as_csv: bool, as_json: bool) -> None:
    """A line a headway: by how much the second train is late with it, and with a second less, and what a run needs."""
    from host.scratch import scratch
    from study.evaluate.headways_driven import DrivenHeadway, HeadwayDrives
    from study.report.headways import kind_name, table_of
    from study.runner.run import TEMPORARY

    with scratch(TEMPORARY) as folder:
        drives = HeadwayDrives(scenario, folder)
        driven: list[DrivenHeadway] = []
        for number, case in enumerate(cases, start=1):
            print_aside(f"{number} of {len(cases)}: {case.station_id}, {case.headway.kind.english}")
            driven.append(drives.drive_headway(case))
    rows = [{**one.case.as_dict(), **one.as_dict()} for one in driven]
    if as_json:
        print_json({"of": "theory, driven", "headways": rows})
        return
    if as_csv:
        sys.stdout.write(table_of(rows).write_csv())
        return
    for one in driven:
        head = f"{one.case.station_id}, {kind_name(one.case)}, {one.case.first} / {one.case.second}"
        sys.stdout.write(f"{head}: {one.text}\n")
    agree = sum(one.agrees for one in driven)
    sys.stdout.write(f"{agree} of {len(driven)}: on time at the headway, and late one second closer\n")


def _print(line: Line, cases: tuple[HeadwayCase, ...]) -> None:
    """A block a station: what the two trains are, the least headway, where, what it costs, and what the plan leaves."""
    from itertools import groupby

    from rich.cells import cell_len, set_cell_size

    from study.capacity.occupation import OccupationCost
    from study.report.headways import kind_name

    if not cases:
        sys.stdout.write("no headway: no two trains of different sets need the same section\n")
        return
    costs = [cost for cost in OccupationCost if any(abs(case.headway.costs_s[cost]) > 0.05 for case in cases)]
    wide = max(len(f"{c.first} / {c.second}") for c in cases)
    long = max(cell_len(kind_name(c)) for c in cases)
    for station_id, own in groupby(cases, key=lambda case: case.station_id):
        heads = ("least s", *(cost.value for cost in costs), "left over")
        rows = [
            f"{line.stations[station_id].name}, {station_id}",
            f"{'first / second':{wide}}  {'':{long}}"
            + "".join(f"{head:>14}" for head in heads)
            + "  section",
        ]
        for case in own:
            one, near = case.headway, case.closest
            cells = (
                f"{one.least_s:.1f}",
                *(f"{one.costs_s[cost]:.1f}" for cost in costs),
                "-" if near is None else f"{near.buffer_s:+.0f}",
            )
            rows.append(
                f"{case.first + ' / ' + case.second:{wide}}  {set_cell_size(kind_name(case), long)}"
                + "".join(f"{cell:>14}" for cell in cells)
                + f"  {one.section_id}"
            )
        sys.stdout.write("\n".join((*rows, "", "")))
