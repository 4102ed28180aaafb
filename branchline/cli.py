"""The command `branchline`: reads arguments, shows progress, prints results.

Heavy imports are inside the commands, so that help is quick. How a command ends: `branchline.ending`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Generator
from contextlib import contextmanager, nullcontext
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from branchline.ending import JSON_OPTION, ended, judged, print_json, stop_by_signals
from branchline.progress import progress_of, tell
from network.errors import InputError
from study.outcome import Outcome

if TYPE_CHECKING:
    from study.run.run import Run

app = typer.Typer(
    name="branchline",
    help="Line-level traffic and interlocking simulator for single-track branch lines.",
    add_completion=False,
    pretty_exceptions_enable=False,
)
importers = typer.Typer(help="Make line and timetable data from outside sources.")
app.add_typer(importers, name="import")

Json = Annotated[
    bool, typer.Option(JSON_OPTION, help="Print one JSON object on stdout and nothing else there.")
]
Seed = Annotated[int | None, typer.Option("--seed", min=0, help="Seed of every chance in the run.")]
Out = Annotated[Path | None, typer.Option("--out", help="Run directory; default runs/<scenario>.")]
LinkName = Annotated[
    str, typer.Option("--link", help="simulated, or zenoh: a process for each wayside device.")
]
UnitsName = Annotated[
    str,
    typer.Option(
        "--units", help="Where on-board units run: 'simulator', or 'processes' (with --link zenoh)."
    ),
]


def main() -> None:
    """Entry point: how a command ends, and one line on stderr wherever a person has to act."""
    stop_by_signals()
    sys.exit(ended(partial(_run_command, sys.argv[1:])).code)


def _run_command(arguments: list[str]) -> Outcome:
    """Commands end by `typer.Exit` with the code of their outcome, or by coming to their end."""
    command = typer.main.get_command(app)
    try:
        with command.make_context("branchline", arguments) as context:
            command.invoke(context)
    except typer.Exit as ending:
        return next(outcome for outcome in Outcome if outcome.code == ending.exit_code)
    return Outcome.GOOD


def _end(outcome: Outcome) -> NoReturn:
    raise typer.Exit(outcome.code)


@contextmanager
def _crashes_into(directory: Path | None) -> Generator[None]:
    """Where a run leaves its journal if a bug ends it."""
    from study.run.crash import Crashed

    try:
        yield
    except Crashed as crashed:
        crashed.out = directory
        raise


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
    """Line-level traffic and interlocking simulator for single-track branch lines."""


@app.command()
def run(
    scenario: Annotated[str, typer.Argument(help="A shipped scenario, or a scenario file (.toml).")],
    link: LinkName = "simulated",
    units: UnitsName = "simulator",
    carrier: Annotated[
        str, typer.Option("--carrier", help="sumo, or plain: one train on plain track.")
    ] = "sumo",
    seed: Seed = None,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Run a scenario and write its run directory with report.html."""
    from study.run.directory import reserved
    from study.run.run import CarrierKind, execute, fill_run, link_of, units_at
    from study.scenario.scenario import load_scenario

    chosen = link_of(link)
    hosted = units_at(units, chosen)
    if carrier not in {kind.value for kind in CarrierKind}:
        raise InputError("command line", "--carrier", carrier, "sumo or plain")
    loaded = load_scenario(scenario, seed)
    directory = (out or Path("runs") / loaded.id).resolve()
    with reserved(directory) as place:
        with _crashes_into(directory), progress_of(loaded.id) as progress:
            done = execute(
                loaded,
                chosen,
                units=hosted,
                carrier=CarrierKind(carrier),
                progress=progress,
                journal=place.journal,
            )
        tell("writing the report")
        report = fill_run(done, place)
    outcome = judged(not done.broken)
    if as_json:
        print_json(done.summary | {"out": str(directory)}, outcome)
    else:
        _print_run(done, report)
    for text in done.summary["outside_design"]:
        tell(f"outside the design: {text}")
    for text in done.broken:
        tell(f"broken: {text}")
    _end(outcome)


def _latest(late_s: float | None) -> str:
    """The worst lateness of a run in words; None: no train arrived."""
    return "no train arrived" if late_s is None else f"{late_s:.1f} s after the timetable"


def _margin(margins: dict[str, Any] | None) -> str:
    """The hop whose timetable leaves least over the least running time, and what was left as run."""
    least, left = (None if margins is None else margins.get(f"smallest_{of}_s") for of in ("margin", "left"))
    if least is None:
        return "-"
    text = f"{least['margin_s']:.0f} s, {least['train']} {least['from_station']} to {least['to_station']}"
    return text if left is None else f"{text}; as run {left['left_s']:.0f} s left, {left['train']}"


