"""The on-board unit's fast state: one row a train, read and written by compiled code every step.

Positions are path coordinates (m, growing in the direction of travel) of the train's front. Everything here is
what the unit believes; the truth is elsewhere and never read.
"""

from __future__ import annotations

from typing import Final

import numpy as np

# what the compiled tick reports to the unit's event-driven part (bits)
EVENT_STOPPED: Final = 1
EVENT_SAFE_REAR: Final = 2  # the safe rear end passed `rear_trigger_m`
EVENT_INTERVENTION: Final = 4  # supervision began or ended a brake application
EVENT_TAG_OVERDUE: Final = 8  # the expected tag was not read within its window
EVENT_MOVING: Final = 16  # the train began to move
EVENT_POSITION: Final = 32  # the position passed `position_trigger_m`
EVENT_TACHOMETER: Final = 64  # the tachometer shows what cannot be
EVENT_VERDICT: Final = 128  # the stop at the mark has turned out impossible: `stop_verdict`

# unit.mode
MODE_HOLD: Final = 0  # stand with the brakes applied
MODE_DRIVE: Final = 1  # drive to `target_stop_m`

# unit.intervention
NO_INTERVENTION: Final = 0
SERVICE_INTERVENTION: Final = 1
EMERGENCY_INTERVENTION: Final = 2

UNIT: Final = np.dtype(
    [
        # localisation
        ("position_m", "f8"),
        ("bound_ahead_m", "f8"),  # the front is at most this far ahead of position_m
        ("bound_behind_m", "f8"),
        ("bound_growth", "f8"),  # m of bound per m run
        ("position_known", "i8"),
        ("odometer_m", "f8"),  # tachometer reading at the last tick
        ("odometer_scale", "f8"),  # calibration against the distance between tags
        ("tachometer_doubt_s", "f8"),  # for how long its readings have not fitted what was commanded
        ("wheel_slide", "i8"),  # from the slide protection: -1 slides, 1 slips, 0 rolls
        ("speed_mps", "f8"),
        ("train_mps", "f8"),  # the train's own speed: the wheel's, but while that slides
        ("acceleration_mps2", "f8"),  # smoothed
        ("expected_tag_m", "f8"),  # where the next tag should be read; +inf: none
        ("tag_window_m", "f8"),  # beyond the bounds by this much without reading: overdue
        # authority and supervision
        ("stop_limit_m", "f8"),  # 停止限界: never passed by the front
        ("restricted_mps", "f8"),  # speed ceiling of the operating mode (非常運転); +inf: none
        ("permitted_mps", "f8"),
        ("intervention", "i8"),
        # driving
        ("mode", "i8"),
        ("target_stop_m", "f8"),  # where the front is to stop
        ("cruise_mps", "f8"),
        ("target_mps", "f8"),
        ("braking_to_stop", "i8"),  # latched: the stop pattern has taken over
        ("fix_correction_m", "f8"),  # by which the last fix moved the position; taken up by the next tick
        ("stop_verdict", "i8"),  # onboard.driving.tasc.Verdict
        ("notch", "f8"),  # > 0 power, < 0 brake
        ("notch_held_s", "f8"),
        ("emergency", "i8"),
        ("rear_trigger_m", "f8"),
        ("position_trigger_m", "f8"),
        # where this train's rows of the path database begin, and how many there are
        ("path_offset", "i8"),
        ("path_rows", "i8"),
    ],
    align=True,
)

PATTERN: Final = np.dtype(
    [
        ("elevation_m", "f8"),
        ("body_elevation_m", "f8"),  # mean over the train's length, its front here
        ("permitted_mps", "f8"),  # supervision: speed limits with the brake curves towards them
        ("driving_mps", "f8"),  # automatic driving stays under this one
    ],
    align=True,
)

BEHAVIOUR: Final = np.dtype(
    [
        ("service_guaranteed_mps2", "f8"),
        ("service_reaction_s", "f8"),
        ("emergency_guaranteed_mps2", "f8"),
        ("emergency_reaction_s", "f8"),
        ("service_margin_mps", "f8"),  # service brake when the permitted speed is passed by this
        ("release_margin_mps", "f8"),  # and released this far below it
        ("emergency_margin_mps", "f8"),
        ("driving_margin_mps", "f8"),  # automatic driving stays this far below the limits
        ("stop_deceleration_mps2", "f8"),  # of the target-speed pattern (目標速度パターン)
        ("stop_gain_per_s", "f8"),  # proportional control of the brake
        ("cruise_gain_per_s", "f8"),
        ("notch_hold_s", "f8"),  # a power notch is kept at least this long
        ("standing_brake_notch", "f8"),
        ("step_s", "f8"),
    ],
    align=True,
)
