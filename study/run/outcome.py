"""What a run came to: which rules it broke, and whether it reached its end. Runs, drills and reports all ask here."""

from __future__ import annotations

from simulation.events import Unsafe
from simulation.judge.checkers import Checker
from simulation.result import Ending, RunResult
from simulation.setup import STEPS_PER_S


def broken_rules(result: RunResult) -> list[tuple[float, str]]:
    """When and what: collisions, what the world calls unsafe, rules that checkers found broken, arrival apart."""
    broken = [(result.end_step / STEPS_PER_S, text) for text in result.collisions]
    broken += [
        (entry.t_s, f"{entry.event.unit_id} {entry.event.text}")
        for entry in result.journal.entries
        if isinstance(entry.event, Unsafe)
    ]
    broken += [
        (v.t_s, f"{v.checker}: {v.text}") for v in result.violations if v.checker != Checker.EVERYONE_ARRIVES
    ]
    return broken


def unfinished(result: RunResult) -> tuple[str, ...]:
    """What is missing for a run that reached its end: trains, stocks, the end itself; empty where nothing is."""
    planned = (*result.trains_planned, *result.empty_planned)
    missing = [n for n in planned if n not in (*result.trains_arrived, *result.empty_arrived)]
    texts = [f"{len(missing)} trains did not arrive: {', '.join(missing)}"] if missing else []
    texts += [
        f"{stock_id} has neither left the line nor stands where its last duty ends"
        for stock_id in result.unfinished
    ]
    if result.ended_because is not Ending.FINISHED:
        texts.append(f"the run was cut short: {result.ended_because}")
    return tuple(texts)
