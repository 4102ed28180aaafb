"""The stop sign (停止位置目標) as a fix of the position: what one frame of the camera says of the train's front.

Invariant: the true front lies within the interval of the fix, while the camera pitches no more than assumed.

The distance comes from the sign's row in the image, so pitch matters: d(distance) = distance^2 / height * pitch,
the height being that of the lens over the sign (Oda, 3.2.2, figure 16).
"""

from __future__ import annotations

from typing import Final

from onboard.localisation.fix import Fix, FixSource
from onboard.records import UnitRow
from vehicle.compiled import compiled

PITCH_BOUND_RAD: Final = 2.0e-3  # assumed: over six times the pitch that vibration gives the line camera
LENS_OVER_SIGN_M: Final = 1.8  # of that camera and its sign
FLOOR_M: Final = 0.1  # rounding to pixels, and the sign's own place
EXPOSED_WITHIN_S: Final = 0.02  # the picture shows a moment at most this long after its start
SIGN_BEYOND_MARK_M: Final = 10.0  # the sign stands this far behind the mark, so that it is seen to the end
NOT_SEEN_M: Final = 20.0  # this near the mark without any sighting the sign counts as not seen


@compiled
def accuracy_m(distance_m: float, speed_mps: float) -> float:
    """How wrong one frame may be, m, at a distance to the sign and a speed."""
    return FLOOR_M + PITCH_BOUND_RAD / LENS_OVER_SIGN_M * distance_m**2 + EXPOSED_WITHIN_S * speed_mps


@compiled
def front_by_sign(row: UnitRow, sign_m: float, distance_m: float) -> tuple[float, float]:
    """Where the front is (m) by a sign at `sign_m` seen `distance_m` ahead, and within what (m either way)."""
    return sign_m - distance_m, accuracy_m(distance_m, row.train_mps)


@compiled
def sign_is_missing(mark_m: float, position_m: float) -> bool:
    """Whether a train that has not seen the sign of its mark (m) yet must count it as not seen."""
    return mark_m - position_m < NOT_SEEN_M


def sign_fix(row: UnitRow, mark_m: float, distance_m: float) -> Fix:
    """What a frame says that shows the sign of the mark at `mark_m` (path coordinate) `distance_m` ahead."""
    position_m, slack_m = front_by_sign(row, mark_m + SIGN_BEYOND_MARK_M, distance_m)
    return Fix(float(position_m), float(slack_m), float(slack_m), FixSource.SIGN)
