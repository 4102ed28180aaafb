"""Minimal-model running time (基準運転時分) and energy of one leg, for choosing a cruise speed.

Full power up to the cruise speed or the limit, hold it, and brake by constant deceleration to lower limits
and to the stop, on dry rail. No dead time, lag or notches; curves count as the climb that they are worth.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vehicle.adhesion import DRY
from vehicle.brakes import electric_brake_n
from vehicle.compiled import compiled
from vehicle.mass import equivalent_mass_kg
from vehicle.pull import full_pull_n, grip_n, held_back_n, mean_gradient_permille
from vehicle.records import TrainRow
from vehicle.wire import power_at_grip_w

STEPS_MAX: Final = 200_000
ALL_MOTORS: Final = 1.0
FASTEST_MPS: Final = 100.0  # no train comes further in a step
LAID_DOWN_TO_S: Final = 5  # as running times are laid down


def laid_down_s(least_s: float) -> int:
    """Standard running time (基準運転時分) of a hop, s: the least, up to the next 5 s."""
    return math.ceil(least_s / LAID_DOWN_TO_S - 1e-9) * LAID_DOWN_TO_S


class Stall(NamedTuple):
    """Where the front of a train comes to a stand against its will (m), and the balance there at rest, N.

    `gradient_permille` is the mean over the train, curves included.
    """

    at_m: float
    gradient_permille: float
    pull_n: float
    needed_n: float


class Conditions(NamedTuple):
    """With what a train runs: its load, the motors in service, and the rail, as a factor of the dry one's adhesion."""

    load_share: float
    motors_share: float = ALL_MOTORS
    adhesion_factor: float = DRY


@compiled
def _pattern_squared(
    limit_mps: NDArray[np.float64], start_m: float, stop_m: float, deceleration_mps2: float, looks_m: float
) -> NDArray[np.float64]:
    """Square of the permitted speed at each metre from floor(start) to ceil(stop), m^2/s^2; no further than what counts
    for who looks at it as far as `looks_m`.
    """
    first = math.floor(start_m)
    last = math.ceil(stop_m)
    # Beyond the stop the pattern runs on below zero, so that it is exact at a stop between two metres.
    at_end = -2.0 * deceleration_mps2 * (last - stop_m)
    if looks_m < stop_m:
        top_mps = 0.0
        for i in range(first, math.ceil(looks_m) + 1):
            top_mps = max(top_mps, limit_mps[i])
        counts_m = looks_m + top_mps * top_mps / (2.0 * deceleration_mps2) + 2.0
        if counts_m < stop_m:
            last = math.ceil(counts_m)
            at_end = limit_mps[last] * limit_mps[last]
    squared = np.empty(last - first + 1)
    squared[last - first] = at_end
    for i in range(last - 1, first - 1, -1):
        limit = limit_mps[i]
        squared[i - first] = min(limit * limit, squared[i + 1 - first] + 2.0 * deceleration_mps2)
    return squared


@compiled
def _permitted_mps(
    squared: NDArray[np.float64],
    limit_mps: NDArray[np.float64],
    first: int,
    position_m: float,
    deceleration_mps2: float,
) -> float:
    """Permitted speed at a position: the limit of its metre, or the braking parabola to the next."""
    i = min(int(position_m) - first, len(squared) - 2)
    limit = limit_mps[i + first]
    parabola = squared[i + 1] + 2.0 * deceleration_mps2 * (i + 1 + first - position_m)
    return math.sqrt(max(0.0, min(limit * limit, parabola)))


