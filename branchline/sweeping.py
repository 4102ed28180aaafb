"""`branchline drill --sweep` and `--sweep-kinds`: what they ask for, show and write."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from branchline.ending import judged, print_json
from branchline.progress import progress_of_runs
from network.errors import InputError
from study.run.directory import replaced
from study.run.drill import find_drill
from study.run.forks import jobs_of
from study.run.moving import moved, single_faults
from study.run.sweep import Window, sweep
from study.run.sweep_report import classes_of, figures_of, owns, text_of, write_sweep
from study.scenario.scenario import load_scenario
from study.scenario.script_file import time_of


@dataclass(frozen=True, slots=True)
class Asked:
    """The options of a sweep, as they were given."""

    every_s: float
    from_time: str | None
    to_time: str | None
    jobs: int | None
    seed: int | None
    out: Path | None
    as_json: bool


def sweep_drill(name: str, asked: Asked) -> bool:
    """Sweep a drill; whether it is good."""
    return _sweep(find_drill(name), asked, kinds=False)


def sweep_kinds(scenario: str, asked: Asked) -> bool:
    """Sweep single faults of every kind over a scenario; whether it is good."""
    return _sweep(scenario, asked, kinds=True)


def _sweep(name: str, asked: Asked, *, kinds: bool) -> bool:
    out = None if asked.out is None else asked.out.resolve()
    window = Window(
        asked.every_s, _time("--from", asked.from_time), _time("--to", asked.to_time), staggered=kinds
    )
    if window.from_s is not None and window.to_s is not None and window.to_s < window.from_s:
        raise InputError("command line", "--to", asked.to_time, f"a time not before {asked.from_time}")
    scenario = load_scenario(name, asked.seed)
    left_out: tuple[str, ...] = ()
    if kinds:
        variations = single_faults(scenario.setup)
    else:
        found = moved(scenario)
        variations, left_out = (found.variation,), found.left_out
    with nullcontext() if out is None else replaced(out, owns, "a sweep") as folder:
        with progress_of_runs(f"sweep of {scenario.id}") as progress:
            swept = sweep(scenario.setup, variations, window, jobs_of(asked.jobs), progress)
        figures = figures_of(scenario, swept, left_out)
        if folder is not None:
            write_sweep(scenario, swept, variations, figures, folder)
    if asked.as_json:
        print_json(figures | {"out": None if out is None else str(out)}, judged(not swept.bad))
        return not swept.bad
    sys.stdout.write(f"{scenario.name}: {figures['runs']} runs, one every {figures['every_s']:g} s\n")
    for text in left_out:
        sys.stdout.write(f"  left out, as it never came due in the drill itself: {text}\n")
    for found_class in classes_of(swept):
        sys.stdout.write(f"  {text_of(found_class)}\n")
        if out is not None and found_class.replay:
            sys.stdout.write(f"        replay: {out / found_class.replay}\n")
    return not swept.bad


def _time(option: str, given: str | None) -> float | None:
    return None if given is None else time_of("command line", option, given)
