"""What a step drew and gave back at the wire, and where it went (電力量の内訳).

Over any stretch

    traction - regenerated = kinetic + resistance + gradient + curve + friction + traction loss + regeneration loss

to rounding. One step is no trapezoid of constant forces, that in which a train comes to a stand: its brakes, and if it
has none its resistance, do no more work than there is energy. A train that the model holds where it would roll back
has work of a gradient in that step that nothing did; it is left to stand in the residual. What wheels do in a slip or
a slide is not followed: a force is counted as the rail takes it, at the speed of the train.
"""

from __future__ import annotations

from vehicle.compiled import compiled
from vehicle.records import PlantRow, TrainRow
from vehicle.wire import power_at_grip_w


@compiled
def count_wire(plant: PlantRow, train: TrainRow, mean_mps: float, dt_s: float) -> None:
    """Count what motors, inverters and auxiliaries took and gave in a step of mean speed `mean_mps`."""
    pull_n, brake_n, share = plant.traction_force_n, plant.regenerative_force_n, plant.motors_share
    drawn_w = power_at_grip_w(train, share, pull_n, mean_mps, 0.0)
    given_w = -power_at_grip_w(train, share, -brake_n, mean_mps, 0.0)
    plant.energy_traction_j += drawn_w * dt_s
    plant.energy_regenerated_j += given_w * dt_s
    plant.energy_auxiliary_j += train.auxiliary_power_w * dt_s
    plant.energy_traction_loss_j += (drawn_w - pull_n * mean_mps) * dt_s
    plant.energy_regeneration_loss_j += (brake_n * mean_mps - given_w) * dt_s


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
        friction_j -= of_brake_j
        resistance_j -= min(undone_j - of_brake_j, resistance_j)
    plant.energy_kinetic_j += kinetic_j
    plant.energy_resistance_j += resistance_j
    plant.energy_gradient_j += gradient_j
    plant.energy_curve_j += curve_j
    plant.energy_friction_j += friction_j
