"""What a day of a sweep costs, beside the same day by `execute` and by SUMO alone; and how busy it keeps the cores.

Each way runs in a fresh process of its own, warmed by one whole day of the same kind, and what is compared is the time
of its processor, so that other work on the machine counts for less. "SUMO alone" is that of `study.evaluate.bench`.
The sweep itself is a real one, with as many processes as there are cores, begun cold: its share of the cores is the
processor time of all its processes by wall time and cores. Beside it stands the share of the time in which a process
had a day at hand, which says the same on a machine that others use too.
"""

from __future__ import annotations

import json
import resource
import statistics
import sys
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import psutil

from host.scratch import scratch
from study.evaluate.afresh import budget_of, figures_afresh, in_rounds
from study.evaluate.bench import record, replay

if TYPE_CHECKING:
    from study.sweep.plan import SweepPlan
    from study.sweep.store import SweepDirectory

MODULE: Final = "study.evaluate.sweep_bench"
EXECUTE: Final = "execute, tables and all"
ON_SUMO: Final = "a sweep's day on SUMO"
ON_PLAIN: Final = "a sweep's day on plain track"
SUMO: Final = "SUMO alone"
WAYS: Final = (EXECUTE, ON_SUMO, ON_PLAIN, SUMO)
CARRIED_BY: Final = {ON_SUMO: "sumo", ON_PLAIN: "plain"}
DAYS: Final = 4  # in one process, so that what a day leaves behind shows in its memory
SWEPT_DAYS: Final = 40  # a process of the sweep, so that what it takes to begin is little of it
OF_EXECUTE_MAX: Final = 1.1
OF_SUMO_MAX: Final = 1.0
PEAK_MB_MAX: Final = 500.0
IDLE_MAX: Final = 0.1


def run_child(way: str, scenario: str, file: str, net: str) -> dict[str, Any]:
    """Days of one way in this process: processor time of each but the first, peak memory, digests."""
    with _day_of(way, scenario, file, net) as one:
        digests = [one()]
        cpu_s: list[float] = []
        for _ in range(1 if way == SUMO else DAYS):
            began_s = time.process_time()
            digests.append(one())
            cpu_s.append(time.process_time() - began_s)
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return {"cpu_s": statistics.median(cpu_s), "peak_mb": peak_mb, "digests": sorted(set(digests))}


@contextmanager
def _day_of(way: str, scenario: str, file: str, net: str) -> Generator[Callable[[], str]]:
    """One day of a way; it gives the digest of its journal, of SUMO alone none."""
    if way == SUMO:

        def alone() -> str:
            replay(Path(file), Path(net))
            return ""

        yield alone
        return
    from scenario.scenario import load_scenario

    loaded = load_scenario(scenario)
    if way == EXECUTE:
        from study.runner.run import PartyLink, execute

        yield lambda: str(execute(loaded, PartyLink.SIMULATED).summary["digest"])
        return
    from study.sweep.worker import Task, run_task

    with _begun(scenario, CARRIED_BY[way], loaded.setup.seed, 1) as (plan, store):
        task = Task(str(store.out), store.token, plan.spec(plan.points[0], 0), 0)
        yield lambda: run_task(task).record.digest


@contextmanager
def _begun(scenario: str, carrier: str, first: int, days: int) -> Generator[tuple[SweepPlan, SweepDirectory]]:
    """A sweep over seeds alone, in a directory of its own."""
    from study.sweep.plan import load_plan
    from study.sweep.store import opened_sweep

    with scratch("branchline-bench-") as folder:
        tables = {"id": "bench", "name": "What a sweep takes", "scenario": scenario, "carrier": carrier}
        lines = [f"{key} = {json.dumps(value)}" for key, value in tables.items()]
        lines += ["[seeds]", f"first = {first}", f"days = {days}", ""]
        file = folder / "sweep.toml"
        file.write_text("\n".join(lines), "utf-8")
        plan = load_plan(str(file))
        with opened_sweep(plan, folder / "out") as store:
            yield plan, store


