"""The road of a run: where the line's level crossings have one, and who drives on it that day."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from simulation.carriers.road import Road
from simulation.setup import Setup
from sumo_cfg.road_net import RoadAt


def roads_at(setup: Setup) -> tuple[RoadAt, ...]:
    """The roads over the crossings of the line, in the line's order."""
    return tuple(
        RoadAt(crossing.id, crossing.piece_id, crossing.position_m, road, crossing.has_detector)
        for crossing in setup.line.crossings.values()
        if (road := setup.roads.get(crossing.id)) is not None
    )


def road_of(setup: Setup, roads: Sequence[RoadAt], folder: Path) -> Road | None:
    """The road of a day in a net with these; None for none. `folder` is for SUMO's file of the vehicles."""
    if not roads:
        return None
    return Road(setup.line, roads, folder, seed=setup.seed, end_s=setup.latest_end_s, today=setup.today)
