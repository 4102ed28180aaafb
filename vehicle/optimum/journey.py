"""When a train is where on a journey of several hops: running time is spent where it saves most, within all windows.

Given the energy of each hop over its running time (`HopCurve`: convex, falling), the least dwell and the windows of
arrival and departure at each stop, `journey_times` finds the times of least total energy, exactly for those curves. The
least cost of being somewhere by a time is convex in that time; along the journey it is joined with the next hop (times
add at equal prices) and cut by the next window, all on graphs of prices, and the times are read off on the way back. So
the price of a second is the same on both sides of a stop unless a window or its least dwell binds there: later would
save, but is forbidden, or earlier would.

`journey_bound_j` is a proof from the other side (weak duality): for any prices the sum of the hops' dual values, less
the most that the windows let those prices times the running times be, is no more than the energy of any journey.

Energies are of running alone: what auxiliaries draw a train draws standing too, so it is no matter of allocation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Final

import numpy as np

from vehicle.optimum.pareto import HopCurve, ParetoPoint
from vehicle.optimum.price_graph import FOREVER_S, NoTimeLeft, PriceGraph, free_between

TOLERANCE_S: Final = 1e-6  # windows missed by less than this are met


@dataclass(frozen=True, slots=True)
class TimeWindow:
    """From when to when something may happen, s; without bound where nothing is said."""

    earliest_s: float = -math.inf
    latest_s: float = math.inf

    def moved(self, by_s: float) -> TimeWindow:
        """The window that much later."""
        return TimeWindow(self.earliest_s + by_s, self.latest_s + by_s)


ANY_TIME: Final = TimeWindow()


@dataclass(frozen=True, slots=True)
class JourneyStop:
    """A place of the journey with its windows. `stands` False: the train passes, and departs as it arrives.

    The first stop has no arrival and needs an earliest departure, the last no departure.
    """

    name: str
    arrival: TimeWindow = ANY_TIME
    departure: TimeWindow = ANY_TIME
    dwell_min_s: float = 0.0
    stands: bool = True


class WindowMissed(Exception):  # noqa: N818 - a planner's finding, not a program error
    """No journey keeps all windows. `late_s` < 0: the train cannot be so slow as to come late enough."""

    def __init__(self, stop: str, event: str, late_s: float) -> None:
        how = (
            f"{late_s:.1f} s after its latest time"
            if late_s > 0.0
            else f"{-late_s:.1f} s before its earliest time"
        )
        super().__init__(f"{event} at {stop} {how}, at best")
        self.stop, self.event, self.late_s = stop, event, late_s


@dataclass(frozen=True, slots=True)
class StopTimes:
    """When the train is at a stop, s."""

    name: str
    arrival_s: float | None
    departure_s: float | None


@dataclass(frozen=True, slots=True)
class TimedJourney:
    """Times at all stops, and what one more second on each hop would save, W."""

    stops: tuple[StopTimes, ...]
    prices_w: tuple[float, ...]

    @property
    def running_s(self) -> tuple[float, ...]:
        """Running time of each hop."""
        return tuple(
            (there.arrival_s or 0.0) - (here.departure_s or 0.0) for here, there in pairwise(self.stops)
        )


@dataclass(frozen=True, slots=True)
class _Event:
    """A departure or an arrival: its window, and the cost of the time since the event before."""

    stop: JourneyStop
    name: str
    window: TimeWindow
    since: PriceGraph


def journey_times(hops: Sequence[HopCurve], stops: Sequence[JourneyStop]) -> TimedJourney:
    """Times of least total energy; of times that cost the same, the earliest.

    One stop more than hops. `WindowMissed` names the stop from which on no journey keeps the windows, ValueError a
    wrong number of stops or a first stop without an earliest departure.
    """
    if len(stops) != len(hops) + 1 or not math.isfinite(stops[0].departure.earliest_s):
        raise ValueError("one stop more than hops, the first with an earliest departure")
    start = stops[0].departure
    cost = free_between(start.earliest_s, min(max(start.latest_s, start.earliest_s), FOREVER_S))
    before: list[PriceGraph] = []  # cost of being at each event by a time, cut by its window
    events = _events(hops, stops)
    for event in events:
        before.append(cost)
        window = event.window
        try:
            cost = cost.joined_with(event.since).in_window(
                window.earliest_s, min(window.latest_s, FOREVER_S), TOLERANCE_S
            )
        except NoTimeLeft as empty:
            raise WindowMissed(event.stop.name, event.name, empty.late_s) from None
    times_s, prices_w = _read_back(before, events, cost)
    return _journey(stops, times_s, prices_w)


def _events(hops: Sequence[HopCurve], stops: Sequence[JourneyStop]) -> list[_Event]:
    events: list[_Event] = []
    for hop, stop in zip(hops, stops[1:], strict=True):
        events.append(_Event(stop, "arrival", stop.arrival, hop.graph))
        if stop is not stops[-1]:
            most_s = FOREVER_S if stop.stands else 0.0
            least_s = stop.dwell_min_s if stop.stands else 0.0
            events.append(_Event(stop, "departure", stop.departure, free_between(least_s, most_s)))
    return events


def _read_back(
    before: Sequence[PriceGraph], events: Sequence[_Event], cost: PriceGraph
) -> tuple[list[float], list[float]]:
    """Time of each event, the start first, and the price that led to each but the start: the last event first fixed."""
    time_s = float(cost.first_s(np.zeros(1))[0])
    times_s, prices_w = [time_s], list[float]()
    price_w = 0.0
    for sooner, event in zip(reversed(before), reversed(events), strict=True):
        low, high = sooner.joined_with(event.since).prices_w(time_s)
        price_w = min(max(price_w, low), high)  # where several will do, that of the hop beyond
        at = np.array([price_w])
        most_s = float(event.since.last_s(at)[0])
        time_s = min(max(float(sooner.first_s(at)[0]), time_s - most_s), float(sooner.last_s(at)[0]))
        times_s.append(time_s)
        prices_w.append(price_w)
    return times_s[::-1], prices_w[::-1]


def _journey(stops: Sequence[JourneyStop], times_s: list[float], prices_w: list[float]) -> TimedJourney:
    """Times in the order departure, arrival, departure, ... put to their stops; the prices of hops are every other."""
    departures: list[float | None] = [*times_s[0::2], None]
    arrivals: list[float | None] = [None, *times_s[1::2]]
    there = zip(stops, arrivals, departures, strict=True)
    return TimedJourney(
        tuple(StopTimes(stop.name, arrival, departure) for stop, arrival, departure in there),
        tuple(prices_w[0::2]),
    )


def earliest_times(
    running_s: Sequence[float], least_s: Sequence[float], stops: Sequence[JourneyStop]
) -> TimedJourney:
    """The journey that runs each hop in the time given and stands no longer than it must: reserve is kept to the end.

    A hop is faster than that, down to its least time, only where a latest time asks for it; `WindowMissed` where that
    is not enough. Prices are 0: nothing is weighed.
    """
    latest_s = _latest_arrivals_s(least_s, stops)
    time_s = stops[0].departure.earliest_s
    times = [StopTimes(stops[0].name, None, time_s)]
    for hop_s, fastest_s, due_s, stop in zip(running_s, least_s, latest_s, stops[1:], strict=True):
        arrival_s = time_s + max(fastest_s, min(hop_s, due_s - time_s))
        arrival_s = max(arrival_s, stop.arrival.earliest_s)
        _in_time(stop, "arrival", arrival_s, stop.arrival)
        if stop is stops[-1]:
            times.append(StopTimes(stop.name, arrival_s, None))
            break
        dwell_s = stop.dwell_min_s if stop.stands else 0.0
        time_s = max(arrival_s + dwell_s, stop.departure.earliest_s)
        _in_time(stop, "departure", time_s, stop.departure)
        times.append(StopTimes(stop.name, arrival_s if stop.stands else time_s, time_s))
    return TimedJourney(tuple(times), tuple(0.0 for _ in running_s))


def _latest_arrivals_s(least_s: Sequence[float], stops: Sequence[JourneyStop]) -> list[float]:
    """Latest arrival at each stop but the first from which all later windows can still be kept."""
    found: list[float] = []
    for stop, onward_s in zip(reversed(stops[1:]), [math.inf, *reversed(least_s)], strict=False):
        leave_by_s = math.inf if stop is stops[-1] else min(stop.departure.latest_s, found[-1] - onward_s)
        dwell_s = stop.dwell_min_s if stop.stands else 0.0
        found.append(min(stop.arrival.latest_s, leave_by_s - dwell_s))
    return found[::-1]


def _in_time(stop: JourneyStop, event: str, time_s: float, window: TimeWindow) -> None:
    if time_s > window.latest_s + TOLERANCE_S:
        raise WindowMissed(stop.name, event, time_s - window.latest_s)


# the bound ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ProvenHop:
    """What is proven of one hop: solutions with their bounds, and a time that no run is faster than, s."""

    points: tuple[ParetoPoint, ...]
    least_s: float = 0.0


def dual_j(hop: ProvenHop, price_w: float, longest_s: float) -> float:
    """No run of the hop in up to `longest_s` has less of energy plus price times running time, J.

    From the solutions' own bounds, each a line below the energy at every time (`ParetoPoint`); minus infinity where no
    solution has one.
    """
    lines = [(p.bound_j + p.price_w * p.time_s, p.price_w) for p in hop.points if math.isfinite(p.bound_j)]
    if not lines:
        return -math.inf
    least_s = min(hop.least_s, longest_s)
    meets = ((a - b) / (s - z) for (a, s), (b, z) in combinations(lines, 2) if s != z)
    times_s = [least_s, longest_s, *(t for t in meets if least_s < t < longest_s)]
    return min(max(a - s * t for a, s in lines) + price_w * t for t in times_s)


def journey_bound_j(
    hops: Sequence[ProvenHop], stops: Sequence[JourneyStop], prices_w: Sequence[float]
) -> float:
    """Energy, J, below which no journey within the windows can be, whatever the prices (>= 0) were found by.

    Nothing is assumed of the energies between a hop's solutions. The last stop needs a latest arrival.
    """
    if any(price < 0.0 for price in prices_w):
        raise ValueError("prices of at least 0")
    start_s, end_s = stops[0].departure.earliest_s, stops[-1].arrival.latest_s
    duals = sum(dual_j(hop, price, end_s - start_s) for hop, price in zip(hops, prices_w, strict=True))
    worth = prices_w[-1] * end_s - prices_w[0] * start_s
    for stop, before_w, after_w in zip(stops[1:-1], prices_w, prices_w[1:], strict=False):
        worth += _most_worth_j(stop, before_w, after_w, start_s, end_s)
    return duals - worth


def _most_worth_j(stop: JourneyStop, before_w: float, after_w: float, start_s: float, end_s: float) -> float:
    """The most that price before times arrival less price after times departure can be in the stop's windows."""
    dwell_s = stop.dwell_min_s if stop.stands else 0.0
    latest_s = min(stop.arrival.latest_s, stop.departure.latest_s - dwell_s, end_s)
    earliest_s = max(stop.arrival.earliest_s, start_s)
    if not stop.stands:
        earliest_s = max(earliest_s, stop.departure.earliest_s)
        return max((before_w - after_w) * earliest_s, (before_w - after_w) * latest_s)
    ready_s = min(max(stop.departure.earliest_s - dwell_s, earliest_s), latest_s)
    return max(
        before_w * at_s - after_w * max(stop.departure.earliest_s, at_s + dwell_s)
        for at_s in (earliest_s, ready_s, latest_s)
    )
