"""The unit's own model of its train: what commands under way will do, and what a notch given now would come to.

A command acts after its dead time and builds up with its lag, so what is predicted is never the present. What the
brake gives beyond the model is estimated where a notch has been kept (Yasunobu and others, 6.2: ノッチ変化が安定して
いる場合には、ブレーキ力を推定する), so that an unknown gradient or a weak brake is in the prediction too.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.ahead import own_at_mps2
from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.fuzzy_records import RING, PredictiveFuzzyRow
from onboard.records import UnitRow
from vehicle.brakes import service_target_mps2
from vehicle.compiled import compiled
from vehicle.mass import equivalent_mass_kg
from vehicle.records import TrainRow
from vehicle.response import approach, dead_time_steps
from vehicle.traction import traction_target_n

STEP_S: Final = 0.1
GAP_S: Final = 0.15  # more between two ticks: the train has stood, or another law has driven
FAR_M: Final = 1.0e5  # a stop that is not in sight
OFF_MAX_MPS2: Final = 0.5  # assumed: twice what 25 permille are worth
ESTIMATE_FROM_MPS: Final = 0.3  # the step in which a train comes to rest tells nothing
SETTLED_MPS2: Final = 0.005
TRANSIENT_STEPS: Final = 80
SLOPE_STEPS: Final = 5  # gradient and resistance are looked up this often in a prediction
LEAST_MPS2: Final = 0.02  # a train that slows by less does not stop
ROUNDS: Final = 4  # of the way to a stop over changing gradients


@compiled
def pull_target_mps2(train: TrainRow, load_share: float, notch: float, speed_mps: float) -> float:
    """What a power notch settles at, as acceleration."""
    if notch <= 0.0:
        return 0.0
    return traction_target_n(train, load_share, notch, speed_mps) / equivalent_mass_kg(train, load_share)


@compiled
def reset_model(own: PredictiveFuzzyRow, cue: CueRow, unit: UnitRow, train: TrainRow) -> None:
    """Begin anew: what was commanded last has built up."""
    for i in range(RING):
        own.notches[i] = unit.notch
    own.head = 0
    own.brake_mps2 = service_target_mps2(train, unit.notch)
    own.pull_mps2 = pull_target_mps2(train, cue.load_share, unit.notch, unit.train_mps)
    own.speed_mps = unit.train_mps
    own.braking_off_mps2 = own.pulling_off_mps2 = 0.0
    own.held_s, own.changed = 1000.0, 0.0


@compiled
def keep_up(own: PredictiveFuzzyRow, cue: CueRow, unit: UnitRow, train: TrainRow) -> None:
    """Carry the model one step on with the command that was really given, whoever gave it, and compare it."""
    own.head = (own.head + 1) % RING
    own.notches[own.head] = -train.brake_notches if unit.emergency != 0 else unit.notch
    acting = own.notches[(own.head - dead_time_steps(train.brake_dead_time_s, STEP_S)) % RING]
    own.brake_mps2 = approach(
        own.brake_mps2,
        service_target_mps2(train, acting),
        train.brake_lag_s,
        train.brake_jerk_max_mps3,
        STEP_S,
    )
    acting = own.notches[(own.head - dead_time_steps(train.traction_dead_time_s, STEP_S)) % RING]
    target = pull_target_mps2(train, cue.load_share, acting, own.speed_mps)
    own.pull_mps2 = approach(
        own.pull_mps2, target, train.traction_lag_s, train.traction_jerk_max_mps3, STEP_S
    )
    expected = own.brake_mps2 - own.pull_mps2 + cue.own_mps2
    beyond = (own.speed_mps - unit.train_mps) / STEP_S - expected
    own.speed_mps = unit.train_mps
    brake_s = train.brake_dead_time_s + 2.0 * train.brake_lag_s
    power_s = train.traction_dead_time_s + 2.0 * train.traction_lag_s
    steady = own.held_s >= max(brake_s, power_s) and unit.wheel_slide == 0 and unit.emergency == 0
    if own.settings.estimates == 0 or not steady or unit.train_mps < ESTIMATE_FROM_MPS:
        return
    share = min(STEP_S / max(own.settings.estimate_s, STEP_S), 1.0)
    if unit.notch > 0.0:
        off = own.pulling_off_mps2 + share * (beyond - own.pulling_off_mps2)
        own.pulling_off_mps2 = min(max(off, -OFF_MAX_MPS2), OFF_MAX_MPS2)
    else:
        off = own.braking_off_mps2 + share * (beyond - own.braking_off_mps2)
        own.braking_off_mps2 = min(max(off, -OFF_MAX_MPS2), OFF_MAX_MPS2)


@compiled
def built_up(built: float, target: float, share: float, change_max: float) -> float:
    """`vehicle.response.approach` with the share of a step worked out before; `change_max` 0: no limit."""
    change = (target - built) * share
    if change_max > 0.0:
        change = min(max(change, -change_max), change_max)
    return built + change


@compiled
def lag_share(lag_s: float) -> float:
    """Share of a change that builds up within a step."""
    return 1.0 - math.exp(-STEP_S / lag_s) if lag_s > 0.0 else 1.0


@compiled
def run_on(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    path: NDArray[np.void],
    notch: float,
    steps: int,
    until_settled: bool,
) -> tuple[float, float, float]:
    """Speed, path coordinate and brake (m/s, m, m/s^2) after so many steps with a notch that is given now.

    `until_settled`: no further than until the brake has built up. A train that comes to rest stays there.
    """
    speed, position = unit.train_mps, unit.position_m
    brake, pull = own.brake_mps2, own.pull_mps2
    brake_dead = dead_time_steps(train.brake_dead_time_s, STEP_S)
    pull_dead = dead_time_steps(train.traction_dead_time_s, STEP_S)
    brake_share, pull_share = lag_share(train.brake_lag_s), lag_share(train.traction_lag_s)
    brake_change = train.brake_jerk_max_mps3 * STEP_S
    pull_change = train.traction_jerk_max_mps3 * STEP_S
    wanted_brake = service_target_mps2(train, notch)
    off = own.pulling_off_mps2 if notch > 0.0 else own.braking_off_mps2
    slowed = 0.0
    for j in range(1, steps + 1):
        brake_target, pulling = wanted_brake, notch
        if j <= brake_dead:
            brake_target = service_target_mps2(train, own.notches[(own.head + j - brake_dead) % RING])
        if j <= pull_dead:
            pulling = own.notches[(own.head + j - pull_dead) % RING]
        pull_target = pull_target_mps2(train, cue.load_share, pulling, speed) if pulling > 0.0 else 0.0
        brake = built_up(brake, brake_target, brake_share, brake_change)
        pull = built_up(pull, pull_target, pull_share, pull_change)
        if j % SLOPE_STEPS == 1:
            slowed = own_at_mps2(unit, train, path, cue.load_share, position, speed) + off
        change = (brake - pull + slowed) * STEP_S
        after = max(speed - change, 0.0)
        if after == 0.0 and change > 0.0:
            return 0.0, position + speed * speed / (2.0 * change) * STEP_S, brake
        position += (speed + after) / 2.0 * STEP_S
        speed = after
        settled = abs(brake_target - brake) < SETTLED_MPS2 and pull < SETTLED_MPS2
        if until_settled and settled and j >= brake_dead and j >= pull_dead:
            break
    return speed, position, brake


@compiled
def stops_at_m(
    own: PredictiveFuzzyRow,
    cue: CueRow,
    unit: UnitRow,
    train: TrainRow,
    path: NDArray[np.void],
    notch: float,
) -> float:
    """X_p: where the front comes to rest under a brake notch given now, path coordinate, m.

    The paper's -v^2 / 2A is what is left once the command has built up; gradient and resistance are those of the
    way there, at its beginning, middle and end.
    """
    speed, position, _ = run_on(own, cue, unit, train, path, notch, TRANSIENT_STEPS, True)
    if speed <= 0.0:
        return position
    energy = speed * speed / 2.0
    steady = service_target_mps2(train, notch) + own.braking_off_mps2
    here = own_at_mps2(unit, train, path, cue.load_share, position, speed)
    run_m = energy / max(steady + here, LEAST_MPS2)
    for _ in range(ROUNDS):
        middle = own_at_mps2(unit, train, path, cue.load_share, position + run_m / 2.0, 0.7 * speed)
        end = own_at_mps2(unit, train, path, cue.load_share, position + run_m, 0.3 * speed)
        slowed = steady + (here + 4.0 * middle + end) / 6.0
        if slowed < LEAST_MPS2:
            return position + FAR_M
        run_m = energy / slowed
    return position + run_m
