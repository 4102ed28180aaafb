"""The measured wheel: what one pulse of its tachometer stands for. SI units."""

from __future__ import annotations

import math

from vehicle.compiled import compiled
from vehicle.records import TrainRow


@compiled
def pulse_m(train: TrainRow) -> float:
    """Way of one pulse of the tachometer (速度発電機) by the diameter that it is set for, m."""
    return math.pi * train.wheel_diameter_m / train.pulses_per_revolution
