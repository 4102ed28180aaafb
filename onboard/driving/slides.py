"""How fast a train may truly run while its wheels slide (滑走): by the axle that the slide protection has let go.

Invariant: the train runs no faster than `unit.slid_mps`, where that is above 0, as long as no rail is more slippery
than `[driving] least_adhesion` and one of the two axles is as good as wheels are stated to be. From the first step in
which wheels do not roll it is the speed that they had, and what a descent or the motors may add. It comes down to what
the axles show where the last one surely rolls: its brake has been off for a while, as the protection lets it go in a
slide, and it does not gain speed as one does that the rail brings back,

    g adhesion / rotating mass factor - what the rail and a descent make of the train.

Slide protections find the speed to which wheels have to return in the same way. Where no least adhesion is stated, an
axle that comes back may look like one that rolls: then the speed before the slide stays until they have rolled again.
"""

from __future__ import annotations

from typing import Final

from onboard.driving.supervision import fastest_share
from onboard.localisation.tachometer import DESCENT_MPS2, ROLLS_S
from onboard.records import BehaviourRow, UnitRow
from vehicle.adhesion import ROTATING_SHARE_MIN
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg
from vehicle.records import TrainRow
from vehicle.traction import full_force_n

LET_GO_S: Final = 0.3  # assumed: a valve has emptied the cylinder of its axle
NO_BRAKE_MPS2: Final = 0.05  # less than this holds no axle on any rail
FREE_S: Final = 1.0  # assumed: brakes let go by so much later than they are designed to


@compiled
def gains_back_mps2(train: TrainRow, least_adhesion: float) -> float:
    """What the speed of an axle that slides, let go, grows by at least, m/s^2."""
    rail_mps2 = GRAVITY_MPS2 * least_adhesion
    return float(rail_mps2 / max(train.rotating_mass_factor, ROTATING_SHARE_MIN) - rail_mps2 - DESCENT_MPS2)


@compiled
def bound_slid_speed(
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    before_mps: float,
    axle_before_mps: float,
    built_mps2: float,
    own_mps2: float,
    load_share: float,
) -> None:
    """Keep `unit.slid_mps`: from the tachometer (m/s) and the last axle of a step ago, and what they show now.

    `own_mps2`: what gradient and running resistance take off the speed.
    """
    rolls = unit.wheel_slide == 0
    if rolls and unit.slid_mps == 0.0:
        return
    step_s, share = behaviour.step_s, fastest_share(unit)
    if unit.slid_mps == 0.0:
        unit.slid_mps = max(before_mps, axle_before_mps) * share
        unit.rolls_s = 0.0
        unit.let_go_s = unit.free_s = 0.0
    lets_go = unit.wheel_slide < 0 and train.wheel_slide_share_max < 1.0
    unit.let_go_s = unit.let_go_s + step_s if lets_go else 0.0
    unit.free_s = unit.free_s + step_s if built_mps2 < NO_BRAKE_MPS2 else 0.0
    pull_mps2 = 0.0
    if unit.notch > 0.0:
        pull_mps2 = full_force_n(train, load_share, unit.slid_mps) / equivalent_mass_kg(train, load_share)
    unit.slid_mps += max(pull_mps2 - own_mps2, 0.0) * step_s
    least, axle_mps = behaviour.settings.least_adhesion, unit.last_axle_mps
    gained_mps2 = (axle_mps - axle_before_mps) / step_s
    shows_it = least > 0.0 and axle_mps >= 0.0 and (unit.let_go_s >= LET_GO_S or unit.free_s >= FREE_S)
    if shows_it and gained_mps2 < gains_back_mps2(train, least):
        unit.slid_mps = min(unit.slid_mps, max(unit.speed_mps, axle_mps) * share)
    if unit.seen_within_mps > 0.0:
        unit.slid_mps = min(unit.slid_mps, unit.seen_speed_mps + unit.seen_within_mps)
    unit.rolls_s = unit.rolls_s + step_s if rolls else 0.0
    if unit.rolls_s >= ROLLS_S:
        unit.slid_mps = 0.0
