"""Markers as a fix and as a speed, from the LiDAR, five times a step.

Invariant: a fix is taken only from a pattern that the map has at a possible place of the train. If the train could also
be at another group, or does not know where it is, the pattern is believed once the group read before it lies as far
away as the wheels have counted; until then it has no effect. So neither a misread pattern nor one laid in the wrong
place moves the estimate off the truth, unless two of them are wrong in the same way.

The interval of a fix covers the shift of points by a speed that is wrong by at most SEEN_WITHIN_MPS, over half the time
that points are kept and since the cycle; the scatter of the first row; and the error of the markers' places. Mochizuki,
Kudo and Yamaguchi, sections 2 and 3. The speed does not come from the wheels; while they slide it limits the assumed
speed of the train (`onboard.localisation.tachometer`).
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

import numpy as np

from onboard.localisation.fix import MISSED, NOTHING, REFUSED, fix_by_rule, missed_m
from onboard.localisation.lidar_points import (
    CYCLE_S,
    FARTHEST_M,
    FILLED,
    KEPT_S,
    MEANS,
    NEAREST_M,
    READ_FROM_M,
    SPOTS,
    SpeedRow,
    detect,
)
from onboard.localisation.marker_patterns import HALF_M, UNREAD
from onboard.records import PLACE_MARKERS, Chart, UnitRow
from vehicle.compiled import compiled, compiled_when_called

SETBACK_M: Final = 0.5  # of the LiDAR behind the train's front
NOISE_WITHIN_MPS: Final = 1.0  # by which a filled mean may be wrong; held against scans by a test
LAG_S: Final = (MEANS - 1) * CYCLE_S + 0.5 * KEPT_S  # by which both means and the points kept are late
HARDEST_MPS2: Final = 1.5  # assumed: no train here brakes or gains faster
SEEN_WITHIN_MPS: Final = NOISE_WITHIN_MPS + LAG_S * HARDEST_MPS2
ROW_WITHIN_M: Final = 0.03  # of the first row, beyond what the speed does: five sigmas of scans
LAID_WITHIN_M: Final = 0.05  # assumed: markers lie within so much of where the map has them
PASSED_BY_M: Final = 2.0  # so far behind the surely passed front a group that has not been read is missed
AGREES_SHARE: Final = 0.02  # of the way between two groups that wheels may count wrongly


class LidarReading(Protocol):
    """What the LiDAR's points on the next markers come to, at SPOTS moments of the step; the last is its end."""

    looks: Annotated[int, "1: there are markers to be seen"]
    pattern: Annotated[int, "that its points show where they show any; 0: none"]
    mean_m: Annotated[list[float], SPOTS, "distance from the LiDAR to their middle; -1: no point"]
    run_m: Annotated[list[float], SPOTS, "by which points have moved from the oldest to the newest"]
    row_m: Annotated[list[float], SPOTS, "distance of the first row, by points that have been moved by that"]
    bears_m: Annotated[
        list[float], SPOTS, "by how much they may be moved wrongly and still show it; -1: not at all"
    ]


class LidarRow(Protocol):
    """What the unit keeps of its LiDAR."""

    fitted: Annotated[int, "1: the train has one"]
    speed: Annotated[SpeedRow, "as it is detected and smoothed"]
    path: Annotated[int, "number of the path that the following belongs to"]
    expected_m: Annotated[float, "first row of the markers that come next; +inf: none"]
    read_m: Annotated[float, "first row of those read last; -inf: none"]
    doubted: Annotated[int, "pattern that waits for another one to agree; 0: none"]
    doubted_front_m: Annotated[float, "how far the front was before its first row"]
    doubted_at_m: Annotated[float, "what the tachometer had counted then"]


@compiled
def see_nothing(own: SpeedRow) -> None:
    """There is nothing to be seen: the means hold zeros, as after so many cycles without a point."""
    own.last_m, own.cycles, own.detected_mps, own.speed_mps = -1.0, 0, 0.0, 0.0
    for k in range(MEANS):
        own.detected[k] = own.smoothed[k] = 0.0


@compiled
def next_markers_m(unit: UnitRow, chart: Chart, beyond_m: float) -> float:
    """The first row (path coordinate, m) of the markers that come next after a place."""
    for k in range(unit.places_offset, unit.places_offset + unit.places_rows):
        place = chart.places[k]
        if place.kind == PLACE_MARKERS and place.position_m > beyond_m:
            return float(place.position_m)
    return np.inf


@compiled_when_called
def begin_path(own: LidarRow, unit: UnitRow, chart: Chart) -> None:
    """On another path: no coordinate holds; markers that are too near to be read are not waited for."""
    own.path = unit.paths_taken_up
    own.doubted, own.read_m = UNREAD, -np.inf
    own.expected_m = next_markers_m(
        unit, chart, unit.position_m + unit.bound_ahead_m + FARTHEST_M + SETBACK_M
    )


