"""The compiled inner loop: sensors, on-board tick and physics of every train, until something happens.

It runs ahead of the carrier by at most `steps` steps and stops after the first step in which any train reports an
event. Between events no telegram, timer or person can act, so running ahead changes nothing; the carrier then
executes the very speeds, and its positions are compared with these before anything else is done.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from onboard.records import MODE_DRIVE
from onboard.rows import UnitRow
from onboard.tick import tick
from simulation.world.records import EVENT_CAMERA, EVENT_FRONT, EVENT_REAR, EVENT_TAG
from simulation.world.rows import TruthRow
from vehicle.brakes import service_notch
from vehicle.compiled import compiled
from vehicle.dynamics import step as move
from vehicle.rows import PlantRow, TrainRow

SIGHT_RESERVE_M = 2.0
SIGHT_BRAKE_MPS2 = 0.5  # what a driver on sight asks for
SIGHT_MARGIN_MPS = 0.5  # the driver brakes this far above the ceiling, whatever the unit shows
SLIDE_SEEN_MPS = 0.05  # the slide protection compares axles no finer than this

Rows = NDArray[np.void]


@compiled
def track_under(truth: TruthRow, profile: Rows, length_m: float) -> tuple[float, float]:
    """Mean gradient (permille, positive uphill ahead) and mean |curvature| (1/m) under the train."""
    last = truth.profile_rows - 1
    front_m = min(max(truth.position_m, 0.0), float(last))
    rear_m = min(max(truth.position_m - length_m, 0.0), float(last))
    if front_m - rear_m < 1.0:
        return 0.0, 0.0
    i = min(int(front_m), last - 1)
    j = min(int(rear_m), last - 1)
    a = profile[truth.profile_offset + i]
    b = profile[truth.profile_offset + i + 1]
    c = profile[truth.profile_offset + j]
    d = profile[truth.profile_offset + j + 1]
    front_share = front_m - i
    rear_share = rear_m - j
    climb = (a.elevation_m + front_share * (b.elevation_m - a.elevation_m)) - (
        c.elevation_m + rear_share * (d.elevation_m - c.elevation_m)
    )
    turn = (a.turn_rad + front_share * (b.turn_rad - a.turn_rad)) - (
        c.turn_rad + rear_share * (d.turn_rad - c.turn_rad)
    )
    run_m = front_m - rear_m
    return 1000.0 * climb / run_m, turn / run_m


@compiled
def world_events(truth: TruthRow, tag_positions_m: NDArray[np.float64], length_m: float) -> int:
    """What the train's front and rear passed in this step; latches the tachometer where a tag was passed."""
    events = 0
    now_m = truth.position_m
    if truth.tag_next < truth.tag_end and now_m >= tag_positions_m[truth.tag_next]:
        events |= EVENT_TAG
        beyond = now_m - tag_positions_m[truth.tag_next]
        truth.odometer_at_tag_m = truth.odometer_m - beyond * truth.tachometer_gain / truth.wheel_factor
    if now_m >= truth.front_boundary_m:
        events |= EVENT_FRONT
    if now_m - length_m >= truth.rear_boundary_m:
        events |= EVENT_REAR
    if now_m >= truth.camera_m:
        truth.camera_m = np.inf
        events |= EVENT_CAMERA
    return events


@compiled
def read_tachometer(truth: TruthRow, plant: PlantRow, wheel_before_m: float, step_s: float) -> float:
    """Count the wheel's turning of one step; returns the speed shown, m/s. A faulty one shows what it shows."""
    if truth.tachometer_frozen_mps >= 0.0:
        truth.odometer_m += truth.tachometer_frozen_mps * step_s
        return truth.tachometer_frozen_mps
    gain = truth.tachometer_gain / truth.wheel_factor
    truth.odometer_m += (plant.wheel_travelled_m - wheel_before_m) * gain
    return plant.wheel_speed_mps * gain


