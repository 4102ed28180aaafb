"""From what a driving law asks for to the notch: limits, the stop at the mark and supervision brake harder (ATO, TASC).

Between stations a law of `onboard.driving.laws` asks for power or brake. Outside it the brake follows the curves
down to lower limits, and keeps below supervision's own. At the station `onboard.driving.stopping` asks for the brake
that follows the target-speed pattern; the strongest of the demands counts. Gradient and running resistance are taken
off the brake demand, since the train's own brake control is calibrated on the level.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from onboard.board import BoardRow
from onboard.driving.ahead import LOOK_AHEAD_S, limit_mps, pattern_mps
from onboard.driving.below_supervision import below_supervision_mps2
from onboard.driving.laws.power import overspeed_mps
from onboard.driving.laws.table import ask
from onboard.driving.stopping import stop_command_mps2
from onboard.driving.tasc import DesignRow
from onboard.records import EMERGENCY_INTERVENTION, MODE_DRIVE, NO_INTERVENTION, BehaviourRow, UnitRow
from vehicle.brakes import service_notch
from vehicle.compiled import compiled
from vehicle.mass import equivalent_mass_kg
from vehicle.records import TrainRow
from vehicle.traction import traction_target_n

BRAKE_OVERSPEED_MPS = 0.5  # between stations the brake is left alone below this
CURVE_BAND_MPS = 0.5  # this near a falling curve the brake follows it
INCHING_M = 0.5  # assumed: a train this near its mark comes to rest where it is


@compiled
def curve_demand_mps2(
    unit: UnitRow, behaviour: BehaviourRow, path: NDArray[np.void], ceiling_mps: float, over_mps: float
) -> float:
    """Acceleration (< 0) that follows the curve down to a lower limit; 0 where the train is not on one.

    A train that means to stay under `ceiling_mps` is not on a curve that is still above it.
    """
    ahead_m = max(unit.speed_mps * LOOK_AHEAD_S, 1.0)
    here = pattern_mps(unit, behaviour, path, unit.position_m)
    ahead = pattern_mps(unit, behaviour, path, unit.position_m + ahead_m)
    falling = (here * here - ahead * ahead) / (2.0 * ahead_m)
    if falling <= 0.0 or here > ceiling_mps or over_mps <= -CURVE_BAND_MPS:
        return 0.0
    return float(min(-behaviour.settings.cruise_gain_per_s * over_mps - falling, 0.0))


@compiled
def drive(board: BoardRow, path: NDArray[np.void], plan: NDArray[np.void]) -> None:
    """Choose this step's notch: what the law asks for, unless limits, stop or supervision brake harder."""
    unit, train, behaviour = board.unit, board.kind, board.behaviour
    unit.emergency = 0
    if unit.mode != MODE_DRIVE:
        unit.target_mps = 0.0
        notch = -behaviour.standing_brake_notch
    else:
        notch = driven_notch(board, path, plan)
    if unit.intervention != NO_INTERVENTION:
        notch = -train.brake_notches
        unit.emergency = 1 if unit.intervention == EMERGENCY_INTERVENTION else 0
    unit.notch_held_s = unit.notch_held_s + behaviour.step_s if notch == unit.notch else 0.0
    unit.notch = notch


@compiled
def is_near_stop(unit: UnitRow, train: TrainRow, design: DesignRow) -> bool:
    """Whether power taken up now would still build up when the brake for the stop has to: of no use, and it lasts.

    A fix near the mark may release the brake, and a train that then pulled would roll on after it has come to rest.
    """
    power_s, brake_s = train.traction_dead_time_s + train.traction_lag_s, design.dead_time_s + design.lag_s
    needed_m = unit.train_mps * (power_s + brake_s + unit.train_mps / (2.0 * design.pattern_mps2))
    return bool(unit.target_stop_m - unit.position_m < needed_m + INCHING_M)


@compiled
def brake_below_mps2(board: BoardRow, path: NDArray[np.void], asked_mps2: float) -> float:
    """`below_supervision_mps2` of this train, with that much power asked for."""
    own_mps2 = board.cue.own_mps2
    args = (board.unit, board.kind, board.behaviour, path, board.tasc, board.design, own_mps2, asked_mps2)
    return float(below_supervision_mps2(*args))


@compiled
def driven_notch(board: BoardRow, path: NDArray[np.void], plan: NDArray[np.void]) -> float:
    """The notch of a train that drives, before supervision; sets `unit.target_mps`."""
    unit, train, behaviour, cue = board.unit, board.kind, board.behaviour, board.cue
    cue.limit_mps = limit_mps(unit, behaviour, path)
    cue.reaction_s = train.brake_dead_time_s + train.brake_lag_s
    cue.ceiling_mps, cue.late_s = np.inf, 0.0
    asked = ask(board.laws, cue, unit, train, behaviour, path, plan)
    if asked > 0.0 and unit.notch <= 0.0 and is_near_stop(unit, train, board.design):
        asked = 0.0
    unit.target_mps = min(cue.limit_mps, cue.ceiling_mps)
    over_mps = overspeed_mps(unit, unit.target_mps, cue.reaction_s)
    demand_mps2 = -curve_demand_mps2(unit, behaviour, path, cue.ceiling_mps, over_mps)
    below_mps2 = brake_below_mps2(board, path, 0.0)
    if asked > 0.0 and below_mps2 <= 0.0:  # no power that would have to be braked once it acts
        asked_n = traction_target_n(train, cue.load_share, asked, unit.speed_mps)
        if brake_below_mps2(board, path, asked_n / equivalent_mass_kg(train, cue.load_share)) > 0.0:
            asked = 0.0
    stop_mps2 = stop_command_mps2(unit, board.tasc, board.design, cue.own_mps2)
    if board.laws.stops == 1:
        stop_mps2 = 0.0  # TASC only watches: its model of the brake and its verdict are kept
    if unit.braking_to_stop == 1 and unit.speed_mps == 0.0:
        return -behaviour.standing_brake_notch
    if over_mps > BRAKE_OVERSPEED_MPS:
        demand_mps2 = max(demand_mps2, behaviour.settings.cruise_gain_per_s * over_mps)
    demand_mps2 = max(demand_mps2, below_mps2)
    notch = asked
    if demand_mps2 > 0.0 or unit.braking_to_stop == 1:
        notch = min(service_notch(train, max(demand_mps2 - cue.own_mps2, stop_mps2, 0.0)), asked)
    keeps = unit.notch > 0.0 and unit.notch_held_s < behaviour.settings.notch_hold_s
    if (
        board.laws.stops == 0
        and keeps
        and below_mps2 <= 0.0
        and notch >= 0.0
        and over_mps < BRAKE_OVERSPEED_MPS
        and unit.braking_to_stop == 0
    ):
        return float(unit.notch)
    return float(notch)
