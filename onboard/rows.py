"""Types of one record of UNIT, PATTERN and BEHAVIOUR as compiled laws see them; a test ties them to the records."""

from __future__ import annotations

from typing import Protocol


class UnitRow(Protocol):
    """One record of UNIT: what the on-board unit believes and decides."""

    position_m: float
    bound_ahead_m: float
    bound_behind_m: float
    bound_growth: float
    position_known: int
    odometer_m: float
    odometer_scale: float
    tachometer_doubt_s: float
    wheel_slide: int
    speed_mps: float
    train_mps: float
    acceleration_mps2: float
    expected_tag_m: float
    tag_window_m: float
    stop_limit_m: float
    restricted_mps: float
    permitted_mps: float
    intervention: int
    mode: int
    target_stop_m: float
    cruise_mps: float
    target_mps: float
    braking_to_stop: int
    fix_correction_m: float
    stop_verdict: int
    notch: float
    notch_held_s: float
    emergency: int
    rear_trigger_m: float
    position_trigger_m: float
    path_offset: int
    path_rows: int


class PathRow(Protocol):
    """One metre of the path database."""

    elevation_m: float
    body_elevation_m: float
    permitted_mps: float
    driving_mps: float


class BehaviourRow(Protocol):
    """One record of BEHAVIOUR: how a unit drives and supervises."""

    service_guaranteed_mps2: float
    service_reaction_s: float
    emergency_guaranteed_mps2: float
    emergency_reaction_s: float
    service_margin_mps: float
    release_margin_mps: float
    emergency_margin_mps: float
    driving_margin_mps: float
    stop_deceleration_mps2: float
    stop_gain_per_s: float
    cruise_gain_per_s: float
    notch_hold_s: float
    standing_brake_notch: float
    step_s: float
