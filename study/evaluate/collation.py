"""What curvature collation costs: one fix over the widest window, and a day with it on every train.

The fix is the compiled `collate` on a ring that holds a stretch of the scenario's own map, with bounds as wide as is
searched. Days run the whole system on SUMO in fresh processes, in turn, with tags alone and with a gyro beside them; a
short run of the same kind comes before what is timed, so that compiled code is loaded.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np

from onboard.localisation.curvature import collate_with_map
from onboard.localisation.curvature_row import WINDOW_MAX
from onboard.records import Chart
from scenario.scenario import load_scenario
from simulation.carriers.plain_track import PlainTrack
from simulation.settings import PositionSensor
from simulation.setup import STEP_S, Setup
from simulation.world.roster import drawn_up
from simulation.world.trains import Trains
from study.evaluate.afresh import Figures, budget_of, in_rounds, walls_of
from study.runner.run import PartyLink, execute

SLOT: Final = 0
WITHOUT: Final = "tags"
WITH: Final = "tags and curvature"
CARRIED: Final = {WITHOUT: (PositionSensor.TAGS,), WITH: (PositionSensor.TAGS, PositionSensor.CURVATURE)}
WARMED_BY: Final = "karasuyama_round_trip"
FIXES: Final = 2000
FIX_MS_MAX: Final = 0.2
RATIO_MAX: Final = 1.5  # of the day without it


def setup_carrying(setup: Setup, what: str) -> Setup:
    """The setup with every train carrying that."""
    sensors = setup.sensors.model_copy(update={"carries": CARRIED[what], "carries_of": {}})
    return replace(setup, sensors=sensors)


def fix_ms(scenario: str, fixes: int = FIXES) -> tuple[float, int]:
    """Milliseconds of one comparison at the widest window, and at how many shifts it looks."""
    setup = setup_carrying(load_scenario(scenario).setup, WITH)
    lengths_m = {piece.id: round(piece.length_m, 6) for piece in setup.line.pieces.values()}
    trains = Trains(setup, PlainTrack(lengths_m, STEP_S))
    unit, own, pool = trains.units[SLOT], trains.readers[SLOT].curvature, trains.pool
    duties = drawn_up(setup, setup.believed_line)[trains.stock_ids[SLOT]]
    rows = trains.rows_of(SLOT, duties[0].mission.path)
    unit.path_offset, unit.path_rows = rows.offset, rows.rows
    unit.position_known, unit.odometer_scale = 1, 1.0
    chart = Chart(pool.pattern, pool.known_places)
    laid = pool.pattern["curvature_per_m"][unit.path_offset : unit.path_offset + unit.path_rows]
    half = int(own.settings.search_m)
    front = int(np.flatnonzero(np.isfinite(laid))[0]) + 2 * WINDOW_MAX
    ring = laid[front - WINDOW_MAX + 1 : front + 1]
    own.bent_per_m[:WINDOW_MAX] = own.bent_per_m[WINDOW_MAX:] = ring
    own.slow_s_per_m[:] = 1.0 / 20.0
    own.metres, own.metre, own.along_m, own.bias_radps2 = WINDOW_MAX, front, float(front), 0.0
    taken_s: list[float] = []
    for _ in range(fixes + 1):
        unit.position_m, unit.bound_ahead_m, unit.bound_behind_m = float(front), float(half), float(half)
        begun_s = time.perf_counter()
        collate_with_map(own, unit, chart)
        taken_s.append(time.perf_counter() - begun_s)
    return 1e3 * statistics.median(taken_s[1:]), int(own.span) + 1


def run_child(what: str, scenario: str) -> dict[str, Any]:
    """One timed day in this process: wall time, s, and the digest of its journal."""
    for name in (WARMED_BY, scenario):
        loaded = load_scenario(name)
        run = execute(replace(loaded, setup=setup_carrying(loaded.setup, what)), PartyLink.SIMULATED)
    return {"wall_s": float(run.summary["wall_s"]), "digest": run.summary["digest"]}


def bench(scenario: str, rounds: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """The median of a fix, and medians of wall time of both days with their ratio. `tell` gets what goes on."""
    found_ms, shifts = fix_ms(scenario)
    tell(f"{scenario}: one fix over {shifts} shifts takes {found_ms:.3f} ms")
    ways = {what: f"{what} on every train" for what in CARRIED}
    figures = in_rounds("study.evaluate.collation", ways, rounds, tell, scenario)
    return {"scenario": scenario, "rounds": rounds, "shifts": shifts} | report(found_ms, figures)


def report(found_ms: float, figures: Figures) -> dict[str, Any]:
    """What the figures of all rounds come to: a row each, and the budgets with whether they are kept."""
    found = walls_of(figures, "carries", "of_tags")
    budgets = [
        budget_of("ms of one fix", FIX_MS_MAX, round(found_ms, 4)),
        budget_of(f"{WITH} of {WITHOUT}", RATIO_MAX, found["rows"][1]["of_tags"]),
    ]
    return found | {"budgets": budgets}


if __name__ == "__main__":
    sys.stdout.write(json.dumps(run_child(*sys.argv[1:3])) + "\n")
