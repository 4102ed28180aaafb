"""`branchline best loops`: where one or two more loops shorten the least interval most."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from branchline.best_interval import ScenarioOut, SetLate, figures_of, new_day, write_answer
from branchline.ending import end_with
from branchline.extras import needing_extra
from branchline.options import Json, ScenarioName

if TYPE_CHECKING:
    from simulation.setup import Setup


def loops(
    scenario: ScenarioName,
    most: Annotated[
        int, typer.Option("--loops", min=1, max=3, help="How many loops may be added at most.")
    ] = 1,
    at: Annotated[
        list[str] | None,
        typer.Option("--at", help="Only at this halt (id); may be repeated. Default: every halt."),
    ] = None,
    set_late: SetLate = False,
    out: ScenarioOut = None,
    as_json: Json = False,
) -> None:
    """Find where more loops shorten the least interval most: every choice of halts, each interval proven."""
    from network.errors import COMMAND_LINE, InputError
    from network.files.toml_input import one_of
    from scenario.scenario import load_scenario

    with needing_extra("plan", "loops"):
        from plan.least_interval import AS_UNITS_ASK, SET_LATE
        from plan.where_to_meet import halts_of, laying, loop_choices

    def with_loops(loops: Sequence[str]) -> Setup:
        return load_scenario(scenario, tables=laying(loops)).setup

    if out is not None:
        new_day(out, scenario)
    halts = halts_of(with_loops(()).line)
    for station_id in at or ():
        if station_id not in halts:
            raise InputError(COMMAND_LINE, "--at", station_id, f"a halt, {one_of(halts)}")
    choices = loop_choices(with_loops, at or halts, most, SET_LATE if set_late else AS_UNITS_ASK)
    best = choices[0]
    if out is not None and best.setup is not None and best.found is not None:
        write_answer(out, best.setup, best.found, scenario, laying(best.loops))
    rows = ["loops at              interval   an hour   waits"]
    for choice in choices:
        where = " ".join(choice.loops) or "none more"
        if choice.found is None or choice.found.interval_s is None:
            rows.append(f"{where:20}  {choice.why_not or 'none fits'}")
        else:
            s = choice.found.interval_s
            rows.append(f"{where:20}  {s:6d} s   {3600 / s:7.2f}  {choice.found.waits_s:4.0f} s")
    if any(choice.found is not None and choice.found.interval_s is not None for choice in choices):
        rows.append("each interval is proven: every smaller whole second is excluded")
    figures = [
        {"loops": c.loops, "why_not": c.why_not, **(figures_of(c.found) if c.found else {})} for c in choices
    ]
    end_with(
        {"choices": figures},
        rows,
        good=best.found is not None and best.found.interval_s is not None,
        as_json=as_json,
    )
