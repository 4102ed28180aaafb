"""How much later a train gets going than the minimal model of running times has it: machinery answers in time."""

from __future__ import annotations

from typing import NamedTuple

from vehicle.adhesion import DRY
from vehicle.brakes import service_target_mps2
from vehicle.compiled import compiled
from vehicle.mass import equivalent_mass_kg, mass_kg
from vehicle.pull import full_pull_n
from vehicle.records import TrainRow
from vehicle.resistance import resistance_n
from vehicle.response import approach, dead_time_steps

SETTLED_STEPS = 100  # of 0.1 s: by then force and brake are what is commanded


class Start(NamedTuple):
    """From the command to leave: until the train moves, and until it runs as if its full pull had come at once, s."""

    moves_s: float
    delay_s: float


@compiled
def start_of(train: TrainRow, load_share: float, standing_notch: float, dt_s: float) -> Start:
    """How a train gets going from a stand on level track.

    Its standing brake (`standing_notch` > 0) lets go after dead time and lag, and its motors take up what the limit of
    jerk leaves beside that, as `vehicle.dynamics` has it. At once where it cannot start.
    """
    inertia = equivalent_mass_kg(train, load_share)
    pull_n = full_pull_n(train, load_share, 1.0, DRY, 0.0)
    held_n = resistance_n(train, mass_kg(train, load_share), 0.0)
    if pull_n <= held_n:
        return Start(0.0, 0.0)
    brake_dead = dead_time_steps(train.brake_dead_time_s, dt_s)
    motors_dead = dead_time_steps(train.traction_dead_time_s, dt_s)
    brake_mps2, built_n, speed_mps = service_target_mps2(train, -standing_notch), 0.0, 0.0
    limit_n, moves_s = train.traction_jerk_max_mps3 * inertia, 0.0
    for step in range(SETTLED_STEPS):
        before_mps2 = brake_mps2
        if step >= brake_dead:
            brake_mps2 = approach(brake_mps2, 0.0, train.brake_lag_s, train.brake_jerk_max_mps3, dt_s)
        if step >= motors_dead:
            before_n = built_n
            built_n = approach(built_n, pull_n, train.traction_lag_s, limit_n, dt_s)
            if limit_n > 0.0:
                left_n = max(limit_n * dt_s - (before_mps2 - brake_mps2) * inertia, 0.0)
                built_n = min(built_n, before_n + left_n)
        speed_mps = max(speed_mps + (built_n - held_n - brake_mps2 * inertia) / inertia * dt_s, 0.0)
        if speed_mps == 0.0:
            moves_s = (step + 1) * dt_s
    return Start(moves_s, SETTLED_STEPS * dt_s - speed_mps / ((pull_n - held_n) / inertia))