def _net(energy: dict[str, Any]) -> str:
    """Net energy of the day, and by distance."""
    by_train, by_car = energy["net_kwh_per_train_km"]["all"], energy["net_kwh_per_car_km"]["all"]
    text = f"{energy['all']['net']:.1f} kWh"
    return text if by_train is None else f"{text}: {by_train:.2f} a train-km, {by_car:.2f} a car-km"


def _print_run(done: Run, report: Path) -> None:
    """The figures of a run for a person."""
    from rich.console import Console
    from rich.table import Table

    summary = done.summary
    error = {key: summary[f"stop_error_m_{key}"] for key in ("mean", "sigma", "max_abs")}
    energy, telegrams = summary["energy_kwh"], summary["telegrams"]

    def metres(value: float | None) -> str:
        return "-" if value is None else f"{value:.3f}"

    rows = [
        ("trains", f"{summary['trains_arrived']} of {summary['trains_planned']} ran their whole journey"),
        ("empty workings", f"{summary['empty_workings_arrived']} of {summary['empty_workings_planned']}"),
        ("latest", _latest(summary["late_s_max"])),
        ("earliest departure", f"{summary['early_departure_s_max']:.1f} s before the timetable"),
        ("smallest margin", _margin(summary["margins"])),
        (
            "stops",
            f"{summary['stops']}: error mean {metres(error['mean'])} m, sigma {metres(error['sigma'])} m,"
            f" largest {metres(error['max_abs'])} m",
        ),
        ("invariants broken", str(summary["invariants_broken"])),
        (
            "energy",
            f"traction {energy['traction']:.1f}, regenerated {energy['regenerated']:.1f},"
            f" auxiliary {energy['auxiliary']:.1f} kWh",
        ),
        ("net energy", _net(summary["energy"])),
        ("telegrams", ", ".join(f"{count} {name}" for name, count in telegrams.items())),
        ("ended because", summary["ended_because"]),
        ("journal digest", summary["digest"]),
        ("motion digest", summary["motion_digest"]),
        ("wall time", f"{summary['wall_s']:.1f} s for {summary['simulated_s'] / 3600.0:.1f} h"),
    ]
    table = Table(title=done.scenario.name, show_header=False, title_justify="left")
    for name, value in rows:
        table.add_row(name, value)
    Console().print(table)
    sys.stdout.write(f"report: {report}\n")  # whole, however long: to be clicked or copied


@app.command()
def drill(
    file: Annotated[
        str, typer.Argument(help="A shipped drill ('list' shows them), or a drill file (.toml).")
    ],
    link: LinkName = "simulated",
    units: UnitsName = "simulator",
    seed: Seed = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Also write the run directory, or what a sweep found, there.")
    ] = None,
    as_json: Json = False,
    sweep: Annotated[
        bool,
        typer.Option(
            "--sweep",
            help="Move its faults and acts, as one piece, over the run: one line for each class of outcome. Its own"
            " expectations make no sense at other instants: what counts is that everyone arrives, that no invariant"
            " is broken, and that nothing crashes.",
        ),
    ] = False,
    sweep_kinds: Annotated[
        bool,
        typer.Option("--sweep-kinds", help="FILE is a scenario: sweep single faults of every kind over it."),
    ] = False,
    every: Annotated[float, typer.Option("--every", min=0.1, help="Of a sweep: its step, s.")] = 1.0,
    from_time: Annotated[
        str | None,
        typer.Option("--from", help="Of a sweep: first instant; default just before the trains hit begin."),
    ] = None,
    to_time: Annotated[
        str | None, typer.Option("--to", help="Of a sweep: last instant; default where their day has ended.")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option("--jobs", min=1, help="Of a sweep: runs at a time; default one a processor.")
    ] = None,
) -> None:
    """Run a drill and print it expectation by expectation; exit code 1 if one is not met, or a swept run is bad."""
    if sweep or sweep_kinds:
        from branchline.sweeping import Asked, sweep_drill
        from branchline.sweeping import sweep_kinds as sweep_all_kinds

        if link != "simulated" or units != "simulator":
            raise InputError("command line", "--link", link, "simulated: a sweep forks one process")
        asked = Asked(every, from_time, to_time, jobs, seed, out, as_json)
        good = sweep_all_kinds(file, asked) if sweep_kinds else sweep_drill(file, asked)
        _end(judged(good))
    from study.run.directory import reserved
    from study.run.drill import fill_drill, run_drill, score_text, sentence_of, shipped_drills
    from study.run.run import link_of, units_at

    if file == "list":
        sentences = {name: sentence_of(name) for name in shipped_drills()}
        if as_json:
            print_json([{"drill": name, "sentence": sentence} for name, sentence in sentences.items()])
        else:
            width = max(map(len, sentences), default=0)
            sys.stdout.write("".join(f"{name:{width}}  {text}\n" for name, text in sentences.items()))
        return
    chosen = link_of(link)
    hosted = units_at(units, chosen)
    with nullcontext() if out is None else reserved(out.resolve()) as place:
        journal = None if place is None else place.journal
        with _crashes_into(None if place is None else place.out), progress_of(Path(file).stem) as progress:
            done = run_drill(file, chosen, seed, progress, hosted, journal)
        if place is not None:
            fill_drill(done, place)
    if as_json:
        print_json(done.as_dict(), judged(done.passed))
    else:
        sys.stdout.write(f"{done.run.scenario.name}\n")
        for verdict in done.verdicts:
            sys.stdout.write(
                f"  {'met    ' if verdict.passed else 'NOT MET'}  {verdict.text}: {verdict.happened}\n"
            )
        sys.stdout.write(f"  {score_text(done.scores)}\n")
    _end(judged(done.passed))


