"""Drive as people do: each driver by habits of his own, drawn once for each stock (運転士ごとのばらつき).

A driver powers up to a little above the speed that the time asks for, lets the train run down to a little under it,
shuts off for good some time before the brake, and brakes from afar as softly as he likes it. He looks up every so
often, and who sees that he will be late gives up coasting and runs as fast as his time then asks for. The last metres
are TASC's. How much drivers differ is set so that the energy of the same hop in the same time scatters as Oda's first
chapter says (`papers.driver_scatter`); the habits themselves are assumed.
"""

from __future__ import annotations

from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray

from network.files.kinds import about
from network.files.quantities import Reaction, Share, ShareAbove0, SpeedMarginMps, Wait
from network.files.toml_input import Record
from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.hold_speed import holding_notch
from onboard.driving.laws.power import overspeed_mps, power_notch
from onboard.records import BehaviourRow, UnitRow
from vehicle.brakes import service_notch
from vehicle.compiled import compiled, compiled_when_called
from vehicle.mass import equivalent_mass_kg
from vehicle.records import TrainRow

HAND_OVER_M = 30.0  # assumed: from here on TASC brings the train to the mark
CREEP_MPS = 3.0  # assumed: held by who starts so near to the mark, until TASC brakes
LEAST_GAIN_MPS2 = 0.15  # assumed: on a gradient a driver takes the notch that still gains this
LEAST_BRAKE_SHARE = 0.4  # assumed: nobody brakes more softly, of the stop pattern's deceleration
LEAST_LOOK_S = 0.3
SLIP_OVER_S = 5.0  # assumed: wheels that rolled for so long after a slip get a notch more again
OFF_TIME_S = 5.0  # assumed: who reckons to be later hurries, and who is that early brakes to the speed wanted

SPREAD = "calibrated together: papers.driver_scatter"


class Driver(Record):
    """`[law.driver]`: a driver's habits, each as its mean over drivers and its standard deviation among them."""

    power_share: Annotated[ShareAbove0, about("share of the power notches used to start", "assumed")] = 0.85
    power_share_sigma: Annotated[Share, about("standard deviation among drivers", SPREAD)] = 0.08
    swing_mps: Annotated[
        SpeedMarginMps,
        about(
            "power is shut off this much above the wanted speed, and taken again this much below it",
            "assumed: 4 km/h",
        ),
    ] = 4.0 / 3.6
    swing_sigma_mps: Annotated[SpeedMarginMps, about("standard deviation among drivers", SPREAD)] = 0.24
    coast_s: Annotated[Wait, about("coasting time before the brake", "assumed")] = 12.0
    coast_sigma_s: Annotated[Wait, about("standard deviation among drivers", SPREAD)] = 3.2
    look_s: Annotated[
        Reaction, about("time between two looks at the speed; the notch is changed only then", "assumed")
    ] = 1.0
    look_sigma_s: Annotated[Reaction, about("standard deviation among drivers", SPREAD)] = 0.12
    under_mps: Annotated[SpeedMarginMps, about("margin kept below the limit", "assumed: 2 km/h")] = 2.0 / 3.6
    under_sigma_mps: Annotated[SpeedMarginMps, about("standard deviation among drivers", SPREAD)] = 0.12
    brake_share: Annotated[
        ShareAbove0, about("share of the stop pattern's deceleration used far from the mark", "assumed")
    ] = 0.85
    brake_share_sigma: Annotated[Share, about("standard deviation among drivers", SPREAD)] = 0.08
    catches_up: Annotated[
        bool,
        about(
            "a driver who expects to be late runs as fast as the timetable needs and no longer coasts",
            "assumed",
        ),
    ] = True


class DriverRow(Protocol):
    """What this law keeps: the settings, what was drawn of each habit for this driver, and what he is doing."""

    settings: Driver
    power_drawn: float
    swing_drawn: float
    coast_drawn: float
    look_drawn: float
    under_drawn: float
    brake_drawn: float
    looks_s: Annotated[float, "when he looks up next"]
    asked: Annotated[float, "the notch that he set when he last did"]
    powering: int
    coasting: Annotated[int, "1: power is shut off for good"]
    ran: Annotated[int, "1: the train has come up to its speed since it left"]
    hurries: Annotated[int, "1: late, so he runs by the limit and coasts no more"]
    late_s: Annotated[float, "as he reckons it: he would stand at the mark so much after his time"]
    eased: Annotated[float, "so many notches less than his habit, as wheels slipped"]
    slipped_s: Annotated[float, "when they last did, or he last took a notch more"]


DRAWN = ("power_drawn", "swing_drawn", "coast_drawn", "look_drawn", "under_drawn", "brake_drawn")


