"""Invariant: what `barriers` and `lit` say is so: barriers move in their time and stop where they are stuck, and a dead
lamp does not shine.

Lamps and barriers of a level crossing (踏切警報機, 遮断機) in the simulated world: the truth, apart from what its
device knows. The simulator owns it, gives it the device's outputs, returns `detection` as the device's input at each
change, and looks at it at `due_s`. `TABLE` is the state of the barriers and the event; where there are none they are
raised when no warning is given, and lowered when one is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import msgspec
from msgspec.structs import replace

from network.model import CrossingClass, LevelCrossing
from simulation.carriers.road_shown import CrossingShown
from simulation.events import BarrierState
from simulation.faults.crossings import IN_ORDER, CrossingCondition
from wayside.crossing_said import CloseCrossing, CrossingDetected, OpenCrossing


class CrossingEquipment(msgspec.Struct, frozen=True):
    """The equipment of one crossing. `closes`: it is to be closed; `lamps_first_s`: they shine so long before the
    barriers move, which takes `lowering_s`; `due_s`: when these have come to their end, None: they do not move.
    """

    crossing_id: str
    has_barriers: bool
    lamps_first_s: float
    lowering_s: float
    barriers: BarrierState = BarrierState.RAISED
    closes: bool = False
    due_s: float | None = None
    condition: CrossingCondition = IN_ORDER
    has_detector: bool = False
    obstacle: bool = False  # as a detector in order has it

    @property
    def lit(self) -> bool:
        """Whether the lamps shine."""
        return self.closes and not self.condition.lamps_dead


@dataclass(frozen=True, slots=True)
class BarrierTimeOver:
    """Event: the time has come to which the barriers had to move."""


@dataclass(frozen=True, slots=True)
class ConditionChanged:
    """Event: something fails or is mended."""

    condition: CrossingCondition


@dataclass(frozen=True, slots=True)
class ObstacleDetected:
    """Event: the detector (障害物検知装置) sees something on the closed road, or no longer does."""

    present: bool


EquipmentEvent = CloseCrossing | OpenCrossing | BarrierTimeOver | ConditionChanged | ObstacleDetected


def equipment_of(crossing: LevelCrossing) -> CrossingEquipment:
    """The equipment of a crossing of the line, open."""
    barriers = crossing.kind is CrossingClass.BARRIERS
    first_s = crossing.closing_s - crossing.lowering_s if barriers else 0.0
    return CrossingEquipment(
        crossing.id,
        barriers,
        first_s,
        crossing.lowering_s if barriers else 0.0,
        has_detector=crossing.has_detector,
    )


def step(equipment: CrossingEquipment, event: EquipmentEvent, now_s: float) -> CrossingEquipment:
    """The equipment after the event at `now_s`."""
    return TABLE[equipment.barriers, type(event)](equipment, event, now_s)


def detection(equipment: CrossingEquipment) -> CrossingDetected:
    """What its contacts show the device; the detector looks while barriers are down, the button is there always."""
    condition, at = equipment.condition, equipment.barriers
    lowered, raised = at is BarrierState.LOWERED, at is BarrierState.RAISED
    seen = equipment.obstacle and not condition.detector_blind
    obstacle = seen or (equipment.has_detector and lowered and condition.detector_occupied)
    if condition.detection_fault:
        return CrossingDetected(
            lamps=False, lowered=False, raised=False, obstacle=obstacle, button=condition.button
        )
    return CrossingDetected(equipment.lit, lowered, raised, obstacle, condition.button)


def shown(equipment: CrossingEquipment) -> CrossingShown:
    """What it shows to drivers."""
    barriers = equipment.barriers if equipment.has_barriers else BarrierState.RAISED
    return CrossingShown(barriers, equipment.lit)


def _moved(equipment: CrossingEquipment, now_s: float) -> CrossingEquipment:
    """On the way to the end that is commanded, unless it is there, or stuck; from where it is it takes no less."""
    ends = BarrierState.LOWERED if equipment.closes else BarrierState.RAISED
    if equipment.condition.stuck or equipment.barriers is ends:
        return replace(equipment, due_s=None)
    if not equipment.has_barriers:
        return replace(equipment, barriers=ends)
    if equipment.closes:
        due_s = now_s + equipment.lamps_first_s + equipment.lowering_s
        return replace(equipment, barriers=BarrierState.LOWERING, due_s=due_s)
    return replace(equipment, barriers=BarrierState.RISING, due_s=now_s + equipment.lowering_s)


def _close(equipment: CrossingEquipment, _event: CloseCrossing, now_s: float) -> CrossingEquipment:
    """Lamps shine at once, and in their time the barriers come down."""
    return equipment if equipment.closes else _moved(replace(equipment, closes=True), now_s)


def _open(equipment: CrossingEquipment, _event: OpenCrossing, now_s: float) -> CrossingEquipment:
    """Lamps go out, and the barriers go up."""
    return _moved(replace(equipment, closes=False), now_s) if equipment.closes else equipment


def _arrive(equipment: CrossingEquipment, _event: BarrierTimeOver, now_s: float) -> CrossingEquipment:
    """At their time they are at their end."""
    if equipment.due_s is None or now_s < equipment.due_s - 1e-9:
        return equipment
    ends = BarrierState.LOWERED if equipment.closes else BarrierState.RAISED
    return replace(equipment, barriers=ends, due_s=None)


def _change(equipment: CrossingEquipment, event: ConditionChanged, now_s: float) -> CrossingEquipment:
    """In another condition: barriers that stick stop where they are, and go on when they are mended."""
    stuck = equipment.condition.stuck
    equipment = replace(equipment, condition=event.condition)
    return equipment if stuck is event.condition.stuck else _moved(equipment, now_s)


def _detect(equipment: CrossingEquipment, event: ObstacleDetected, _now_s: float) -> CrossingEquipment:
    """Shown to the device."""
    return replace(equipment, obstacle=event.present)


def _stay(equipment: CrossingEquipment, _event: EquipmentEvent, _now_s: float) -> CrossingEquipment:
    """Nothing happens."""
    return equipment


TABLE: Final[
    Mapping[tuple[BarrierState, type], Callable[[CrossingEquipment, Any, float], CrossingEquipment]]
] = MappingProxyType(
    {
        (BarrierState.RAISED, BarrierTimeOver): _stay,
        (BarrierState.RISING, BarrierTimeOver): _arrive,
        (BarrierState.LOWERING, BarrierTimeOver): _arrive,
        (BarrierState.LOWERED, BarrierTimeOver): _stay,
        **dict.fromkeys(((at, CloseCrossing) for at in BarrierState), _close),
        **dict.fromkeys(((at, OpenCrossing) for at in BarrierState), _open),
        **dict.fromkeys(((at, ConditionChanged) for at in BarrierState), _change),
        **dict.fromkeys(((at, ObstacleDetected) for at in BarrierState), _detect),
    }
)
