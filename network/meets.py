"""Where opposing trains meet on the train graph (行違い), and which of these meets the line cannot hold.

Trains are straight lines between the kilometrages of their calls, on the line's one axis of kilometrage.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from typing import Final

from network.model import Direction, Line, Station
from network.timetable import Timetable, TimetableTrain, clock

_AT_STATION_M: Final = 1.0
_SAME_PLACE_M: Final = 1e-6


@dataclass(frozen=True, slots=True)
class Meet:
    """Two opposing trains at one place at one time, as planned.

    `low_station` and `high_station` are the stations (or halts) on either side, the same when the trains meet
    at one; `crossing_station` is where they can pass each other, None when they cannot.
    """

    down_train: str
    up_train: str
    time_s: float
    position_m: float
    low_station: str | None
    high_station: str | None
    crossing_station: str | None

    def __str__(self) -> str:
        """For reports: who, where, when."""
        place = (
            f"at {self.low_station}"
            if self.low_station == self.high_station
            else f"between {self.low_station} and {self.high_station}"
        )
        return f"{self.down_train} and {self.up_train} meet {place} at {clock(self.time_s)}"


@dataclass(frozen=True, slots=True)
class _Trajectory:
    """A train on the train graph: corners in order of time."""

    train: TimetableTrain
    times_s: tuple[float, ...]
    positions_m: tuple[float, ...]

    def position_m(self, time_s: float) -> float:
        """Position between the corners around `time_s`, which lies within the trajectory."""
        after = min(max(bisect_right(self.times_s, time_s), 1), len(self.times_s) - 1)
        t0_s, t1_s = self.times_s[after - 1], self.times_s[after]
        p0_m, p1_m = self.positions_m[after - 1], self.positions_m[after]
        return p1_m if t1_s <= t0_s else p0_m + (p1_m - p0_m) * (time_s - t0_s) / (t1_s - t0_s)


def planned_meets(line: Line, timetable: Timetable) -> tuple[Meet, ...]:
    """All meets of opposing trains, in order of time; each pair meets at most once."""
    by_direction: dict[Direction, list[_Trajectory]] = {Direction.DOWN: [], Direction.UP: []}
    for train in timetable.trains.values():
        by_direction[train.direction].append(_trajectory(line, train, timetable.dwell_min_s))
    meets: list[Meet] = []
    for down, up in product(by_direction[Direction.DOWN], by_direction[Direction.UP]):
        found = _meeting(down, up)
        if found is not None:
            meets.append(_meet(line, down.train, up.train, *found))
    return tuple(sorted(meets, key=lambda meet: (meet.time_s, meet.down_train, meet.up_train)))


def unresolvable_meets(line: Line, timetable: Timetable) -> tuple[Meet, ...]:
    """Meets where the trains cannot pass each other: between stations, or with no second track for one."""
    return tuple(meet for meet in planned_meets(line, timetable) if meet.crossing_station is None)


def meet_text(meet: Meet, line: Line) -> str:
    """One clause for people: who meets where and when, and if they cannot pass, why not and where they could."""
    trains = f"{meet.down_train} and {meet.up_train}"
    when = clock(meet.time_s // 60 * 60)[:-3]
    if meet.crossing_station is not None:
        return f"{trains} pass each other at {line.stations[meet.crossing_station].name} at {when}"
    where, why = _place_and_reason(meet, line)
    passing = [s for s in line.stations.values() if _has_two_tracks(s) and s.id != meet.low_station]
    nearest = min(passing, key=lambda s: abs(s.position_m - meet.position_m), default=None)
    other = "other " if meet.low_station == meet.high_station else ""
    remedy = (
        f"no {other}station has two tracks"
        if nearest is None
        else f"the nearest {other}station with two tracks is {nearest.name}"
    )
    return f"{trains} would meet {where} at {when}: {why}, and {remedy}"


def _place_and_reason(meet: Meet, line: Line) -> tuple[str, str]:
    """Where two trains that cannot pass meet, by name, and what is missing there."""
    low, high = (
        line.stations[name] if name is not None else None for name in (meet.low_station, meet.high_station)
    )
    if low is not None and low is high:
        if low.is_halt:
            return f"at {low.name}", "a halt has no second track"
        if not _has_two_tracks(low):
            return f"at {low.name}", "it has one track"
        return f"at {low.name}", "both need the same track"
    if low is None or high is None:
        end = low or high
        return f"beyond {end.name}" if end else "on the line", "the line is single there"
    return f"between {low.name} and {high.name}", "the line is single there"


def _has_two_tracks(station: Station) -> bool:
    return not station.is_halt and len(station.tracks) > 1


def _trajectory(line: Line, train: TimetableTrain, dwell_min_s: float) -> _Trajectory:
    """A call without arrival gets the shortest dwell, at most half the time since the call before."""
    times_s: list[float] = []
    positions_m: list[float] = []
    for call in train.calls:
        arrival_s: float = call.first_s
        if call.arrival_s is None and times_s:
            arrival_s = max(arrival_s - dwell_min_s, (arrival_s + times_s[-1]) / 2)
        times_s += [arrival_s, call.last_s]
        positions_m += [line.stations[call.station_id].position_m] * 2
    return _Trajectory(train, tuple(times_s), tuple(positions_m))


def _meeting(down: _Trajectory, up: _Trajectory) -> tuple[float, float] | None:
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


def _meet(line: Line, down: TimetableTrain, up: TimetableTrain, time_s: float, position_m: float) -> Meet:
    stations = sorted(line.stations.values(), key=lambda station: station.position_m)
    here = next((s for s in stations if abs(s.position_m - position_m) <= _AT_STATION_M), None)
    if here is not None:
        crossing = here.id if _can_cross(here, down, up) else None
        return Meet(down.number, up.number, time_s, position_m, here.id, here.id, crossing)
    low = _last(s.id for s in stations if s.position_m < position_m)
    high = next((s.id for s in stations if s.position_m > position_m), None)
    return Meet(down.number, up.number, time_s, position_m, low, high, None)


def _last(names: Iterable[str]) -> str | None:
    found = None
    for name in names:
        found = name
    return found


def _can_cross(station: Station, down: TimetableTrain, up: TimetableTrain) -> bool:
    """Whether the two can stand on different tracks of the station, those planned where given."""
    if station.is_halt:
        return False
    tracks = {
        train.direction: [
            track.name
            for track in station.tracks
            if train.direction in track.marks_m and _planned(train, station.id) in (None, track.name)
        ]
        for train in (down, up)
    }
    return any(a != b for a, b in product(tracks[Direction.DOWN], tracks[Direction.UP]))


def _planned(train: TimetableTrain, station_id: str) -> str | None:
    return next((call.track for call in train.calls if call.station_id == station_id), None)
