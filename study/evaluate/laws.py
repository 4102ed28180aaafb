"""What driving well costs in time: the same day with the law that plans optimal profiles, and with the present law.

Each runs the whole system on SUMO in a fresh process, in turn, round after round. A short run of the same law comes
before what is timed, so that compiled code is loaded; what is timed is the run, from the first step to the last.
"""

from __future__ import annotations

import json
import statistics
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

from onboard.driving.laws.optimal import optimal
from onboard.driving.laws.table import LAW_NAMES
from scenario.law_choice import driven_by
from scenario.scenario import load_scenario
from study.evaluate.afresh import budget_of, figures_afresh
from study.runner.run import PartyLink, execute

COMPARED: Final = (LAW_NAMES[0], optimal.__name__)
WARMED_BY: Final = "karasuyama_round_trip"
RATIO_MAX: Final = 1.2  # of the present law's time


def run_child(law: str, scenario: str) -> dict[str, Any]:
    """One timed day in this process: wall time, s, and the digest of its journal."""
    for name in (WARMED_BY, scenario):
        loaded = load_scenario(name)
        run = execute(replace(loaded, setup=driven_by(loaded.setup, law)), PartyLink.SIMULATED)
    return {"wall_s": float(run.summary["wall_s"]), "digest": run.summary["digest"]}


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """Medians of wall time of both laws, and their ratio. `tell` gets what goes on."""
    load_scenario(scenario)  # an unknown name is an error before anything runs
    figures: dict[str, list[dict[str, Any]]] = {law: [] for law in COMPARED}
    for number in range(rounds):
        for law in COMPARED:
            tell(f"{scenario}, round {number + 1} of {rounds}: {law} on every train")
            figures[law].append(figures_afresh("study.evaluate.laws", law, law, scenario))
    return {"scenario": scenario, "rounds": rounds} | report(figures)


def report(figures: dict[str, list[dict[str, Any]]]) -> dict[str, Any]:
    """What the figures of all rounds come to: a row a law, and the budget with whether it is kept."""
    present = COMPARED[0]
    median = {law: statistics.median(f["wall_s"] for f in rounds) for law, rounds in figures.items()}
    ratio = round(median[COMPARED[1]] / median[present], 3)
    rows = [
        {
            "law": law,
            "wall_s": round(median[law], 3),
            "wall_s_min": round(min(f["wall_s"] for f in rounds), 3),
            "wall_s_max": round(max(f["wall_s"] for f in rounds), 3),
            "of_present": round(median[law] / median[present], 3),
        }
        for law, rounds in figures.items()
    ]
    budget = budget_of(f"{COMPARED[1]} of {present}", RATIO_MAX, ratio)
    same = all(len({f["digest"] for f in rounds}) == 1 for rounds in figures.values())
    return {"rows": rows, "same_digest": same, "budgets": [budget]}


if __name__ == "__main__":
    sys.stdout.write(json.dumps(run_child(*sys.argv[1:3])) + "\n")
