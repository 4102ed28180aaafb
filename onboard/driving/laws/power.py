"""Which notch gives a force, and how far above its target the train will be when its machinery answers."""

from __future__ import annotations

from onboard.records import UnitRow
from vehicle.compiled import compiled
from vehicle.records import TrainRow
from vehicle.traction import full_force_n, notch_share


@compiled
def power_notch(train: TrainRow, load_share: float, speed_mps: float, force_n: float) -> float:
    """The lowest power notch whose force at this speed reaches `force_n`; 0 where none is wanted."""
    if force_n <= 0.0:
        return 0.0
    full_n = full_force_n(train, load_share, speed_mps)
    highest = int(train.power_notches)
    for notch in range(1, highest + 1):
        if notch_share(train, float(notch), speed_mps) * full_n >= force_n:
            return float(notch)
    return float(highest)


@compiled
def overspeed_mps(unit: UnitRow, target_mps: float, reaction_s: float) -> float:
    """How far above the target the train will be when the machinery answers, m/s; negative below.

    Wheels that slide tell neither: then it is the train's own speed, as far as it is known.
    """
    if unit.wheel_slide < 0:
        return float(unit.train_mps / unit.odometer_scale - target_mps)
    return float(max(unit.speed_mps + unit.acceleration_mps2 * reaction_s, 0.0) - target_mps)
