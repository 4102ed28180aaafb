"""`branchline best trains`: the most trains each way that repeat every hour, or every so many minutes."""

from __future__ import annotations

from typing import Annotated

import typer

from branchline.best_interval import ScenarioOut, SetLate, new_day, write_day_of
from branchline.ending import end_with
from branchline.extras import needing_extra
from branchline.options import Json, ScenarioName, SolverWork


def trains(
    context: typer.Context,
    scenario: ScenarioName,
    every: Annotated[int, typer.Option("--every", min=1, max=1440, help="Length of the pattern, min.")] = 60,
    set_late: SetLate = False,
    work: SolverWork = 8.0,
    out: ScenarioOut = None,
    as_json: Json = False,
) -> None:
    """Find the most trains each way in a repeating pattern, evenly spaced or not, and a proven upper bound."""
    from scenario.scenario import load_scenario

    with needing_extra("plan", "trains"):
        from plan.least_interval import AS_UNITS_ASK, SET_LATE
        from plan.most_trains import TRAINS_MAX, most_trains

    if out is not None:
        new_day(out, scenario)
    setup = load_scenario(scenario).setup
    found = most_trains(setup, 60 * every, work, SET_LATE if set_late else AS_UNITS_ASK, context.obj)
    if out is not None and found.waits is not None:
        write_day_of(out, setup, found.pattern, found.waits.moves_s, found.repeats_s, scenario)
    proven = "as many as can be" if found.trains == found.at_most else f"no more than {found.at_most} can be"
    rows = [
        f"{found.trains} trains each way every {every} min: {proven}",
        f"a train each way has {found.section_id} for {found.held_s:.1f} s of {60 * every} s",
    ]
    if found.undecided:
        first, last = found.undecided[0], found.undecided[-1]
        numbers = f"{first}" if first == last else f"{len(found.undecided)} numbers from {first} to {last}"
        more = "more of it by --work" if first <= TRAINS_MAX else "so many are looked for evenly spaced only"
        rows.append(f"neither found nor excluded: {numbers} (work {found.work:.2f}; {more})")
    if found.waits is not None:
        surely = "least that it can be" if found.waits.proven else "perhaps more than it need be"
        rows.append(f"waits: {found.waits.waits_s:.0f} s of all trains together, {surely}")
    figures = {
        "trains": found.trains,
        "at_most": found.at_most,
        "undecided": found.undecided,
        "work": round(found.work, 3),
        "section": found.section_id,
        "held_s": round(found.held_s, 1),
        "waits_s": None if found.waits is None else found.waits.waits_s,
    }
    end_with(figures, rows, good=found.trains > 0, as_json=as_json)
