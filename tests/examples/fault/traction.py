"""Faults of a train's traction: motors cut out. The unit does not know; it drives on as if all pulled."""

from __future__ import annotations

from pydantic import Field

from simulation.faults.fault import UnitFault


class WeakTraction(UnitFault[float]):
    """The train pulls with a share of its force."""

    kind = "weak_traction"
    changes = "traction"
    factor: float = Field(default=0.5, ge=0.0, le=1.0, description="force left over that of the train file")

    def base(self) -> float:
        return 1.0

    def applied_to(self, share: float) -> float:
        return share * self.factor
