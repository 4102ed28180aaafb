"""How machinery answers a command: dead time (無駄時間), first-order lag (一次遅れ), jerk limit."""

from __future__ import annotations

import math

from vehicle.compiled import compiled
from vehicle.records import COMMAND_DELAY_STEPS_MAX


@compiled
def dead_time_steps(dead_time_s: float, dt_s: float) -> int:
    """Whole steps nearest to a dead time, at most what the ring of commands holds less the newest."""
    return min(int(dead_time_s / dt_s + 0.5), COMMAND_DELAY_STEPS_MAX - 1)


@compiled
def approach(value: float, target: float, lag_s: float, rate_max: float, dt_s: float) -> float:
    """`value` one step on towards `target`: exact first-order lag, changing by at most `rate_max` dt.

    0 means no lag, or no limit. Units of `value` are the caller's, `rate_max` is in those per second.
    """
    change = target - value
    if lag_s > 0.0:
        change *= 1.0 - math.exp(-dt_s / lag_s)
    if rate_max > 0.0:
        change = min(max(change, -rate_max * dt_s), rate_max * dt_s)
    return value + change
