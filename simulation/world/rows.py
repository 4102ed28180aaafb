"""Type of one record of TRUTH as compiled laws see it; a test ties it to the record."""

from __future__ import annotations

from typing import Protocol


class TruthRow(Protocol):
    """One record of TRUTH: where a train really is."""

    active: int
    position_m: float
    offset_m: float
    profile_offset: int
    profile_rows: int
    front_boundary_m: float
    rear_boundary_m: float
    tag_next: int
    tag_end: int
    odometer_at_tag_m: float
    wheel_factor: float
    odometer_m: float
    tachometer_gain: float
    tachometer_frozen_mps: float
    sight_m: float
    camera_m: float
    events: int
