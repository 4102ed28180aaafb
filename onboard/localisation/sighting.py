"""The stop sign (停止位置目標) as a fix of the position: what one frame of the camera says of the train's front.

Invariant: the true front lies within the interval of the fix, while the camera pitches no more than assumed.

The distance comes from the sign's row in the image, so pitch matters: d(distance) = distance^2 / height * pitch,
the height being that of the lens over the sign (Oda, 3.2.2, figure 16).
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

import numpy as np

from onboard.localisation.fix import MISSED, NOTHING, TAKEN, taken
from onboard.records import UnitRow
from vehicle.compiled import compiled

PITCH_BOUND_RAD: Final = 2.0e-3  # assumed: over six times the pitch that vibration gives the line camera
LENS_OVER_SIGN_M: Final = 1.8  # of that camera and its sign
FLOOR_M: Final = 0.1  # rounding to pixels, and the sign's own place
EXPOSED_WITHIN_S: Final = 0.02  # the picture shows a moment at most this long after its start
SIGN_BEYOND_MARK_M: Final = 10.0  # the sign stands this far behind the mark, so that it is seen to the end
NOT_SEEN_M: Final = 20.0  # this near the mark without any sighting the sign counts as not seen


class SignReading(Protocol):
    """What the camera shows."""

    taken: Annotated[int, "1: it took a frame in this step"]
    distance_m: Annotated[float, "from the front to the sign; +inf: the frame shows none"]


class SignRow(Protocol):
    """What the unit keeps of the sign that it goes by."""

    mark_m: Annotated[float, "path coordinate of the mark where it is to stop; +inf: none"]
    seen: Annotated[int, "1: the sign of that mark has been seen"]


@compiled
def accuracy_m(distance_m: float, speed_mps: float) -> float:
    """How wrong one frame may be, m, at a distance to the sign and a speed."""
    pitch_m = PITCH_BOUND_RAD / LENS_OVER_SIGN_M * distance_m * distance_m
    return FLOOR_M + pitch_m + EXPOSED_WITHIN_S * speed_mps


@compiled
def front_by_sign(row: UnitRow, sign_m: float, distance_m: float) -> tuple[float, float]:
    """Where the front is (m) by a sign at `sign_m` seen `distance_m` ahead, and within what (m either way)."""
    return sign_m - distance_m, accuracy_m(distance_m, row.train_mps) + row.pulse_m


@compiled
def sign_is_missing(mark_m: float, position_m: float) -> bool:
    """Whether a train that has not seen the sign of its mark (m) yet must count it as not seen."""
    return mark_m - position_m < NOT_SEEN_M


@compiled
def sign(own: SignRow, reading: SignReading, unit: UnitRow, _step_s: float) -> int:
    """A frame that shows the sign of the next mark is a fix; near the mark without any, the sign was missed."""
    if reading.taken == 0 or not np.isfinite(own.mark_m):
        return NOTHING
    outcome = NOTHING
    if np.isfinite(reading.distance_m) and unit.position_known == 1:
        front_m, slack_m = front_by_sign(unit, own.mark_m + SIGN_BEYOND_MARK_M, reading.distance_m)
        outcome = taken(unit, front_m, slack_m, slack_m)
    if outcome == TAKEN:
        own.seen = 1
    if own.seen == 0 and sign_is_missing(own.mark_m, unit.position_m):
        outcome = MISSED
    return outcome