@app.command()
def bench(
    scenarios: Annotated[
        list[str] | None, typer.Argument(help="Scenarios to measure; default karasuyama_weekday.")
    ] = None,
    rounds: Annotated[int, typer.Option("--rounds", min=1, help="Rounds; medians are shown.")] = 3,
    as_json: Json = False,
) -> None:
    """Measure the same day three ways: SUMO alone, full system, full system over Zenoh."""
    from study.evaluate.bench import bench as measure

    found = [measure(scenario, rounds, tell) for scenario in scenarios or ["karasuyama_weekday"]]
    outcome = judged(all(figures["same_digest"] for figures in found))
    if as_json:
        print_json({"scenarios": found}, outcome)
    else:
        for figures in found:
            _print_bench(figures)
    _end(outcome)


def _print_bench(figures: dict[str, Any]) -> None:
    head = f"{figures['scenario']}, {figures['trains']} trains: medians of {figures['rounds']} rounds"
    sys.stdout.write(head + "\n")
    _print_table(("", "wall s", "min", "max", "of SUMO", "of simulated", "peak MB"), figures["rows"])
    sys.stdout.write(f"microseconds, {figures['stretches']} stretches\n")
    heads = ("", "queries", "telegrams", "us a query", "us a telegram", "us a stretch", "beyond SUMO")
    _print_table(heads, figures["parts"])
    sys.stdout.write(f"{figures['computed']}\n")
    for budget in figures["budgets"]:
        kept = "kept" if budget["kept"] else "NOT KEPT"
        sys.stdout.write(
            f"budget: {budget['what']} at most {budget['limit']:g}: {budget['found']:g}, {kept}\n"
        )
    same = "the same journal digest" if figures["same_digest"] else "DIFFERENT journal digests"
    tell(f"the full runs gave {same}")


def _print_table(heads: tuple[str, ...], rows: list[dict[str, object]]) -> None:
    for line in (heads, *(tuple(_short(value) for value in row.values()) for row in rows)):
        sys.stdout.write(f"{line[0]:32}" + "".join(f"{cell:>14}" for cell in line[1:]) + "\n")


def _short(value: object) -> str:
    return value if isinstance(value, str) else f"{value:g}"


