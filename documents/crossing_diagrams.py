"""What the machines of a level crossing are explored with, for their state diagrams: device, barriers, unit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

from network.model import CrossingClass, CrossingControl, LevelCrossing
from onboard.crossings import machine as unit_side
from onboard.crossings.machine import CrossingPlace, CrossingSeen, CrossingView
from radio.messages import CrossingOver, CrossingRequest
from simulation.faults.crossings import CrossingCondition
from simulation.world import crossing_equipment
from simulation.world.crossing_equipment import BarrierTimeOver, ConditionChanged, CrossingEquipment
from verify.breadth import Explored, Keyed, explore
from wayside import level_crossing
from wayside.config import CrossingConfig
from wayside.crossing_said import CloseCrossing, CrossingContact, CrossingDetected, NoTrainComes, OpenCrossing
from wayside.level_crossing import ClosureAsked, CrossingDevice, CrossingLeft, CrossingMemory, CrossingTimeDue

STATES_MAX: Final = 1500
_CONFIG: Final = CrossingConfig("line", "C", barriers=True, closing_s=15.0, closed_s=20.0)
_CROSSING: Final = LevelCrossing(
    "C", "C", CrossingClass.BARRIERS, CrossingControl.RADIO, "6", 700.0, 6.0, 8.0, 15.0, 20.0
)
_LATER_S: Final = 100.0
_PLACE: Final = ("C", 0, 0, 35.0, 15.0, 15.0)


def devices() -> Explored[Keyed]:
    """What the device of a level crossing has commanded and knows; all at one time, but for what is due later."""
    fresh = level_crossing.start(_CONFIG, CrossingMemory())
    return explore([_keyed(fresh)], _device, lambda keyed: keyed.state.state.value, STATES_MAX)


def _keyed(device: CrossingDevice) -> Keyed:
    known = device.state, device.memory, device.detected, device.deadline_s, device.lit_s
    said = device.persons, device.frees_s, device.doubted
    return Keyed((*known, *said, tuple(sorted(device.approaches.items(), key=str))), device)


def _device(keyed: Keyed) -> Iterator[tuple[str, Keyed]]:
    device: CrossingDevice = keyed.state
    down = CrossingDetected(lamps=True, lowered=True, raised=False)
    up = CrossingDetected(lamps=False, lowered=False, raised=True)
    events: tuple[level_crossing.CrossingEvent, ...] = (
        *(ClosureAsked("u1", 1, CrossingRequest(arrives_s, math.inf)) for arrives_s in (20.0, 60.0)),
        CrossingLeft("u1", 1, CrossingOver(passed=True)),
        down,
        up,
        *(NoTrainComes(person) for person in ("controller", "staff")),
        *(CrossingContact(first) for first in (True, False) if device.memory.counted < 2 or not first),
    )
    for event in events:
        yield type(event).__name__, _keyed(level_crossing.step(device, event, 0.0)[0])
    yield CrossingTimeDue.__name__, _keyed(level_crossing.step(device, CrossingTimeDue(), _LATER_S)[0])


def barriers() -> Explored[CrossingEquipment]:
    """Where the barriers are."""
    fresh = crossing_equipment.equipment_of(_CROSSING)
    return explore([fresh], _equipment, lambda equipment: equipment.barriers.value, STATES_MAX)


def _equipment(equipment: CrossingEquipment) -> Iterator[tuple[str, CrossingEquipment]]:
    events: tuple[crossing_equipment.EquipmentEvent, ...] = (
        CloseCrossing("C"),
        OpenCrossing("C"),
        *(ConditionChanged(CrossingCondition(stuck=stuck)) for stuck in (True, False)),
    )
    for event in events:
        yield type(event).__name__, crossing_equipment.step(equipment, event, 0.0)
    yield BarrierTimeOver.__name__, crossing_equipment.step(equipment, BarrierTimeOver(), _LATER_S)


def views() -> Explored[CrossingView]:
    """Where a unit stands with a crossing on its path."""
    return explore([CrossingView("C")], _view, lambda view: view.phase.value, STATES_MAX)


def _view(view: CrossingView) -> Iterator[tuple[str, CrossingView]]:
    due: dict[str, Any] = {"arrives_s": 40.0, "fastest_s": 30.0, "proof_s": 20.0}
    places = (
        None,
        CrossingPlace(*_PLACE, **due),
        CrossingPlace(*_PLACE, stands=True),
        CrossingPlace(*_PLACE, entered=True, under=True),
        CrossingPlace(*_PLACE, entered=True, under=True, beyond=True, clear=True),
    )
    for now_s in (0.0, _LATER_S):
        for place in places:
            yield CrossingSeen.__name__, unit_side.step(view, CrossingSeen(place), now_s)[0]
    events: tuple[unit_side.CrossingEvent, ...] = (
        *(unit_side.CrossingAnswered(closed, 12.0) for closed in (True, False)),
        unit_side.CrossingOverAnswered(),
        unit_side.CrossingBooted(),
        unit_side.CrossingOffLine(),
        unit_side.CreepAllowed(),
    )
    for event in events:
        yield type(event).__name__, unit_side.step(view, event, 0.0)[0]
