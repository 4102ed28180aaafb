"""How the time of a journey is shared among its hops, as the planner wishes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from onboard.driving.planner.windows import made_possible
from onboard.driving.planner.wish import Margin, Style
from vehicle.optimum import Course
from vehicle.optimum.journey import JourneyStop, TimedJourney, earliest_times, journey_times
from vehicle.optimum.pareto import HopCurve, proportional_curve
from vehicle.optimum.samples import coast_curve, cruise_curve, optimal_curve
from vehicle.running_time import laid_down_s


@dataclass(frozen=True, slots=True)
class Allocated:
    """Times of a journey, and by how much the timetable's windows were missed at most, s: 0, all are kept."""

    journey: TimedJourney
    late_s: float


def hop_curve(course: Course, style: Style) -> HopCurve:
    """Energy of a hop over its running time for trains of a style."""
    match style:
        case Style.HOLD:
            return cruise_curve(course)
        case Style.COAST:
            return coast_curve(course)
        case Style.OPTIMAL:
            return optimal_curve(course)


def allocated(hops: Sequence[HopCurve], stops: Sequence[JourneyStop], margin: Margin) -> Allocated:
    """Times at all stops by the planner's wish; for a train that is late, with windows as late as it has to be."""
    least_s = [hop.least_s for hop in hops]
    possible, late_s = made_possible(stops, least_s)
    match margin:
        case Margin.END:
            standard_s = [float(laid_down_s(time_s)) for time_s in least_s]
            journey = earliest_times(standard_s, least_s, possible)
        case Margin.SPREAD:
            journey = journey_times([proportional_curve(time_s) for time_s in least_s], possible)
        case Margin.SAVING:
            journey = journey_times(hops, possible)
    return Allocated(journey, late_s)
