"""A timetable with other times, in words and as a file."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import replace

from network.timetable import Call, Timetable, TimetableTrain
from plan.reserves.delays import PlannedTimes
from plan.reserves.problem import PlanEvent, ReserveProblem, ReserveTrain


def with_times(
    timetable: Timetable, problem: ReserveProblem, times: PlannedTimes, timetable_id: str, made: str
) -> Timetable:
    """The timetable with these times; a station that a train runs through keeps its share of the way between stops."""
    head = timetable.head.model_copy(update={"id": timetable_id, "assumed": [*timetable.head.assumed, made]})
    trains = {
        number: _moved(train, problem.trains[number], times) for number, train in timetable.trains.items()
    }
    return replace(timetable, head=head, trains=trains)


def _moved(train: TimetableTrain, own: ReserveTrain, times: PlannedTimes) -> TimetableTrain:
    knots = sorted(_knots(own, times).items())
    calls = tuple(
        replace(call, arrival_s=_at(call.arrival_s, knots), departure_s=_at(call.departure_s, knots))
        if not call.stops
        else _stop(call, own, times)
        for call in train.calls
    )
    return replace(train, calls=calls)


def _stop(call: Call, own: ReserveTrain, times: PlannedTimes) -> Call:
    at = next(index for index, stop in enumerate(own.stops) if stop.station_id == call.station_id)
    arrives, departs = (PlanEvent(own.number, at, departs=departs) for departs in (False, True))
    return replace(
        call,
        arrival_s=None if call.arrival_s is None else times.get(arrives, call.arrival_s),
        departure_s=None if call.departure_s is None else times.get(departs, call.departure_s),
    )


def _knots(own: ReserveTrain, times: PlannedTimes) -> Mapping[int, int]:
    found: dict[int, int] = {}
    for index, stop in enumerate(own.stops):
        if index:
            found[stop.arrival_s] = times[PlanEvent(own.number, index, departs=False)]
        if stop.departure_s is not None:
            found[stop.departure_s] = times[PlanEvent(own.number, index, departs=True)]
    return found


def _at(time_s: int | None, knots: list[tuple[int, int]]) -> int | None:
    if time_s is None:
        return None
    after = min(max(bisect_right(knots, (time_s, 10**9)), 1), len(knots) - 1)
    (from_s, new_from_s), (to_s, new_to_s) = knots[after - 1], knots[after]
    share = (time_s - from_s) / (to_s - from_s) if to_s > from_s else 0.0
    return round(new_from_s + share * (new_to_s - new_from_s))


def reserves_of(
    problem: ReserveProblem, times: PlannedTimes
) -> Iterator[tuple[ReserveTrain, int, list[tuple[str, float, float]]]]:
    """One train of each shape, by how much its first departure is moved, s, and its stops.

    Of each stop the station, the reserve of the run there and that of the stand, s.
    """
    seen: set[object] = set()
    for train in problem.trains.values():
        if train.shape in seen:
            continue
        seen.add(train.shape)
        rows: list[tuple[str, float, float]] = []
        for index, stop in enumerate(train.stops):
            arrives, departs = (PlanEvent(train.number, index, departs=departs) for departs in (False, True))
            run_s = 0.0
            if index:
                left = PlanEvent(train.number, index - 1, departs=True)
                run_s = times[arrives] - times[left] - stop.run_s
            stay_s = times[departs] - times[arrives] - stop.stay_s if index and departs in times else 0.0
            rows.append((stop.station_id, run_s, stay_s))
        first = PlanEvent(train.number, 0, departs=True)
        yield train, times[first] - problem.planned_s(first), rows
