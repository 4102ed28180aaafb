"""Faults of the equipment of level crossings (踏切); their devices and links have the faults of any other.

`target` is the crossing. They end when they are over.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from simulation.faults.fault import Fault


@dataclass(frozen=True, slots=True)
class CrossingCondition:
    """What is wrong: barriers that do not move, lamps that do not shine, contacts that show nothing, a button that was
    pressed, an obstacle detector that sees nothing, or always something.
    """

    stuck: bool = False
    lamps_dead: bool = False
    detection_fault: bool = False
    button: bool = False
    detector_blind: bool = False
    detector_occupied: bool = False


IN_ORDER: Final = CrossingCondition()


class CrossingFault(Fault[CrossingCondition]):
    """What is wrong with lamps, barriers, contacts, button and detector of a level crossing."""

    aims_at = "level crossing"
    changes = "crossing"
    in_order = IN_ORDER
    target: str


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


class ButtonPressed(CrossingFault):
    """Somebody at a level crossing presses its button (支障報知装置); it stays pressed until staff reset it."""

    kind = "button_pressed"

    def applied_to(self, condition: CrossingCondition) -> CrossingCondition:
        return replace(condition, button=True)


class DetectorBlind(CrossingFault):
    """The obstacle detector of a level crossing shows a free road whatever stands on it."""

    kind = "detector_blind"

    def applied_to(self, condition: CrossingCondition) -> CrossingCondition:
        return replace(condition, detector_blind=True)


class DetectorOccupied(CrossingFault):
    """The obstacle detector of a level crossing shows that something stands on its road, though nothing does."""

    kind = "detector_occupied"

    def applied_to(self, condition: CrossingCondition) -> CrossingCondition:
        return replace(condition, detector_occupied=True)


class DetectorOff(DetectorOccupied):
    """The obstacle detector of a level crossing has no power: its relay falls, as if something stood there."""

    kind = "detector_off"
