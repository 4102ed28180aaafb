"""The records that compiled code works on: one row a train, field names carry their units.

Structured arrays instead of objects, because a day is some 650,000 steps and the laws of motion are compiled
(numba reads `row.speed_mps` as it stands). `TRAIN` holds what does not change during a run, `PLANT` the state
of one train's body and machinery. `vehicle.train_file.load_train` fills a TRAIN row.
"""

from __future__ import annotations

from typing import Final

import numpy as np

NOTCHES_MAX: Final = 16
COMMAND_DELAY_STEPS_MAX: Final = 64
CURVE_POINTS_MAX: Final = 128

TRAIN: Final = np.dtype(
    [
        # body
        ("length_m", "f8"),
        ("mass_empty_kg", "f8"),
        ("mass_load_full_kg", "f8"),
        ("rotating_mass_factor", "f8"),  # equivalent mass = mass * (1 + factor)
        ("cars", "f8"),
        ("motored_mass_share", "f8"),  # share of the mass on motored cars, for JIS running resistance
        # running resistance R[N] = sum of mass terms and the air term, see vehicle.resistance
        ("resistance_motored_constant_n_per_kn", "f8"),
        ("resistance_motored_linear_n_per_kn_kmh", "f8"),
        ("resistance_trailer_constant_n_per_kn", "f8"),
        ("resistance_trailer_linear_n_per_kn_kmh", "f8"),
        ("resistance_air_n_per_kmh2", "f8"),
        ("starting_resistance_n_per_kn", "f8"),
        ("curve_resistance_coefficient_m", "f8"),  # permille = coefficient / radius
        # traction
        ("power_notches", "f8"),
        ("traction_force_max_n", "f8"),
        ("traction_power_max_w", "f8"),
        ("traction_weak_field_speed_mps", "f8"),  # above it force falls with the square of speed; 0: never
        ("traction_notch_share", "f8", (NOTCHES_MAX,)),  # share of the full-notch force, index = notch
        ("traction_speed_cap_mps", "f8", (NOTCHES_MAX,)),  # a notch pulls up to this speed; 0: no cap
        ("traction_dead_time_s", "f8"),
        ("traction_lag_s", "f8"),
        ("traction_jerk_max_mps3", "f8"),
        (
            "traction_load_compensated",
            "f8",
        ),  # 1: the force limit grows with the load, as force per mass at empty
        (
            "traction_curve_points",
            "f8",
        ),  # 0: force and power limits above; else the measured curve below replaces them
        ("traction_curve_step_mps", "f8"),
        ("traction_curve_n", "f8", (CURVE_POINTS_MAX,)),  # full-notch force at index * step
        ("motors", "f8"),
        ("motored_axle_mass_share", "f8"),  # share of the weight on driven axles, for the adhesion limit
        # brakes: nominal deceleration of each service notch at any load (load compensation)
        ("brake_notches", "f8"),
        ("brake_deceleration_mps2", "f8", (NOTCHES_MAX,)),  # index = notch
        ("brake_stepless", "f8"),  # 1: fractional notches are allowed
        ("emergency_deceleration_mps2", "f8"),
        ("brake_dead_time_s", "f8"),
        ("brake_lag_s", "f8"),
        ("brake_jerk_max_mps3", "f8"),
        ("emergency_dead_time_s", "f8"),
        ("emergency_lag_s", "f8"),
        # regenerative part of the service brake; the air brake supplies the rest
        ("regenerative_force_max_n", "f8"),
        ("regenerative_power_max_w", "f8"),
        ("regenerative_fade_from_mps", "f8"),
        ("regenerative_fade_to_mps", "f8"),
        # energy at the wire
        ("efficiency_traction", "f8"),
        ("efficiency_regeneration", "f8"),
        ("auxiliary_power_w", "f8"),
        # limits
        ("speed_max_mps", "f8"),
        ("adhesion_dry", "f8"),
        ("adhesion_speed_factor_s_per_m", "f8"),  # adhesion = dry / (1 + factor * v)
        (
            "wheel_slide_share_max",
            "f8",
        ),  # deepest slide the protection allows, share of train speed; 1: may lock
        # sensors on the axle
        ("wheel_diameter_m", "f8"),
        ("pulses_per_revolution", "f8"),
    ],
    align=True,
)

PLANT: Final = np.dtype(
    [
        ("load_share", "f8"),  # 0 empty, 1 full
        ("adhesion_factor", "f8"),  # 1 dry; the weather, set by the scenario
        ("brake_factor", "f8"),  # real over nominal service brake deceleration
        ("travelled_m", "f8"),  # distance run since the record was made, by the trapezoid
        ("speed_mps", "f8"),
        ("acceleration_mps2", "f8"),
        ("wheel_travelled_m", "f8"),  # what the tachometer's axle rolled, slip and slide included
        ("wheel_speed_mps", "f8"),
        ("traction_force_n", "f8"),  # after lag, jerk limit and adhesion
        ("traction_built_n", "f8"),  # after lag and jerk limit, before adhesion
        ("service_deceleration_mps2", "f8"),  # built-up service brake, before adhesion
        ("emergency_deceleration_mps2", "f8"),
        ("regenerative_force_n", "f8"),
        ("air_force_n", "f8"),
        ("sliding", "i8"),  # 1: adhesion exceeded in this step
        ("energy_traction_j", "f8"),  # at the wire
        ("energy_regenerated_j", "f8"),
        ("energy_auxiliary_j", "f8"),
        ("command_head", "i8"),  # ring buffers of commands, one entry a step, for the dead times
        ("command_notch", "f8", (COMMAND_DELAY_STEPS_MAX,)),  # > 0 power, < 0 brake, 0 coast
        ("command_emergency", "i8", (COMMAND_DELAY_STEPS_MAX,)),
    ],
    align=True,
)
