"""Faults of the LiDAR, of the air in front of it, and of the markers."""

from __future__ import annotations

import math

from pydantic import Field

from network.files.quantities import VisibilityM
from simulation.faults.fault import Fault, SwitchedFault, UnitFault
from simulation.settings import PositionSensor


class LidarFault(UnitFault[float]):
    """What a train's LiDAR sees through besides the air of the day: visibility in m."""

    changes = "lidar"
    in_order = math.inf
    of_sensor = PositionSensor.LIDAR


class LidarBlind(LidarFault):
    """The LiDAR sees nothing: dirt or ice on its window, or it is defective."""

    kind = "lidar_blind"

    def applied_to(self, _visibility_m: float) -> float:
        return 0.0


class LidarFog(LidarFault):
    """Fog, snow or spray in front of the LiDAR."""

    kind = "lidar_fog"
    visibility_m: VisibilityM = Field(description="visibility for people")

    def applied_to(self, visibility_m: float) -> float:
        return min(visibility_m, self.visibility_m)


class MarkerMissing(SwitchedFault, Fault[bool]):
    """One marker of a group is missing: the others are seen, but the pattern is not recognised."""

    kind = "marker_missing"
    aims_at = "group of markers"
    changes = "markers"
    in_order = True
    target: str