@compiled
def read_spot(reading: LidarReading, k: int, speed_mps: float) -> bool:
    """Whether points that are moved by this speed show their pattern, between READ_FROM_M and NEAREST_M."""
    if reading.mean_m[k] < 0.0 or reading.pattern == UNREAD:
        return False
    spread_m = reading.run_m[k] - speed_mps * KEPT_S
    middle_m = reading.row_m[k] + HALF_M + 0.5 * spread_m
    return bool(NEAREST_M <= middle_m <= READ_FROM_M and abs(spread_m) <= reading.bears_m[k])


@compiled
def told_apart(
    own: LidarRow, unit: UnitRow, chart: Chart, pattern: int, ahead_m: float, within_m: float
) -> float:
    """First row (path coordinate, m) of the markers that are read `ahead_m` before the front; nan: not believed.

    Keeps what is not believed yet, for the next group to agree with.
    """
    here = others = 0
    place_m, agreed_m, agreeing = np.nan, np.nan, 0
    for k in range(unit.places_offset, unit.places_offset + unit.places_rows):
        place = chart.places[k]
        if place.kind != PLACE_MARKERS:
            continue
        fits = missed_m(unit, place.position_m - ahead_m, within_m, within_m) <= 0.0
        if place.number != pattern:
            others += 1 if fits else 0
            continue
        if fits:
            here += 1
            place_m = place.position_m
            if agrees(own, unit, chart, place.position_m, place.position_m - ahead_m, within_m):
                agreeing += 1
                agreed_m = place.position_m
    own.doubted, own.doubted_front_m, own.doubted_at_m = pattern, ahead_m, unit.odometer_m
    if unit.position_known == 1 and here == 1 and others == 0:
        own.doubted = UNREAD
        return float(place_m)
    return float(agreed_m) if agreeing == 1 else np.nan


@compiled
def agrees(
    own: LidarRow, unit: UnitRow, chart: Chart, place_m: float, front_m: float, within_m: float
) -> bool:
    """Whether the group in doubt, another than that at `place_m`, lies as far back as the wheels have counted since."""
    run_m = (unit.odometer_m - own.doubted_at_m) * unit.odometer_scale
    if own.doubted == UNREAD or run_m <= 0.0:
        return False
    for k in range(unit.places_offset, unit.places_offset + unit.places_rows):
        place = chart.places[k]
        if place.kind == PLACE_MARKERS and place.number == own.doubted and place.position_m < place_m:
            away_m = front_m - (place.position_m - own.doubted_front_m) - run_m
            if abs(away_m) <= AGREES_SHARE * run_m + 2.0 * within_m:
                return True
    return False


@compiled
def lidar(own: LidarRow, reading: LidarReading, unit: UnitRow, chart: Chart, _step_s: float) -> int:
    """Markers in sight give a speed; a pattern read near enough gives a fix; a group passed unread was missed."""
    if own.fitted == 0:
        return NOTHING
    if own.path != unit.paths_taken_up:
        begin_path(own, unit, chart)
    unit.seen_within_mps = 0.0
    outcome = NOTHING
    if reading.looks == 0:
        if own.speed.cycles > 0 or own.speed.speed_mps > 0.0:
            see_nothing(own.speed)
    else:
        outcome = take_points(own, reading, unit, chart)
    if unit.position_known == 1 and unit.position_m - unit.bound_behind_m > own.expected_m + PASSED_BY_M:
        if outcome == NOTHING and own.read_m != own.expected_m:
            outcome = MISSED
        own.expected_m = next_markers_m(unit, chart, own.expected_m)
    return outcome


@compiled_when_called
def take_points(own: LidarRow, reading: LidarReading, unit: UnitRow, chart: Chart) -> int:
    """Take one step's points: the speed, and the fix of the last moment at which the pattern shows."""
    ahead_m, age_s = np.nan, 0.0
    for k in range(SPOTS):
        mean_m = reading.mean_m[k]
        detect(own.speed, mean_m if NEAREST_M <= mean_m <= FARTHEST_M else -1.0)
        settled = own.speed.cycles >= FILLED
        if settled and read_spot(reading, k, own.speed.speed_mps):
            age_s = (SPOTS - 1 - k) * CYCLE_S
            spread_m = reading.run_m[k] - own.speed.speed_mps * KEPT_S
            ahead_m = reading.row_m[k] + 0.5 * spread_m - SETBACK_M - own.speed.speed_mps * age_s
    if own.speed.cycles >= FILLED:
        unit.seen_speed_mps, unit.seen_within_mps = own.speed.speed_mps, SEEN_WITHIN_MPS
    if not np.isfinite(ahead_m):
        return NOTHING
    within_m = SEEN_WITHIN_MPS * (0.5 * KEPT_S + age_s) + ROW_WITHIN_M + LAID_WITHIN_M
    place_m = told_apart(own, unit, chart, reading.pattern, ahead_m, within_m)
    if not np.isfinite(place_m):
        return REFUSED
    own.read_m = place_m
    return fix_by_rule(unit, place_m - ahead_m, within_m, within_m)
