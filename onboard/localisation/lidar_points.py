"""What is made of a LiDAR's points on markers: their places moved by the way run since, the train's speed, the pattern.

Mochizuki, Kudo and Yamaguchi, sections 2.3 and 3, tables 2 and 3. Every cycle takes the points of the last `b` seconds.
Speed is the change of their mean distance from one cycle to the next (equation 3, 0 where there is none), twice the
mean of 25 of those (equation 4). With it each point is moved by the way that the train has run since (equation 2).
"""

from __future__ import annotations

from typing import Annotated, Any, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from onboard.localisation.marker_patterns import ROW_M, ROWS, recognised_pattern
from vehicle.compiled import compiled
from vehicle.record import dtype_of

CYCLE_S: Final = 0.02  # T and T_v, table 2
KEPT_S: Final = 0.1  # b and b_v
SPOTS: Final = 5  # cycles in a step of 0.1 s
FARTHEST_M: Final = 30.0  # mean distances at which speed is detected, table 2
NEAREST_M: Final = 5.0
READ_FROM_M: Final = 6.0  # and those at which patterns are read: from here to NEAREST_M
LOOKED_FOR_M: Final = (
    8.0  # over the last of these, before the points are moved: the fastest train runs half that in b
)
MEANS: Final = 25  # n of equation 4: 98 % of the field takes 0.5 s
FILLED: Final = 2 * MEANS - 1  # cycles until both means hold detected speeds only

Floats = NDArray[np.float64]


class SpeedRow(Protocol):
    """The speed as it is detected and smoothed."""

    last_m: Annotated[float, "mean distance one cycle ago; not above 0: there was none"]
    cycles: Annotated[int, "detected in a row"]
    at: Annotated[int, "place in the rings"]
    detected: Annotated[list[float], MEANS, "m/s"]
    smoothed: Annotated[list[float], MEANS, "once"]
    detected_mps: Annotated[float, "the last, equation 3"]
    speed_mps: Annotated[float, "smoothed twice, equation 4: the train's"]


SPEED: Final = dtype_of(SpeedRow)


class PointUse(NamedTuple):
    """How points are made use of: how long they are kept (s), moved, smoothed in speed; the rows' spacing (m)."""

    kept_s: float = KEPT_S
    corrected: bool = True
    smoothed: bool = True
    spacing_m: float = ROW_M


@compiled
def mean_of_ring(ring: Any) -> float:  # noqa: ANN401 - a field of a row
    """Mean of a ring, in the order in which it lies: the same whatever came before."""
    total = 0.0
    for k in range(MEANS):
        total += ring[k]
    return float(total / MEANS)


@compiled
def detect(own: SpeedRow, mean_m: float) -> None:
    """One cycle: the mean distance of the points now (m), not above 0 where there is none; equations 3 and 4."""
    seen = mean_m > 0.0 and own.last_m > 0.0
    own.detected_mps = (own.last_m - mean_m) / CYCLE_S if seen else 0.0
    own.cycles = own.cycles + 1 if seen else 0
    own.last_m = mean_m
    own.at = (own.at + 1) % MEANS
    own.detected[own.at] = own.detected_mps
    own.smoothed[own.at] = mean_of_ring(own.detected)
    own.speed_mps = mean_of_ring(own.smoothed)


@compiled
def mean_distance_m(x_m: Floats, first: int, end: int) -> float:
    """Mean distance of the points from `first` to before `end`, m; -1 where there are none or it is out of range."""
    if end <= first:
        return -1.0
    total = 0.0
    for i in range(first, end):
        total += x_m[i]
    mean_m = total / (end - first)
    return mean_m if NEAREST_M <= mean_m <= FARTHEST_M else -1.0


@compiled
def places_now(x_m: Floats, time_s: Floats, first: int, end: int, now_s: float, speed_mps: float) -> Floats:
    """Where points are now that were taken at their times: equation 2."""
    out = np.empty(end - first)
    for i in range(first, end):
        out[i - first] = x_m[i] - speed_mps * (now_s - time_s[i])
    return out


@compiled
def read_window_m(spacing_m: float) -> float:
    """Mean distance (m) at which patterns are read last: for rows further apart more, so the nearest row is as near."""
    return NEAREST_M + 0.5 * (ROWS - 1) * (spacing_m - ROW_M)


@compiled
def window(time_s: Floats, now_s: float, kept_s: float, first: int, end: int) -> tuple[int, int]:
    """The points of the last `kept_s` seconds: from where to before where, given where that was a cycle ago."""
    while end < len(time_s) and time_s[end] <= now_s:
        end += 1
    while first < end and time_s[first] <= now_s - kept_s:
        first += 1
    return first, end


@compiled
def passage(time_s: Floats, x_m: Floats, y_m: Floats, own: SpeedRow, used: PointUse, cycles: Floats) -> None:
    """All cycles of a passage by the points' times (s) and places (m), in order of time.

    Fills `cycles` (n, 5): mean distance (m; -1: none), detected and smoothed speed (m/s), the pattern read (UNREAD:
    none, -1: not looked for), the first row's distance (m).
    """
    first = end = 0
    last_m = read_window_m(used.spacing_m)
    for c in range(cycles.shape[0]):
        now_s = (c + 1) * CYCLE_S
        first, end = window(time_s, now_s, used.kept_s, first, end)
        mean_m = mean_distance_m(x_m, first, end)
        detect(own, mean_m)
        cycles[c, 0], cycles[c, 1], cycles[c, 2] = mean_m, own.detected_mps, own.speed_mps
        cycles[c, 3], cycles[c, 4] = -1.0, 0.0
        if end == first or mean_m > last_m + LOOKED_FOR_M:
            continue
        speed_mps = own.speed_mps if used.smoothed else own.detected_mps
        at_m = places_now(x_m, time_s, first, end, now_s, speed_mps if used.corrected else 0.0)
        if last_m <= np.mean(at_m) <= last_m + READ_FROM_M - NEAREST_M:
            number, row_m = recognised_pattern(at_m, y_m[first:end], used.spacing_m)
            cycles[c, 3], cycles[c, 4] = float(number), row_m
