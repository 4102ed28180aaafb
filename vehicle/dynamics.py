"""One step of a train's body and machinery: command in, motion and energy out.

Forces are those at the start of the step and hold through it; distance follows by the trapezoid of the two
speeds, as SUMO's ballistic integration does, so work and kinetic energy agree to rounding. Speed is never
negative: a train whose brakes and resistances outweigh the gradient stands. Without brakes it rolls forward
on a falling gradient; where it would roll back it is held at 0: no carrier here runs a train backwards.
"""

from __future__ import annotations

from vehicle.adhesion import (
    CLEANED_RAIL,
    adhesion_coefficient,
    axle_excess_n,
    bounded_slip_mps,
    next_slip_mps,
    rotating_mass_kg,
)
from vehicle.brakes import electric_brake_n, service_target_mps2
from vehicle.compiled import compiled
from vehicle.energy import NO_FORCE_SHARE, count_wire, count_work
from vehicle.mass import GRAVITY_MPS2, equivalent_mass_kg, mass_kg
from vehicle.records import COMMAND_DELAY_STEPS_MAX, PlantRow, TrainRow
from vehicle.resistance import curve_resistance_n, gradient_force_n, resistance_n
from vehicle.response import approach, dead_time_steps
from vehicle.source import brake_within_n, pull_within_n
from vehicle.traction import full_force_n, motored_grip_n, traction_target_n

__all__ = ["equivalent_mass_kg", "step"]


@compiled
def _push(plant: PlantRow, notch: float, emergency: bool) -> None:
    """Put this step's command at the head of the ring."""
    head = (plant.command_head + 1) % COMMAND_DELAY_STEPS_MAX
    plant.command_head = head
    plant.command_notch[head] = notch
    plant.command_emergency[head] = 1 if emergency else 0


@compiled
def _slot(plant: PlantRow, dead_time_s: float, dt_s: float) -> int:
    """Place in the ring of the command given a dead time ago."""
    return (plant.command_head - dead_time_steps(dead_time_s, dt_s)) % COMMAND_DELAY_STEPS_MAX


@compiled
def _build_up(plant: PlantRow, train: TrainRow, dt_s: float) -> None:
    """Traction force and brake decelerations one step on: dead time, lag, jerk limit; not yet adhesion."""
    before_mps2 = max(plant.service_deceleration_mps2, plant.emergency_deceleration_mps2)
    slot = _slot(plant, train.brake_dead_time_s, dt_s)
    service = service_target_mps2(train, plant.command_notch[slot]) * plant.brake_factor
    plant.service_deceleration_mps2 = approach(
        plant.service_deceleration_mps2, service, train.brake_lag_s, train.brake_jerk_max_mps3, dt_s
    )
    slot = _slot(plant, train.emergency_dead_time_s, dt_s)
    emergency = train.emergency_deceleration_mps2 if plant.command_emergency[slot] != 0 else 0.0
    emergency *= plant.emergency_factor
    plant.emergency_deceleration_mps2 = approach(
        plant.emergency_deceleration_mps2, emergency, train.emergency_lag_s, 0.0, dt_s
    )
    after_mps2 = max(plant.service_deceleration_mps2, plant.emergency_deceleration_mps2)
    _pull(plant, train, max(before_mps2 - after_mps2, 0.0) / dt_s, dt_s)


@compiled
def _pull(plant: PlantRow, train: TrainRow, released_mps3: float, dt_s: float) -> None:
    """Traction force one step on, while the brakes let go at `released_mps3`.

    What the limit of jerk leaves beside that is for the motors: a start is no rougher than either limit.
    """
    slot = _slot(plant, train.traction_dead_time_s, dt_s)
    if plant.command_emergency[slot] != 0:  # opens the line breaker, comfort does not count
        plant.traction_built_n = approach(plant.traction_built_n, 0.0, train.traction_lag_s, 0.0, dt_s)
        return
    target_n = traction_target_n(train, plant.load_share, plant.command_notch[slot], plant.speed_mps)
    target_n *= plant.motors_share
    limit_mps3 = train.traction_jerk_max_mps3
    inertia = equivalent_mass_kg(train, plant.load_share)
    before_n = plant.traction_built_n
    plant.traction_built_n = approach(before_n, target_n, train.traction_lag_s, limit_mps3 * inertia, dt_s)
    if limit_mps3 > 0.0:
        left_n = max(limit_mps3 - released_mps3, 0.0) * inertia * dt_s
        plant.traction_built_n = min(plant.traction_built_n, before_n + left_n)


