"""Faults of the rail under a train, on top of the adhesion of the weather, which is drawn for each leg."""

from __future__ import annotations

from pydantic import Field

from network.files.quantities import Share
from simulation.faults.fault import UnitFault


class RailFault(UnitFault[float]):
    """The adhesion under a train, as a share of what the weather leaves."""

    changes = "rail"
    in_order = 1.0


class Slippery(RailFault):
    """The rail is slippery: wheels slip and slide if the physics say so."""

    kind = "slippery"
    factor: Share = Field(description="adhesion as a share of that of the weather")

    def applied_to(self, share: float) -> float:
        return share * self.factor
