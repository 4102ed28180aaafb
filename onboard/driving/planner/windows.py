"""The windows of a journey: from when to when a train may arrive and depart, by the timetable that the unit carries.

What freedom there is: passengers are promised the departures, so none is early, and with no tolerance none is late
either; an arrival may be as late as the published one, and as the least dwell before the departure lets it. Where
trains can meet (more than one track) another may wait for this one's arrival, and the unit does not know which: there,
and where the train begins and ends, the published times hold whatever the tolerance. Elsewhere only passengers on the
platform see a few seconds.
Each arrival is aimed at `time_margin_s` before the latest.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from vehicle.optimum.journey import JourneyStop, TimeWindow

if TYPE_CHECKING:
    from collections.abc import Sequence

    from onboard.mission import Mission, Target


def journey_stops(
    mission: Mission,
    at: int,
    now_s: float,
    dwell_min_s: float,
    time_margin_s: float,
    tolerance_s: float = 0.0,
) -> tuple[JourneyStop, ...]:
    """Windows of the rest of a mission for a train that stands at target `at`: that one, then all beyond, in order.

    Stations that are passed are no stops of it. The departure is not before `now_s`, nor before its time.
    """
    over_s = [_over_s(mission, index, tolerance_s) for index in range(len(mission.targets))]
    here = mission.targets[at]
    leaves_s = now_s if here.departure_s is None else max(now_s, here.departure_s)
    leaves = TimeWindow(leaves_s, max(leaves_s, _latest_departure_s(here, over_s[at])))
    stops = [JourneyStop(here.place_id, departure=leaves)]
    for target, later_s in zip(mission.targets[at + 1 :], over_s[at + 1 :], strict=True):
        dwell_s = dwell_min_s if target.passengers else 0.0
        latest_s = target.latest_arrival_s(dwell_min_s)
        arrival = TimeWindow(latest_s=math.inf if latest_s is None else latest_s + later_s - time_margin_s)
        early_s = -math.inf if target.departure_s is None else target.departure_s
        departure = TimeWindow(early_s, _latest_departure_s(target, later_s))
        stops.append(JourneyStop(target.place_id, arrival, departure, dwell_s))
    return tuple(stops)


def made_possible(
    stops: Sequence[JourneyStop], least_s: Sequence[float]
) -> tuple[tuple[JourneyStop, ...], float]:
    """The same windows, later where they cannot be kept: as late as the fastest train is; and the most of that, s.

    A late train gets a plan by this that loses no more, and is on time again as soon as it can be.
    """
    made = [replace(stops[0], departure=_reached(stops[0].departure, stops[0].departure.earliest_s))]
    time_s, late_s = stops[0].departure.earliest_s, 0.0
    for stop, run_s in zip(stops[1:], least_s, strict=True):
        arrival_s = max(time_s + run_s, stop.arrival.earliest_s)
        time_s = max(arrival_s + (stop.dwell_min_s if stop.stands else 0.0), stop.departure.earliest_s)
        late_s = max(late_s, arrival_s - stop.arrival.latest_s, time_s - stop.departure.latest_s)
        made.append(
            replace(
                stop, arrival=_reached(stop.arrival, arrival_s), departure=_reached(stop.departure, time_s)
            )
        )
    return tuple(made), late_s


def _reached(window: TimeWindow, time_s: float) -> TimeWindow:
    return replace(window, latest_s=max(window.latest_s, time_s))


def _latest_departure_s(target: Target, over_s: float) -> float:
    return math.inf if target.departure_s is None else target.departure_s + over_s


def _over_s(mission: Mission, index: int, tolerance_s: float) -> float:
    """How much later than the timetable a plan may be at a target."""
    stations = [i for i, target in enumerate(mission.targets) if target.station_id is not None]
    at_end = not stations or index <= stations[0] or index >= stations[-1]
    return 0.0 if at_end or mission.targets[index].crossing else tolerance_s
