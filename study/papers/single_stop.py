"""One stop at a mark, compiled: the train's body, its tachometer, beacons or signs, TASC and supervision.

The mark is at 0 and positions grow in the direction of travel, so the train starts at a negative one. Position
errors are those of Oda's figures 12 to 14: a share of the distance run since the last fix, and after a sign is
seen the distance run within one camera frame (equation 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from onboard.driving.supervision import stop_curve_mps
from onboard.driving.tasc import (
    DESIGN,
    SIGN_BEYOND_LIMIT,
    TARGET_NOT_SEEN,
    TASC,
    DesignRow,
    TascRow,
    Verdict,
    aim_m,
    judge,
    tasc_step,
)
from vehicle.brakes import service_notch
from vehicle.compiled import compiled
from vehicle.dynamics import step
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg, mass_kg
from vehicle.records import PLANT, PlantRow, TrainRow
from vehicle.resistance import gradient_force_n, resistance_n

FIXES_MAX: Final = 8
STEPS_MAX: Final = 3000
FIX_ACCURACY_M: Final = 0.1  # Oda, table 1: odometry and marker, about 0.1 m
# Aiming this far before a stop limit, the pattern stays under the supervision's curve with its reaction time.
LIMIT_MARGIN_M: Final = 5.0

STOP: Final = np.dtype(
    [
        ("speed_mps", "f8"),
        ("start_m", "f8"),  # distance to the mark at the beginning
        ("since_fix_m", "f8"),  # run since the last fix before that
        ("odometer_error", "f8"),  # share of the distance run; positive: the estimate runs ahead
        ("speed_error", "f8"),  # share, of the tachometer's speed
        ("beacons", "i8"),
        ("beacon_m", "f8", (FIXES_MAX,)),  # distances before the mark, falling
        ("beacon_error_m", "f8", (FIXES_MAX,)),
        ("signs", "i8"),
        ("sign_m", "f8", (FIXES_MAX,)),
        ("detection_m", "f8"),  # a sign is seen from this far
        ("frame_s", "f8"),  # the estimate is ahead of the truth by speed times this while a sign is seen
        (
            "fix_due_m",
            "f8",
        ),  # without a fix nearer to the mark than this many m by then: not seen; 0: never due
        ("stop_limit_m", "f8"),  # 停止限界, from the mark; +inf: no supervision
        ("bound_growth", "f8"),  # share of the run since the last fix that the position's bound grows by
        ("emergency_guaranteed_mps2", "f8"),
        ("emergency_reaction_s", "f8"),
        ("gradient_permille", "f8"),
        ("gradient_believed_permille", "f8"),
        ("load_share", "f8"),
        ("adhesion_factor", "f8"),
        ("brake_factor", "f8"),
    ],
    align=True,
)

OUTCOME: Final = np.dtype(
    [
        ("error_m", "f8"),  # where the front stopped; positive: past the mark
        ("time_s", "f8"),
        ("deceleration_max_mps2", "f8"),
        ("rest_mps2", "f8"),  # deceleration that ends when the train comes to rest
        ("within_limit", "i8"),
        ("verdict", "i8"),
        ("emergency", "i8"),
        ("slid_steps", "i8"),
        ("steps", "i8"),
    ],
    align=True,
)

TRACE: Final = np.dtype(
    [
        ("speed_mps", "f8"),
        ("measured_mps", "f8"),
        ("position_m", "f8"),
        ("estimate_m", "f8"),
        ("command_mps2", "f8"),  # designed deceleration (設計減速度)
        ("own_mps2", "f8"),  # by gradient and resistance, as the unit believes
        ("deceleration_mps2", "f8"),
    ],
    align=True,
)


class StopRow(Protocol):
    """One record of STOP."""

    speed_mps: float
    start_m: float
    since_fix_m: float
    odometer_error: float
    speed_error: float
    beacons: int
    beacon_m: list[float]
    beacon_error_m: list[float]
    signs: int
    sign_m: list[float]
    detection_m: float
    frame_s: float
    fix_due_m: float
    stop_limit_m: float
    bound_growth: float
    emergency_guaranteed_mps2: float
    emergency_reaction_s: float
    gradient_permille: float
    gradient_believed_permille: float
    load_share: float
    adhesion_factor: float
    brake_factor: float


class OutcomeRow(Protocol):
    """One record of OUTCOME."""

    error_m: float
    time_s: float
    deceleration_max_mps2: float
    rest_mps2: float
    within_limit: int
    verdict: int
    emergency: int
    slid_steps: int
    steps: int


class TraceRow(Protocol):
    """One record of TRACE."""

    speed_mps: float
    measured_mps: float
    position_m: float
    estimate_m: float
    command_mps2: float
    own_mps2: float
    deceleration_mps2: float


@compiled
def fixed_estimate_m(
    stop: StopRow, before_m: float, after_m: float, estimate_m: float, speed_mps: float
) -> tuple[float, bool]:
    """Estimate after the fixes between two true positions of one step, and whether there was one."""
    seen = False
    for i in range(stop.beacons):
        beacon_m = -stop.beacon_m[i]
        if before_m < beacon_m <= after_m:
            since_m = (after_m - beacon_m) * (1.0 + stop.odometer_error)
            estimate_m = beacon_m + stop.beacon_error_m[i] + since_m
            seen = True
    for i in range(stop.signs):
        ahead_m = -stop.sign_m[i] - after_m
        if 0.0 <= ahead_m <= stop.detection_m:
            estimate_m = after_m + speed_mps * stop.frame_s
            seen = True
    return estimate_m, seen


@compiled
def supervised(stop: StopRow, estimate_m: float, bound_m: float, speed_mps: float) -> bool:
    """Whether supervision must brake: the speed is above the emergency curve to the stop limit."""
    left_m = stop.stop_limit_m - estimate_m - bound_m
    climb_m = left_m * stop.gradient_believed_permille / 1000.0
    curve_mps = stop_curve_mps(
        left_m, climb_m, stop.emergency_guaranteed_mps2, stop.emergency_reaction_s, GRAVITY_MPS2
    )
    return speed_mps > curve_mps


@compiled
def begin(stop: StopRow, plant: PlantRow) -> None:
    """Put a train's body into the state a stop begins with."""
    plant.load_share = stop.load_share
    plant.adhesion_factor = stop.adhesion_factor
    plant.brake_factor = stop.brake_factor
    plant.speed_mps = stop.speed_mps
    plant.wheel_speed_mps = stop.speed_mps
    plant.travelled_m = 0.0
    plant.wheel_travelled_m = 0.0
    plant.acceleration_mps2 = 0.0
    plant.traction_force_n = 0.0
    plant.traction_built_n = 0.0
    plant.service_deceleration_mps2 = 0.0
    plant.emergency_deceleration_mps2 = 0.0
    for i in range(len(plant.command_notch)):
        plant.command_notch[i] = 0.0
        plant.command_emergency[i] = 0


