"""How long trains of a published timetable take for a leg, and the times that it leaves out.

Where only a departure is published, the train is there DWELL_S before it: a published time is the best that is known,
and a time in whole minutes hides up to one. It is there earlier where somebody who knows the trains, or a train of the
timetable that has both times on the leg, says so; and later where no train can be there yet (`Times.least`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

from network.files.quantities import SPEED
from network.timetable import Call

DWELL_S: Final = (
    20  # assumed: how long a train stands at least where only departures are published; a quiet platform
)
CHANGE_MPS2: Final = (
    0.8  # assumed: starting and braking of a lively railcar, which none on such a line outdoes
)


@dataclass(frozen=True, slots=True)
class StationRun:
    """A run from one station to another; `from_stand` and `to_stand`: whether the train stands at its ends."""

    from_id: str
    to_id: str
    from_stand: bool
    to_stand: bool


Running = Callable[[StationRun], float | None]  # least running time of a leg, s; None where it is not known


@dataclass(frozen=True, slots=True)
class KnownRunningTimes:
    """What is known of running times: `exact` from departure to arrival, `rough` also where only departures tell.

    `least` is what no train on the line takes less than, s, whatever others say.
    """

    exact: Running
    rough: Running
    least: Callable[[StationRun], float]


class UntimedError(Exception):
    """A train with too few times for the others to be found; the message says where."""


def leg_of(before: Call, after: Call) -> StationRun:
    """The leg between two calls."""
    return StationRun(before.station_id, after.station_id, before.stops, after.stops)


def least_s(distance_m: float) -> float:
    """Time (s) that no train takes less than for a distance (m)."""
    return max(1.0, abs(distance_m) / (SPEED.spans[-1][1] / 3.6))


def plausible_s(distance_m: float, speed_mps: float, stands: int) -> float:
    """Time (s) that no train takes less than for a distance (m) at a line's speed, from or to `stands` stands (0 to 2).

    Each start from a stand, and each stop at one, is at CHANGE_MPS2; where the distance is too short for it, the speed
    is not reached.
    """
    length_m = abs(distance_m)
    if stands and length_m < stands * speed_mps**2 / (2.0 * CHANGE_MPS2):
        return math.sqrt(2.0 * stands * length_m / CHANGE_MPS2)
    return length_m / speed_mps + stands * speed_mps / (2.0 * CHANGE_MPS2)


def observed_running(trains: Iterable[Sequence[Call]], *, rough: bool = False) -> Running:
    """Running times of the quickest trains of a timetable, from departure to arrival.

    `rough`: where no arrival is published, from departure to departure less DWELL_S, for which the train that stands
    shortest counts; too short by up to a minute where times are in whole ones.
    """
    to_arrival: dict[StationRun, int] = {}
    to_departure: dict[StationRun, int] = {}
    for calls in trains:
        for before, after in pairwise(calls):
            if before.departure_s is None:
                continue
            exact = after.arrival_s is not None or not after.stops
            time_s = after.arrival_s if after.arrival_s is not None else after.departure_s
            if time_s is None or time_s <= before.departure_s:
                continue
            table, leg = (to_arrival if exact else to_departure), leg_of(before, after)
            run_s = time_s - before.departure_s
            table[leg] = min(table.get(leg, run_s), run_s)
    if not rough:
        return to_arrival.get
    known: Mapping[StationRun, float] = {
        **{leg: max(time_s - DWELL_S, time_s / 2) for leg, time_s in to_departure.items()},
        **to_arrival,
    }
    return known.get


def with_all_times(
    calls: Sequence[Call], positions_m: Sequence[float], times: KnownRunningTimes
) -> tuple[Call, ...]:
    """Calls with the times that the source leaves out, inferred; `positions_m` (m) are those of the calls' stations.

    Raises UntimedError where nothing before or after tells when the train is there.
    """
    given = list(calls)
    _fill_untimed(given, positions_m, times)
    for i, call in enumerate(given):
        if not call.stops or i == 0:
            continue
        if call.arrival_s is None:
            given[i] = replace(call, arrival_s=_arrival_s(given[i - 1], call, times), inferred=True)
        elif call.departure_s is None and i < len(given) - 1:
            latest_s = max(call.arrival_s, given[i + 1].first_s - 1)
            given[i] = replace(call, departure_s=min(call.arrival_s + DWELL_S, latest_s), inferred=True)
    return tuple(given)


def _arrival_s(before: Call, call: Call, times: KnownRunningTimes) -> int:
    """Arrival of a train whose departure alone is known: DWELL_S before it, unless it is known to be there earlier.

    Not before it can be there; at its departure where it cannot be there by then either.
    """
    left_s, leaves_s, leg = before.last_s, call.last_s, leg_of(before, call)
    run_s, least_run_s = times.exact(leg), times.least(leg)
    there_s = leaves_s - DWELL_S
    if run_s is not None:
        there_s = min(there_s, left_s + round(run_s))
    return min(leaves_s, max(there_s, left_s + max(1, math.ceil(least_run_s))))


def _untimed(call: Call) -> bool:
    return call.arrival_s is None and call.departure_s is None


def _fill_untimed(calls: list[Call], positions_m: Sequence[float], times: KnownRunningTimes) -> None:
    """Calls with no time at all lie between those around them in proportion of the legs' running times."""
    timed = [i for i, call in enumerate(calls) if not _untimed(call)]
    if not timed:
        raise UntimedError("no time is given at all")
    _fill_ends(calls, timed, times)
    timed = [i for i, call in enumerate(calls) if not _untimed(call)]
    for first, last in pairwise(timed):
        if last == first + 1:
            continue
        from_s = calls[first].last_s
        legs = range(first, last)
        least = [least_s(positions_m[i + 1] - positions_m[i]) for i in legs]
        span_s = calls[last].first_s - from_s
        if calls[last].stops and calls[last].arrival_s is None:
            span_s = max(span_s - DWELL_S, min(span_s, math.ceil(sum(least))))
        spare_s = max(span_s - sum(least), 0.0)
        times_s = [
            run_s + spare_s * share
            for run_s, share in zip(least, _shares(calls, least, legs, times.rough), strict=True)
        ]
        for i in range(first + 1, last):
            calls[i] = _at(calls[i], from_s + round(sum(times_s[: i - first])))


