"""When a train that stands at a stop means to arrive at the next ones, by the planner's wish.

A departure that is fixed parts a journey: what comes after it gains nothing from what was before. So the unit looks
ahead to the next such stop alone, and where that is the very next one there is nothing to share and nothing to solve.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from onboard.driving.planner.allocation import allocated, hop_curve
from onboard.driving.planner.windows import journey_stops
from onboard.driving.planner.wish import Margin, Planning
from onboard.mission import Mission
from vehicle.optimum import Course, least_time
from vehicle.optimum.journey import ANY_TIME, JourneyStop
from vehicle.optimum.pareto import HopCurve, proportional_curve
from vehicle.records import TrainRow

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TrainOnMap:
    """The train and its way as the unit knows them: climb and driving speed on the path's 1 m grid."""

    train: TrainRow
    load_share: float
    climb_m: Floats
    driving_mps: Floats
    deceleration_mps2: float

    def course(self, start_m: float, stop_m: float) -> Course:
        """The run between two marks."""
        return Course(
            self.train,
            self.load_share,
            self.climb_m,
            self.driving_mps,
            start_m,
            stop_m,
            self.deceleration_mps2,
        )


@dataclass(frozen=True, slots=True)
class ArrivalAims:
    """What the unit aims at: its least dwell and its reserve before each arrival."""

    dwell_min_s: float
    margin_s: float


def arrivals_s(
    planning: Planning, on_map: TrainOnMap, mission: Mission, at: int, now_s: float, times: ArrivalAims
) -> tuple[float, ...]:
    """Arrivals meant at the targets after `at`, up to the next whose departure is fixed; infinite where no time is set.

    The train stands at `at`. A late one is as early as it can be. ValueError where it cannot get there.
    """
    tolerance_s = planning.plan_tolerance_s
    stops = up_to_fixed(journey_stops(mission, at, now_s, times.dwell_min_s, times.margin_s, tolerance_s))
    latest_s = stops[-1].arrival.latest_s
    if math.isinf(latest_s) or (len(stops) == 2 and planning.margin is not Margin.END):
        return (latest_s,)
    marks_m = [target.mark_m for target in mission.targets[at : at + len(stops)]]
    courses = [on_map.course(here_m, there_m) for here_m, there_m in pairwise(marks_m)]
    journey = allocated([_curve(course, planning) for course in courses], stops, planning.margin).journey
    return tuple(stop.arrival_s or 0.0 for stop in journey.stops[1:])


def up_to_fixed(stops: Sequence[JourneyStop]) -> tuple[JourneyStop, ...]:
    """The journey up to the first stop that it need not look beyond: a fixed departure, the last with a time."""
    for i, stop in enumerate(stops[1:], 1):
        timeless = math.isinf(stop.arrival.latest_s)
        fixed = stop.departure.latest_s <= stop.departure.earliest_s
        if timeless or fixed or i == len(stops) - 1:
            last = max(i - 1, 1) if timeless else i  # what has no time takes none from the stops before it
            return (*stops[:last], replace(stops[last], departure=ANY_TIME))
    raise ValueError("a journey has a stop to go to")


def _curve(course: Course, planning: Planning) -> HopCurve:
    """What the wish needs to know of a hop: its energies where they are weighed, else its least time alone."""
    if planning.margin is Margin.SAVING:
        return hop_curve(course, planning.style)
    return proportional_curve(float(least_time(course).time_s[-1]))
