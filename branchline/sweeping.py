"""`branchline drill --sweep` and `--sweep-kinds`: what they ask for, show and write."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from branchline.ending import judged, print_json
from branchline.progress import progress_of_runs
from network.errors import InputError
from network.files.toml_input import one_of
from simulation.setup import Setup
from study.run.directory import replaced
from study.run.drill import find_drill
from study.run.forks import jobs_of
from study.run.moving import moved, single_faults
from study.run.sweep import NOTHING, Variation, Window, sweep
from study.run.sweep_report import classes_of, figures_of, owns, text_of, write_sweep
from study.run.telegram_grid import Chosen, grid_of
from study.scenario.scenario import Scenario, load_scenario
from study.scenario.script_file import time_of

AT_TELEGRAMS: Final = "telegrams"


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


def sweep_telegrams(name: str, asked: Asked, at: str, faults: str) -> bool:
    """Single faults beside a drill's own, around its telegrams; whether it is good."""
    if at != AT_TELEGRAMS:
        raise InputError("command line", "--at", at, AT_TELEGRAMS)
    if faults not in (known := [chosen.value for chosen in Chosen]):
        raise InputError("command line", "--faults", faults, one_of(known, faults))
    window = _window(asked)
    scenario = load_scenario(str(find_drill(name)), asked.seed)
    grid = grid_of(scenario.setup, Chosen(faults), window)
    return _swept(scenario, grid.setup, grid.variations, window, asked, beside=True)


def _window(asked: Asked, *, staggered: bool = False) -> Window:
    from_s, to_s = _time("--from", asked.from_time), _time("--to", asked.to_time)
    if from_s is not None and to_s is not None and to_s < from_s:
        raise InputError("command line", "--to", asked.to_time, f"a time not before {asked.from_time}")
    return Window(asked.every_s, from_s, to_s, staggered)


def _sweep(name: str, asked: Asked, *, kinds: bool) -> bool:
    window = _window(asked, staggered=kinds)
    scenario = load_scenario(name, asked.seed)
    left_out: tuple[str, ...] = ()
    if kinds:
        variations = single_faults(scenario.setup)
    else:
        found = moved(scenario)
        variations, left_out = (found.variation,), found.left_out
    return _swept(scenario, scenario.setup, variations, window, asked, left_out)


def _swept(
    scenario: Scenario,
    setup: Setup,
    variations: Sequence[Variation],
    window: Window,
    asked: Asked,
    left_out: Sequence[str] = (),
    *,
    beside: bool = False,
) -> bool:
    """Sweep a setup, write and show what became of it; whether it is good."""
    out = None if asked.out is None else asked.out.resolve()
    began_s = time.monotonic()
    with nullcontext() if out is None else replaced(out, owns, "a sweep") as folder:
        with progress_of_runs(f"sweep of {scenario.id}") as progress:
            script = setup.script if beside else NOTHING
            swept = sweep(setup, variations, window, jobs_of(asked.jobs), progress, script)
        figures = figures_of(scenario, swept, left_out)
        figures |= {"wall_s": round(time.monotonic() - began_s, 1)}
        figures |= {"every_s": None} if beside else {}
        if folder is not None:
            write_sweep(scenario, swept, variations, figures, folder, beside=beside)
    if asked.as_json:
        print_json(figures | {"out": None if out is None else str(out)}, judged(not swept.bad))
        return not swept.bad
    how = "before and after telegrams" if beside else f"one every {figures['every_s']:g} s"
    sys.stdout.write(f"{scenario.name}: {figures['runs']} runs, {how}, in {figures['wall_s']:.0f} s\n")
    for kind, count in figures["by_kind"].items():
        sys.stdout.write(f"  {count:6d}  {kind}\n")
    for text in left_out:
        sys.stdout.write(f"  left out, as it never came due in the drill itself: {text}\n")
    for found_class in classes_of(swept):
        sys.stdout.write(f"  {text_of(found_class)}\n")
        if out is not None and found_class.replay:
            sys.stdout.write(f"        replay: {out / found_class.replay}\n")
    return not swept.bad


def _time(option: str, given: str | None) -> float | None:
    return None if given is None else time_of("command line", option, given)
