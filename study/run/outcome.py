"""What a run came to: which rules it broke, and whether it reached its end. Runs, drills and reports all ask here."""

from __future__ import annotations

from network.clock import clock
from simulation.events import Unsafe
from simulation.judge.checkers import Checker
from simulation.judge.rail import Slippery
from simulation.result import Ending, RunResult
from simulation.setup import STEPS_PER_S


def broken_rules(result: RunResult) -> list[tuple[float, str]]:
    """When and what: collisions, what the world calls unsafe, rules that checkers found broken, arrival apart.

    What followed from less adhesion than the design counts on is not among them; a collision always is.
    """
    outside = {(v.t_s, v.text) for v in result.outside_design}
    broken = [(result.end_step / STEPS_PER_S, text) for text in result.collisions]
    unsafe = [
        (entry.t_s, f"{entry.event.unit_id} {entry.event.text}")
        for entry in result.journal.entries
        if isinstance(entry.event, Unsafe)
    ]
    broken += [happened for happened in unsafe if happened not in outside]
    broken += [
        (v.t_s, f"{v.checker}: {v.text}") for v in result.violations if v.checker != Checker.EVERYONE_ARRIVES
    ]
    return broken


def outside_design(result: RunResult) -> tuple[str, ...]:
    """Who ran on less adhesion than the design counts on, and what followed from it: told, and not broken."""
    by_unit: dict[str, list[Slippery]] = {}
    for stretch in result.slippery:
        by_unit.setdefault(stretch.unit_id, []).append(stretch)
    texts: list[str] = []
    for unit_id, stretches in sorted(by_unit.items()):
        last_s = stretches[-1].to_s
        until = "the end" if last_s is None else clock(int(last_s))
        times = "once" if len(stretches) == 1 else f"{len(stretches)} times"
        texts.append(
            f"{unit_id} had less adhesion than the design counts on {times} from {clock(int(stretches[0].from_s))} to"
            f" {until}, at least {min(s.least for s in stretches):.2f} of the dry rail's"
        )
    return (*texts, *(f"{clock(int(v.t_s))} {v.checker}: {v.text}" for v in result.outside_design))


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
