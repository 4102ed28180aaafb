"""The null method: the same reserves spread evenly over all runs, whatever is likely to happen."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from plan.reserves.delays import PlannedTimes
from plan.reserves.model import MOVE_S, LinearRows, ShapeTimes
from plan.reserves.problem import ReserveProblem

EVEN: Final = 100.0  # weight of the greatest deviation against the sum of all
ROOM_S: Final = 60  # assumed: more room at a meet is no reserve


def spread_evenly(problem: ReserveProblem, move_s: int = MOVE_S) -> PlannedTimes:
    """Runs longer by one share, stops as short as they may, as nearly as meets allow; most room at meets then."""
    shapes, rows = ShapeTimes(problem, move_s), LinearRows()
    differences = list(shapes.differences())
    between, cost = shapes.between(), [0.0] * shapes.count
    room, worst = len(cost), len(cost) + 1
    between += [(0.0, ROOM_S), (0.0, math.inf)]
    cost += [-1.0, EVEN]
    within = set(_within_trains(shapes))
    for after, before, least in differences:
        meets = [] if (after, before) in within else [(room, -1.0)]
        rows.add(((after, 1.0), (before, -1.0), *meets), least)
    for begins, train in shapes.trains.items():
        stays_s = sum(s.stay_s for s in train.stops[:-1])
        run_s = sum(s.run_s for s in train.stops)
        share = (train.journey_s - stays_s) / run_s
        for at, stop in enumerate(train.stops[1:]):
            arrives = begins + 2 * at + 1
            wanted = [(arrives, arrives - 1, share * stop.run_s)]
            if stop.departure_s is not None:
                wanted.append((arrives + 1, arrives, stop.stay_s))
            for after, before, length_s in wanted:
                off = len(cost)
                cost.append(1.0)
                between.append((0.0, math.inf))
                rows.add(((off, 1.0), (after, -1.0), (before, 1.0)), -length_s)
                rows.add(((off, 1.0), (after, 1.0), (before, -1.0)), length_s)
                rows.add(((worst, 1.0), (off, -1.0)), 0.0)
    values, _ = rows.minimise(cost, between)
    return shapes.times([math.floor(value + 0.5) for value in values[: shapes.count]])


def _within_trains(shapes: ShapeTimes) -> Iterator[tuple[int, int]]:
    """The pairs of variables between which a train's own runs, stops and journey are."""
    for begins, train in shapes.trains.items():
        ends = begins + 2 * len(train.stops) - 3
        yield begins, ends
        yield from ((at, at - 1) for at in range(begins + 1, ends + 1))
