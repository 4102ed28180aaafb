"""What the radar shows as a fix: the way run since the position was last known, by the train's own speed.

Invariant: the true front lies within the interval while the radar is wrong by no more than `WRONG_BY_MPS`.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from onboard.localisation.fix import NOTHING, REFUSED, fix_by_rule
from onboard.records import Chart, UnitRow
from vehicle.compiled import compiled

WRONG_BY_MPS: Final = 0.06  # the largest bias, and what the speed does within a step


class RadarReading(Protocol):
    """What the radar shows."""

    shown: Annotated[int, "1: the train has one"]
    speed_mps: float


class RadarRunRow(Protocol):
    """The interval of the front by the radar, on the path where it began; m."""

    rear_m: float
    front_m: float
    speed_mps: Annotated[float, "shown in the step before"]
    path: Annotated[int, "path of these coordinates, counted from 1; 0: none yet"]


@compiled
def radar_run(own: RadarRunRow, reading: RadarReading, unit: UnitRow, _chart: Chart, step_s: float) -> int:
    """Carry the interval on by what was shown, and cut the position with it."""
    if reading.shown == 0:
        return NOTHING
    run_m = 0.5 * (own.speed_mps + reading.speed_mps) * step_s
    own.speed_mps = reading.speed_mps
    path = unit.paths_taken_up
    if unit.position_known == 0 or own.path != path:
        own.path = path if unit.position_known == 1 else 0
        own.rear_m = unit.position_m - unit.bound_behind_m
        own.front_m = unit.position_m + unit.bound_ahead_m
        return NOTHING
    own.rear_m += max(run_m - WRONG_BY_MPS * step_s, 0.0)
    own.front_m += max(run_m + WRONG_BY_MPS * step_s, 0.0)
    half_m = 0.5 * (own.front_m - own.rear_m)
    outcome = fix_by_rule(unit, own.rear_m + half_m, half_m, half_m)
    if outcome != REFUSED:  # what a tag has cut meanwhile holds here too
        own.rear_m = unit.position_m - unit.bound_behind_m
        own.front_m = unit.position_m + unit.bound_ahead_m
    return outcome