@compiled
def _grip(plant: PlantRow, train: TrainRow, mass: float, held_n: float, dt_s: float) -> tuple[float, float]:
    """Cap the forces by adhesion and source, share the brake between motors and air, against what holds the train.

    Returns the next slip of first and last axle, m/s.
    """
    adhesion = adhesion_coefficient(train, plant.adhesion_factor, plant.speed_mps)
    weight_n = mass * GRAVITY_MPS2 * adhesion
    motored_n = motored_grip_n(train, mass * GRAVITY_MPS2, adhesion)
    traction_limit_n = plant.motors_share * motored_n
    inertia = mass * (1.0 + train.rotating_mass_factor)
    # What the source does not give is not built up either, so that the force comes back within the limit of jerk.
    plant.traction_built_n = pull_within_n(
        plant, train, plant.traction_built_n, held_n, inertia, motored_n, dt_s
    )
    traction_n = min(plant.traction_built_n, traction_limit_n)
    deceleration = max(plant.service_deceleration_mps2, plant.emergency_deceleration_mps2)
    asked_n = deceleration * mass * (1.0 + train.rotating_mass_factor)
    brake_n = min(asked_n, weight_n)

    regenerative_n = 0.0
    # The emergency brake is air alone, and the motors do not brake while they still pull.
    # In a slide it is cut.
    released = traction_n <= NO_FORCE_SHARE * full_force_n(train, plant.load_share, plant.speed_mps)
    slides = asked_n > brake_n or plant.wheel_speed_mps < plant.speed_mps
    if plant.emergency_deceleration_mps2 < 1e-3 and released and not slides:
        regenerative_n = electric_brake_n(train, plant.motors_share, brake_n, motored_n, plant.speed_mps)
        change_mps = (traction_n - brake_n - held_n) / inertia * dt_s
        middle_mps = plant.speed_mps + 0.5 * max(change_mps, -plant.speed_mps)
        regenerative_n = brake_within_n(plant, train, regenerative_n, middle_mps, motored_n, dt_s)
    plant.traction_force_n = traction_n
    plant.regenerative_force_n = regenerative_n
    plant.air_force_n = brake_n - regenerative_n

    rotating_kg = rotating_mass_kg(train, mass)
    pull_n = plant.traction_built_n
    excess_n = axle_excess_n(pull_n, traction_limit_n, asked_n, weight_n, plant.speed_mps)
    plant.sliding = 1 if excess_n != 0.0 else 0
    slip = plant.wheel_speed_mps - plant.speed_mps
    spare_n = traction_limit_n - traction_n if slip > 0.0 else weight_n - brake_n
    first = next_slip_mps(slip, excess_n, spare_n, rotating_kg, dt_s)
    # The last axle is a trailing one where there are any, and runs on cleaned rail. What the train loses where that
    # axle is let go is left out, as is what the axles on cleaned rail give beyond the mean.
    weight_n *= CLEANED_RAIL
    traction_limit_n *= CLEANED_RAIL
    if train.motored_axle_mass_share < 1.0:
        pull_n = 0.0
    if plant.last_axle_released != 0:
        asked_n = 0.0
    excess_n = axle_excess_n(pull_n, traction_limit_n, asked_n, weight_n, plant.speed_mps)
    slip = plant.last_wheel_speed_mps - plant.speed_mps
    spare_n = max(traction_limit_n - pull_n if slip > 0.0 else weight_n - asked_n, 0.0)
    return first, next_slip_mps(slip, excess_n, spare_n, rotating_kg, dt_s)


@compiled
def step(
    plant: PlantRow,
    train: TrainRow,
    notch: float,
    emergency: bool,
    mean_gradient_permille: float,
    mean_curvature_per_m: float,
    dt_s: float,
) -> None:
    """Advance one train (a record of PLANT, changed in place) by `dt_s` under a command.

    `notch` > 0 power, < 0 brake, 0 coast; `emergency` applies the emergency brake. Gradient (permille,
    positive uphill in the direction of travel) and curvature (1/m) are means over the train's length.
    """
    _push(plant, notch, emergency)
    _build_up(plant, train, dt_s)
    mass, speed = mass_kg(train, plant.load_share), plant.speed_mps
    running_n = resistance_n(train, mass, speed)
    gradient_n = gradient_force_n(mass, mean_gradient_permille)
    curve_n = curve_resistance_n(train, mass, mean_curvature_per_m)
    slip, last_slip = _grip(plant, train, mass, running_n + gradient_n + curve_n, dt_s)

    net_n = (
        plant.traction_force_n
        - plant.regenerative_force_n
        - plant.air_force_n
        - running_n
        - gradient_n
        - curve_n
    )
    speed_after = max(0.0, speed + net_n / (mass * (1.0 + train.rotating_mass_factor)) * dt_s)
    distance = 0.5 * (speed + speed_after) * dt_s
    wheel_after = speed_after + bounded_slip_mps(train, slip, speed_after)
    plant.wheel_travelled_m += 0.5 * (plant.wheel_speed_mps + wheel_after) * dt_s
    plant.wheel_speed_mps = wheel_after
    plant.last_wheel_speed_mps = speed_after + bounded_slip_mps(train, last_slip, speed_after)
    plant.travelled_m += distance
    plant.acceleration_mps2 = (speed_after - speed) / dt_s
    plant.speed_mps = speed_after

    count_wire(plant, train, distance / dt_s, dt_s)
    kinetic_j = 0.5 * mass * (1.0 + train.rotating_mass_factor) * (speed_after * speed_after - speed * speed)
    count_work(plant, kinetic_j, running_n, gradient_n, curve_n, distance)
