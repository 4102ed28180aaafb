"""`branchline run`: runs a day, writes its run directory, and prints its figures for a person."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from branchline.comparing import OVER_S, check_over, print_comparison
from branchline.ending import AskedToStop, end, judged_outcome, print_json
from branchline.options import Json, LinkName, Out, ScenarioName, Seed, UnitsName
from branchline.progress import print_aside
from network.clock import clock
from study.outcome import BY_SIGNAL

if TYPE_CHECKING:
    from study.runner.run import FinishedRun


def run(
    scenario: ScenarioName,
    link: LinkName = "simulated",
    units: UnitsName = "simulator",
    listen: Annotated[
        str | None,
        typer.Option(
            "--listen",
            metavar="tls/ADDRESS:PORT",
            help="With --link zenoh: wait here for parties on other machines (serve-party).",
        ),
    ] = None,
    certificates: Annotated[
        Path | None,
        typer.Option("--certificates", help="With --listen: the folder that `branchline certificates` made."),
    ] = None,
    elsewhere: Annotated[
        list[str] | None,
        typer.Option(
            "--elsewhere",
            metavar="PARTY",
            help="With --listen: a party on another machine; may be repeated. Default: all processes.",
        ),
    ] = None,
    carrier: Annotated[
        str,
        typer.Option("--carrier", help="What moves the trains: sumo, or plain (without SUMO; the same run)."),
    ] = "sumo",
    seed: Seed = None,
    against: Annotated[
        Path | None, typer.Option("--against", help="Also say what changed since this run of the same line.")
    ] = None,
    over: Annotated[
        float, typer.Option("--over", help="With --against: list only times that moved by more than this, s.")
    ] = OVER_S,
    begins: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="HH:MM",
            help="Run a part of the day: every set begins where it last stood by then, maybe minutes earlier.",
        ),
    ] = None,
    until: Annotated[
        str | None, typer.Option("--until", metavar="HH:MM", help="Run only the part of the day before then.")
    ] = None,
    out: Out = None,
    anyway: Annotated[
        bool, typer.Option("--anyway", help="Run even if `branchline check` says that the plan cannot work.")
    ] = False,
    gui: Annotated[
        bool, typer.Option("--gui", help="Watch the run in sumo-gui (extra net); the result is the same.")
    ] = False,
    gui_delay: Annotated[
        int,
        typer.Option(
            "--gui-delay", min=0, max=10_000, help="With --gui: milliseconds for each step of 0.1 s."
        ),
    ] = 20,
    as_json: Json = False,
) -> None:
    """Run a day and write its run directory with report.html.

    A plan that cannot work is refused with exit code 2.
    """
    from branchline.whole_run import RunAsked, elsewhere_of, run_whole
    from scenario.part_of_day import part_of_day
    from scenario.scenario import load_scenario

    check_over(over)
    far = elsewhere_of(link, listen, certificates, elsewhere or ())
    asked = RunAsked(link, units, carrier, against, over, anyway, gui, gui_delay, far)
    loaded = load_scenario(scenario, seed)
    of_part = "".join(
        f"-{word}-{at.replace(':', '')}" for word, at in (("from", begins), ("until", until)) if at
    )
    if of_part:
        loaded = part_of_day(loaded, begins, until)
    directory = (out or Path("runs") / f"{loaded.id}{of_part}").resolve()
    with AskedToStop() as stop:
        ran = run_whole(loaded, directory, asked, progress=True, stop=stop)
    done, compared = ran.done, ran.compared
    outcome = judged_outcome(not done.broken) if stop.by is None or not done.stopped else BY_SIGNAL[stop.by]
    if as_json:
        found = {} if compared is None else {"against": compared.found.as_dict()}
        print_json(done.summary | {"out": str(ran.report.parent)} | found, outcome)
    else:
        _print_run(done, ran.report)
        if compared is not None:
            print_comparison(compared.found)
    if (off := _off_the_mark(done.summary)) is not None:
        print_aside(off)
    for text in done.summary["outside_design"]:
        print_aside(f"outside the design: {text}")
    for text in done.broken:
        print_aside(f"broken: {text}")
    if done.stopped:
        at = clock(done.scenario.setup.latest_end_s)
        print_aside(f"interrupted at {at}; what was run so far is in {ran.report.parent}")
    end(outcome)


def _passing(at: dict[str, Any] | None) -> list[tuple[str, str]]:
    """The latest passing, where trains pass."""
    if at is None:
        return []
    side = "after" if at["late_s"] >= 0.0 else "before"
    text = f"{abs(at['late_s']):.1f} s {side} the timetable, {at['train']} at {at['station']}"
    return [("latest passing", text)]


def _latest(late_s: float | None) -> str:
    """The worst lateness of a run in words; None: no train arrived."""
    return "no train arrived" if late_s is None else f"{late_s:.1f} s after the timetable"


def _errors(summary: dict[str, Any]) -> str:
    """How far trains stood from their marks, of at least one; of one there is no sigma."""
    sigma_m = summary["stop_error_m_sigma"]
    sigma = "" if sigma_m is None else f" sigma {sigma_m:.3f} m,"
    return f"error mean {summary['stop_error_m_mean']:.3f} m,{sigma} largest {summary['stop_error_m_max_abs']:.3f} m"


def _earliest(early_s: float | None) -> str:
    return "no train departed" if early_s is None else f"{early_s:.1f} s before the timetable"


def _margin(margins: dict[str, Any] | None) -> str:
    """The hop whose timetable leaves least over the least running time, and what was left as run."""
    least, left = (None if margins is None else margins.get(f"smallest_{of}_s") for of in ("margin", "left"))
    if least is None:
        return "-"
    text = f"planned {least['margin_s']:.0f} s {_hop(least)}"
    if left is None:
        return text
    came = "" if left["run_s"] is not None else ", where it did not run"
    return f"{text}; least left as run {left['left_s']:.0f} s {_hop(left)}{came}"


def _hop(row: dict[str, Any]) -> str:
    """Which train runs from where to where."""
    return f"({row['train']}, {row['from_station']} to {row['to_station']})"


def _off_the_mark(summary: dict[str, Any]) -> str | None:
    """What is said of stops that were not at their marks; None where all were."""
    from simulation.tolerance import OFF_MARK_M

    at = summary["stop_off_at"]
    if at is None:
        return None
    return (
        f"warning: {summary['stops_off']} of {summary['stops']} stops more than {OFF_MARK_M:g} m off their marks,"
        f" {at['error_m']:+.2f} m the worst ({at['train']} at {at['station']})"
    )


def _net(energy: dict[str, Any]) -> str:
    """Net energy of the day, and by distance as the report says it."""
    from study.report.facts import net_by_distance

    return "; ".join(filter(None, (f"{energy['all']['net']:,.1f} kWh", net_by_distance(energy).en)))


def _print_run(done: FinishedRun, report: Path) -> None:
    """The figures of a run for a person."""
    from rich.console import Console
    from rich.table import Table

    summary = done.summary
    energy, telegrams = summary["energy_kwh"], summary["telegrams"]

    rows = [
        ("trains", f"{summary['trains_arrived']} of {summary['trains_planned']} ran their whole journey"),
        ("empty workings", f"{summary['empty_workings_arrived']} of {summary['empty_workings_planned']}"),
        ("latest", _latest(summary["late_s_max"])),
        *_passing(summary["late_passing_at"]),
        ("earliest departure", _earliest(summary["early_departure_s_max"])),
        ("smallest margin", _margin(summary["margins"])),
        ("stops", f"{summary['stops']}: {_errors(summary)}" if summary["stops"] else "none measured"),
        ("invariants broken", str(summary["invariants_broken"])),
        (
            "energy",
            f"traction {energy['traction']:,.1f}, regenerated {energy['regenerated']:,.1f},"
            f" auxiliary {energy['auxiliary']:,.1f} kWh",
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