@compiled
def own_mps2(train: TrainRow, stop: StopRow, speed_mps: float) -> float:
    """Deceleration by running resistance and the believed gradient, m/s^2, as the unit knows them."""
    mass = mass_kg(train, stop.load_share)
    force_n = resistance_n(train, mass, speed_mps)
    force_n += gradient_force_n(mass, stop.gradient_believed_permille)
    return force_n / equivalent_mass_kg(train, stop.load_share)


@compiled
def note(
    row: TraceRow,
    speed_mps: float,
    measured_mps: float,
    position_m: float,
    estimate_m: float,
    command_mps2: float,
    own_mps2: float,
    plant: PlantRow,
) -> None:
    """Write one step down."""
    row.speed_mps = speed_mps
    row.measured_mps = measured_mps
    row.position_m = position_m
    row.estimate_m = estimate_m
    row.command_mps2 = command_mps2
    row.own_mps2 = own_mps2
    row.deceleration_mps2 = -plant.acceleration_mps2


@compiled
def keep_count(outcome: OutcomeRow, plant: PlantRow, steps: int) -> None:
    """Take one more step into the outcome; the last one, in which the train comes to rest, only as time."""
    outcome.steps = steps
    outcome.slid_steps += plant.sliding
    if plant.speed_mps > 0.0:
        outcome.deceleration_max_mps2 = max(outcome.deceleration_max_mps2, -plant.acceleration_mps2)
        outcome.rest_mps2 = -plant.acceleration_mps2


