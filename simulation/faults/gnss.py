"""Faults of the satellite receiver: no signals; fixes beyond its protection level, late, or always of one place."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pydantic import Field

from network.files.quantities import CorrelationWay, ReceiverBias, ReceiverLatency
from simulation.faults.fault import UnitFault
from simulation.settings import PositionSensor


@dataclass(frozen=True, slots=True)
class Reception:
    """What is wrong: no signals, what is added to fixes (over how much way), older than stated, all the same place."""

    no_signals: bool = False
    bias_m: float = 0.0
    over_m: float = 0.0
    late_s: float = 0.0
    frozen: bool = False


class GnssFault(UnitFault[Reception]):
    """What the receiver of a train shows; nothing where it has none."""

    changes = "gnss"
    in_order = Reception()
    of_sensor = PositionSensor.GNSS


class GnssAntenna(GnssFault):
    """The antenna is dead: no fix."""

    kind = "gnss_antenna"

    def applied_to(self, reception: Reception) -> Reception:
        return replace(reception, no_signals=True)


class GnssJammed(GnssFault):
    """A transmitter jams the satellites: no fix, and none for some time after."""

    kind = "gnss_jammed"

    def applied_to(self, reception: Reception) -> Reception:
        return replace(reception, no_signals=True)


class GnssReflections(GnssFault):
    """Reflections cause errors beyond the protection level, though the receiver sees an open sky."""

    kind = "gnss_reflections"
    bias_m: ReceiverBias = Field(description="error along the train's way")
    over_m: CorrelationWay = Field(default=80.0, description="distance over which it builds up and goes away")

    def applied_to(self, reception: Reception) -> Reception:
        return replace(reception, bias_m=reception.bias_m + self.bias_m, over_m=self.over_m)


class GnssJump(GnssFault):
    """The receiver's position jumps, without a greater protection level."""

    kind = "gnss_jump"
    bias_m: ReceiverBias = Field(description="jump along the train's way")

    def applied_to(self, reception: Reception) -> Reception:
        return replace(reception, bias_m=reception.bias_m + self.bias_m, over_m=0.0)


class GnssTimeTag(GnssFault):
    """Fixes are older than their time tags say."""

    kind = "gnss_time_tag"
    late_s: ReceiverLatency = Field(description="additional age")

    def applied_to(self, reception: Reception) -> Reception:
        return replace(reception, late_s=reception.late_s + self.late_s)


class GnssFrozen(GnssFault):
    """All fixes repeat the last position, with new time tags."""

    kind = "gnss_frozen"

    def applied_to(self, reception: Reception) -> Reception:
        return replace(reception, frozen=True)
