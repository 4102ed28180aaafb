"""The truth about each train that compiled code works on: one row a train slot.

Never handed to `onboard`: the unit sees what the sensors make of it.
"""

from __future__ import annotations

from typing import Final

import numpy as np

# what the world reports to the event-driven part (bits above those of onboard.records)
EVENT_TAG: Final = 1 << 8  # the front passed a tag
EVENT_FRONT: Final = 1 << 9  # the front passed the end of a track piece
EVENT_REAR: Final = 1 << 10  # the rear passed the end of a track piece
EVENT_CAMERA: Final = 1 << 11  # the front came to where the camera may see the next stop sign
EVENT_UNIT_BITS: Final = (1 << 8) - 1

TRUTH: Final = np.dtype(
    [
        ("active", "i8"),
        ("position_m", "f8"),  # path coordinate of the front, from the carrier
        ("offset_m", "f8"),  # position_m - plant.travelled_m
        ("profile_offset", "i8"),
        ("profile_rows", "i8"),
        ("front_boundary_m", "f8"),  # path coordinate at which the front leaves its piece
        ("rear_boundary_m", "f8"),
        ("tag_next", "i8"),  # row of the tag pool; the next tag ahead
        ("tag_end", "i8"),
        ("odometer_at_tag_m", "f8"),  # latched by the reader when the front passed the tag
        ("wheel_factor", "f8"),  # true circumference over the one the tachometer is set for
        ("odometer_m", "f8"),  # what the tachometer has counted
        ("tachometer_gain", "f8"),  # 1 in order, 0 silent
        ("tachometer_frozen_mps", "f8"),  # shows this speed for ever; negative: in order
        ("sight_m", "f8"),  # where the driver stops on sight while the unit does not know its position
        ("camera_m", "f8"),  # path coordinate from where the next sign may be seen; +inf: none
        ("events", "i8"),
    ],
    align=True,
)

TRACE_EVERY_STEPS: Final = 10  # a sample a second, and one at every event
TRACE: Final = np.dtype(
    [
        ("step", "i8"),
        ("slot", "i8"),
        ("position_m", "f8"),
        ("speed_mps", "f8"),
        ("acceleration_mps2", "f8"),
        ("notch", "f8"),
        ("intervention", "i8"),
        ("permitted_mps", "f8"),
        ("target_mps", "f8"),
        ("stop_limit_m", "f8"),
        ("estimate_error_m", "f8"),
        ("bound_ahead_m", "f8"),
        ("bound_behind_m", "f8"),
    ],
    align=True,
)
