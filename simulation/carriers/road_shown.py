"""What road and device tell each other: what a crossing shows to drivers, and what stands on it while it is closed."""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

from simulation.events import BarrierState


class CrossingShown(NamedTuple):
    """What drivers see: barriers, which are always raised where there are none, and whether the lamps flash."""

    barriers: BarrierState
    lamps: bool


OPEN: Final = CrossingShown(BarrierState.RAISED, lamps=False)


class ObstacleDetectors(Protocol):
    """The inputs of obstacle detectors (障害物検知装置)."""

    def obstacle(self, crossing_id: str, at_step: int, *, present: bool) -> None:
        """At the present step a vehicle is on the closed crossing, or is no longer."""
        ...
