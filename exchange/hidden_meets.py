"""Meets that a published timetable does not show: a train that is written as passing stands there (運転停車).

Passengers are told of no stop that is not for them, so public timetables write an operating stop as a passing. Two
opposing trains that pass a station at one time, or that cross between two stations where one of them only passes, show
that there is one: on a single track one of the two has to stand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from exchange.planned import TrainOnLine
from network.clock import clock
from network.model import Direction, Line
from network.timetable import Call, CallKind


@dataclass(frozen=True, slots=True)
class HiddenMeet:
    """Two trains that meet where the timetable has no stop: at one station, or at or between two (ids)."""

    down: str
    up: str
    low_id: str
    high_id: str
    time_s: int

    def text(self, line: Line) -> str:
        """For reports: who, where, when."""
        low, high = (line.stations[name].name or name for name in (self.low_id, self.high_id))
        place = f"at {low}" if low == high else f"at {low} or {high} or between them,"
        return (
            f"{self.down} and {self.up} meet {place} about {clock(self.time_s)[:-3]}, where the source has no stop for"
            " it: one of them may stand there (運転停車)"
        )


def hidden_meets(trains: Sequence[TrainOnLine], line: Line) -> tuple[HiddenMeet, ...]:
    """All of a day's, in order of time."""
    down = [train for train in trains if train.direction is Direction.DOWN]
    up = [train for train in trains if train.direction is Direction.UP]
    found: list[HiddenMeet] = []
    for one in down:
        for other in up:
            if (
                one.calls[0].first_s <= other.calls[-1].last_s
                and other.calls[0].first_s <= one.calls[-1].last_s
            ):
                meet = _meet(one, other, line)
                found += [meet] if meet is not None else []
    return tuple(sorted(found, key=lambda meet: (meet.time_s, meet.down, meet.up)))


def _meet(down: TrainOnLine, up: TrainOnLine, line: Line) -> HiddenMeet | None:
    """Where two trains meet, if no stop of either is there."""
    theirs = {call.station_id: call for call in up.calls}
    common = [(call, theirs[call.station_id]) for call in down.calls if call.station_id in theirs]
    common.sort(key=lambda pair: line.stations[pair[0].station_id].position_m)
    for ours, other in common:
        if _order(ours, other) == 0:
            if CallKind.PASS is ours.kind is other.kind:
                return HiddenMeet(down.number, up.number, ours.station_id, ours.station_id, ours.first_s)
            return None
    for (low, low_up), (high, high_up) in pairwise(common):
        if _order(low, low_up) < 0 < _order(high, high_up):
            if any(call.kind is CallKind.PASS for call in (low, low_up, high, high_up)):
                return HiddenMeet(down.number, up.number, low.station_id, high.station_id, high_up.last_s)
            return None
    return None


def _order(ours: Call, other: Call) -> int:
    """Below 0 where ours is gone before the other comes, above 0 where it comes after, 0 where both are there."""
    return (ours.first_s > other.last_s) - (ours.last_s < other.first_s)
