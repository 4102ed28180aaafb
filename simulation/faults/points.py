"""Faults of point machines (転てつ機). They end when staff repair the points."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pydantic import Field

from network.files.quantities import Slowness
from simulation.faults.fault import Fault


@dataclass(frozen=True, slots=True)
class Condition:
    """The state of repair of a point machine."""

    stuck: bool = False
    detection_fault: bool = False
    throw_factor: float = 1.0


class PointsFault(Fault[Condition]):
    """What is wrong with a point machine."""

    aims_at = "points"
    changes = "points"
    in_order = Condition()
    target: str


class Stuck(PointsFault):
    """The points do not move."""

    kind = "stuck"

    def applied_to(self, condition: Condition) -> Condition:
        return replace(condition, stuck=True)


class NoDetection(PointsFault):
    """The points move, but are not detected in any position."""

    kind = "no_detection"

    def applied_to(self, condition: Condition) -> Condition:
        return replace(condition, detection_fault=True)


class Slow(PointsFault):
    """The points take longer to throw."""

    kind = "slow"
    factor: Slowness = Field(description="throw time as a multiple of that in the line file")

    def applied_to(self, condition: Condition) -> Condition:
        return replace(condition, throw_factor=condition.throw_factor * self.factor)
