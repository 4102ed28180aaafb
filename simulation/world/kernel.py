"""The compiled inner loop: sensors, on-board tick and physics of every train, until something happens.

It runs ahead of the carrier by at most `steps` steps and stops after the first step in which any train reports an
event. Between events no telegram, timer or person can act, so running ahead changes nothing; the carrier then
executes the very speeds, and its positions are compared with these before anything else is done.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from onboard.records import EVENT_FOUND, MODE_DRIVE, MODE_HOLD, Chart, UnitRow
from onboard.tick import tick
from simulation.result import TRACE_EVERY_STEPS
from simulation.ride import count_motion, count_notches
from simulation.sensors.scene import NO_TAG_M
from simulation.sensors.table import sense_all
from simulation.world.charge_control import drain, offer_power, steer
from simulation.world.records import (
    PASSED_CROSSING,
    PASSED_FROM_A_STAND,
    PASSED_FRONT,
    PASSED_REAR,
    PASSED_TAG,
    PASSED_TO_A_STAND,
    StockRow,
    TraceRow,
    TruthRow,
)
from vehicle.adhesion import adhesion_coefficient
from vehicle.brakes import service_notch
from vehicle.compiled import compiled, compiled_when_called
from vehicle.dynamics import step as move
from vehicle.mass import GRAVITY_MPS2, mass_kg
from vehicle.records import PlantRow, TrainRow
from vehicle.traction import motored_grip_n

MOVING_STEPS_MAX: Final = 50  # it runs ahead of the carrier by at most this
STANDING_STEPS_MAX: Final = 600
SIGHT_RESERVE_M = 2.0
SIGHT_BRAKE_MPS2 = 0.5  # what a driver on sight asks for
SEES_END_M = 200.0  # a driver sees the end of the track from this far, on a straight by day
END_BRAKE_MPS2 = 0.7  # which the service brake of any train here gives on a damp rail
SIGHT_MARGIN_MPS = 0.5  # the driver brakes this far above the ceiling, whatever the unit shows

Rows = NDArray[np.void]


class PathArrays(NamedTuple):
    """The pool of all paths: the real profile, what units know of it, their plans, where tags and other things lie."""

    profile: Rows
    pattern: Rows
    plan: Rows
    tag_positions_m: NDArray[np.float64]
    places: Rows  # PLACE: what there is, path by path, beacons before markers, by position
    known_places: Rows  # PLACE: what units know of, path by path, by position


class Sheet(NamedTuple):
    """What Python reads after a stretch, in blocks; the first axis is the order of `movers`, or the slot where said."""

    # slots of the stock that drove or rolled, ascending; then of stock that began to move
    movers: NDArray[np.int64]
    speeds_mps: NDArray[np.float64]  # (movers, steps): at the end of each step
    # (slots, 6), by slot: of the step in which bounds were broken most, or nearest to it: by how much (m; -inf: no
    # step with a known position), the step, true position, believed position, bound behind, bound ahead
    worst: NDArray[np.float64]
    passed: NDArray[np.int64]  # by slot: what its front and rear passed in the last step
    events: NDArray[np.int64]  # by slot: what its unit reported in the last step


def new_sheet(slots: int) -> Sheet:
    """An empty sheet for that many slots."""
    return Sheet(
        np.zeros(slots, dtype=np.int64),
        np.zeros((slots, STANDING_STEPS_MAX)),
        np.zeros((slots, 6)),
        np.zeros(slots, dtype=np.int64),
        np.zeros(slots, dtype=np.int64),
    )


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
def passed_in_step(truth: TruthRow, tag_positions_m: NDArray[np.float64], length_m: float) -> int:
    """What the train's front and rear passed in this step, as bits."""
    found = 0
    now_m = truth.position_m
    if truth.tag_next < truth.tag_end and now_m >= tag_positions_m[truth.tag_next]:
        found |= PASSED_TAG
    if now_m >= truth.front_boundary_m:
        found |= PASSED_FRONT
    if now_m - length_m >= truth.rear_boundary_m:
        found |= PASSED_REAR
    if now_m >= truth.crossing_m:
        found |= PASSED_CROSSING
    return found


@compiled
def stands_after_m(plant: PlantRow, train: TrainRow, brake_mps2: float) -> float:
    """How far a train runs that is braked from now on, m; until the brake answers the motors go on as they do."""
    reaction_s = train.brake_dead_time_s + train.brake_lag_s
    after_mps = plant.speed_mps + max(plant.acceleration_mps2, 0.0) * reaction_s
    return float(
        (plant.speed_mps + after_mps) / 2.0 * reaction_s + after_mps * after_mps / (2.0 * brake_mps2)
    )


