"""What road and device tell each other: what a crossing shows to drivers, and what stands on it while it is closed."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple, Protocol


class BarrierPosition(Enum):
    """Where the barriers (遮断かん) of a crossing are; one without barriers has them always raised."""

    RAISED = "raised"
    LOWERING = "lowering"
    LOWERED = "lowered"
    RISING = "rising"


class CrossingShown(NamedTuple):
    """What drivers see: barriers, and whether the lamps flash."""

    barriers: BarrierPosition
    lamps: bool


class CrossingsShown(Protocol):
    """All crossings' equipment, as it is seen from the road."""

    def shown(self, crossing_id: str, step: int) -> CrossingShown:
        """What a crossing shows at a step."""
        ...


class ObstacleDetectors(Protocol):
    """What is told of a closed crossing: the input of its obstacle detector (障害物検知装置)."""

    def obstacle(self, crossing_id: str, at_step: int, *, present: bool) -> None:
        """At the present step a vehicle is on the closed crossing, or is no longer."""
        ...
