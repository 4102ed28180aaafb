"""Where opposing trains meet on the train graph (行違い): straight lines between the kilometrages of their stations.

On the line's one axis of kilometrage, and without a word on whether they can pass each other there: that follows from
the tracks that a run takes, and `study.feasibility` says it.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

from network.clock import clock
from network.model import Direction, Line

_AT_STATION_M: Final = 1.0
_SAME_PLACE_M: Final = 1e-6


@dataclass(frozen=True, slots=True)
class Meet:
    """Two opposing trains at one place at one time, as planned.

    `low_station` and `high_station` are the stations (or halts) on either side, the same when the trains meet at one.
    """

    down_train: str
    up_train: str
    time_s: float
    position_m: float
    low_station: str | None
    high_station: str | None

    @property
    def station(self) -> str | None:
        """The station or halt at which they meet; None between two."""
        return self.low_station if self.low_station == self.high_station else None

    def __str__(self) -> str:
        """For reports: who, where, when."""
        place = (
            f"at {self.low_station}"
            if self.low_station == self.high_station
            else f"between {self.low_station} and {self.high_station}"
        )
        return f"{self.down_train} and {self.up_train} meet {place} at {clock(self.time_s)}"


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A train on the train graph: corners in order of time, s after midnight and kilometrage, m."""

    number: str
    direction: Direction
    times_s: tuple[float, ...]
    positions_m: tuple[float, ...]

    def position_m(self, time_s: float) -> float:
        """Position between the corners around `time_s`, which lies within the trajectory."""
        after = min(max(bisect_right(self.times_s, time_s), 1), len(self.times_s) - 1)
        t0_s, t1_s = self.times_s[after - 1], self.times_s[after]
        p0_m, p1_m = self.positions_m[after - 1], self.positions_m[after]
        return p1_m if t1_s <= t0_s else p0_m + (p1_m - p0_m) * (time_s - t0_s) / (t1_s - t0_s)


def meets_of(line: Line, trajectories: Sequence[Trajectory]) -> tuple[Meet, ...]:
    """All meets of opposing trains, in order of time; each pair meets at most once."""
    by_direction: dict[Direction, list[Trajectory]] = {Direction.DOWN: [], Direction.UP: []}
    for trajectory in trajectories:
        by_direction[trajectory.direction].append(trajectory)
    meets: list[Meet] = []
    for down, up in product(by_direction[Direction.DOWN], by_direction[Direction.UP]):
        found = _meeting(down, up)
        if found is not None:
            meets.append(_meet(line, down.number, up.number, *found))
    return tuple(sorted(meets, key=lambda meet: (meet.time_s, meet.down_train, meet.up_train)))


def _meeting(down: Trajectory, up: Trajectory) -> tuple[float, float] | None:
    """First time and position at which the two are at one place; None when they never are."""
    from_s, to_s = max(down.times_s[0], up.times_s[0]), min(down.times_s[-1], up.times_s[-1])
    if to_s <= from_s:
        return None
    between = {t for t in (*down.times_s, *up.times_s) if from_s < t < to_s}
    before_s, before_m = from_s, down.position_m(from_s) - up.position_m(from_s)
    if before_m > _SAME_PLACE_M:
        return None
    for time_s in sorted({from_s, to_s} | between):
        gap_m = down.position_m(time_s) - up.position_m(time_s)
        if abs(gap_m) <= _SAME_PLACE_M:
            return time_s, down.position_m(time_s)
        if gap_m > 0:
            meet_s = before_s + (time_s - before_s) * -before_m / (gap_m - before_m)
            return meet_s, down.position_m(meet_s)
        before_s, before_m = time_s, gap_m
    return None


def _meet(line: Line, down: str, up: str, time_s: float, position_m: float) -> Meet:
    stations = sorted(line.stations.values(), key=lambda station: station.position_m)
    here = next((s for s in stations if abs(s.position_m - position_m) <= _AT_STATION_M), None)
    if here is not None:
        return Meet(down, up, time_s, position_m, here.id, here.id)
    low = [s.id for s in stations if s.position_m < position_m]
    high = next((s.id for s in stations if s.position_m > position_m), None)
    return Meet(down, up, time_s, position_m, low[-1] if low else None, high)
