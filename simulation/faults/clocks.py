"""Faults of the parties' own clocks (装置の時計).

A party uses its clock for everything: to stamp telegrams and judge the age of those it receives, for its timers, and,
in a unit, for the departures of its timetable (with its clock behind, it departs late). Without a fault every clock is
right. When the fault ends the clock is right again at once, as if somebody had set it.
"""

from __future__ import annotations

from typing import Self

from pydantic import Field, PrivateAttr

from network.files.quantities import ClockDrift, ClockOffset
from simulation.clock import Clock
from simulation.faults.fault import Fault, Onset


class ClockFault(Fault[Clock]):
    """What is wrong with the clock of the block manager, a terminal or an on-board unit."""

    aims_at = "device"
    changes = "clock"
    in_order = Clock()
    target: str


class WrongClock(ClockFault):
    """The clock shows a wrong time, and runs too fast or too slow."""

    kind = "clock"
    offset_s: ClockOffset = Field(
        default=0.0, description="time by which it is ahead from the beginning; below 0: behind"
    )
    drift_ppm: ClockDrift = Field(
        default=0.0, description="rate by which it then runs too fast; below 0: too slow"
    )
    _since_s: float = PrivateAttr(default=0.0)

    def taking_hold(self, onset: Onset) -> Self:
        begun = self.model_copy()
        begun._since_s = onset.t_s
        return begun

    def applied_to(self, clock: Clock) -> Clock:
        return clock.wrong(self.offset_s, self.drift_ppm * 1e-6, self._since_s)
