"""What commands cost beside the day: CPU seconds, user and system, of fresh processes whose code is compiled.

Outside the day is all of `branchline run` before its second stretch and after its last: imports, inputs, the check,
loading compiled code, tables, report. CPU seconds, because how fast a person sees it depends on what else the machine
does. Each command has run once before it is measured; where code had to be compiled, Python's bytecode too, that is not
in the figures.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from host.scratch import scratch
from simulation.loop import Progress, Simulation
from simulation.result import RunResult
from study.evaluate.afresh import budget_of
from study.record.directory import SUMMARY_FILE

RUN: Final = "run, outside the day"
PLOT: Final = "train-graph"
CPU_S_MAX: Final = {
    RUN: 4.0,
    "check": 1.5,
    "--help": 0.3,
    "running-times": 5.0,
    f"plot {PLOT}": 2.0,
}
OUT: Final = "run"


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """Medians of CPU seconds of each command. `tell` is told what goes on."""
    figures: dict[str, list[float]] = {what: [] for what in CPU_S_MAX}
    digests: set[str] = set()
    with scratch("branchline-") as folder:
        for number in range(-1, rounds):
            for what in CPU_S_MAX:
                at = "first, not counted" if number < 0 else f"round {number + 1} of {rounds}"
                tell(f"{scenario}, {at}: {what}")
                cpu_s = _cpu_s(command_of(what, scenario), folder)
                if number >= 0:
                    figures[what].append(cpu_s)
            summary = json.loads((folder / OUT / SUMMARY_FILE).read_text("utf-8"))
            digests.add(summary["digest"])
    return {"scenario": scenario, "rounds": rounds, "same_digest": len(digests) == 1} | report(figures)


def command_of(what: str, scenario: str) -> tuple[str, ...]:
    """The arguments of the command that is measured; those of reading commands are of the run made before."""
    return {
        RUN: ("run", scenario, "--out", OUT),
        "--help": (what,),
        f"plot {PLOT}": ("plot", OUT, PLOT, "--out", "plot.svg"),
    }.get(what, (what, scenario))


def _cpu_s(arguments: Sequence[str], folder: Path) -> float:
    """CPU seconds of a command in a fresh process, without the day that it runs."""
    runs_day = arguments[0] == "run"
    module = "study.evaluate.start_bench" if runs_day else "branchline"
    command = [sys.executable, "-m", module, *arguments]
    before = os.times()
    done = subprocess.run(command, cwd=folder, env=_env(), capture_output=True, text=True, check=False)
    after = os.times()
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(arguments)} failed: {done.stderr.strip()[-500:]}")
    whole_s = after.children_user - before.children_user + after.children_system - before.children_system
    return whole_s - (float(done.stderr.splitlines()[-1]) if runs_day else 0.0)


def _env() -> dict[str, str]:
    """Where the program's packages are found, also from another folder; bytecode is kept, as where it is installed."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return kept | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}


def report(figures: dict[str, list[float]]) -> dict[str, Any]:
    """What the figures of all rounds come to: a row each, and the budgets with whether they are kept."""
    medians = {what: round(statistics.median(found), 3) for what, found in figures.items()}
    rows = [
        {
            "command": what,
            "cpu_s": medians[what],
            "cpu_s_min": round(min(found), 3),
            "cpu_s_max": round(max(found), 3),
        }
        for what, found in figures.items()
    ]
    budgets = [budget_of(f"CPU s of {what}", CPU_S_MAX[what], found_s) for what, found_s in medians.items()]
    return {"rows": rows, "budgets": budgets}


def _run_child(arguments: Sequence[str]) -> None:
    """`branchline run` in this process, and the CPU seconds of the day in it, from its second stretch on, on stderr."""
    advance, finish = Simulation.advance, Simulation.finish
    begun_s: list[float] = []
    day_s: list[float] = []

    def advance_timed(simulation: Simulation) -> None:
        advance(simulation)
        begun_s.append(time.process_time())

    def finish_timed(
        simulation: Simulation, progress: Progress | None = None, stop: Callable[[], bool] | None = None
    ) -> RunResult:
        result = finish(simulation, progress, stop)
        day_s.append(time.process_time() - begun_s[0])
        return result

    timed: Any = Simulation
    timed.advance, timed.finish = advance_timed, finish_timed
    sys.argv = ["branchline", *arguments]
    try:
        import_module("branchline.__main__").main()
    finally:
        sys.stderr.write(f"\n{sum(day_s):.4f}\n")


if __name__ == "__main__":
    _run_child(sys.argv[1:])