@compiled
def brake_on_sight(truth: TruthRow, plant: PlantRow, unit: UnitRow, train: TrainRow) -> None:
    """The driver of a train on sight, who sees the line, brakes it to a stand before `sight_m`."""
    if unit.mode != MODE_DRIVE or unit.emergency != 0:
        return
    room_m = truth.sight_m - truth.position_m - SIGHT_RESERVE_M
    speed = plant.speed_mps
    if room_m <= 0.0 or speed > unit.restricted_mps + SIGHT_MARGIN_MPS:
        unit.notch = -train.brake_notches
    elif stands_after_m(plant, train, SIGHT_BRAKE_MPS2) > room_m:
        unit.notch = min(unit.notch, service_notch(train, SIGHT_BRAKE_MPS2))


@compiled
def brake_at_end(truth: TruthRow, plant: PlantRow, unit: UnitRow, train: TrainRow) -> None:
    """A driver who sees that the train would run off the end of its track brakes by the full service brake."""
    room_m = truth.track_end_m - truth.position_m - SIGHT_RESERVE_M
    if room_m > SEES_END_M or unit.emergency != 0:
        return
    if stands_after_m(plant, train, END_BRAKE_MPS2) > room_m:
        unit.notch = -train.brake_notches


@compiled
def heading_rad(profile: Rows, truth: TruthRow, front_m: float) -> float:
    """Where the leading car points with its front at `front_m`: the mean of the track's heading between its bogies.

    Simpson's rule at the two bogies and half-way between them: a body follows its bogies, and turns no faster.
    """
    first_m = front_m - truth.lead_bogie_m
    base_m = truth.bogie_base_m
    ends_rad = points_rad(profile, truth, first_m) + points_rad(profile, truth, first_m - base_m)
    return (ends_rad + 4.0 * points_rad(profile, truth, first_m - 0.5 * base_m)) / 6.0


@compiled
def points_rad(profile: Rows, truth: TruthRow, at_m: float) -> float:
    """Where the rails as laid point at a path coordinate (m), rad; beyond the ends as at the ends."""
    last = truth.profile_rows - 1
    at_m = min(max(at_m, 0.0), float(last))
    i = min(int(at_m), last - 1)
    a, b = profile[truth.profile_offset + i], profile[truth.profile_offset + i + 1]
    here = a.heading_rad + a.irregularity_rad
    return float(here + (at_m - i) * (b.heading_rad + b.irregularity_rad - here))


@compiled_when_called
def look_around(row: StockRow, track: PathArrays, before_m: float, curvature_per_m: float) -> None:
    """What else there is to be sensed by a train that was at `before_m` a step ago."""
    scene, truth = row.scene, row.truth
    now_m = truth.position_m
    scene.carries_more = 1
    scene.curvature_per_m = curvature_per_m
    scene.turned_rad = heading_rad(track.profile, truth, now_m) - heading_rad(track.profile, truth, before_m)
    here = min(max(int(now_m), 0), truth.profile_rows - 1)
    underneath = track.profile[truth.profile_offset + here]
    scene.sky, scene.kilometrage_m = underneath.sky, underneath.kilometrage_m
    scene.front_m = now_m
    last = truth.profile_offset + max(here - 1, 0)
    scene.down = 1.0 if track.profile[last + 1].kilometrage_m >= track.profile[last].kilometrage_m else -1.0
    scene.beacon_beyond_m = NO_TAG_M
    if truth.beacon_next < truth.beacon_end and now_m >= track.places[truth.beacon_next].position_m:
        beacon = track.places[truth.beacon_next]
        scene.beacon_beyond_m = now_m - beacon.position_m
        scene.beacon_number, scene.beacon_told = beacon.number, beacon.told
        truth.beacon_next += 1
    while truth.markers_next < truth.markers_end and now_m >= track.places[truth.markers_next].position_m:
        truth.markers_next += 1
    scene.markers_ahead_m = np.inf
    if truth.markers_next < truth.markers_end:
        scene.markers_ahead_m = track.places[truth.markers_next].position_m - now_m
        scene.markers_number = track.places[truth.markers_next].number


