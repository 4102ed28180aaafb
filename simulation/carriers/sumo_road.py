"""SUMO as the carrier of trains and of the road at level crossings: one simulation in which both are.

Trains are carried as without a road. `run` also ends after a step in which a train struck a road vehicle, or in which a
detector changed: then nothing has collided, and `Road.tell` says what was noticed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from network.model import Direction
from simulation.carriers.road import Road
from simulation.carriers.sumo import SumoCarrier
from simulation.carriers.sumo_api import SumoApi


class SumoRoadCarrier(SumoCarrier):
    """`net` has the edges of the road; each method is that of `SumoCarrier`, of which the road hears."""

    def __init__(self, net: Path, begin_s: float, road: Road, api: SumoApi | None = None) -> None:
        super().__init__(net, begin_s, api, road.routes(begin_s))
        self._road = road
        road.begin(self._sumo, begin_s)

    def insert(
        self, unit_id: str, pieces: Sequence[str], direction: Direction, offset_m: float, length_m: float
    ) -> None:
        """Put a standing train on the net."""
        super().insert(unit_id, pieces, direction, offset_m, length_m)
        self._road.put(unit_id, pieces, direction, offset_m, length_m)

    def run(self, columns: Sequence[tuple[str, Sequence[float]]], steps: int) -> int:
        """Execute the speeds step by step, watching for collisions and for what detectors see."""
        if steps <= 0:
            return 0
        self._road.expect(columns, steps)
        hit = super().run(columns, steps)
        for unit_id, _ in columns:
            self._road.follow(unit_id, self.truth(unit_id))
        return hit

    def _run_steps(self, columns: Sequence[tuple[str, Sequence[float]]], first: int, last: int) -> int:
        for k in range(first, last):
            for unit_id, speeds in columns:
                self._sumo.set_speed(unit_id, speeds[k])
            self._sumo.step()
            self._judged = True
            tells = self._road.stepped()
            if (self._sumo.colliding() and self._note_collisions()) or tells:
                return k + 1
        return 0

    def reroute(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change what lies ahead."""
        super().reroute(unit_id, pieces, direction)
        self._road.lead(unit_id, pieces)

    def reverse(self, unit_id: str, pieces: Sequence[str], direction: Direction) -> None:
        """Change ends in place."""
        super().reverse(unit_id, pieces, direction)
        self._road.turn(unit_id, pieces)

    def remove(self, unit_id: str) -> None:
        """Take a train off the line."""
        super().remove(unit_id)
        self._road.remove(unit_id)

    def close(self) -> None:
        """End the simulation. May be called more than once."""
        if self._open:
            self._road.finish()
        super().close()

    def collisions(self) -> tuple[str, ...]:
        """What SUMO's own check found of trains, and which of them struck a road vehicle."""
        return (*super().collisions(), *(each.text for each in self._road.struck))
