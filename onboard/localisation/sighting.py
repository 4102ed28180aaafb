"""The stop sign (停止位置目標) as a fix of the position: what one frame of the camera says of the train's front.

Invariant: an interval that holds the true front, cut with another one that holds it, still does. A frame whose
interval misses the present one is not believed.

The distance comes from the sign's row in the image, so pitch matters: d(distance) = distance^2 / height * pitch,
the height being that of the lens over the sign (Oda, 3.2.2, figure 16).
"""

from __future__ import annotations

from typing import Final

from onboard.records import UnitRow

PITCH_BOUND_RAD: Final = 2.0e-3  # assumed: over six times the pitch that vibration gives the line camera
LENS_OVER_SIGN_M: Final = 1.8  # of that camera and its sign
FLOOR_M: Final = 0.1  # rounding to pixels, and the sign's own place
EXPOSED_WITHIN_S: Final = 0.02  # the picture shows a moment at most this long after its start
SIGN_BEYOND_MARK_M: Final = 10.0  # the sign stands this far behind the mark, so that it is seen to the end
NOT_SEEN_M: Final = 20.0  # this near the mark without any sighting the sign counts as not seen


def accuracy_m(distance_m: float, speed_mps: float) -> float:
    """How wrong one frame may be, m, at a distance to the sign and a speed."""
    return FLOOR_M + PITCH_BOUND_RAD / LENS_OVER_SIGN_M * distance_m**2 + EXPOSED_WITHIN_S * speed_mps


def take_sighting(row: UnitRow, mark_m: float, distance_m: float) -> float | None:
    """Correct the position by a frame that shows the sign of the mark at `mark_m` (path coordinate) `distance_m` ahead.

    Returns the correction, m; None where the frame is not believed or the position is unknown. The new estimate
    lies between the two, weighted by the squares of what each may be wrong by.
    """
    if row.position_known == 0:
        return None
    seen_m = mark_m + SIGN_BEYOND_MARK_M - distance_m
    slack_m = accuracy_m(distance_m, row.train_mps)
    rear_m = max(row.position_m - row.bound_behind_m, seen_m - slack_m)
    front_m = min(row.position_m + row.bound_ahead_m, seen_m + slack_m)
    if front_m < rear_m:
        return None
    own_m = (row.bound_ahead_m + row.bound_behind_m) / 2.0
    weight = own_m**2 / (own_m**2 + slack_m**2)
    before_m = row.position_m
    estimate_m = min(max(before_m + weight * (seen_m - before_m), rear_m), front_m)
    row.position_m = estimate_m
    row.bound_ahead_m = front_m - estimate_m
    row.bound_behind_m = estimate_m - rear_m
    row.fix_correction_m += estimate_m - before_m
    return float(estimate_m - before_m)
