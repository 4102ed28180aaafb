"""Trains that wait for one another in a ring when a run has ended: nothing would ever have freed them."""

from __future__ import annotations

from typing import Final

from simulation.events import MANAGER, EventType
from simulation.result import Ending, RunResult
from wayside.said import Granted, Refused

READS: Final[tuple[EventType, ...]] = (Granted, Refused)  # events that a journal must have kept


def deadlocked(result: RunResult) -> tuple[str, ...]:
    """Numbers of the trains in a ring, each waiting for what the next one has; empty where there is none."""
    if result.ended_because is Ending.FINISHED:
        return ()
    waits_for: dict[str, str] = {}
    for entry in result.journal.entries:
        match entry.event:
            case Refused(unit_id=unit, other_id=other) if entry.who == MANAGER and other:
                waits_for[unit] = other
            case Granted(unit_id=unit) if entry.who == MANAGER:
                waits_for.pop(unit, None)
            case _:
                pass
    stand = {waiting.stock_id: waiting.number for waiting in result.waiting if waiting.stands}
    for first in stand:
        ring = _ring_from(first, {unit: other for unit, other in waits_for.items() if unit in stand})
        if ring:
            return tuple(stand[unit] for unit in ring)
    return ()


def _ring_from(first: str, waits_for: dict[str, str]) -> list[str]:
    """The units that one waits for, and those that they wait for, if that comes back to it."""
    ring, unit = [first], waits_for.get(first, "")
    while unit in waits_for and unit not in ring:
        ring.append(unit)
        unit = waits_for[unit]
    return ring if unit == first else []
