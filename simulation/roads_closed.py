"""Roads that are closed although no train comes there, as who looks along the track would say (踏切の無用な遮断).

A train comes to a level crossing while any of it is on the road, while it moves towards it, and while it stands before
it with a unit that works and holds the way over it; where contacts control the crossing, wherever it is between them.
"""

from __future__ import annotations

from typing import Final

from network.model import CrossingControl, LevelCrossing
from simulation.world.crossings import CrossingsOnTrack
from simulation.world.on_board import OnBoard
from simulation.world.trains import Trains

LOOKS_ALONG_M: Final = 2000.0  # assumed: a train that runs farther away is no reason to leave a road closed


class RoadsClosedForNothing:
    """Looks at the crossings of a run by the truth; what units and devices believe is no part of it."""

    def __init__(self, trains: Trains, on_board: OnBoard, crossings: CrossingsOnTrack) -> None:
        self._trains, self._on_board, self._crossings = trains, on_board, crossings

    def for_nothing(self) -> tuple[str, ...]:
        """The crossings that are commanded closed, and to which no train comes."""
        return tuple(
            crossing.id
            for crossing in self._crossings.on_line
            if self._crossings.equipment[crossing.id].closes
            and not any(self._comes(slot, crossing) for slot in self._trains.active())
        )

    def _comes(self, slot: int, crossing: LevelCrossing) -> bool:
        trains, path = self._trains, self._trains.true_path(slot)
        if crossing.piece_id not in path:
            return False
        front_m = float(trains.truths[slot].position_m)
        road_m, way_m = path.to_road_m(crossing), path.to_road_m(crossing) - front_m
        beyond_m = front_m - float(trains.bodies[slot].length_m) - (road_m + crossing.width_m)
        before_m, after_m = 0.0, 0.0
        if crossing.control is CrossingControl.CONTACTS:
            before_m, after_m = crossing.contacts_from_road_m(path.direction)
        if way_m <= before_m and beyond_m <= after_m:
            return True
        if way_m <= 0.0:
            return False
        if float(trains.plants[slot].speed_mps) > 0.0:
            return way_m < LOOKS_ALONG_M
        works = slot not in self._on_board.unpowered
        held = self._on_board.shown_to_driver(slot).held
        return works and trains.setup.line.pieces[crossing.piece_id].section_id in held
