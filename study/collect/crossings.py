"""Level crossings of a run as tables: when their roads were closed, and how long they had warned as fronts came."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import product

import polars as pl

from network.model import Line
from simulation.result import RunResult, TraceSpan
from simulation.setup import STEP_S, STEPS_PER_S
from study.collect.energy_hours import HOUR_S, shares
from study.measures.road_closures import FrontAtCrossing, RoadClosure, RoadsClosed, roads_closed
from study.record.crossings import CrossingHour, CrossingPassage
from study.record.tables import make_table


def crossing_tables(result: RunResult, line: Line) -> dict[str, pl.DataFrame]:
    """The tables `crossings`, by crossing and hour, and `warnings`, in the order of time; empty without crossings."""
    roads = roads_closed(result.journal.entries, result.end_step * STEP_S)
    number_at = _numbers(result)
    warns = [crossing.id for crossing in line.crossings.values() if crossing.has_device]
    return {
        "crossings": make_table("crossings", hours_of(roads, product(warns, hours_run(result)))),
        "warnings": make_table(
            "warnings", [_passage(front, number_at(front.unit_id, front.at_s)) for front in roads.fronts]
        ),
    }


@dataclass(slots=True)
class _HourSeen:
    closed_s: list[float] = field(default_factory=list[float])
    closures_s: list[float] = field(default_factory=list[float])
    warned_s: list[float] = field(default_factory=list[float])


def hours_run(result: RunResult) -> range:
    """The hours of the day that a run meets, from midnight."""
    return range(_hour(result.begin_step * STEP_S), math.ceil(result.end_step * STEP_S / HOUR_S))


def hours_of(roads: RoadsClosed, quiet: Iterable[tuple[str, int]] = ()) -> list[CrossingHour]:
    """A row for each crossing and hour from midnight with a closure or a front, and for those that may be quiet; a
    closure is cut at whole hours.
    """
    seen: dict[tuple[str, int], _HourSeen] = defaultdict(_HourSeen, {key: _HourSeen() for key in quiet})
    for closure in roads.closures:
        for hour, closed_s in _cut(closure):
            seen[closure.crossing_id, hour].closed_s.append(closed_s)
        seen[closure.crossing_id, _hour(closure.from_s)].closures_s.append(closure.length_s)
    for front in roads.fronts:
        seen[front.crossing_id, _hour(front.at_s)].warned_s.append(front.warned_s)
    return [
        CrossingHour(
            crossing,
            hour,
            closed_s=round(math.fsum(it.closed_s), 1),
            closures=len(it.closures_s),
            closure_s_max=max(it.closures_s, default=None),
            trains=len(it.warned_s),
            warned_s_mean=math.fsum(it.warned_s) / len(it.warned_s) if it.warned_s else None,
            warned_s_min=min(it.warned_s, default=None),
            warned_s_max=max(it.warned_s, default=None),
        )
        for (crossing, hour), it in sorted(seen.items())
    ]


def _cut(closure: RoadClosure) -> Iterable[tuple[int, float]]:
    """Hour and seconds of each hour in which it was closed."""
    whole_s = closure.to_s - closure.from_s
    return ((_hour(hour_s), share * whole_s) for hour_s, share in shares(closure.from_s, closure.to_s))


def _hour(t_s: float) -> int:
    return int(t_s // HOUR_S)


def _passage(front: FrontAtCrossing, number: str) -> CrossingPassage:
    return CrossingPassage(
        front.crossing_id,
        number,
        front.unit_id,
        front.at_s,
        front.speed_mps,
        front.warned_s,
        front.closed_s,
        front.ran_s,
        front.from_stand,
    )


def _numbers(result: RunResult) -> Callable[[str, float], str]:
    """Which train a unit was at a time, s; empty before its first."""
    by_unit: dict[str, list[TraceSpan]] = defaultdict(list)
    for span in sorted(result.spans, key=lambda span: span.from_step):
        by_unit[result.stock_ids[span.slot]].append(span)

    def number_at(unit_id: str, t_s: float) -> str:
        spans = by_unit[unit_id]
        index = bisect_left(spans, t_s * STEPS_PER_S, key=lambda span: span.from_step)
        return spans[index - 1].number if index else ""

    return number_at
