"""One single track between two crossing stations: how much traffic it takes at what speed, from headways alone.

Trains come to either end at random (seeded), as many each way, and go in the order in which they come. After one that
goes the same way the next may follow by the headway of following trains, after an opposing one when that has arrived.
Stations are taken to have room for all that wait: what a loop with two tracks adds to that is not in here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from network.model import Direction
from radio.chance import generator
from study.capacity.headway import HeadwayKind, least_between, visits_at
from study.capacity.legs import SetLeg
from study.capacity.orders import DayOfLegs

TRAINS: Final = 5_000
BISECTIONS: Final = 30


@dataclass(frozen=True, slots=True)
class StretchHeadways:
    """Headways of a stretch by direction of the second train, s: `following_s` from departure to departure,
    `meeting_s` from the arrival of the opposing train to the departure; `runs_s` from departure to arrival.
    """

    following_s: tuple[float, float]
    meeting_s: tuple[float, float]
    runs_s: tuple[float, float]

    def apart_s(self) -> np.ndarray:
        """From one departure to the next by the directions of the two (0 down, 1 up), s; shape (2, 2)."""
        (down_s, up_s), (to_down_s, to_up_s) = self.following_s, self.meeting_s
        return np.array([[down_s, self.runs_s[0] + to_up_s], [self.runs_s[1] + to_down_s, up_s]])

    @property
    def trains_per_hour_max(self) -> float:
        """Most trains an hour in that random order, whatever they wait."""
        return 3600.0 / float(self.apart_s().mean())


def stretch_of(
    legs: Sequence[SetLeg], copies: Sequence[SetLeg], ends: tuple[frozenset[str], frozenset[str]]
) -> StretchHeadways:
    """The stretch between two stations, given by their tracks, low end first; `copies`: the same legs as other trains.

    ValueError where no leg leads from one to the other each way.
    """
    low, high = ends
    down = _leg(legs, low, high, Direction.DOWN)
    up = _leg(legs, high, low, Direction.UP)
    following = (_least(legs, copies, low, Direction.DOWN), _least(legs, copies, high, Direction.UP))
    meeting = (_meets(legs, copies, low, Direction.DOWN), _meets(legs, copies, high, Direction.UP))
    return StretchHeadways(following, meeting, (down.arrives_s - down.departs_s, up.arrives_s - up.departs_s))


def _leg(legs: Sequence[SetLeg], start: frozenset[str], end: frozenset[str], direction: Direction) -> SetLeg:
    for leg in legs:
        if leg.start is None or leg.end is None or leg.direction is not direction:
            continue
        if leg.start.section_id in start and leg.end.section_id in end:
            return leg
    raise ValueError(f"no train runs {direction.name.lower()} there")


def _least(legs: Sequence[SetLeg], copies: Sequence[SetLeg], tracks: frozenset[str], way: Direction) -> float:
    """From departure to departure in a direction; the station has a track for whoever waits there."""
    found: list[float] = []
    for first in (v for v in visits_at(legs, tracks) if v.direction is way):
        for second in (v for v in visits_at(copies, tracks) if v.direction is way):
            one, other = first.departure, second.departure
            if one is None or other is None:
                continue
            least = least_between(HeadwayKind.FOLLOWING, one, other, DayOfLegs(), tracks)
            found += [] if least is None else [least.least_s]
    return max(found)


def _meets(legs: Sequence[SetLeg], copies: Sequence[SetLeg], tracks: frozenset[str], way: Direction) -> float:
    """From the arrival of the opposing train to the departure of one in a direction.

    Each has a track of its own, also where both are laid out by one: else who departs would have come there after it.
    """
    ahead = [v for v in visits_at(legs, tracks) if v.direction is way.opposite]
    behind = [v for v in visits_at(copies, tracks) if v.direction is way]
    found: list[float] = []
    for first in ahead:
        for second in behind:
            arrival, departure = first.arrival, second.departure
            if arrival is None or departure is None:
                continue
            start = arrival.leg.start
            room = tracks if start is None else tracks | {start.section_id}
            one = least_between(HeadwayKind.ARRIVAL_DEPARTURE, arrival, departure, DayOfLegs(), room)
            found += [] if one is None else [one.least_s]
    return max(found)


def mean_wait_s(stretch: StretchHeadways, trains_per_hour: float, seed: int, count: int = TRAINS) -> float:
    """How long a train waits on average for its turn, s; infinite beyond what the stretch takes."""
    if trains_per_hour >= stretch.trains_per_hour_max:
        return math.inf
    chance = generator(seed, "shared stretch")
    comes_s = np.cumsum(chance.exponential(3600.0 / trains_per_hour, count))
    ways = chance.integers(0, 2, count)
    apart_s = stretch.apart_s()
    free_s, waits_s = -math.inf, 0.0
    for index in range(count):
        goes_s = max(float(comes_s[index]), free_s)
        waits_s += goes_s - float(comes_s[index])
        if index + 1 < count:
            free_s = goes_s + float(apart_s[ways[index], ways[index + 1]])
    return waits_s / count


def traffic_at(stretch: StretchHeadways, wait_s: float, seed: int) -> float:
    """The traffic, trains an hour, at which a train waits so long on average."""
    low, high = 0.0, stretch.trains_per_hour_max
    for _ in range(BISECTIONS):
        middle = (low + high) / 2.0
        if mean_wait_s(stretch, middle, seed) < wait_s:
            low = middle
        else:
            high = middle
    return (low + high) / 2.0
