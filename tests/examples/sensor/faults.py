"""Faults of the radar: it has been knocked, and is further off its angle than it was mounted."""

from __future__ import annotations

from pydantic import Field

from network.files.quantities import SpeedMarginMps
from simulation.faults.fault import SensorFault


class RadarKnocked(SensorFault[float]):
    """The radar is off its angle."""

    kind = "radar_knocked"
    changes = "radar"
    sensor, field = "radar", "knocked_mps"
    off_mps: SpeedMarginMps = Field(description="shown beyond the real speed")

    def base(self) -> float:
        return 0.0

    def applied_to(self, off_mps: float) -> float:
        return off_mps + self.off_mps
