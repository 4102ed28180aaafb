"""`branchline export sumo`: a scenario for plain SUMO, to be looked at in sumo-gui and netedit."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from branchline.ending import print_json
from branchline.options import Json, ScenarioName
from study.outcome import Outcome


def export_sumo_command(
    scenario: ScenarioName,
    out: Annotated[Path, typer.Argument(help="Directory to write into.")],
    as_json: Json = False,
) -> None:
    """Write a scenario's net, trains, stations, tags, points and ends of sections for SUMO, and a .sumocfg."""
    from study.exchange.sumo_day import export_sumo
    from study.scenario.scenario import load_scenario

    day = export_sumo(load_scenario(scenario), out)
    figures = {
        "config": str(day.config),
        "files": [str(path) for path in day.files],
        "vehicles": day.vehicles,
        "trains": day.trains,
        "stops": day.stops,
    }
    if as_json:
        print_json(figures, Outcome.GOOD)
        return
    sys.stdout.write("".join(f"wrote {path}\n" for path in day.files))
    sys.stdout.write(f"{day.trains} trains as {day.vehicles} vehicles with {day.stops} stops\n")
    sys.stdout.write(f"look at it: sumo-gui -c {day.config}\n")