@app.command()
def reproduce(
    name: Annotated[str, typer.Argument(help="Name of a reproduction; 'list' shows them.")],
    link: LinkName = "simulated",
    seed: Annotated[int, typer.Option("--seed", min=0)] = 1,
    out: Annotated[
        Path | None, typer.Option("--out", help="Directory for plots, where there are any.")
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A short slice; the remarks say what it leaves out.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Rebuild a published experiment and print the paper's figures beside ours."""
    from study.papers.reproduction import REPRODUCTIONS, Options, reproduction
    from study.run.run import link_of

    if name == "list":
        print_json(sorted(REPRODUCTIONS)) if as_json else sys.stdout.write(
            "\n".join(sorted(REPRODUCTIONS)) + "\n"
        )
        return
    options = Options(seed=seed, link=link_of(link).value, out=None if out is None else str(out), quick=quick)
    result = reproduction(name)(options)
    outcome = judged(result.passed)
    if as_json:
        print_json(result.as_dict(), outcome)
    else:
        _print_reproduction(result.as_dict(), result.beside)
    _end(outcome)


def _print_reproduction(result: dict[str, Any], beside: str) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(soft_wrap=False)
    parameters = Table(title=f"{result['name']}: {result['title']}", title_justify="left")
    for head in ("parameter", "value", "origin"):
        parameters.add_column(head)
    for p in result["parameters"]:
        parameters.add_row(p["name"], f"{p['value']} {p['unit']}".strip(), p["origin"])
    console.print(parameters)
    rows = Table()
    columns = ("paper", "ours", *((beside,) if beside else ()))
    for head in ("case", *columns, "criterion", "passed"):
        rows.add_column(head)
    for row in result["rows"]:
        cells = ("" if row[column] is None else str(row[column]) for column in columns)
        rows.add_row(row["case"], *cells, row["criterion"], "yes" if row["passed"] else "NO")
    console.print(rows)
    if result["figures"]:
        figures = Table(title="told, not judged", title_justify="left")
        for head in ("figure", "value", "what it says"):
            figures.add_column(head)
        for figure in result["figures"]:
            figures.add_row(figure["name"], str(figure["value"]), figure["meaning"])
        console.print(figures)
    for remark in result["remarks"]:
        console.print(f"- {remark}")
    console.print("passed" if result["passed"] else "NOT passed")


@app.command()
def check(
    scenario: Annotated[str, typer.Argument(help="A shipped scenario, or a scenario file (.toml).")],
    as_json: Json = False,
) -> None:
    """Read a scenario with all that it names and say whether its trains can meet; runs nothing."""
    from network.meets import meet_text, planned_meets, unresolvable_meets
    from study.evaluate.release import CONFIRMED_BY_EYE, confirmed_by_eye
    from study.scenario.scenario import load_scenario

    loaded = load_scenario(scenario)
    line, timetable = loaded.setup.line, loaded.setup.timetable
    impossible = [meet_text(meet, line) for meet in unresolvable_meets(line, timetable)]
    weaker = confirmed_by_eye(loaded.setup)
    figures = {
        "scenario": loaded.id,
        "line": line.id,
        "trains": len(timetable.trains),
        "stocks": len(timetable.diagrams),
        "meets": len(planned_meets(line, timetable)),
        "impossible_meets": impossible,
        "confirmed_by_eye": weaker,
    }
    outcome = judged(not impossible)
    if as_json:
        print_json(figures, outcome)
    else:
        for key, value in figures.items():
            if key not in ("impossible_meets", "confirmed_by_eye"):
                sys.stdout.write(f"{key}: {value}\n")
        for text in impossible:
            sys.stdout.write(f"impossible: {text}\n")
        for place, trains in weaker.items():
            sys.stdout.write(f"weaker: {place}: {CONFIRMED_BY_EYE} ({', '.join(trains)})\n")
    _end(outcome)


@app.command()
def schema(
    kind: Annotated[str | None, typer.Argument(help="line, timetable, train, scenario or drill.")] = None,
) -> None:
    """Print the JSON Schema of a kind of file; without one, of all kinds by name."""
    from study.scenario.schemas import KINDS, schema_of

    print_json({name: schema_of(name) for name in KINDS} if kind is None else schema_of(kind))


@importers.command("geometry")
def import_geometry_command(
    polyline: Annotated[Path, typer.Argument(help="Track polyline (GeoJSON, longitude and latitude).")],
    stations: Annotated[Path, typer.Argument(help="Stations of the line (JSON of the same source).")],
    out: Annotated[Path, typer.Argument(help="TOML fragment to write.")],
) -> None:
    """Fit kilometrage, straights, transitions and curves to a track polyline."""
    from network.exchange.geometry import import_geometry

    import_geometry(polyline, stations, out)
    tell(f"wrote {out}")


@importers.command("timetable")
def import_timetable_command(
    source: Annotated[Path, typer.Argument(help="Timetable in the form of mini-tokyo-3d (JSON).")],
    out: Annotated[Path, typer.Argument(help="Timetable file (TOML) to write.")],
    calendar: Annotated[str, typer.Option("--calendar", help="Weekday or SaturdayHoliday.")] = "Weekday",
) -> None:
    """Make a timetable file of the Karasuyama line from published times."""
    from network.exchange.mini_tokyo import import_timetable

    import_timetable(source, out, calendar)
    tell(f"wrote {out}")


if __name__ == "__main__":
    os.environ.setdefault("PYTHONUNBUFFERED", "1")
    main()
