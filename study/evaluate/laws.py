"""What driving well costs in time: the same day with the law that plans optimal profiles, and with the present law.

Each runs the whole system on SUMO in a fresh process, in turn, round after round. A short run of the same law comes
before what is timed, so that compiled code is loaded; what is timed is the run, from the first step to the last.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

from onboard.driving.laws.optimal import optimal
from onboard.driving.laws.table import LAW_NAMES
from scenario.law_choice import driven_by
from scenario.scenario import load_scenario
from study.evaluate.afresh import Figures, budget_of, in_rounds, walls_of
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
    ways = {law: f"{law} on every train" for law in COMPARED}
    figures = in_rounds("study.evaluate.laws", ways, rounds, tell, scenario)
    return {"scenario": scenario, "rounds": rounds} | report(figures)


def report(figures: Figures) -> dict[str, Any]:
    """What the figures of all rounds come to: a row a law, and the budget with whether it is kept."""
    found = walls_of(figures, "law", "of_present")
    ratio = found["rows"][1]["of_present"]
    return found | {"budgets": [budget_of(f"{COMPARED[1]} of {COMPARED[0]}", RATIO_MAX, ratio)]}


if __name__ == "__main__":
    sys.stdout.write(json.dumps(run_child(*sys.argv[1:3])) + "\n")
