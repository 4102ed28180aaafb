"""`branchline drill`: a drill, expectation by expectation, or a sweep of it."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from branchline.ending import crashes_into, end, judged_outcome, print_json
from branchline.options import Json, LinkName, Seed, UnitsName
from branchline.progress import print_aside, progress_of
from network.errors import InputError

if TYPE_CHECKING:
    from study.drilling.drill import Drill


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
            help="Move the drill's faults and acts, as one piece, over all instants of the run, and print one line for"
            " each class of outcome. A run is good if every train arrives, no invariant is broken but those that"
            " the drill expects people's wrong acts to break, and nothing crashes; its other expectations are not"
            " judged.",
        ),
    ] = False,
    sweep_kinds: Annotated[
        bool,
        typer.Option(
            "--sweep-kinds", help="FILE is a scenario: try single faults of every kind at all instants."
        ),
    ] = False,
    at: Annotated[
        str | None,
        typer.Option(
            "--at",
            help="'telegrams': add a single fault just before and just after every telegram that it may concern is sent"
            " or takes effect, with staff who react. FILE is a drill, or a folder of shipped drills ('rtri').",
        ),
    ] = None,
    faults: Annotated[
        str,
        typer.Option(
            "--faults", help="With --at: power of each party, links (each cut one way), or all kinds."
        ),
    ] = "power",
    sample: Annotated[
        int | None,
        typer.Option("--sample", min=1, help="With --at: run an even sample of this size; default all."),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="With --sweep, --sweep-kinds or --at: keep the runs of the same inputs that an earlier sweep, stopped"
            " or complete, has left in --out, even by another version of the code, and run the rest.",
        ),
    ] = False,
    every: Annotated[
        float,
        typer.Option("--every", min=0.1, help="With --sweep or --sweep-kinds: step between instants, s."),
    ] = 1.0,
    from_time: Annotated[
        str | None,
        typer.Option(
            "--from",
            help="With --sweep, --sweep-kinds or --at: first instant, HH:MM; default just before the trains begin.",
        ),
    ] = None,
    to_time: Annotated[
        str | None,
        typer.Option(
            "--to",
            help="With --sweep, --sweep-kinds or --at: last instant, HH:MM; default the end of their day.",
        ),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(
            "--jobs",
            min=1,
            help="With --sweep, --sweep-kinds or --at: runs at a time; default one per processor.",
        ),
    ] = None,
) -> None:
    """Run a drill and print the verdict on each of its expectations.

    Exit code 1: an expectation is not met, or a run of a sweep is bad.
    """
    if sweep or sweep_kinds or at is not None:
        from branchline.sweeping import SweepOptions, sweep_drill, sweep_telegrams
        from branchline.sweeping import sweep_kinds as sweep_all_kinds

        if link != "simulated" or units != "simulator":
            raise InputError("command line", "--link", link, "simulated: a sweep forks one process")
        if resume and out is None:
            raise InputError("command line", "--resume", True, "--out DIR, where the runs are")
        asked = SweepOptions(every, from_time, to_time, jobs, seed, out, as_json, sample, resume)
        if at is not None:
            end(judged_outcome(sweep_telegrams(file, asked, at, faults)))
        good = sweep_all_kinds(file, asked) if sweep_kinds else sweep_drill(file, asked)
        end(judged_outcome(good))
    from study.drilling.drill import fill_drill, run_drill, score_text, sentence_of, shipped_drills
    from study.feasibility.early import early_text
    from study.record.directory import reserved
    from study.runner.run import link_of, units_at

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
        with crashes_into(None if place is None else place.out), progress_of(Path(file).stem) as progress:
            done = run_drill(file, chosen, seed, progress, hosted, journal)
        if place is not None:
            fill_drill(done, place)
    if as_json:
        print_json(done.as_dict(), judged_outcome(done.passed))
    else:
        sys.stdout.write(f"{done.run.scenario.name}\n")
        for verdict in done.verdicts:
            sys.stdout.write(
                f"  {'met    ' if verdict.passed else 'NOT MET'}  {verdict.text}: {verdict.happened}\n"
            )
        early = early_text(done.run.scenario.setup)
        sys.stdout.write(f"  came due {early}\n" if early else "")
        sys.stdout.write("".join(f"  never came due: {text}\n" for text in done.never_due))
        sys.stdout.write(f"  {score_text(done.scores).en}\n")
    if not done.passed:
        tell_of_plan(done)
    end(judged_outcome(done.passed))


def tell_of_plan(done: Drill) -> None:
    """A drill that fails on a plan that could not work without its faults either."""
    from study.feasibility.check import feasibility

    plan = feasibility(done.run.scenario.setup)
    if not plan.on_time:
        print_aside(f"its plan, faults apart: {plan.verdict}")
