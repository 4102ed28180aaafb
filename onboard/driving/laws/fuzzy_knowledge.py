"""What rule C-2 knows of the line: how long the train takes to the mark if it coasts from here until it has to brake.

The paper has a table of the time that coasting to a point X_k adds (5.1 (3)); here it is worked out on the way, over
the unit's own map of gradients, curves and limits: once a second, more often the nearer coasting is to keeping the
time. X_k is where the brake for the stop begins, or less far where a train that coasts is too late for that.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.ahead import own_at_mps2, pattern_mps
from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.fuzzy_model import STEP_S, run_on
from onboard.driving.laws.fuzzy_records import PredictiveFuzzyRow
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled
from vehicle.mass import equivalent_mass_kg, mass_kg
from vehicle.records import TrainRow
from vehicle.resistance import resistance_n
from vehicle.response import dead_time_steps

GRID_M: Final = 10.0  # pieces of a coast,
PIECES: Final = 400.0  # or so many of them where the way is longer
LOOK_S: Final = 1.0
LOOK_SHARE: Final = 0.1  # of the time that coasting would be late; running on changes that by less


@compiled
def steps_to_act(train: TrainRow) -> int:
    """Steps until motors that are switched off no longer pull."""
    return dead_time_steps(train.traction_dead_time_s + 2.0 * train.traction_lag_s, STEP_S) + 1


@compiled
def coast(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    mark_m: float,
) -> tuple[float, float, float]:
    """Time (s) to a stop at `mark_m` when coasting from now on, how much of it coasting adds, and where it ends (m).

    Limits hold for a coasting train too. Infinite where it would get too slow on its way.
    """
    steps = steps_to_act(train)
    speed, position, _ = run_on(own, cue, unit, train, path, 0.0, steps, False)
    time, added = steps * STEP_S, 0.0
    brake_mps2 = behaviour.settings.stop_deceleration_mps2
    least = own.settings.coast_least_share * min(own.hold_mps, cue.limit_mps)
    piece_m = max(GRID_M, (mark_m - position) / PIECES)
    while speed > least and speed > 0.0:
        left_m = mark_m - position - speed * cue.reaction_s - speed * speed / (2.0 * brake_mps2)
        if left_m <= 0.0:
            return time + cue.reaction_s + speed / brake_mps2, added, position
        way_m = min(piece_m, left_m)
        slowed = own_at_mps2(unit, train, path, cue.load_share, position + way_m / 2.0, speed)
        limit = pattern_mps(unit, behaviour, path, position + way_m) - own.settings.target_margin_mps
        after = np.sqrt(max(speed * speed - 2.0 * slowed * way_m, 0.0))
        after = min(after, max(limit, least))
        step_s = 2.0 * way_m / (speed + after)
        time += step_s
        added += step_s - way_m / max(min(limit, own.hold_mps), least)
        position += way_m
        speed = after
        if left_m < 0.5:
            return time + cue.reaction_s + speed / brake_mps2, added, position
    return np.inf, np.inf, position


@compiled
def hold_mps(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    mark_m: float,
) -> float:
    """Speed to hold so that coasting from it, where that is of use, brings the train to the mark in its time, m/s.

    The cruising speed V takes it there without coasting. A coast of s from V to uV, slowed evenly as on the level,
    takes (1 - u)/(1 + u) s/V longer than holding V, which holding more makes good; s is the whole way at the most.
    """
    cruise = unit.cruise_mps
    way_m = mark_m - unit.position_m
    if own.settings.c_2 == 0 or not np.isfinite(cue.due_s) or not np.isfinite(cruise) or way_m <= 0.0:
        return cruise
    share = own.settings.coast_share
    mass = mass_kg(train, cue.load_share)
    resistance = resistance_n(train, mass, cruise * (1.0 + share) / 2.0)
    slowed = resistance / equivalent_mass_kg(train, cue.load_share)
    coast_m = min((1.0 - share * share) * cruise * cruise / (2.0 * slowed), way_m)
    return cruise * (1.0 + (1.0 - share) / (1.0 + share) * coast_m / way_m)


@compiled
def look_ahead(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    behaviour: BehaviourRow,
    path: NDArray[np.void],
    mark_m: float,
) -> None:
    """Keep `coasts` and X_k (`coast_to_m`) true, as often as needed."""
    if own.settings.c_2 == 0 or not np.isfinite(cue.due_s) or not np.isfinite(mark_m):
        own.coasts = 0
        return
    if cue.now_s < own.look_s:
        return
    time_s, added_s, ends_m = coast(own, cue, unit, train, behaviour, path, mark_m)
    late_s = cue.now_s + time_s - cue.due_s
    if late_s <= 0.0:
        own.coasts = 1
        own.coast_to_m = ends_m
    elif own.coasts == 1:
        # Too late for all of it: X_k comes back, in the end behind the train, by the time that it is late.
        if late_s < added_s:
            own.coast_to_m = unit.position_m + (1.0 - late_s / added_s) * (ends_m - unit.position_m)
        else:
            beyond_s = min(late_s - max(added_s, 0.0), 1000.0) if np.isfinite(added_s) else 1000.0
            own.coast_to_m = unit.position_m - beyond_s * unit.train_mps
    wait_s = LOOK_S if own.coasts == 1 else min(max(LOOK_SHARE * late_s, STEP_S), LOOK_S)
    own.look_s = cue.now_s + wait_s - STEP_S / 2.0