@compiled
def _held_mps(
    squared: NDArray[np.float64],
    limit_mps: NDArray[np.float64],
    first: int,
    position_m: float,
    stop_m: float,
    speed_mps: float,
    wanted_mps: float,
    deceleration_mps2: float,
    dt_s: float,
) -> float:
    """`wanted_mps`, or as much of it as the pattern permits where that speed will be reached."""
    after = wanted_mps
    for _ in range(3):
        ahead = min(position_m + 0.5 * (speed_mps + after) * dt_s, stop_m)
        after = min(after, _permitted_mps(squared, limit_mps, first, ahead, deceleration_mps2))
    # The search above may fall short; the parabola from here is always open, and exact while braking.
    drop = deceleration_mps2 * dt_s
    here = _permitted_mps(squared, limit_mps, first, position_m, deceleration_mps2)
    root = 0.25 * drop * drop + here * here - drop * speed_mps
    parabola = math.sqrt(root) - 0.5 * drop if root > 0.0 else 0.0
    return max(after, min(parabola, wanted_mps), 0.0)


@compiled
def predicted_run(
    train: TrainRow,
    load_share: float,
    elevation_m: NDArray[np.float64],
    limit_mps: NDArray[np.float64],
    start_m: float,
    stop_m: float,
    cruise_mps: float,
    deceleration_mps2: float,
    dt_s: float,
    initial_mps: float = 0.0,
    until_m: float = math.inf,
    rolls: bool = False,
) -> tuple[float, float]:
    """Time (s) and net energy at the wire (J: traction + auxiliary - regenerated) from `start_m` to a stop.

    With `until_m` before the stop: to where the front passes that, on its way to the stop. A train that is faster than
    its cruise speed brakes down to it; or, if it `rolls`, only the resistance makes it slower.

    `elevation_m[i]` is the height at metre i counted in the direction of travel, curves included
    (`vehicle.resistance.climb_m`), `limit_mps[i]` the limit for the train's front from metre i to i + 1 (train
    length already folded in); both reach beyond ceil(stop_m), and 0 <= start_m <= stop_m. A train that cannot climb
    gives an infinite time; `stall_of` says where it stands then.
    """
    time_s, energy_j, _ = _run(
        train,
        Conditions(load_share, ALL_MOTORS, DRY),
        elevation_m,
        limit_mps,
        start_m,
        stop_m,
        cruise_mps,
        deceleration_mps2,
        dt_s,
        initial_mps,
        until_m,
        np.empty((0, 3)),
        rolls,
    )
    return time_s, energy_j


def predicted_course(
    train: TrainRow,
    load_share: float,
    elevation_m: NDArray[np.float64],
    limit_mps: NDArray[np.float64],
    start_m: float,
    stop_m: float,
    cruise_mps: float,
    deceleration_mps2: float,
    dt_s: float,
    initial_mps: float = 0.0,
    until_m: float = math.inf,
) -> NDArray[np.float64]:
    """The run of `predicted_run` step by step: time since its begin (s), front (m), speed (m/s); shape (n, 3).

    One row where the train cannot climb, or has no way to go.
    """
    run = elevation_m, limit_mps, start_m, stop_m, cruise_mps, deceleration_mps2, dt_s, initial_mps, until_m
    time_s, _ = predicted_run(train, load_share, *run)
    rows = np.full((round(time_s / dt_s) + 2 if time_s < math.inf else 1, 3), math.nan)
    _run(train, Conditions(load_share, ALL_MOTORS, DRY), *run, rows)
    rows = rows[~np.isnan(rows[:, 0])]
    if not 0.0 < time_s < math.inf:
        return np.array([[0.0, start_m, initial_mps]])
    ends = [time_s, min(stop_m, until_m), 0.0 if until_m >= stop_m else rows[-1, 2]]
    return np.vstack([rows[rows[:, 0] < time_s], ends])


