"""Faults of the satellite receiver: no signals; fixes beyond its protection level, late, or all of one place."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pydantic import Field

from network.files.quantities import CorrelationWay, ReceiverBias, ReceiverLatency
from simulation.faults.fault import UnitFault


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

    def base(self) -> Reception:
        return Reception()


class GnssAntenna(GnssFault):
    """The antenna is dead: no fix."""

    kind = "gnss_antenna"

    def over(self, reception: Reception) -> Reception:
        return replace(reception, no_signals=True)


class GnssJammed(GnssFault):
    """Somebody's transmitter drowns the satellites: no fix, and none for a time after."""

    kind = "gnss_jammed"

    def over(self, reception: Reception) -> Reception:
        return replace(reception, no_signals=True)


class GnssReflections(GnssFault):
    """Reflections beyond the protection level, under what the receiver takes for an open sky: it states wrongly."""

    kind = "gnss_reflections"
    bias_m: ReceiverBias = Field(description="what they come to, along the train's way")
    over_m: CorrelationWay = Field(default=80.0, description="the way over which they come, and go")

    def over(self, reception: Reception) -> Reception:
        return replace(reception, bias_m=reception.bias_m + self.bias_m, over_m=self.over_m)


class GnssJump(GnssFault):
    """The receiver's position jumps, and its statement is wrong."""

    kind = "gnss_jump"
    bias_m: ReceiverBias = Field(description="by so much, along the train's way")

    def over(self, reception: Reception) -> Reception:
        return replace(reception, bias_m=reception.bias_m + self.bias_m, over_m=0.0)


class GnssTimeTag(GnssFault):
    """Fixes are older than their time tags say."""

    kind = "gnss_time_tag"
    late_s: ReceiverLatency = Field(description="by so much")

    def over(self, reception: Reception) -> Reception:
        return replace(reception, late_s=reception.late_s + self.late_s)


class GnssFrozen(GnssFault):
    """Fixes are all of the place of the last one before, with new time tags: what computes the position has died."""

    kind = "gnss_frozen"

    def over(self, reception: Reception) -> Reception:
        return replace(reception, frozen=True)
