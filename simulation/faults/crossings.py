"""Faults of the equipment of level crossings (踏切); their devices and links have the faults of any other.

`target` is the crossing. They end when they are over.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from simulation.faults.fault import Fault, Names


@dataclass(frozen=True, slots=True)
class CrossingCondition:
    """What is wrong: barriers that do not move, lamps that do not shine, contacts that show nothing."""

    stuck: bool = False
    lamps_dead: bool = False
    detection_fault: bool = False


IN_ORDER: Final = CrossingCondition()


class CrossingFault(Fault[CrossingCondition]):
    """What is wrong with lamps, barriers and contacts of a level crossing."""

    aims_at = "level crossing"
    changes = "crossing"
    target: str

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        return names.crossings

    def base(self) -> CrossingCondition:
        return IN_ORDER


class BarriersStuck(CrossingFault):
    """The barriers of a level crossing stay where they are, or stop on their way."""

    kind = "barriers_stuck"

    def applied_to(self, condition: CrossingCondition) -> CrossingCondition:
        return replace(condition, stuck=True)


class LampsDead(CrossingFault):
    """The lamps of a level crossing do not shine."""

    kind = "lamps_dead"

    def applied_to(self, condition: CrossingCondition) -> CrossingCondition:
        return replace(condition, lamps_dead=True)


class CrossingUndetected(CrossingFault):
    """Lamps and barriers of a level crossing move and shine, but their contacts show nothing."""

    kind = "crossing_undetected"

    def applied_to(self, condition: CrossingCondition) -> CrossingCondition:
        return replace(condition, detection_fault=True)
