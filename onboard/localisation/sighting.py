"""The stop sign (停止位置目標) as a fix of the position: what one frame of the camera says of the train's front.

Invariant: a sighting moves the estimate inside the bounds and never the bounds. A camera can be deceived and can fail
to see: safety depends on tags and wheels, and sightings decide where the train stops at its mark.

A sighting is valid while the camera pitches no more than assumed. One that contradicts the sightings before it is
refused; after the third in a row the estimate starts again. The distance comes from the sign's row in the image, so
pitch matters: d(distance) = distance^2 / height * pitch, with the height of the lens over the sign (Oda, 3.2.2, figure
16).
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

import numpy as np

from onboard.localisation.fix import MISSED, NOTHING, REFUSED, TAKEN, missed_m, move_estimate
from onboard.records import Chart, UnitRow
from vehicle.compiled import compiled, compiled_when_called

PITCH_BOUND_RAD: Final = 2.0e-3  # assumed: over six times the pitch that vibration gives the line camera
LENS_OVER_SIGN_M: Final = 1.8  # of that camera and its sign
FLOOR_M: Final = 0.1  # rounding to pixels, and the sign's own place
EXPOSED_WITHIN_S: Final = 0.02  # the picture shows a moment at most this long after its start
SIGN_BEYOND_MARK_M: Final = 10.0  # the sign stands this far behind the mark, so that it is seen to the end
CONTRADICTIONS: Final = 3  # sightings in a row that contradict the estimate, and it begins anew: it was wrong
NOT_SEEN_M: Final = 20.0  # this near the mark without any sighting the sign counts as not seen


class SignReading(Protocol):
    """What the camera shows."""

    taken: Annotated[int, "1: it took a frame in this step"]
    distance_m: Annotated[float, "from the front to the sign; +inf: the frame shows none"]


class SignRow(Protocol):
    """What the unit keeps of the sign that it goes by."""

    mark_m: Annotated[float, "path coordinate of the mark where it is to stop; +inf: none"]
    seen: Annotated[int, "1: the sign of that mark has been seen"]
    slack_m: Annotated[float, "what the estimate may be wrong by if all sightings so far were true"]
    bounds_m: Annotated[float, "half of what the bounds spanned at the last step"]
    contradictions: Annotated[int, "sightings in a row that were not where they could be by that"]


@compiled
def accuracy_m(distance_m: float, speed_mps: float) -> float:
    """How wrong one frame may be, m, at a distance to the sign and a speed, if the picture counts as its start."""
    pitch_m = PITCH_BOUND_RAD / LENS_OVER_SIGN_M * distance_m * distance_m
    return FLOOR_M + pitch_m + EXPOSED_WITHIN_S * speed_mps


@compiled
def front_by_sign(row: UnitRow, sign_m: float, distance_m: float) -> tuple[float, float]:
    """Where the front is (m) by a sign at `sign_m` seen `distance_m` ahead, and within what (m either way)."""
    return sign_m - distance_m, accuracy_m(distance_m, row.train_mps) + row.pulse_m


@compiled
def front_by_frame(row: UnitRow, sign_m: float, distance_m: float) -> tuple[float, float]:
    """The same at the frame's start, with the way run until the middle of the time in which rows are exposed."""
    front_m, within_m = front_by_sign(row, sign_m, distance_m)
    middle_m = 0.5 * EXPOSED_WITHIN_S * row.train_mps
    return front_m - middle_m, within_m - middle_m


class LeaningRow(Protocol):
    """What a reader keeps that moves the estimate alone."""

    slack_m: float
    bounds_m: float


@compiled
def carry_slack(own: LeaningRow, unit: UnitRow) -> None:
    """What widens the bounds widens what sightings have come to; what cuts them has set the estimate anew."""
    half_m = (unit.bound_ahead_m + unit.bound_behind_m) / 2.0
    wider_m = half_m - own.bounds_m
    own.slack_m = half_m if wider_m < 0.0 else min(own.slack_m + wider_m, half_m)
    own.bounds_m = half_m


def begin_slack(own: SignRow, unit: UnitRow, slack_m: float) -> None:
    """The estimate is as good as the tag just believed says, m, whatever the bounds span besides (decision 035)."""
    own.bounds_m = (unit.bound_ahead_m + unit.bound_behind_m) / 2.0
    own.slack_m = min(slack_m, own.bounds_m)


@compiled_when_called
def sign_sighted(own: SignRow, unit: UnitRow, front_m: float, within_m: float) -> int:
    """One frame that shows a sign, so that the front is at `front_m` or within so much of it.

    TAKEN, or REFUSED where it contradicts the bounds or the sightings before it.
    """
    if not missed_m(unit, front_m, within_m, within_m) <= 0.0:
        return REFUSED
    if abs(front_m - unit.position_m) > own.slack_m + within_m:
        own.contradictions += 1
        if own.contradictions < CONTRADICTIONS:
            return REFUSED
        own.slack_m = unit.bound_ahead_m + unit.bound_behind_m
    own.contradictions = 0
    own.slack_m = move_estimate(unit, own.slack_m, front_m, within_m)
    return TAKEN


@compiled
def sign_is_missing(mark_m: float, position_m: float) -> bool:
    """Whether a train that has not seen the sign of its mark (m) yet must count it as not seen."""
    return mark_m - position_m < NOT_SEEN_M


@compiled
def sign(own: SignRow, reading: SignReading, unit: UnitRow, _chart: Chart, _step_s: float) -> int:
    """A frame that shows the sign of the next mark is a fix; near the mark without any, the sign was missed."""
    carry_slack(own, unit)
    if reading.taken == 0 or not np.isfinite(own.mark_m):
        return NOTHING
    outcome = NOTHING
    if np.isfinite(reading.distance_m) and unit.position_known == 1:
        front_m, within_m = front_by_frame(unit, own.mark_m + SIGN_BEYOND_MARK_M, reading.distance_m)
        outcome = sign_sighted(own, unit, front_m, within_m)
    if outcome == TAKEN:
        own.seen = 1
    if own.seen == 0 and sign_is_missing(own.mark_m, unit.position_m):
        outcome = MISSED
    return outcome
