"""What a step drew and gave back at the wire, and where it went (電力量の内訳).

Over any stretch

    traction - regenerated = kinetic + resistance + gradient + curve + friction + traction loss + regeneration loss

to rounding. One step is no trapezoid of constant forces, that in which a train comes to a stand: its brakes, and if it
has none what resists it, do no more work than there is energy. A train that the model holds where it would roll back
has work of a gradient in that step that nothing did; it is left to stand in the residual. What wheels do in a slip or
a slide is not followed: a force is counted as the rail takes it, at the speed of the train.
"""

from __future__ import annotations

from typing import Final

from vehicle.adhesion import adhesion_coefficient
from vehicle.compiled import compiled
from vehicle.mass import GRAVITY_MPS2, mass_kg
from vehicle.records import PlantRow, TrainRow
from vehicle.traction import full_force_n, motored_grip_n
from vehicle.wire import power_at_grip_w, wire_power_w

NO_FORCE_SHARE: Final = (
    0.01  # of the full force: a lag dies away and never quite ends, so less than that is none
)


@compiled
def motors_power_w(plant: PlantRow, train: TrainRow, mean_mps: float) -> float:
    """Power of a train with a map of losses at the wire, W, for the forces of a step."""
    force_n = plant.traction_force_n - plant.regenerative_force_n
    adhesion = adhesion_coefficient(train, plant.adhesion_factor, mean_mps)
    grip_n = motored_grip_n(train, mass_kg(train, plant.load_share) * GRAVITY_MPS2, adhesion)
    small_n = NO_FORCE_SHARE * full_force_n(train, plant.load_share, mean_mps)
    if abs(force_n) > small_n:
        return power_at_grip_w(train, plant.motors_share, force_n, mean_mps, grip_n)
    idle_w = power_at_grip_w(train, plant.motors_share, 0.0, mean_mps, grip_n)
    if idle_w > plant.source_gives_w - train.auxiliary_power_w:
        idle_w = 0.0
    return force_n * mean_mps + idle_w


@compiled
def count_wire(plant: PlantRow, train: TrainRow, mean_mps: float, dt_s: float) -> None:
    """Count what motors, inverters and auxiliaries took and gave in a step of mean speed `mean_mps`."""
    pull_n, brake_n, share = plant.traction_force_n, plant.regenerative_force_n, plant.motors_share
    if train.losses_given > 0.0:
        power_w = motors_power_w(plant, train, mean_mps)
        drawn_w, given_w = max(power_w, 0.0), max(-power_w, 0.0)
        loss_w = power_w - (pull_n - brake_n) * mean_mps
        pulling_w = 0.0 if brake_n > pull_n else loss_w
        braking_w = loss_w - pulling_w
    else:
        drawn_w = wire_power_w(train, share, pull_n, mean_mps)
        given_w = -wire_power_w(train, share, -brake_n, mean_mps)
        pulling_w, braking_w = drawn_w - pull_n * mean_mps, brake_n * mean_mps - given_w
    plant.energy_traction_j += drawn_w * dt_s
    plant.energy_regenerated_j += given_w * dt_s
    plant.energy_auxiliary_j += train.auxiliary_power_w * dt_s
    plant.energy_traction_loss_j += pulling_w * dt_s
    plant.energy_regeneration_loss_j += braking_w * dt_s


@compiled
def count_work(
    plant: PlantRow,
    kinetic_j: float,
    running_n: float,
    gradient_n: float,
    curve_n: float,
    distance_m: float,
) -> None:
    """Count what the forces of a step did over its way; `kinetic_j` is the change of kinetic energy."""
    if distance_m <= 0.0:
        return
    resistance_j, friction_j = running_n * distance_m, plant.air_force_n * distance_m
    gradient_j, curve_j = gradient_n * distance_m, curve_n * distance_m
    if plant.speed_mps <= 0.0:
        motors_j = (plant.traction_force_n - plant.regenerative_force_n) * distance_m
        undone_j = max(kinetic_j - motors_j + friction_j + resistance_j + gradient_j + curve_j, 0.0)
        of_brake_j = min(undone_j, friction_j)
        of_curve_j = min(undone_j - of_brake_j, curve_j)
        friction_j, curve_j = friction_j - of_brake_j, curve_j - of_curve_j
        resistance_j -= min(undone_j - of_brake_j - of_curve_j, resistance_j)
    plant.energy_kinetic_j += kinetic_j
    plant.energy_resistance_j += resistance_j
    plant.energy_gradient_j += gradient_j
    plant.energy_curve_j += curve_j
    plant.energy_friction_j += friction_j
