"""`branchline new scenario|timetable|train|drill|curvature-map`: files to begin with, which run as they stand."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from branchline.options import ScenarioName, Seed
from branchline.progress import print_aside

NewFile = Annotated[Path, typer.Argument(help="File to write, NAME.toml; NAME is its id.")]
OnScenario = Annotated[str, typer.Option(help="A shipped scenario, or a scenario file (.toml).")]


def new_scenario(out: NewFile, extends: OnScenario = "karasuyama_weekday") -> None:
    """Write a what-if: a scenario that extends another, with examples of changes."""
    from study.making.scenario import new_scenario as made

    made(extends, out)
    print_aside(f"wrote {out}: `branchline run {out}`")


def new_curvature_map(
    scenario: ScenarioName,
    out: Annotated[Path, typer.Argument(help="Map (JSON) to write, for `curvature.map` of a scenario.")],
    train: Annotated[
        str | None,
        typer.Option(
            "--train", help="Number of the train that makes a first run; without it, the design of the line."
        ),
    ] = None,
    seed: Seed = None,
) -> None:
    """Write a map of curvature, from the line's design or from a first run of a train."""
    from papers.first_run import new_curvature_map as made

    of = made(scenario, out, train, seed)
    print_aside(
        f"wrote {out}: {len(of.pieces)} pieces of {of.line_id} by {of.made}; `[curvature] map = {out.name!r}`"
    )


def new_drill(out: NewFile, scenario: OnScenario = "rtri_test_line") -> None:
    """Write a drill for a scenario: one fault, one act, and what is expected."""
    from study.making.scenario import new_drill as made

    made(scenario, out)
    print_aside(f"wrote {out}: `branchline drill {out}`")


def new_train(
    out: NewFile,
    like: Annotated[str, typer.Option(help="A shipped train, or a train file, to start from.")] = "ev_e301",
    name: Annotated[str | None, typer.Option(help="What people call it.")] = None,
    length_m: Annotated[float | None, typer.Option("--length-m", help="Length, m.")] = None,
    mass_t: Annotated[float | None, typer.Option("--mass-t", help="Empty mass, t.")] = None,
    cars: Annotated[int | None, typer.Option("--cars", help="Number of cars.")] = None,
    power_kw: Annotated[float | None, typer.Option("--power-kw", help="Power at the wheel, kW.")] = None,
    force_kn: Annotated[
        float | None, typer.Option("--force-kn", help="Tractive force at a start, kN.")
    ] = None,
    max_speed_kmh: Annotated[
        float | None, typer.Option("--max-speed-kmh", help="Maximum speed, km/h.")
    ] = None,
) -> None:
    """Write a train file: a shipped one with its keys explained and with the figures that you give."""
    from study.making.train import Figures
    from study.making.train import new_train as made

    made(like, out, Figures(name, length_m, mass_t, cars, power_kw, force_kn, max_speed_kmh))
    print_aside(f"wrote {out}: name it in a scenario, `[trains] default = {str(out)!r}`")


def new_timetable(
    out: NewFile,
    line: Annotated[str, typer.Option("--line", help="A shipped line, or a line file (.toml).")],
    every: Annotated[int, typer.Option("--every", help="Minutes from one train to the next, each way.")] = 60,
    from_time: Annotated[str, typer.Option("--from", help="First departure, HH:MM.")] = "06:00",
    to_time: Annotated[
        str, typer.Option("--to", help="From then on no train leaves an end, HH:MM.")
    ] = "22:00",
    train: Annotated[str, typer.Option("--train", help="A shipped train, or a train file.")] = "ev_e301",
    scenario: Annotated[
        Path | None, typer.Option("--scenario", help="Also write a scenario that runs it.")
    ] = None,
) -> None:
    """Write a timetable that works: trains both ways over the whole line at even intervals."""
    from network.timetable import seconds_of
    from study.making.timetable import Pattern
    from study.making.timetable import new_timetable as made

    times_s = [
        seconds_of("command line", key, text, None)
        for key, text in (("--from", from_time), ("--to", to_time))
    ]
    day = made(line, train, Pattern(60 * every, *times_s), out, scenario)
    print_aside(f"wrote {out}: {day.trains} trains, {day.sets} set{'s' if day.sets > 1 else ''}")
    if day.tight:
        places = f"{day.tight} place{'s' if day.tight > 1 else ''}"
        print_aside(f"remark: no pattern was found that has room everywhere: this one is tight at {places}")
    if scenario is not None:
        print_aside(f"wrote {scenario}: `branchline run {scenario}`")
