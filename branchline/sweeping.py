"""`branchline drill --sweep` and `--sweep-kinds`: what they ask for, show and write."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import blake2b
from pathlib import Path
from typing import Any, Final

from branchline.ending import judged_outcome, print_json
from branchline.progress import progress_of_runs
from network.errors import InputError
from network.files.toml_input import one_of
from scenario.scenario import Scenario, load_scenario
from scenario.script_file import time_of
from simulation.setup import Setup
from study.drilling.drill import drills_in, find_drill
from study.drilling.every_instant import NOTHING, InstantWindow, SweepOutcomes, Variation, sweep
from study.drilling.forks import jobs_of
from study.drilling.grid_report import classes_of, figures_of, owns_file, text_of, write_sweep
from study.drilling.moving import single_faults, staffed, what_is_moved
from study.drilling.outcome_class import expected_breaks
from study.drilling.swept_rows import MadeOf, growing_rows
from study.drilling.telegram_grid import FaultChoice, TelegramGrid, grid_of
from study.record.directory import asked_folder
from study.sweep.digest import code_digest, inputs_digest

AT_TELEGRAMS: Final = "telegrams"
JUDGES: Final = "study/drilling"  # decides, beside the code of a day, what a run of a sweep is called


@dataclass(frozen=True, slots=True)
class SweepOptions:
    """The options of a sweep, as they were given."""

    every_s: float
    from_time: str | None
    to_time: str | None
    jobs: int | None
    seed: int | None
    out: Path | None
    as_json: bool
    sample: int | None = None
    resume: bool = False


def sweep_drill(name: str, asked: SweepOptions) -> bool:
    """Sweep a drill; whether it is good."""
    return _sweep(find_drill(name), asked, kinds=False)


def sweep_kinds(scenario: str, asked: SweepOptions) -> bool:
    """Sweep single faults of every kind over a scenario; whether it is good."""
    return _sweep(scenario, asked, kinds=True)


def sweep_telegrams(name: str, asked: SweepOptions, at: str, faults: str) -> bool:
    """Single faults beside a drill's own, or each of a folder's, around its telegrams; whether all is good."""
    if at != AT_TELEGRAMS:
        raise InputError("command line", "--at", at, AT_TELEGRAMS)
    if faults not in (known := [chosen.value for chosen in FaultChoice]):
        raise InputError("command line", "--faults", faults, one_of(known, faults))
    window = _window(asked)
    every: list[dict[str, Any]] = []
    for each in (names := drills_in(name)):
        scenario = staffed(load_scenario(str(find_drill(each)), asked.seed))
        grid = grid_of(scenario.setup, FaultChoice(faults), window)
        grid = grid if asked.sample is None else grid.sample(asked.sample)
        own = asked if asked.out is None or len(names) == 1 else replace(asked, out=asked.out / scenario.id)
        every.append(_swept(scenario, grid.setup, grid.variations, window, own, grid=grid))
    if len(names) == 1:
        return _told(every[0], asked)
    total = {key: sum(figures[key] for figures in every) for key in ("runs", "grid", "bad_runs", "wall_s")}
    good = not total["bad_runs"]
    if asked.as_json:
        print_json({"drills": every, **total}, judged_outcome(good))
    else:
        text = f"{len(names)} drills, {total['runs']} runs of {total['grid']}, {total['bad_runs']} bad"
        sys.stdout.write(f"{text}, in {total['wall_s']:.0f} s\n")
    return good


def _window(asked: SweepOptions, *, staggered: bool = False) -> InstantWindow:
    from_s, to_s = _time("--from", asked.from_time), _time("--to", asked.to_time)
    if from_s is not None and to_s is not None and to_s < from_s:
        raise InputError("command line", "--to", asked.to_time, f"a time not before {asked.from_time}")
    return InstantWindow(asked.every_s, from_s, to_s, staggered)


def _sweep(name: str, asked: SweepOptions, *, kinds: bool) -> bool:
    window = _window(asked, staggered=kinds)
    scenario = load_scenario(name, asked.seed)
    left_out: tuple[str, ...] = ()
    if kinds:
        scenario = staffed(scenario)
        variations = single_faults(scenario.setup)
    else:
        found = what_is_moved(scenario)
        variations, left_out = (found.variation,), found.left_out
    return _told(_swept(scenario, scenario.setup, variations, window, asked, left_out), asked)


def _told(figures: dict[str, Any], asked: SweepOptions) -> bool:
    """The figures of one sweep for a program; whether they are good."""
    if asked.as_json:
        print_json(figures, judged_outcome(not figures["bad"]))
    return not figures["bad"]


def _swept(
    scenario: Scenario,
    setup: Setup,
    variations: Sequence[Variation],
    window: InstantWindow,
    asked: SweepOptions,
    left_out: Sequence[str] = (),
    *,
    grid: TelegramGrid | None = None,
) -> dict[str, Any]:
    """Sweep a setup, write what became of it, and show it to a person. A grid is beside the setup's own script."""
    beside = grid is not None
    out = None if asked.out is None else asked.out.resolve()
    began_s = time.monotonic()
    made_of = MadeOf(_inputs_of(setup), code_digest(JUDGES))
    with (
        growing_rows(out, made_of, resume=asked.resume) as rows,
        asked_folder(out, owns_file, "a sweep") as folder,
    ):
        with progress_of_runs(f"sweep of {scenario.id}") as progress:
            script = setup.script if beside else NOTHING
            swept = sweep(setup, variations, window, jobs_of(asked.jobs), progress, script, rows)
            swept = swept.beside(*(expected_breaks(setup.script) if grid is None else grid.own))
        figures = figures_of(scenario, swept, left_out)
        figures |= {"wall_s": round(time.monotonic() - began_s, 1)}
        figures |= (
            {} if grid is None else {"every_s": None, "grid": grid.of, "own": [run.label for run in grid.own]}
        )
        figures |= {"taken_up": len(rows.taken_up), "taken_up_of_other_code": rows.of_other_code}
        figures |= {"out": None if out is None else str(out)}
        if folder is not None:
            write_sweep(scenario, swept, variations, figures, folder, rows=rows, beside=beside)
    if not asked.as_json:
        how = f"one every {figures['every_s']:g} s" if grid is None else "before and after telegrams"
        sampled = "" if grid is None or grid.of == grid.runs else f", an even sample of {grid.of}"
        _show(scenario, swept, figures, how + sampled, out)
    return figures


def _inputs_of(setup: Setup) -> str:
    """Digest of a setup with its seed."""
    return blake2b(f"{inputs_digest(setup)} {setup.seed}".encode()).hexdigest()


def _show(
    scenario: Scenario, swept: SweepOutcomes, figures: dict[str, Any], how: str, out: Path | None
) -> None:
    sys.stdout.write(f"{scenario.name}: {figures['runs']} runs, {how}, in {figures['wall_s']:.0f} s\n")
    if taken_up := figures["taken_up"]:
        other = figures["taken_up_of_other_code"]
        sys.stdout.write(f"  {taken_up:6d}  of these were there before, {other} of them run by other code\n")
    for kind, count in figures["by_kind"].items():
        sys.stdout.write(f"  {count:6d}  {kind}\n")
    for text in figures["left_out"]:
        sys.stdout.write(f"  left out, as it never came due in the drill itself: {text}\n")
    for found_class in classes_of(swept):
        sys.stdout.write(f"  {text_of(found_class)}\n")
        if out is not None and found_class.replay:
            sys.stdout.write(f"        replay: {out / found_class.replay}\n")
    sys.stdout.flush()


def _time(option: str, given: str | None) -> float | None:
    return None if given is None else time_of("command line", option, given)