def stall_of(
    train: TrainRow,
    conditions: Conditions,
    elevation_m: NDArray[np.float64],
    limit_mps: NDArray[np.float64],
    start_m: float,
    stop_m: float,
    deceleration_mps2: float,
    dt_s: float,
) -> Stall | None:
    """Where a train stalls on its way from a stand to the next one, or cannot start; None: it gets there.

    At full power up to the limits; arguments as of `predicted_run`.
    """
    if stop_m <= start_m:
        return None
    time_s, _, reached_m = _run(
        train,
        conditions,
        elevation_m,
        limit_mps,
        start_m,
        stop_m,
        math.inf,
        deceleration_mps2,
        dt_s,
        0.0,
        math.inf,
        np.empty((0, 3)),
    )
    return None if time_s < math.inf else balance_at(train, conditions, elevation_m, reached_m)


@compiled
def balance_at(
    train: TrainRow, conditions: Conditions, elevation_m: NDArray[np.float64], at_m: float
) -> Stall:
    """What a train at rest with its front at a place can pull, and what it needs to start there, N."""
    load, motors, factor = conditions.load_share, conditions.motors_share, conditions.adhesion_factor
    return Stall(
        at_m,
        mean_gradient_permille(elevation_m, at_m, train.length_m),
        full_pull_n(train, load, motors, factor, 0.0),
        held_back_n(train, load, elevation_m, at_m, 0.0),
    )


@compiled
def _run(
    train: TrainRow,
    conditions: Conditions,
    elevation_m: NDArray[np.float64],
    limit_mps: NDArray[np.float64],
    start_m: float,
    stop_m: float,
    cruise_mps: float,
    deceleration_mps2: float,
    dt_s: float,
    initial_mps: float,
    until_m: float,
    course: NDArray[np.float64],
    rolls: bool = False,
) -> tuple[float, float, float]:
    """Time (s), net energy (J) and where the front is then (m); see `predicted_run`. Fills the rows of `course`."""
    load_share, motors_share, adhesion_factor = conditions
    inertia = equivalent_mass_kg(train, load_share)
    first = math.floor(start_m)
    squared = _pattern_squared(limit_mps, start_m, stop_m, deceleration_mps2, until_m + FASTEST_MPS * dt_s)
    position, speed, time_s, energy_j = start_m, initial_mps, 0.0, 0.0
    drop = deceleration_mps2 * dt_s
    for step in range(STEPS_MAX):
        if step < course.shape[0]:
            course[step, 0], course[step, 1], course[step, 2] = time_s, position, speed
        left = stop_m - position
        # Within the last step of the pattern: what is left is one plain stop, no harder than the pattern's.
        if speed <= drop and left <= speed * dt_s:
            last_s = 2.0 * left / speed if speed > 0.0 else 0.0
            return time_s + last_s, energy_j + train.auxiliary_power_w * last_s, stop_m
        full_n = full_pull_n(train, load_share, motors_share, adhesion_factor, speed)
        resist_n = held_back_n(train, load_share, elevation_m, position, speed)
        free = speed + (full_n - resist_n) / inertia * dt_s
        slower = min(resist_n / inertia * dt_s, drop) if rolls else drop
        wanted = max(0.0, min(free, max(cruise_mps, speed - max(slower, 0.0))))
        after = _held_mps(squared, limit_mps, first, position, stop_m, speed, wanted, deceleration_mps2, dt_s)
        after = max(after, min(speed - drop, free))
        distance = 0.5 * (speed + after) * dt_s
        if distance <= 0.0:
            return (time_s if left <= 1e-3 else math.inf), energy_j, position
        force_n = inertia * (after - speed) / dt_s + resist_n
        energy_j += train.auxiliary_power_w * dt_s
        rail_n = grip_n(train, load_share, adhesion_factor, speed)
        motors_n = force_n
        if force_n <= 0.0:
            motors_n = -electric_brake_n(train, motors_share, -force_n, rail_n, speed)
        energy_j += power_at_grip_w(train, motors_share, motors_n, distance / dt_s, rail_n) * dt_s
        if distance >= min(left, until_m - position):
            share = min(left, until_m - position) / distance
            return time_s + share * dt_s, energy_j, min(stop_m, until_m)
        position += distance
        speed = after
        time_s += dt_s
    return math.inf, energy_j, position
