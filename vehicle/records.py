"""The records that compiled code works on: one row a train, field names carry their units.

`TRAIN` holds what does not change during a run, `PLANT` the state of one train's body and machinery.
`vehicle.train_file.load_train` fills a TRAIN row.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from vehicle.record import dtype_of
from vehicle.resistance_file import RunningResistance

NOTCHES_MAX: Final = 16
COMMAND_DELAY_STEPS_MAX: Final = 64
CURVE_POINTS_MAX: Final = 128


class TrainRow(Protocol):
    """What a train is; it does not change during a run."""

    # body
    length_m: float
    mass_empty_kg: float
    mass_load_full_kg: float
    rotating_mass_factor: Annotated[float, "equivalent mass = mass * (1 + factor)"]
    cars: float
    motored_mass_share: Annotated[float, "share of the mass on motored cars, for JIS running resistance"]
    resistance: RunningResistance  # see vehicle.resistance
    # traction
    power_notches: float
    traction_force_max_n: float
    traction_power_max_w: float
    traction_weak_field_speed_mps: Annotated[float, "above it force falls with the square of speed; 0: never"]
    traction_notch_share: Annotated[list[float], NOTCHES_MAX, "share of the full-notch force, index = notch"]
    traction_speed_cap_mps: Annotated[list[float], NOTCHES_MAX, "a notch pulls up to this speed; 0: no cap"]
    traction_dead_time_s: float
    traction_lag_s: float
    traction_jerk_max_mps3: float
    traction_load_compensated: Annotated[
        float, "1: the force limit grows with the load, as force per mass at empty"
    ]
    traction_curve_points: Annotated[
        float, "0: force and power limits above; else the measured curve below replaces them"
    ]
    traction_curve_step_mps: float
    traction_curve_n: Annotated[list[float], CURVE_POINTS_MAX, "full-notch force at index * step"]
    motors: float
    motored_axle_mass_share: Annotated[float, "share of the weight on driven axles, for the adhesion limit"]
    # brakes: nominal deceleration of each service notch at any load (load compensation)
    brake_notches: float
    brake_deceleration_mps2: Annotated[list[float], NOTCHES_MAX, "index = notch"]
    brake_stepless: Annotated[float, "1: fractional notches are allowed"]
    emergency_deceleration_mps2: float
    brake_dead_time_s: float
    brake_lag_s: float
    brake_jerk_max_mps3: float
    emergency_dead_time_s: float
    emergency_lag_s: float
    # regenerative part of the service brake; the air brake supplies the rest
    regenerative_force_max_n: float
    regenerative_power_max_w: float
    regenerative_fade_from_mps: float
    regenerative_fade_to_mps: float
    # energy at the wire
    efficiency_traction: float
    efficiency_regeneration: float
    auxiliary_power_w: float
    # losses of one motor, its inverter and its gear in place of the two efficiencies, see vehicle.losses
    losses_given: Annotated[float, "1: these hold; 0: the efficiencies above"]
    loss_base_speed_mps: Annotated[float, "full flux up to it; above, flux falls as 1 / speed"]
    loss_force_n: Annotated[float, "of one motor, to which copper and inverter losses refer"]
    loss_standby_w: float
    loss_magnetising_w: float
    loss_hysteresis_w: float
    loss_eddy_w: float
    loss_inverter_w: float
    loss_copper_w: float
    loss_gear_share: float
    motors_cut_out: Annotated[float, "1: as many motors run as lose least; 0: all in service"]
    magnetised_coasting: Annotated[float, "1: motors stay magnetised when the train coasts"]
    # limits
    speed_max_mps: float
    adhesion_dry: float
    adhesion_speed_factor_s_per_m: Annotated[float, "adhesion = dry / (1 + factor * v)"]
    wheel_slide_share_max: Annotated[
        float, "deepest slide the protection allows, share of train speed; 1: may lock"
    ]
    # sensors on the axle
    wheel_diameter_m: float
    pulses_per_revolution: float


TRAIN: Final = dtype_of(TrainRow)


class PlantRow(Protocol):
    """The state of one train's body and machinery, changed in place."""

    load_share: Annotated[float, "0 empty, 1 full"]
    adhesion_factor: Annotated[float, "1 dry; the weather, set by the scenario"]
    brake_factor: Annotated[float, "real over nominal service brake deceleration"]
    emergency_factor: Annotated[float, "real over nominal emergency brake deceleration"]
    motors_share: Annotated[float, "of the motors in service; 1: all"]
    source_gives_w: Annotated[float, "what wire or battery can give now, auxiliaries among it; +inf: all"]
    source_takes_w: Annotated[
        float, "what it can take back now beside the train's own auxiliaries; +inf: all"
    ]
    travelled_m: Annotated[float, "distance run since the record was made, by the trapezoid"]
    speed_mps: float
    acceleration_mps2: float
    wheel_travelled_m: Annotated[float, "what the tachometer's axle rolled, slip and slide included"]
    wheel_speed_mps: float
    last_wheel_speed_mps: Annotated[float, "of the last axle, on rail that the others have cleaned"]
    last_axle_released: Annotated[
        int, "1: slide protection has let it go, so that it shows the train's speed"
    ]
    traction_force_n: Annotated[float, "after lag, jerk limit and adhesion"]
    traction_built_n: Annotated[float, "after lag and jerk limit, before adhesion"]
    service_deceleration_mps2: Annotated[float, "built-up service brake, before adhesion"]
    emergency_deceleration_mps2: float
    regenerative_force_n: float
    air_force_n: float
    sliding: Annotated[int, "1: adhesion exceeded in this step"]
    energy_traction_j: Annotated[float, "drawn by motors and inverters, at the wire or battery"]
    energy_regenerated_j: Annotated[float, "given back there"]
    energy_auxiliary_j: float
    # where it went: traction - regenerated = kinetic + ... + regeneration_loss, to rounding and the step that stops
    energy_kinetic_j: Annotated[float, "change of kinetic energy, of what turns too"]
    energy_resistance_j: Annotated[float, "running and starting resistance"]
    energy_gradient_j: Annotated[float, "lifted; < 0 downhill"]
    energy_curve_j: float
    energy_friction_j: Annotated[float, "taken by the air brake"]
    energy_traction_loss_j: Annotated[float, "in motors and inverters that pull or coast"]
    energy_regeneration_loss_j: Annotated[float, "in motors and inverters that brake"]
    energy_rejected_j: Annotated[float, "could have been given back, but the source did not take it"]
    command_head: Annotated[int, "ring buffers of commands, one entry a step, for the dead times"]
    command_notch: Annotated[list[float], COMMAND_DELAY_STEPS_MAX, "> 0 power, < 0 brake, 0 coast"]
    command_emergency: Annotated[list[int], COMMAND_DELAY_STEPS_MAX]


PLANT: Final = dtype_of(PlantRow)