@compiled
def slide_seen(plant: PlantRow) -> int:
    """What the slide protection tells the unit: -1 the wheels slide, 1 they slip, 0 they roll."""
    difference = plant.wheel_speed_mps - plant.speed_mps
    if abs(difference) <= SLIDE_SEEN_MPS:
        return 0
    return -1 if difference < 0.0 else 1


@compiled
def brake_on_sight(truth: TruthRow, plant: PlantRow, unit: UnitRow, train: TrainRow) -> None:
    """The driver, who sees the line, brakes a train without a position to a stand before `sight_m`."""
    if unit.mode != MODE_DRIVE or unit.emergency != 0:
        return
    room_m = truth.sight_m - truth.position_m - SIGHT_RESERVE_M
    speed = plant.speed_mps
    if room_m <= 0.0 or speed > unit.restricted_mps + SIGHT_MARGIN_MPS:
        unit.notch = -train.brake_notches
    elif (
        speed * (train.brake_dead_time_s + train.brake_lag_s) + speed * speed / (2.0 * SIGHT_BRAKE_MPS2)
        > room_m
    ):
        unit.notch = min(unit.notch, service_notch(train, SIGHT_BRAKE_MPS2))


@compiled
def advance(
    truths: Rows,
    plants: Rows,
    units: Rows,
    bodies: Rows,
    trains: Rows,
    behaviours: Rows,
    tascs: Rows,
    designs: Rows,
    waves: Rows,
    profile: Rows,
    path: Rows,
    tag_positions_m: NDArray[np.float64],
    speeds_mps: NDArray[np.float64],
    trace: Rows,
    trace_used: int,
    first_step: int,
    steps: int,
    trace_every: int,
) -> tuple[int, int]:
    """Run all active trains for up to `steps` steps from `first_step`; returns (steps done, trace rows used).

    `bodies` are the trains as they are, `trains` as their units believe them to be (both rows of TRAIN).
    `speeds_mps[k, slot]` is each train's speed at the end of step k; events are left in `truths.events`.
    """
    done = 0
    step_s = behaviours[0].step_s
    for slot in range(truths.size):
        truths[slot].events = 0
    for k in range(steps):
        happened = 0
        for slot in range(truths.size):
            truth = truths[slot]
            if truth.active == 0:
                continue
            plant = plants[slot]
            unit = units[slot]
            train = trains[slot]
            gradient, curvature = track_under(truth, profile, train.length_m)
            wheel_before_m = plant.wheel_travelled_m
            move(plant, bodies[slot], unit.notch, unit.emergency != 0, gradient, curvature, step_s)
            truth.position_m = truth.offset_m + plant.travelled_m
            speeds_mps[k, slot] = plant.speed_mps
            shown_mps = read_tachometer(truth, plant, wheel_before_m, step_s)
            unit.wheel_slide = slide_seen(plant)
            events = world_events(truth, tag_positions_m, train.length_m)
            events |= tick(
                unit,
                train,
                behaviours[slot],
                path,
                truth.odometer_m,
                shown_mps,
                plant.load_share,
                tascs[slot],
                designs[slot],
                waves[slot],
            )
            if unit.position_known == 0:
                brake_on_sight(truth, plant, unit, train)
            truth.events = events
            happened |= events
            sample = (first_step + k + 1) % trace_every == 0
            if (sample and (plant.speed_mps > 0.0 or unit.mode == MODE_DRIVE)) or events != 0:
                row = trace[trace_used]
                trace_used += 1
                row.step = first_step + k + 1
                row.slot = slot
                row.position_m = truth.position_m
                row.speed_mps = plant.speed_mps
                row.acceleration_mps2 = plant.acceleration_mps2
                row.notch = unit.notch
                row.intervention = unit.intervention
                row.permitted_mps = unit.permitted_mps
                row.target_mps = unit.target_mps
                row.stop_limit_m = unit.stop_limit_m
                row.estimate_error_m = unit.position_m - truth.position_m
                row.bound_ahead_m = unit.bound_ahead_m
                row.bound_behind_m = unit.bound_behind_m
        done = k + 1
        if happened != 0:
            break
    return done, trace_used