@compiled
def used_adhesion(plant: PlantRow, body: TrainRow) -> float:
    """Force that the measured axle, which is driven, puts on the rail over what it could; < 0: it brakes."""
    weight_n = mass_kg(body, plant.load_share) * GRAVITY_MPS2
    adhesion = adhesion_coefficient(body, plant.adhesion_factor, plant.speed_mps)
    pulls = plant.traction_force_n / max(motored_grip_n(body, weight_n, adhesion), 1.0)
    brakes = (plant.regenerative_force_n + plant.air_force_n) / max(weight_n * adhesion, 1.0)
    return float(min(max(pulls - brakes, -1.0), 1.0))


@compiled
def show_scene(row: StockRow, tag_beyond_m: float, wheel_before_m: float, step: int, step_s: float) -> None:
    """Show the row's sensors what there is to be sensed after its body has moved."""
    scene, plant = row.scene, row.plant
    scene.step, scene.now_s, scene.step_s = step, step * step_s, step_s
    scene.speed_mps, scene.acceleration_mps2 = plant.speed_mps, plant.acceleration_mps2
    scene.wheel_mps, scene.wheel_run_m = plant.wheel_speed_mps, plant.wheel_travelled_m - wheel_before_m
    scene.last_wheel_mps, scene.load_share = plant.last_wheel_speed_mps, plant.load_share
    scene.tag_beyond_m = tag_beyond_m
    scene.sign_ahead_m = row.truth.sign_m - row.truth.position_m
    row.sensed.now_s = scene.now_s + row.truth.clock_ahead_s
    sense_all(row.sensors, scene, row.sensed)


@compiled
def step_one(row: StockRow, track: PathArrays, step: int) -> tuple[int, int]:
    """One stock through one step: its body moves, its sensors show it, its unit ticks.

    Returns what it passed and what its unit reports, as bits.
    """
    truth, plant, unit = row.truth, row.plant, row.board.unit
    step_s = row.board.behaviour.step_s
    gradient, curvature = track_under(truth, track.profile, row.body.length_m)
    wheel_before_m = plant.wheel_travelled_m
    before_mps, before_mps2 = plant.speed_mps, plant.acceleration_mps2
    dead = truth.powered == 0
    notch = -row.body.brake_notches if dead else unit.notch
    protects = row.body.wheel_slide_share_max < 1.0
    plant.last_axle_released = 1 if protects and row.sensed.wheel_slide < 0 else 0
    emergency = dead or unit.emergency != 0
    count_notches(row.ride, unit, plant, notch)
    battery = row.battery
    traction_j, regenerated_j = plant.energy_traction_j, plant.energy_regenerated_j
    if battery.fitted != 0:
        offer_power(battery, row.charging, plant, step_s)
    move(plant, row.body, notch, emergency, gradient, curvature, step_s)
    if battery.fitted != 0:
        drain(battery, row.charging, plant, row.body, traction_j, regenerated_j, step_s)
        held = 1 if dead or unit.mode == MODE_HOLD else 0
        ahead_s = row.truth.clock_ahead_s
        steer(battery, row.charging, plant.speed_mps, held, step * step_s, ahead_s)
    count_motion(row.ride, plant, before_mps, before_mps2, emergency, step_s)
    before_m = truth.position_m
    truth.position_m = truth.offset_m + plant.travelled_m
    row.scene.run_m = truth.position_m - before_m
    if truth.wheels_vary != 0:
        row.scene.curvature_per_m = curvature
        row.scene.used_adhesion = used_adhesion(plant, row.body)
    if truth.carries_more != 0:
        look_around(row, track, before_m, curvature)
    found = passed_in_step(truth, track.tag_positions_m, row.body.length_m)
    if before_mps > 0.0 and plant.speed_mps == 0.0:
        found |= PASSED_TO_A_STAND
    elif before_mps == 0.0 and plant.speed_mps > 0.0:
        found |= PASSED_FROM_A_STAND
    beyond_m = NO_TAG_M
    if found & PASSED_TAG != 0:
        beyond_m = truth.position_m - track.tag_positions_m[truth.tag_next]
    show_scene(row, beyond_m, wheel_before_m, step, step_s)
    if dead:
        return found, 0
    events = tick(row.board, row.sensed, Chart(track.pattern, track.known_places), track.plan)
    if truth.sight_m < np.inf:
        brake_on_sight(truth, plant, unit, row.board.kind)
    brake_at_end(truth, plant, unit, row.board.kind)
    return found, events