def real_sweep(scenario: str, jobs: int, days: int) -> dict[str, Any]:
    """A real sweep on plain track, every tenth day on SUMO too, in processes of this one: its share of the cores."""
    from study.sweep.go import run_missing, sweep_begun
    from study.sweep.local import LocalPump

    with _begun(scenario, CARRIED_BY[ON_PLAIN], 1, days) as (plan, store):
        state = sweep_begun(plan, store, anyway=False)
        began_s, before_s = time.perf_counter(), _spent_s()
        run_missing(state, store, LocalPump(jobs))
        wall_s = time.perf_counter() - began_s
    share = (_spent_s() - before_s) / (wall_s * jobs)
    return {
        "days": len(state.records),
        "wall_s": round(wall_s, 1),
        "share": round(share, 3),
        "at_hand": round(state.wall_s / (wall_s * jobs), 3),
        "peak_mb": round(state.peak_bytes / 2**20, 1),
        "differ": sum(record.differs for record in state.records.values()),
    }


def _spent_s() -> float:
    """Processor time of this process and of those of its own that have ended, s."""
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in both)


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """Medians of processor time of all ways, and one real sweep. `tell` gets what goes on."""
    with scratch("branchline-bench-") as folder:
        tell(f"recording {scenario}")
        recording = record(scenario, folder)
        kept = str(recording.file), str(recording.net)
        figures = in_rounds(MODULE, dict(zip(WAYS, WAYS, strict=True)), rounds, tell, scenario, *kept)
    jobs = psutil.cpu_count() or 1
    tell(f"{scenario}: a sweep of {jobs * SWEPT_DAYS} days by {jobs} processes")
    ran = figures_afresh(MODULE, "sweep", "sweep", scenario, str(jobs), str(jobs * SWEPT_DAYS))
    return {"scenario": scenario, "rounds": rounds, "sweep": ran} | report(figures, ran)


def report(figures: dict[str, list[dict[str, Any]]], ran: dict[str, Any]) -> dict[str, Any]:
    """What the figures of all rounds come to: a row each, and the budgets with whether they are kept."""
    median = {way: statistics.median(f["cpu_s"] for f in rounds) for way, rounds in figures.items()}
    peak_mb = {way: max(f["peak_mb"] for f in rounds) for way, rounds in figures.items()}
    rows = [
        {
            "way": way,
            "cpu_s": round(median[way], 3),
            "cpu_s_min": round(min(f["cpu_s"] for f in rounds), 3),
            "cpu_s_max": round(max(f["cpu_s"] for f in rounds), 3),
            "of_execute": round(median[way] / median[EXECUTE], 3),
            "of_sumo_alone": round(median[way] / median[SUMO], 3),
            "peak_mb": round(peak_mb[way], 1),
        }
        for way, rounds in figures.items()
    ]
    worker_mb = round(max(peak_mb[ON_SUMO], peak_mb[ON_PLAIN], ran["peak_mb"]), 1)
    found = (
        (f"{ON_SUMO} of {EXECUTE}", OF_EXECUTE_MAX, round(median[ON_SUMO] / median[EXECUTE], 3)),
        (f"{ON_PLAIN} of {SUMO}", OF_SUMO_MAX, round(median[ON_PLAIN] / median[SUMO], 3)),
        ("peak MB of a sweep's process", PEAK_MB_MAX, worker_mb),
        ("share of the cores that a sweep leaves idle", IDLE_MAX, round(1.0 - ran["share"], 3)),
    )
    return {
        "rows": rows,
        "same_digest": _same([f for way in WAYS[:3] for f in figures[way]]) and ran["differ"] == 0,
        "budgets": [budget_of(*one) for one in found],
    }


def _same(rounds: Sequence[dict[str, Any]]) -> bool:
    return len({digest for figures in rounds for digest in figures["digests"]}) == 1


if __name__ == "__main__":
    what, *rest = sys.argv[1:]
    done = real_sweep(rest[0], int(rest[1]), int(rest[2])) if what == "sweep" else run_child(what, *rest)
    sys.stdout.write(json.dumps(done) + "\n")
