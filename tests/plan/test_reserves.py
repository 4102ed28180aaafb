"""Reserves placed against sampled days: by hand, against every timetable there is, and on a line."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import pytest

import plan.reserves.problem as problem_module
from plan.reserves.delays import PlannedTimes, SampledDelays, events_of, planned_times
from plan.reserves.evenly import spread_evenly
from plan.reserves.model import least_late
from plan.reserves.problem import (
    PlanEvent,
    ReserveProblem,
    ReserveStop,
    ReserveTrain,
    SectionWait,
    reserve_problem,
)
from plan.reserves.robust import TRAINING_SEED, most_robust, timetables_of
from plan.reserves.sampled import SampledDay, sampled_days
from scenario.part_of_day import part_of_day
from scenario.scenario import load_scenario
from simulation.late_day import DrawnStay
from study.feasibility.check import feasibility
from tests.plain import run_on_plain


def train(number: str, departs_s: int, legs: list[tuple[str, int, int, float, float]]) -> ReserveTrain:
    """Legs: where to, arrival and departure after the first departure, least run and stand."""
    stops = [ReserveStop("X", departs_s, departs_s, False, 0.0, 0.0)]
    for place, arrives, departs, run_s, stay_s in legs:
        leaves_s = None if place == legs[-1][0] else departs_s + departs
        stops.append(ReserveStop(place, departs_s + arrives, leaves_s, True, run_s, stay_s))
    return ReserveTrain(number, tuple(stops), None, 0.0, None)


def test_a_reserve_goes_where_people_take_longer() -> None:
    """20 s of reserve lie before Y, where people need 20 s more: Z is reached 20 s late until they lie behind."""
    own = train("1", 0, [("Y", 120, 150, 100.0, 30.0), ("Z", 250, 0, 100.0, 0.0)])
    problem = ReserveProblem({"1": own}, ())
    day = SampledDay({}, {("1", "Y"): DrawnStay(20.0)})
    assert SampledDelays(problem, [day]).mean_s(planned_times(problem)) == 10.0
    found = least_late(problem, [day])
    assert (found.mean_s, found.bound_s) == (0.0, pytest.approx(0.0))
    assert found.times[PlanEvent("1", 2, departs=False)] <= 250
    # spread evenly: 10 s on each run, half of which comes too early to be of use
    evenly = SampledDelays(problem, [day]).mean_s(spread_evenly(problem))
    assert evenly == 5.0


def small_problem() -> ReserveProblem:
    """Two trains of one shape 40 s apart, and one the other way between them on the single track X - Y."""
    there = [("Y", 12, 15, 10.0, 2.0), ("Z", 26, 0, 10.0, 0.0)]
    one, other = train("1", 0, there), train("3", 40, there)
    back = train("2", 20, [("W", 12, 0, 10.0, 0.0)])
    waits = (
        SectionWait(PlanEvent("1", 1, departs=False), PlanEvent("2", 0, departs=True), 8.0, "X-Y"),
        SectionWait(PlanEvent("2", 1, departs=False), PlanEvent("3", 0, departs=True), 8.0, "X-Y"),
    )
    return ReserveProblem({"1": one, "2": back, "3": other}, waits, early_s=1.0)


DAYS = (
    SampledDay({}, {("1", "Y"): DrawnStay(6.0), ("3", "Y"): DrawnStay(1.0), ("2", "X"): DrawnStay(0.0, 2.0)}),
    SampledDay({}, {("1", "X"): DrawnStay(0.0, 7.0), ("3", "Y"): DrawnStay(3.0, 1.0)}),
    SampledDay({}, {("1", "Y"): DrawnStay(2.0), ("2", "X"): DrawnStay(0.0, 4.0)}),
)


def mean_by_hand(a: tuple[int, int, int], b: tuple[int, int]) -> float:
    """The mean delay of all arrivals, one train after the other. `a`: Y, from Y, Z; `b`: from Y, W."""
    late_s: list[float] = []

    def runs(number: str, first_s: float, day: SampledDay, ready_s: float) -> float:
        y, from_y, z = (first_s + time for time in a)
        drawn = {place: day.stays.get((number, place), DrawnStay()) for place in "XY"}
        left = max(first_s + drawn["X"].doors_s, ready_s)
        at_y = max(left + 10, y - 1)
        left = max(from_y + drawn["Y"].doors_s, at_y + 2 + drawn["Y"].people_s + drawn["Y"].doors_s)
        late_s.extend((max(at_y - y, 0.0), max(left + 10 - z, 0.0)))
        return at_y

    for day in DAYS:
        at_y = runs("1", 0, day, 0)
        doors_s = day.stays.get(("2", "X"), DrawnStay()).doors_s
        at_w = max(max(b[0] + doors_s, at_y + 8) + 10, b[1] - 1)
        late_s.append(max(at_w - b[1], 0.0))
        runs("3", 40, day, at_w + 8)
    return sum(late_s) / len(late_s)


def every_timetable() -> Iterator[tuple[tuple[int, int, int], tuple[int, int]]]:
    for y in range(10, 15):
        for from_y in range(y + 2, 17):
            for z in range(from_y + 10, 27):
                for back in range(y + 8, 23):
                    for w in range(back + 10, min(back + 12, 32) + 1):
                        yield (y, from_y, z), (back, w)


def test_no_timetable_is_better_of_all_that_there_are() -> None:
    problem = small_problem()
    found = least_late(problem, DAYS)
    least = min(mean_by_hand(*times) for times in every_timetable())
    assert found.mean_s == pytest.approx(least)
    assert found.bound_s == pytest.approx(least)
    times = found.times
    a = tuple(times[PlanEvent("1", stop, departs)] for stop, departs in ((1, False), (1, True), (2, False)))
    b = times[PlanEvent("2", 0, departs=True)], times[PlanEvent("2", 1, departs=False)]
    assert (a, b) in set(every_timetable())
    assert mean_by_hand((a[0], a[1], a[2]), b) == pytest.approx(found.mean_s)


def test_without_waiting_for_one_another_less_is_lost() -> None:
    problem = small_problem()
    alone = least_late(replace(problem, waits=()), DAYS)
    assert alone.bound_s < least_late(problem, DAYS).bound_s - 0.1


def journeys(problem: ReserveProblem, times: PlannedTimes) -> dict[str, int]:
    ends = {number: len(own.stops) - 1 for number, own in problem.trains.items()}
    return {
        number: times[PlanEvent(number, last, departs=False)] - times[PlanEvent(number, 0, departs=True)]
        for number, last in ends.items()
    }


LATE = "karasuyama_late"


def test_the_published_day_with_its_reserves_placed() -> None:
    """No journey is longer, no order another, `check` lets it run, and neither its own nor even reserves are better."""
    setup = load_scenario(LATE).setup
    found = most_robust(setup, 4, range(1, 9))
    assert found.bound_s <= found.placed.trained_s <= found.bound_s + 0.2
    assert found.placed.trained_s <= min(found.evenly.trained_s, found.as_it_is.trained_s)
    before, after = (journeys(found.problem, plan.times) for plan in (found.as_it_is, found.placed))
    assert all(after[number] <= before[number] for number in before)
    placed, _ = timetables_of(setup, found, "placed")
    judged = feasibility(replace(setup, timetable=placed))
    assert judged.good
    for own in placed.trains.values():
        times_s = [s for call in own.calls for s in (call.arrival_s, call.departure_s) if s is not None]
        assert all(one <= other for one, other in pairwise(times_s))
    assert set(found.training_seeds).isdisjoint(found.fresh_seeds)
    assert found.training_seeds.start == TRAINING_SEED


def test_the_model_is_as_late_as_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of single trains' delays on a morning when the first one comes 12 minutes late and others wait for it."""
    morning = part_of_day(load_scenario(LATE, 3), None, "09:00")
    setup = morning.setup
    ran = run_on_plain(morning).result
    whole = reserve_problem(load_scenario(LATE).setup)
    (day,) = sampled_days(load_scenario(LATE).setup, [3])
    model = dict(
        zip(events_of(whole), SampledDelays(whole, [day]).late_s(planned_times(whole))[:, 0], strict=True)
    )
    off_s: list[float] = []
    for stop in ran.stops:
        call = next(c for c in setup.timetable.trains[stop.number].calls if c.station_id == stop.station_id)
        stops = whole.trains[stop.number].stops
        at = next((i for i, one in enumerate(stops) if one.station_id == stop.station_id), None)
        if at and stop.arrival_s is not None and call.arrival_s is not None:
            late_s = max(stop.arrival_s - call.arrival_s, 0.0)
            off_s.append(late_s - max(model[PlanEvent(stop.number, at, departs=False)], 0.0))
    assert len(off_s) > 20
    assert abs(sum(off_s) / len(off_s)) < 6.0
    monkeypatch.setattr(problem_module, "ORDERED", False)
    assert reserve_problem(load_scenario(LATE).setup).waits == ()