def _fill_ends(calls: list[Call], timed: Sequence[int], times: KnownRunningTimes) -> None:
    """What lies before the first and after the last time given follows from running times, or is not known."""
    for i in range(timed[0] - 1, -1, -1):
        run_s = _run_s(leg_of(calls[i], calls[i + 1]), times)
        if run_s is None:
            raise UntimedError(f"no time is given at {calls[i].station_id}, where it begins")
        calls[i] = _at(calls[i], calls[i + 1].first_s - round(run_s))
    for i in range(timed[-1] + 1, len(calls)):
        run_s = _run_s(leg_of(calls[i - 1], calls[i]), times)
        if run_s is None:
            raise UntimedError(f"no time is given at {calls[i].station_id}, where it ends")
        calls[i] = _at(calls[i], calls[i - 1].last_s + round(run_s))


def _run_s(leg: StationRun, times: KnownRunningTimes) -> float | None:
    run_s = times.rough(leg)
    return None if run_s is None else max(run_s, math.ceil(times.least(leg)))


def _at(call: Call, time_s: int) -> Call:
    return replace(call, arrival_s=time_s if call.stops else None, departure_s=time_s, inferred=True)


def _shares(calls: Sequence[Call], least: Sequence[float], legs: range, running: Running) -> list[float]:
    """What part each leg has of the time over the least: that of its running time, else that of its length."""
    runs = [running(leg_of(calls[i], calls[i + 1])) for i in legs]
    known = [run_s for run_s in runs if run_s is not None]
    weights = known if len(known) == len(runs) else least
    return [weight / sum(weights) for weight in weights]
