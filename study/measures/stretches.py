"""A stock's day by the truth: when it was off the line, moved, or stood, and in which phase of its duty."""

from __future__ import annotations

from dataclasses import dataclass

from simulation.result import EnergyPhase, EnergyRecord, RunResult
from simulation.setup import STEPS_PER_S


@dataclass(frozen=True, slots=True)
class DayStretch:
    """A part of a stock's day in which it is off the line, moves, or stands, by the truth; `phase` None: off it."""

    unit: str
    train: str
    phase: EnergyPhase | None
    from_id: str
    to_id: str
    from_s: float
    to_s: float


def stretches(result: RunResult, unit: str) -> tuple[DayStretch, ...]:
    """A stock's day by the truth, from the beginning of the run to its end, without gap or overlap."""
    begin_s, end_s = result.begin_step / STEPS_PER_S, result.end_step / STEPS_PER_S
    records = sorted((r for r in result.energy if r.stock_id == unit), key=lambda r: r.begin_s)
    found: list[DayStretch] = []
    at_s = begin_s
    for record in records:
        if record.end_s <= record.begin_s:
            continue
        if record.begin_s > at_s:
            found.append(_off(unit, at_s, record.begin_s))
        found.append(_on(record, max(record.begin_s, at_s)))
        at_s = record.end_s
    if at_s < end_s:
        found.append(_off(unit, at_s, end_s))
    return tuple(found)


def _off(unit: str, from_s: float, to_s: float) -> DayStretch:
    return DayStretch(unit, "", None, "", "", from_s, to_s)


def _on(record: EnergyRecord, from_s: float) -> DayStretch:
    ends = record.from_id, record.to_id
    return DayStretch(record.stock_id, record.number, record.phase, *ends, from_s, record.end_s)
