"""Faults of the clocks that parties have of their own (装置の時計).

All that a party does in time it does by its clock: it stamps telegrams and judges the age of those it hears, its
timers run by what passes of it, and a unit reads the departures of its timetable off it (a late clock departs late).
Without a fault every clock is right. A fault that ends leaves it right again at once, as if it had been set.
"""

from __future__ import annotations

from typing import Self

from pydantic import Field, PrivateAttr

from network.files.quantities import ClockDrift, ClockOffset
from simulation.clock import Clock
from simulation.faults.fault import Fault, Names, Onset


class ClockFault(Fault[Clock]):
    """What is wrong with the clock of the block manager, a terminal or an on-board unit."""

    aims_at = "device"
    changes = "clock"
    target: str

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        return *names.devices, *names.units

    def base(self) -> Clock:
        return Clock()


class WrongClock(ClockFault):
    """The clock shows a wrong time, and goes too fast or too slow."""

    kind = "clock"
    offset_s: ClockOffset = Field(
        default=0.0, description="time by which it is ahead at once; below 0: behind"
    )
    drift_ppm: ClockDrift = Field(
        default=0.0, description="by which it goes too fast from then on; below 0: too slow"
    )
    _since_s: float = PrivateAttr(default=0.0)

    def begun(self, onset: Onset) -> Self:
        begun = self.model_copy()
        begun._since_s = onset.t_s
        return begun

    def over(self, clock: Clock) -> Clock:
        return clock.wrong(self.offset_s, self.drift_ppm * 1e-6, self._since_s)
