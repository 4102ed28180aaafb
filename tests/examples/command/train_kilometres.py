"""`branchline train-kilometres`: how far all trains of a scenario's timetable run together."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from branchline.ending import print_json
from branchline.options import Json


def train_kilometres(
    scenario: Annotated[str, typer.Argument(help="A shipped scenario or a scenario file (.toml).")],
    as_json: Json = False,
) -> None:
    """How far all trains of a timetable run together, km."""
    from scenario.scenario import load_scenario

    setup = load_scenario(scenario).setup
    at_m = {station.id: station.position_m for station in setup.line.stations.values()}
    found_km = sum(
        abs(at_m[train.calls[-1].station_id] - at_m[train.calls[0].station_id]) / 1000.0
        for train in setup.timetable.trains.values()
    )
    if as_json:
        print_json({"train_km": found_km})
    else:
        sys.stdout.write(f"{found_km:.1f} km\n")
