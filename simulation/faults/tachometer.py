"""Faults of a train's tachometer (速度発電機): factors multiply; one that is stuck shows the same whatever they are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Self

from pydantic import Field, PrivateAttr

from simulation.faults.fault import Fault, Names, World

IN_ORDER: Final = -1.0  # what the compiled truth holds where nothing is stuck


@dataclass(frozen=True, slots=True)
class Reading:
    """What the tachometer makes of the wheel: its speed times `gain`, or `stuck_mps` for ever."""

    gain: float = 1.0
    stuck_mps: float | None = None


class TachometerFault(Fault[Reading]):
    """What the tachometer of a train shows."""

    aims_at = "unit"
    changes = "tachometer"
    target: str

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        return names.units

    def base(self, _world: World) -> Reading:
        return Reading()

    def put(self, world: World, reading: Reading) -> None:
        slot = world.slot(self.target)
        tachometer = world.trains.tachometers[slot]
        tachometer.gain = reading.gain
        tachometer.frozen_mps = IN_ORDER if reading.stuck_mps is None else reading.stuck_mps
        world.trains.tachometer_faults[slot] = reading != Reading()


class Scale(TachometerFault):
    """Shows the speed times a factor."""

    kind = "scale"
    factor: float = Field(ge=0.0, le=10.0, description="shown over real speed")

    def over(self, reading: Reading) -> Reading:
        return replace(reading, gain=reading.gain * self.factor)


class NoOutput(TachometerFault):
    """Shows nothing, even if it was stuck before."""

    kind = "no_output"

    def over(self, _reading: Reading) -> Reading:
        return Reading(gain=0.0)


class StuckOutput(TachometerFault):
    """Shows for ever what it shows when it begins."""

    kind = "stuck_output"
    _shown_mps: float = PrivateAttr(default=0.0)

    def begun(self, world: World) -> Self:
        slot = world.slot(self.target)
        tachometer, plant = world.trains.tachometers[slot], world.trains.plants[slot]
        copy = self.model_copy()
        turned_mps = float(plant.wheel_speed_mps * tachometer.gain / tachometer.wheel_factor)
        stuck_mps = float(tachometer.frozen_mps)
        copy._shown_mps = stuck_mps if stuck_mps >= 0.0 else turned_mps
        return copy

    def over(self, reading: Reading) -> Reading:
        return replace(reading, stuck_mps=self._shown_mps)