@compiled
def run_stop(
    stop: StopRow,
    train: TrainRow,
    design: DesignRow,
    tasc: TascRow,
    plant: PlantRow,
    outcome: OutcomeRow,
    trace: NDArray[np.void],
) -> None:
    """Run one stop to rest; fills `outcome` and `trace` (rows of TRACE, as far as it reaches), zeros before."""
    begin(stop, plant)
    dt_s = design.step_s
    position_m = -stop.start_m
    estimate_m = position_m + stop.since_fix_m * stop.odometer_error
    bound_m = abs(stop.since_fix_m) * stop.bound_growth
    fix_m = -np.inf  # true position at the last fix
    emergency = False
    if stop.stop_limit_m < 0.0:
        judge(tasc, SIGN_BEYOND_LIMIT)
    fixed = False
    run_m = 0.0
    wheel_m = 0.0
    distance_m = stop.start_m
    for i in range(STEPS_MAX):
        measured_mps = plant.wheel_speed_mps * (1.0 + stop.speed_error)
        if stop.fix_due_m > 0.0 and estimate_m > -stop.fix_due_m and fix_m == -np.inf:
            judge(tasc, TARGET_NOT_SEEN)
        own = own_mps2(train, stop, measured_mps)
        expected_m = distance_m - run_m
        distance_m = aim_m(-estimate_m, stop.stop_limit_m - estimate_m - bound_m, LIMIT_MARGIN_M)
        moved_m = expected_m - distance_m if fixed else 0.0
        command = tasc_step(tasc, design, measured_mps, distance_m, moved_m, own)
        if stop.stop_limit_m < np.inf and not emergency:
            emergency = supervised(stop, estimate_m, bound_m, measured_mps)
        before_m, before_mps = position_m, plant.speed_mps
        step(plant, train, service_notch(train, command), emergency, stop.gradient_permille, 0.0, dt_s)
        position_m = -stop.start_m + plant.travelled_m
        if i < trace.shape[0]:
            note(trace[i], before_mps, measured_mps, before_m, estimate_m, command, own, plant)
        run_m = (plant.wheel_travelled_m - wheel_m) * (1.0 + stop.odometer_error)
        wheel_m = plant.wheel_travelled_m
        estimate_m += run_m
        bound_m += run_m * stop.bound_growth
        estimate_m, fixed = fixed_estimate_m(stop, before_m, position_m, estimate_m, plant.speed_mps)
        if fixed:
            fix_m = position_m
            bound_m = FIX_ACCURACY_M + run_m * stop.bound_growth + abs(stop.frame_s) * plant.speed_mps
        keep_count(outcome, plant, i + 1)
        if plant.speed_mps <= 0.0:
            break
    outcome.error_m = position_m
    outcome.time_s = outcome.steps * dt_s
    outcome.within_limit = 1 if position_m <= stop.stop_limit_m and plant.speed_mps <= 0.0 else 0
    outcome.emergency = 1 if emergency else 0
    outcome.verdict = tasc.verdict


def new_stops(n: int) -> NDArray[np.void]:
    """`n` rows of STOP: dry and level, nominal brakes, no beacon, no sign, no supervision."""
    rows = np.zeros(n, dtype=STOP)
    rows["adhesion_factor"] = 1.0
    rows["brake_factor"] = 1.0
    rows["stop_limit_m"] = np.inf
    rows["emergency_guaranteed_mps2"] = 1.0
    rows["emergency_reaction_s"] = 1.5
    return rows


@dataclass(frozen=True, slots=True)
class StopResult:
    """What came of one stop; `error_m` is positive past the mark."""

    error_m: float
    time_s: float
    deceleration_max_mps2: float
    rest_mps2: float
    within_limit: bool
    verdict: Verdict
    emergency: bool
    slid: bool


def one_stop(
    stop: NDArray[np.void], train: TrainRow, design: NDArray[np.void], trace_steps: int = 0
) -> tuple[StopResult, NDArray[np.void]]:
    """Run a single stop (STOP and DESIGN rows, shape (1,)); also its trace, at most `trace_steps` rows of TRACE."""
    out = np.zeros(1, dtype=OUTCOME)
    trace = np.zeros(trace_steps, dtype=TRACE)
    run_stop(
        stop[0], train, design[0], np.zeros(1, dtype=TASC)[0], np.zeros(1, dtype=PLANT)[0], out[0], trace
    )
    row = out[0]
    result = StopResult(
        float(row["error_m"]),
        float(row["time_s"]),
        float(row["deceleration_max_mps2"]),
        float(row["rest_mps2"]),
        bool(row["within_limit"]),
        Verdict(int(row["verdict"])),
        bool(row["emergency"]),
        bool(row["slid_steps"]),
    )
    return result, trace[: int(row["steps"])]


def design_row(**fields: float) -> NDArray[np.void]:
    """A row of DESIGN, shape (1,), from values by field; a field left out is 0."""
    row = np.zeros(1, dtype=DESIGN)
    for name, value in fields.items():
        row[name] = value
    return row
