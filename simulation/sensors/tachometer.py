"""The tachometer (速度発電機): counts the turning of one axle, by a circumference that may not be the wheel's.

Its faults: a scale other than 1, no output (gain 0), an output that stays at one speed for ever.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from vehicle.compiled import compiled
from vehicle.records import PlantRow

SLIDE_SEEN_MPS: Final = 0.05  # the slide protection compares axles no finer than this


class TachometerRow(Protocol):
    """One train's tachometer."""

    wheel_factor: Annotated[float, "true circumference over the one it is set for"]
    odometer_m: Annotated[float, "what it has counted"]
    gain: Annotated[float, "1 in order, 0 silent"]
    miscount_share: Annotated[float, "of the distance, counted too much (< 0: pulses lost); speed is right"]
    frozen_mps: Annotated[float, "shows this speed for ever; negative: in order"]


@compiled
def read_tachometer(
    tachometer: TachometerRow, plant: PlantRow, wheel_before_m: float, step_s: float
) -> float:
    """Count the wheel's turning of one step; returns the speed shown, m/s. A faulty one shows what it shows."""
    if tachometer.frozen_mps >= 0.0:
        tachometer.odometer_m += tachometer.frozen_mps * step_s
        return tachometer.frozen_mps
    gain = tachometer.gain / tachometer.wheel_factor
    tachometer.odometer_m += (plant.wheel_travelled_m - wheel_before_m) * (
        gain * (1.0 + tachometer.miscount_share)
    )
    return plant.wheel_speed_mps * gain


@compiled
def slide_seen(plant: PlantRow) -> int:
    """What the slide protection tells the unit: -1 the wheels slide, 1 they slip, 0 they roll."""
    difference = plant.wheel_speed_mps - plant.speed_mps
    if abs(difference) <= SLIDE_SEEN_MPS:
        return 0
    return -1 if difference < 0.0 else 1
