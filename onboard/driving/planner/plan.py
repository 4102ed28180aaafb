"""Plans for laws that follow one: an optimal profile on the unit's own map, laid metre by metre (運転曲線).

A plan is made at each departure, and anew when the train is off it; the unit's own model of train and line decides it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.ahead import LOOK_AHEAD_S
from onboard.driving.laws.cue import PLAN, PLAN_COAST, PLAN_FOLLOW, PLAN_HOLD
from onboard.driving.planner.wish import PLAIN, Planning, Style
from vehicle.optimum import Course, Optimum, Profile
from vehicle.optimum.coast import coast_on, cruise_on
from vehicle.optimum.mesh import CourseOnMesh, laid_course, places_m
from vehicle.optimum.solve import optimum_of
from vehicle.records import TrainRow

LEVEL_MPS2: Final = 0.01  # assumed: a speed that changes by less is held: half of what the lowest notch gives
NO_FORCE_MPS2: Final = 0.005  # assumed: so little force is none: what a solver leaves of a coast

POINTS: Final = 150  # assumed: a plan that a unit makes at a departure needs no finer mesh

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PlanOnPath:
    """A plan as the tick takes it: rows of PLAN on the path's grid, and how long the run takes by it, s.

    That begins with what the machinery needs to answer.
    """

    rows: NDArray[np.void]
    takes_s: float


def plan_rows(
    profile: Profile | Optimum, rim_mps2: Floats, path_rows: int, idle_s: float = 0.0
) -> PlanOnPath:
    """Rows of PLAN, one for each of the path's `path_rows` metres; none outside the profile.

    `rim_mps2`: acceleration that motors and brakes give between its points, resistances apart; one fewer than points.
    """
    at_m, speed_mps = profile.position_m, profile.speed_mps
    energy = 0.5 * speed_mps * speed_mps
    slope_mps2 = np.diff(energy) / np.diff(at_m)
    left_s = profile.time_s[-1] - profile.time_s
    modes = np.where(
        np.abs(rim_mps2) < NO_FORCE_MPS2,
        PLAN_COAST,
        np.where(np.abs(slope_mps2) < LEVEL_MPS2, PLAN_HOLD, PLAN_FOLLOW),
    )
    first, last = max(int(np.floor(at_m[0])), 0), min(int(np.ceil(at_m[-1])), path_rows - 1)
    metres = np.arange(first, last + 1, dtype=np.float64)
    interval = np.clip(np.searchsorted(at_m, metres, side="right") - 1, 0, slope_mps2.size - 1)
    run_m = np.clip(metres, at_m[0], at_m[-1]) - at_m[interval]
    there_mps = np.sqrt(np.maximum(2.0 * (energy[interval] + slope_mps2[interval] * run_m), 0.0))
    since_s = 2.0 * run_m / np.maximum(speed_mps[interval] + there_mps, 1e-6)
    rows = np.zeros(path_rows, dtype=PLAN)
    rows["speed_mps"][first : last + 1] = there_mps
    rows["time_left_s"][first : last + 1] = left_s[interval] - since_s
    rows["mode"][first : last + 1] = modes[interval]
    return PlanOnPath(rows, idle_s + float(left_s[0]))


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """What a plan is asked for: the run to the next mark, on the unit's own map, in the time that is left."""

    train: TrainRow
    load_share: float
    climb_m: Floats
    driving_mps: Floats
    start_m: float
    stop_m: float
    initial_mps: float
    deceleration_mps2: float
    available_s: float
    regeneration_share: float = 1.0  # of what comes back that counts


def plan_in_time(ahead: PlanRequest, planning: Planning = PLAIN) -> PlanOnPath | None:
    """The plan for the time that is left, or for little more than the least where that is too short.

    None where the train cannot get there, or no run is found.
    """
    idle_s = answers_s(ahead.train) if ahead.initial_mps == 0.0 else 0.0
    try:
        course = Course(
            ahead.train,
            ahead.load_share,
            ahead.climb_m,
            kept_mps(ahead.driving_mps),
            ahead.start_m,
            ahead.stop_m,
            ahead.deceleration_mps2,
            initial_mps=ahead.initial_mps,
            regeneration=ahead.regeneration_share,
        )
        found = laid_course(course)
        free = math.isinf(ahead.available_s)
        reserve = planning.free_reserve_share if free else planning.late_reserve_share
        ordered_s = 0.0 if free else ahead.available_s - idle_s
        profile, rim_mps2 = _run(found, max(ordered_s, (1.0 + reserve) * found.least_s), planning.style)
    except ValueError:
        return None
    return plan_rows(profile, rim_mps2, ahead.climb_m.size, idle_s)


def _run(found: CourseOnMesh, time_s: float, style: Style) -> tuple[Profile | Optimum, Floats]:
    """The run of a style in a time, and what motors and brakes give on each of its stretches."""
    match style:
        case Style.HOLD:
            held = cruise_on(found, time_s)
            return held.profile, held.rim_mps2
        case Style.COAST:
            coasted = coast_on(found, time_s)
            return coasted.profile, coasted.rim_mps2
        case Style.OPTIMAL:
            best = optimum_of(found, time_s, places_m(found, POINTS))
            return best, (best.force_n - best.brake_n) / found.inertia_kg


def answers_s(train: TrainRow) -> float:
    """How much later than its plan a train is that starts from a stand: its brake lets go, its motors build up."""
    brake_s = float(train.brake_dead_time_s + train.brake_lag_s)
    return max(brake_s, float(train.traction_dead_time_s + train.traction_lag_s))


def kept_mps(driving_mps: Floats) -> Floats:
    """The speed that driving keeps on each metre: where the limit falls it looks `LOOK_AHEAD_S` ahead; shape (n,)."""
    metres = np.arange(driving_mps.size)
    ahead = np.minimum(
        metres + np.maximum(driving_mps * LOOK_AHEAD_S, 1.0).astype(np.int64), driving_mps.size - 1
    )
    return np.minimum(driving_mps, driving_mps[ahead])
