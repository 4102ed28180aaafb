"""Faults of the tachometer: a wrong scale, no output, or a constant output.

Factors multiply; a stuck output stays the same whatever the factors are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from pydantic import Field, PrivateAttr

from network.files.quantities import ReadingFactor
from simulation.faults.fault import Onset, UnitFault


@dataclass(frozen=True, slots=True)
class Reading:
    """What the tachometer makes of the wheel: its speed times `gain`, or `stuck_mps` for ever."""

    gain: float = 1.0
    stuck_mps: float | None = None


class ShownByTachometer(UnitFault[Reading]):
    """What the tachometer of a train shows."""

    changes = "tachometer"
    in_order = Reading()


class Scale(ShownByTachometer):
    """The output is the speed times a factor."""

    kind = "scale"
    factor: ReadingFactor = Field(description="shown speed as a multiple of the real speed")

    def applied_to(self, reading: Reading) -> Reading:
        return replace(reading, gain=reading.gain * self.factor)


class NoOutput(ShownByTachometer):
    """There is no output, even if it was stuck before."""

    kind = "no_output"

    def applied_to(self, _reading: Reading) -> Reading:
        return Reading(gain=0.0)


class StuckOutput(ShownByTachometer):
    """The output stays as it is when the fault begins."""

    kind = "stuck_output"
    _shown_mps: float = PrivateAttr(default=0.0)

    def taking_hold(self, onset: Onset) -> Self:
        copy = self.model_copy()
        copy._shown_mps = onset.shown_mps(self.target)
        return copy

    def applied_to(self, reading: Reading) -> Reading:
        return replace(reading, stuck_mps=self._shown_mps)