@compiled
def judge_bounds(row: StockRow, events: int, worst: NDArray[np.float64], step: int) -> None:
    """Remember the moment of this stretch in which the truth was furthest out of the stated bounds, or nearest to it.

    The checker judges it; here nothing is decided. `worst`: see `Sheet.worst`. A position that a sensor has found in
    this step is stated from the next one on, if the unit then believes it.
    """
    unit = row.board.unit
    if unit.position_known == 0 or events & EVENT_FOUND != 0 or row.truth.powered == 0:
        return
    beyond_m = row.truth.position_m - unit.position_m
    ahead_m, behind_m = beyond_m - unit.bound_ahead_m, -beyond_m - unit.bound_behind_m
    out_m = np.nan if np.isnan(ahead_m + behind_m) else max(ahead_m, behind_m)
    if not (out_m <= worst[0] or np.isnan(worst[0])):  # what is no number is out, and nothing further out
        worst[0] = out_m
        worst[1] = step
        worst[2] = row.truth.position_m
        worst[3] = unit.position_m
        worst[4] = unit.bound_behind_m
        worst[5] = unit.bound_ahead_m


@compiled
def sample(trace: TraceRow, row: StockRow, step: int, slot: int) -> None:
    """Write one row of the trace."""
    truth, plant, unit = row.truth, row.plant, row.board.unit
    trace.step = step
    trace.slot = slot
    trace.position_m = truth.position_m
    trace.speed_mps = plant.speed_mps
    trace.acceleration_mps2 = plant.acceleration_mps2
    trace.notch = unit.notch
    trace.intervention = unit.intervention
    trace.permitted_mps = unit.permitted_mps
    trace.target_mps = unit.target_mps
    trace.stop_limit_m = unit.stop_limit_m
    trace.estimate_error_m = unit.position_m - truth.position_m
    trace.bound_ahead_m = unit.bound_ahead_m
    trace.bound_behind_m = unit.bound_behind_m


@compiled
def list_movers(stock: Rows, sheet: Sheet) -> int:
    """Write down the slots that drive or roll as a stretch begins; returns their number."""
    count = 0
    for slot in range(stock.size):
        row = stock[slot]
        if row.truth.active != 0 and (row.board.unit.mode == MODE_DRIVE or row.plant.speed_mps > 0.0):
            sheet.movers[count] = slot
            count += 1
    return count


@compiled
def begins_to_move(sheet: Sheet, count: int, slot: int, speed_mps: float, done: int) -> None:
    """Add stock that stood without driving and yet moved in step `done`: by traction left over, or on a gradient."""
    sheet.movers[count] = slot
    sheet.speeds_mps[count, :done] = 0.0
    sheet.speeds_mps[count, done] = speed_mps


@compiled
def advance(
    stock: Rows, track: PathArrays, sheet: Sheet, trace: Rows, trace_used: int, first_step: int, steps: int
) -> tuple[int, int, int]:
    """Run all active trains for up to `steps` steps from `first_step`; returns steps done, trace rows used, movers.

    The first `movers` rows of the sheet tell of all stock that moved; `sheet.passed` and `sheet.events` of every
    slot. Nothing else has to be read from `stock` after a stretch in which nothing happened. The first movement of
    stock that stood ends the stretch, so whoever moves in it has all its speeds in the sheet.
    """
    moving = list_movers(stock, sheet)
    told = moving
    steps = min(steps, MOVING_STEPS_MAX if moving > 0 else STANDING_STEPS_MAX)
    sheet.worst[:, 0] = -np.inf
    sheet.passed[:] = 0
    sheet.events[:] = 0
    done = 0
    while done < steps:
        happened = 0
        mover = 0
        step = first_step + done + 1
        for slot in range(stock.size):
            row = stock[slot]
            if row.truth.active == 0:
                continue
            found, events = step_one(row, track, step)
            judge_bounds(row, events, sheet.worst[slot], step)
            if mover < moving and sheet.movers[mover] == slot:
                sheet.speeds_mps[mover, done] = row.plant.speed_mps
                mover += 1
            elif row.plant.speed_mps > 0.0:
                begins_to_move(sheet, told, slot, row.plant.speed_mps, done)
                told += 1
            sheet.passed[slot] = found
            sheet.events[slot] = events
            happened |= found | events
            whole = step % TRACE_EVERY_STEPS == 0
            moves = row.plant.speed_mps > 0.0 or row.board.unit.mode == MODE_DRIVE
            if (whole and moves) or (found & ~PASSED_CROSSING | events) != 0:
                sample(trace[trace_used], row, step, slot)
                trace_used += 1
        done += 1
        if happened != 0:
            break
    return done, trace_used, told
