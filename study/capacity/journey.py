"""How a train of the plan runs by prediction alone: where its front is when, and at which speed.

The running times are those of the units (`onboard.duty.timekeeping`, `vehicle.running_time`): each hop at the lowest
speed that brings the train to its stop in time, or at the limits where the plan leaves no time; at the scenario's mean
load. A train that is late by its own running times stays late; other trains do not hinder it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from network.model import Direction
from onboard.mission import Mission
from onboard.plan import DutyPlan


@dataclass(frozen=True, slots=True)
class JourneyStay:
    """A stop of a train, s; the last one ends when the train has done with its number."""

    target: int  # of the mission
    arrives_s: float
    departs_s: float


@dataclass(frozen=True, slots=True)
class TrainJourney:
    """One train of the day. `course`: time (s), front (m of its path), speed (m/s), shape (n, 3), in order of time.

    `begins_s`: it takes up its number; `ends_s`: it has done with it. `asks_s`: by route id, when it asks for the
    routes from its stops.
    """

    stock_id: str
    mission: Mission
    plan: DutyPlan
    length_m: float
    course: NDArray[np.float64]
    stays: tuple[JourneyStay, ...]
    begins_s: float
    ends_s: float
    enters: bool
    leaves: bool
    asks_s: Mapping[str, float] = field(default_factory=dict[str, float])

    @property
    def number(self) -> str:
        """Its number."""
        return self.mission.number

    @property
    def direction(self) -> Direction:
        """Its direction of travel."""
        return self.mission.direction

    def at_s(self, position_m: float) -> float:
        """When its front first comes to a path coordinate (m); infinite where it never does."""
        times_s, fronts_m = self.course[:, 0], self.course[:, 1]
        index = int(np.searchsorted(fronts_m, position_m, side="left"))
        if index >= len(fronts_m):
            return math.inf
        if index == 0:
            return float(times_s[0]) if position_m >= fronts_m[0] else -math.inf
        before_m, after_m = float(fronts_m[index - 1]), float(fronts_m[index])
        share = (position_m - before_m) / (after_m - before_m)
        return float(times_s[index - 1] + share * (times_s[index] - times_s[index - 1]))

    def leaves_last_s(self, before_m: float) -> float:
        """When it leaves its last stop short of a path coordinate (m), s; its begin where there is none."""
        left_s = self.begins_s
        for stay in self.stays[:-1]:
            if self.mission.targets[stay.target].mark_m < before_m:
                left_s = stay.departs_s
        return left_s

    def ended(self, at_s: float) -> TrainJourney:
        """The same, done with its number only then."""
        last = replace(self.stays[-1], departs_s=at_s)
        return replace(self, stays=(*self.stays[:-1], last), ends_s=at_s)

    def moved(self, by_s: float) -> TrainJourney:
        """The same journey so much later."""
        stays = tuple(JourneyStay(s.target, s.arrives_s + by_s, s.departs_s + by_s) for s in self.stays)
        return replace(
            self,
            course=self.course + np.array([by_s, 0.0, 0.0]),
            stays=stays,
            begins_s=self.begins_s + by_s,
            ends_s=self.ends_s + by_s,
            asks_s={route_id: ask_s + by_s for route_id, ask_s in self.asks_s.items()},
        )