@compiled_when_called
def driver(
    own: DriverRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    plan: NDArray[np.void],
) -> float:
    """The notch that this driver sets."""
    swing_mps = max(own.settings.swing_mps + own.settings.swing_sigma_mps * own.swing_drawn, 0.0)
    under_mps = max(own.settings.under_mps + own.settings.under_sigma_mps * own.under_drawn, 0.0)
    limit_mps = max(cue.limit_mps - under_mps, 0.0)
    brake_share = own.settings.brake_share + own.settings.brake_share_sigma * own.brake_drawn
    brake_mps2 = behaviour.settings.stop_deceleration_mps2 * min(max(brake_share, LEAST_BRAKE_SHARE), 1.0)
    left_m = unit.target_stop_m - unit.position_m
    wanted_mps = min(limit_mps, unit.cruise_mps)
    own.late_s = late_by_s(cue, wanted_mps, left_m, brake_mps2) if own.ran == 1 else 0.0
    if own.late_s > OFF_TIME_S:
        own.hurries = own.settings.catches_up
    elif own.late_s <= 0.0:
        own.hurries = 0
    cue.ceiling_mps = unit.cruise_mps + swing_mps if own.late_s < -OFF_TIME_S else np.inf
    if own.hurries == 1:
        wanted_mps = min(max(required_mps(cue, left_m, brake_mps2), wanted_mps), limit_mps)
    shut_off_mps = min(wanted_mps + swing_mps, limit_mps)
    if left_m <= HAND_OVER_M:
        own.asked = last_notch(own, cue, unit, train, behaviour, limit_mps)
        return own.asked
    powers_or_coasts(own, unit, left_m, brake_mps2, wanted_mps - swing_mps, shut_off_mps)
    if own.asked > 0.0 and (own.powering == 0 or own.coasting == 1):
        own.asked = 0.0  # he sees it come, and shuts off in time
    if cue.now_s < own.looks_s and unit.speed_mps > 0.0:
        return own.asked
    own.looks_s = cue.now_s + max(
        own.settings.look_s + own.settings.look_sigma_s * own.look_drawn, LEAST_LOOK_S
    )
    own.asked = notch_of(own, cue, unit, train, behaviour, left_m, brake_mps2)
    return own.asked


@compiled
def last_notch(
    own: DriverRow, cue: CueRow, unit: UnitRow, train: TrainRow, behaviour: BehaviourRow, limit_mps: float
) -> float:
    """The notch where TASC takes over: none, but for a train that has left a stand so near to the mark and creeps."""
    moves = unit.speed_mps > 0.0
    if not moves:
        own.ran = 0
    if own.ran == 1 or (moves and unit.notch < 0.0):
        return 0.0
    over_mps = overspeed_mps(unit, min(limit_mps, CREEP_MPS), cue.reaction_s)
    return holding_notch(unit, train, behaviour, cue, over_mps)


@compiled
def late_by_s(cue: CueRow, wanted_mps: float, left_m: float, brake_mps2: float) -> float:
    """How late a train would be that ran at the speed wanted from here and then braked, s; 0 where no time is set."""
    if not (np.isfinite(cue.due_s) and np.isfinite(wanted_mps) and wanted_mps > 0.0 and left_m > 0.0):
        return 0.0
    return float(cue.now_s + left_m / wanted_mps + wanted_mps / (2.0 * brake_mps2) - cue.due_s)


@compiled
def required_mps(cue: CueRow, left_m: float, brake_mps2: float) -> float:
    """The speed that, held from here to the brake, still keeps the time, m/s; +inf where none does."""
    left_s = max(cue.due_s - cue.now_s, 0.0)
    room = left_s * left_s - 2.0 * left_m / brake_mps2
    return float(brake_mps2 * (left_s - np.sqrt(room))) if room >= 0.0 else np.inf


@compiled
def brake_curve_mps(behaviour: BehaviourRow, left_m: float, brake_mps2: float) -> float:
    """Speed at this distance to the mark from which a brake so soft meets the stop pattern where TASC takes over."""
    there = 2.0 * behaviour.settings.stop_deceleration_mps2 * HAND_OVER_M
    return float(np.sqrt(max(there + 2.0 * brake_mps2 * (left_m - HAND_OVER_M), 0.0)))


@compiled
def powers_or_coasts(
    own: DriverRow, unit: UnitRow, left_m: float, brake_mps2: float, low_mps: float, shut_off_mps: float
) -> None:
    """Whether he powers or lets it run; from a stand he powers."""
    speed_mps = unit.speed_mps
    if speed_mps == 0.0:
        own.powering, own.coasting, own.ran = 1, 0, 0
        return
    coast_s = max(own.settings.coast_s + own.settings.coast_sigma_s * own.coast_drawn, 0.0)
    brakes_at_m = speed_mps * speed_mps / (2.0 * brake_mps2)
    near = left_m - brakes_at_m < coast_s * speed_mps
    own.coasting = 1 if near and own.hurries == 0 else 0
    if speed_mps >= shut_off_mps:
        own.powering, own.ran = 0, 1
    elif speed_mps < low_mps:
        own.powering = 1


@compiled
def notch_of(
    own: DriverRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    left_m: float,
    brake_mps2: float,
) -> float:
    """The notch for what he does: the brake where its curve is met, else power or none."""
    over_mps = unit.speed_mps - brake_curve_mps(behaviour, left_m, brake_mps2)
    if over_mps + brake_mps2 * cue.reaction_s > 0.0:
        demand_mps2 = brake_mps2 + behaviour.settings.cruise_gain_per_s * over_mps - cue.own_mps2
        return service_notch(train, max(demand_mps2, 0.0))
    if own.powering == 0 or own.coasting == 1:
        return 0.0
    share = min(max(own.settings.power_share + own.settings.power_share_sigma * own.power_drawn, 0.0), 1.0)
    habit = max(np.floor(share * train.power_notches + 0.5), 1.0)
    climbs_n = (cue.own_mps2 + LEAST_GAIN_MPS2) * equivalent_mass_kg(train, cue.load_share)
    notch = max(habit, power_notch(train, cue.load_share, unit.speed_mps, climbs_n))
    eases_where_wheels_slip(own, cue, unit)
    own.eased = min(own.eased, notch - 1.0)
    return float(notch - own.eased)


@compiled
def eases_where_wheels_slip(own: DriverRow, cue: CueRow, unit: UnitRow) -> None:
    """A notch less at each look at which wheels slip; one more again once they have rolled for a while."""
    if unit.wheel_slide > 0:
        own.eased, own.slipped_s = own.eased + 1.0, cue.now_s
    elif own.eased > 0.0 and cue.now_s > own.slipped_s + SLIP_OVER_S:
        own.eased, own.slipped_s = own.eased - 1.0, cue.now_s
