"""Hold the cruising speed that the timetable asks for, with whole notches (ATO).

The notches swing the speed about the target; brakes are for descents. What slows the train by itself, gradient and
running resistance, is taken off the brake demand, since the train's own brake control is calibrated on the level.
"""

from __future__ import annotations

from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray

from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.power import overspeed_mps, power_notch
from onboard.records import BehaviourRow, UnitRow
from vehicle.brakes import service_notch
from vehicle.compiled import compiled, compiled_when_called
from vehicle.mass import equivalent_mass_kg
from vehicle.records import TrainRow
from vehicle.traction import full_force_n, notch_share

HOLD_BAND_MPS = (
    0.25  # the speed swings this far about the target: notches are whole, and each is worth 0.1 m/s2
)


class HoldSpeedRow(Protocol):
    """What this law keeps."""

    over_mps: Annotated[float, "how far above its target the train will be when its machinery answers"]


@compiled_when_called
def hold_speed(
    own: HoldSpeedRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    plan: NDArray[np.void],
) -> float:
    """The notch that holds `unit.cruise_mps`, or the limit where that is lower."""
    cue.ceiling_mps = unit.cruise_mps
    own.over_mps = overspeed_mps(unit, min(cue.limit_mps, unit.cruise_mps), cue.reaction_s)
    return holding_notch(unit, train, behaviour, cue, own.over_mps)


@compiled
def holding_notch(
    unit: UnitRow, train: TrainRow, behaviour: BehaviourRow, cue: CueRow, over_mps: float
) -> float:
    """The notch that holds the target between stations: the speed swings between the notches either side of it.

    A rising train keeps a notch that is stronger than what slows it up to the band's upper edge, then one that
    is weaker down to the lower edge; a brake once applied is kept down to the target.
    """
    own_mps2, load_share = cue.own_mps2, cue.load_share
    if unit.notch < 0.0 and over_mps > 0.0:
        needed = own_mps2 - behaviour.settings.cruise_gain_per_s * over_mps
        return service_notch(train, -needed) if needed < 0.0 else 0.0
    inertia_kg = equivalent_mass_kg(train, load_share)
    strongest_n = full_force_n(train, load_share, unit.speed_mps)
    present_n = notch_share(train, unit.notch, unit.speed_mps) * strongest_n if unit.notch > 0.0 else 0.0
    rising = unit.notch > 0.0 and present_n > own_mps2 * inertia_kg
    upper = HOLD_BAND_MPS if rising else -HOLD_BAND_MPS
    if over_mps < upper:
        wanted = behaviour.settings.cruise_gain_per_s * max(-over_mps, 0.0)
        return power_notch(train, load_share, unit.speed_mps, (own_mps2 + wanted) * inertia_kg)
    weaker = power_notch(train, load_share, unit.speed_mps, own_mps2 * inertia_kg) - 1.0
    return max(weaker, 0.0)
