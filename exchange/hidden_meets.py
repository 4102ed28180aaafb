"""Meets that a published timetable does not show: a train that is written as passing stands there (運転停車).

Passengers are told of no stop that is not for them, so public timetables write an operating stop as a passing. Two
opposing trains that pass a station at one time, or that cross between two stations where one of them only passes, show
that there is one: on a single track one of the two has to stand.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from exchange.planned import TrainOnLine
from network.clock import clock
from network.model import Direction, Line
from network.timetable import Call, CallKind, Timetable

COARSE_S: Final = 120  # two printed minutes, as trains that meet at a station may be written
_Pair = tuple[Call, Call]  # of a down and an up train at one station


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
    meets = [_meet(one, other, line) for one in down for other in up]
    found = [meet for meet in meets if meet is not None]
    return tuple(sorted(found, key=lambda meet: (meet.time_s, meet.down, meet.up)))


def meets_between(timetable: Timetable, line: Line) -> Iterator[tuple[str, str]]:
    """Neighbours (ids, the lower first) between which opposing trains meet by the timetable, once for each two: neither
    is at either of them within `COARSE_S` of the other, as printed minutes are coarse.
    """
    neighbours = frozenset(pairwise(s.id for s in sorted(line.stations.values(), key=lambda s: s.position_m)))
    by_way = {way: [t.calls for t in timetable.trains.values() if t.direction is way] for way in Direction}
    for down in by_way[Direction.DOWN]:
        for up in by_way[Direction.UP]:
            place = _place(down, up, line)
            if place is None:
                continue
            (low, low_up), (high, high_up) = place
            apart_s = min(low_up.first_s - low.last_s, high.first_s - high_up.last_s)
            ends = (low.station_id, high.station_id)
            if apart_s > COARSE_S and ends in neighbours:
                yield ends


def _meet(down: TrainOnLine, up: TrainOnLine, line: Line) -> HiddenMeet | None:
    """Where two trains meet, if no stop of either is there."""
    place = _place(down.calls, up.calls, line)
    if place is None:
        return None
    (low, low_up), (high, high_up) = place
    passes = [call.kind is CallKind.PASS for call in (low, low_up, high, high_up)]
    if not (all(passes) if low is high else any(passes)):
        return None
    at_s = low.first_s if low is high else high_up.last_s
    return HiddenMeet(down.number, up.number, low.station_id, high.station_id, at_s)


def _place(down: Sequence[Call], up: Sequence[Call], line: Line) -> tuple[_Pair, _Pair] | None:
    """The calls of a down and an up train between which they meet, the lower first; twice one where both are."""
    if down[0].first_s > up[-1].last_s or up[0].first_s > down[-1].last_s:
        return None
    theirs = {call.station_id: call for call in up}
    common = [(call, theirs[call.station_id]) for call in down if call.station_id in theirs]
    common.sort(key=lambda pair: line.stations[pair[0].station_id].position_m)
    for pair in common:
        if _order(*pair) == 0:
            return pair, pair
    between = (two for two in pairwise(common) if _order(*two[0]) < 0 < _order(*two[1]))
    return next(between, None)


def _order(ours: Call, other: Call) -> int:
    """Below 0 where ours is gone before the other comes, above 0 where it comes after, 0 where both are there."""
    return (ours.first_s > other.last_s) - (ours.last_s < other.first_s)
