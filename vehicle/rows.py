"""Types of one record of TRAIN and PLANT as compiled laws see them; a test ties them to `vehicle.records`.

numba reads a field as an attribute; numpy's own type of a record does not know the names, these do.
"""

from __future__ import annotations

from typing import Protocol


class TrainRow(Protocol):
    """One record of TRAIN: what does not change during a run."""

    length_m: float
    mass_empty_kg: float
    mass_load_full_kg: float
    rotating_mass_factor: float
    cars: float
    motored_mass_share: float
    resistance_motored_constant_n_per_kn: float
    resistance_motored_linear_n_per_kn_kmh: float
    resistance_trailer_constant_n_per_kn: float
    resistance_trailer_linear_n_per_kn_kmh: float
    resistance_air_n_per_kmh2: float
    starting_resistance_n_per_kn: float
    curve_resistance_coefficient_m: float
    power_notches: float
    traction_force_max_n: float
    traction_power_max_w: float
    traction_weak_field_speed_mps: float
    traction_notch_share: list[float]
    traction_speed_cap_mps: list[float]
    traction_dead_time_s: float
    traction_lag_s: float
    traction_jerk_max_mps3: float
    traction_load_compensated: float
    traction_curve_points: float
    traction_curve_step_mps: float
    traction_curve_n: list[float]
    motors: float
    motored_axle_mass_share: float
    brake_notches: float
    brake_deceleration_mps2: list[float]
    brake_stepless: float
    emergency_deceleration_mps2: float
    brake_dead_time_s: float
    brake_lag_s: float
    brake_jerk_max_mps3: float
    emergency_dead_time_s: float
    emergency_lag_s: float
    regenerative_force_max_n: float
    regenerative_power_max_w: float
    regenerative_fade_from_mps: float
    regenerative_fade_to_mps: float
    efficiency_traction: float
    efficiency_regeneration: float
    auxiliary_power_w: float
    speed_max_mps: float
    adhesion_dry: float
    adhesion_speed_factor_s_per_m: float
    wheel_slide_share_max: float
    wheel_diameter_m: float
    pulses_per_revolution: float


class PlantRow(Protocol):
    """One record of PLANT: the state of one train's body and machinery, changed in place."""

    load_share: float
    adhesion_factor: float
    brake_factor: float
    travelled_m: float
    speed_mps: float
    acceleration_mps2: float
    wheel_travelled_m: float
    wheel_speed_mps: float
    traction_force_n: float
    traction_built_n: float
    service_deceleration_mps2: float
    emergency_deceleration_mps2: float
    regenerative_force_n: float
    air_force_n: float
    sliding: int
    energy_traction_j: float
    energy_regenerated_j: float
    energy_auxiliary_j: float
    command_head: int
    command_notch: list[float]
    command_emergency: list[int]
