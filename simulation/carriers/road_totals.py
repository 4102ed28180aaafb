"""What the road of a run comes to, by crossing and hour: who passed, how long they waited, how long queues were."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from sumo_cfg.road_net import RoadAt
from sumo_cfg.road_traffic import RoadVehicle

HOUR_S: Final = 3600.0


@dataclass(slots=True)
class RoadTotal:
    """Of one crossing and hour of the day in which vehicles came, or stood in a queue."""

    passages: int = 0
    waited_s: float = 0.0  # of all, over an unhindered passage
    waited_s_max: float = 0.0
    queue: int = 0  # vehicles in the longest queue of a lane


@dataclass(slots=True)
class RoadTotals:
    """All of a run, by id of the crossing and hour from midnight."""

    of: dict[tuple[str, int], RoadTotal] = field(default_factory=dict[tuple[str, int], RoadTotal])
    _now: dict[str, int] = field(default_factory=dict[str, int])

    def passed(self, vehicle: RoadVehicle, at_s: float) -> None:
        """A vehicle has come to the end of its road; it counts in the hour in which it wanted to come."""
        self._total(vehicle.at.crossing_id, vehicle.depart_s).passages += 1
        self.waited(vehicle, at_s - vehicle.depart_s - vehicle.free_s)

    def waited(self, vehicle: RoadVehicle, waited_s: float) -> None:
        """A vehicle has come so much later to where it is than if nothing had hindered it."""
        total = self._total(vehicle.at.crossing_id, vehicle.depart_s)
        total.waited_s += max(0.0, waited_s)
        total.waited_s_max = max(total.waited_s_max, waited_s)

    def queue(self, at: RoadAt, standing: Sequence[int], at_s: float) -> None:
        """So many vehicles stand in each lane of the approaches."""
        self._now[at.crossing_id] = longest = max(standing)
        total = self._total(at.crossing_id, at_s)
        total.queue = max(total.queue, longest)

    def queues(self, at: RoadAt) -> bool:
        """Whether vehicles stood there at the last count."""
        return self._now.get(at.crossing_id, 0) > 0

    def _total(self, crossing_id: str, at_s: float) -> RoadTotal:
        return self.of.setdefault((crossing_id, int(at_s // HOUR_S)), RoadTotal())
