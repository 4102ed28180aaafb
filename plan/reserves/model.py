"""The reserves that leave trains least late on average on sampled days: one linear program over all of them.

Sample average approximation (Kleywegt, Shapiro, Homem-de-Mello, SIAM J. Optimization 12, 2002) of a timetable whose
times are chosen once, before the day, and of the delays that follow on each day by `plan.reserves.delays`. With the
order of trains given all of it is linear, so that the optimum is a bound too: on these days no timetable of these
orders does better. Times are differences of two variables each, with whole seconds between them, so rounding all of
them at one threshold keeps what holds between them.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.sparse import coo_matrix

from plan.reserves.delays import PlannedTimes, SampledDelays, events_of, held_s, time_rules
from plan.reserves.problem import PlanEvent, ReserveProblem, ReserveTrain, SectionWait
from plan.reserves.sampled import SampledDay

ITERATIONS_MAX: Final = 500_000  # counted work of a linear program
ROUNDINGS: Final = 10  # thresholds that are tried
MOVE_S: Final = 60  # assumed: nobody calls it another train that leaves a minute sooner or later


@dataclass(frozen=True, slots=True)
class FoundReserves:
    """Times of all trains. `mean_s`: the mean delay of an arrival on the sampled days; none has less than `bound_s`."""

    times: PlannedTimes
    mean_s: float
    bound_s: float


@dataclass(slots=True)
class LinearRows:
    """Rows `sum of coefficients times variables >= least` of a linear program."""

    at: list[int] = field(default_factory=list[int])
    of: list[int] = field(default_factory=list[int])
    factors: list[float] = field(default_factory=list[float])
    least: list[float] = field(default_factory=list[float])

    def add(self, terms: Iterable[tuple[int, float]], least: float) -> None:
        """One more row."""
        for variable, factor in terms:
            self.at.append(len(self.least))
            self.of.append(variable)
            self.factors.append(factor)
        self.least.append(least)

    def minimise(
        self, cost: Sequence[float], between: Sequence[tuple[float, float]]
    ) -> tuple[NDArray[np.float64], float]:
        """The variables and the cost. Raises ValueError where there is no solution."""
        shape = len(self.least), len(cost)
        places = np.array(self.at), np.array(self.of)
        matrix = coo_matrix((-np.array(self.factors), places), shape=shape).tocsr()
        limits = {"maxiter": ITERATIONS_MAX}
        solve = cast("Any", linprog)  # its stub knows no sparse matrices
        found = solve(cost, matrix, -np.array(self.least), bounds=between, method="highs", options=limits)
        if found.x is None or found.status != 0:
            raise ValueError(f"no times were found: {found.message}")
        return np.asarray(found.x), float(found.fun)


class ShapeTimes:
    """The times of a timetable as variables: one a time of a shape, relative to the first departure of its trains."""

    def __init__(self, problem: ReserveProblem, move_s: int) -> None:
        self.problem: Final = problem
        self._move_s: Final = move_s
        shapes = list(dict.fromkeys(train.shape for train in problem.trains.values()))
        self._shape_of: Final = {n: shapes.index(train.shape) for n, train in problem.trains.items()}
        self.trains: Final[dict[int, ReserveTrain]] = {}  # one of each shape, by its first variable
        begins, first = list[int](), 0
        for shape in shapes:
            begins.append(first)
            first += 2 * len(shape)
        self._begins: Final = begins
        for number, train in problem.trains.items():
            self.trains.setdefault(begins[self._shape_of[number]], train)
        self.count: Final = first

    def place(self, event: PlanEvent) -> tuple[int, int]:
        """The variable of a time, and what the train adds to it, s."""
        train = self.problem.trains[event.number]
        at = self._begins[self._shape_of[event.number]] + 2 * event.stop - (0 if event.departs else 1)
        return at, train.stops[0].departure_s or 0

    def times(self, values: Sequence[int]) -> PlannedTimes:
        """The times of all trains by the values of the variables."""
        placed = {event: self.place(event) for event in events_of(self.problem)}
        return {event: values[at] + first_s for event, (at, first_s) in placed.items()}

    def between(self) -> list[tuple[float, float]]:
        """Within what each variable may be: the first departures of the first shape stay, others move so much."""
        found: list[tuple[float, float]] = [(-math.inf, math.inf)] * self.count
        for begins in self._begins:
            found[begins] = (-self._move_s, self._move_s) if begins else (0, 0)
        return found

    def differences(self) -> Iterator[tuple[int, int, int]]:
        """`after`, `before`, `least`: whole seconds between two variables, each pair once."""
        most: dict[tuple[int, int], int] = defaultdict(lambda: -(10**9))
        for after, before, least in self._all():
            most[after, before] = max(most[after, before], least)
        yield from ((after, before, least) for (after, before), least in most.items() if after != before)

    def _all(self) -> Iterator[tuple[int, int, int]]:
        for begins, train in self.trains.items():
            for arrives, stop in enumerate(train.stops[1:]):
                at = begins + 2 * arrives + 1
                leaves_s = train.stops[arrives].departure_s or 0
                yield at, at - 1, min(math.ceil(stop.run_s), stop.arrival_s - leaves_s)
                if stop.departure_s is not None:
                    yield at + 1, at, min(math.ceil(stop.stay_s), stop.departure_s - stop.arrival_s)
            yield begins, begins + 2 * len(train.stops) - 3, -train.journey_s
        for train in self.problem.trains.values():
            if train.follows is not None:
                last = PlanEvent(
                    train.follows, len(self.problem.trains[train.follows].stops) - 1, departs=False
                )
                yield self._difference(PlanEvent(train.number, 0, departs=True), last, train.turn_s)
        for wait in self.problem.waits:
            yield self._difference(wait.after, wait.before, self._planned_s(wait))

    def _planned_s(self, wait: SectionWait) -> float:
        """Nobody is planned to leave for a section before the train in it has come, though its tag frees it sooner."""
        trains = self.problem.trains
        before = trains[wait.before.number].stops[wait.before.stop]
        after = trains[wait.after.number].stops[wait.after.stop]
        meets = before.station_id == after.station_id and not wait.before.departs
        return max(wait.least_s, 0.0) if meets else wait.least_s

    def _difference(self, after: PlanEvent, before: PlanEvent, least_s: float) -> tuple[int, int, int]:
        """A least difference, no more than the timetable itself has."""
        (later, add_s), (sooner, from_s) = self.place(after), self.place(before)
        has_s = self.problem.planned_s(after) - self.problem.planned_s(before)
        return later, sooner, min(math.ceil(least_s), has_s) - add_s + from_s


def least_late(problem: ReserveProblem, days: Sequence[SampledDay], move_s: int = MOVE_S) -> FoundReserves:
    """The times with which arrivals are least late on these days, in whole seconds.

    `move_s`: by how much the first departures of trains of one shape may move together.
    """
    shapes, rows = ShapeTimes(problem, move_s), LinearRows()
    for after, before, least in shapes.differences():
        rows.add(((after, 1.0), (before, -1.0)), least)
    between, cost, events = shapes.between(), [0.0] * shapes.count, list(events_of(problem))
    counts = [e for e in events if not e.departs and problem.trains[e.number].stops[e.stop].counted]
    for day in days:
        at = {event: len(between) + index for index, event in enumerate(events)}
        between += [(held_s(problem, day, event), math.inf) for event in events]
        for rule in time_rules(problem, day):
            (after, add_s), (before, from_s) = shapes.place(rule.after), shapes.place(rule.before)
            terms = ((at[rule.after], 1.0), (after, 1.0), (at[rule.before], -1.0), (before, -1.0))
            rows.add(terms, rule.least_s - add_s + from_s)
        for index, event in enumerate(counts):  # what is late of it: an early arrival is on time
            rows.add(((len(between) + index, 1.0), (at[event], -1.0)), 0.0)
        cost += [0.0] * len(events) + [1.0 / (len(counts) * len(days))] * len(counts)
        between += [(0.0, math.inf)] * len(counts)
    values, bound_s = rows.minimise(cost, between)
    delays = SampledDelays(problem, days)
    rounded = (
        shapes.times([math.floor(value + shift / ROUNDINGS + 1e-6) for value in values[: shapes.count]])
        for shift in range(ROUNDINGS)
    )
    mean_s, times = min(((delays.mean_s(times), times) for times in rounded), key=lambda pair: pair[0])
    return FoundReserves(times, mean_s, bound_s)
