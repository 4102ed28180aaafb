"""The table of stops: every call of every train as planned and as it went, passings by the truth of its trajectory."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import polars as pl
from numpy.typing import NDArray

from network.timetable import CallKind
from simulation.result import StopRecord, TraceSpan
from simulation.setup import STEPS_PER_S
from study.measures.passings import PlannedPassing
from study.record.calls import CallAsRun
from study.record.tables import make_table

Times = tuple[float | None, float | None]  # of arrival and departure, s


@dataclass(frozen=True, slots=True)
class Passed:
    """A passing and when it came, s; None: it did not."""

    planned: PlannedPassing
    time_s: float | None


def passed(
    passings: Sequence[PlannedPassing], spans: Iterable[tuple[TraceSpan, NDArray[np.void]]]
) -> tuple[Passed, ...]:
    """When each front passed, between the rows of its trajectory; `spans` are those of `rows_by_span`."""
    by_number = {span.number: (span, rows) for span, rows in spans}
    return tuple(Passed(passing, _time_s(passing, by_number.get(passing.number))) for passing in passings)


def _time_s(passing: PlannedPassing, found: tuple[TraceSpan, NDArray[np.void]] | None) -> float | None:
    if found is None or passing.piece_id not in found[0].piece_ids:
        return None
    span, rows = found
    index = span.piece_ids.index(passing.piece_id)
    at_m = span.starts_m[index] + abs(passing.kilometrage_m - span.entries_m[index])
    front_m, time_s = rows["position_m"], rows["step"] / STEPS_PER_S
    if not front_m[0] <= at_m <= front_m[-1]:
        return None
    return round(float(np.interp(at_m, front_m, time_s)), 1)


def stops_table(stops: Sequence[StopRecord], passings: Sequence[Passed] = ()) -> pl.DataFrame:
    """The table: each passing before the stop that follows it, or behind the train's last row if that never came."""
    before: dict[tuple[str, str], list[Passed]] = {}
    for one in passings:
        before.setdefault((one.planned.number, one.planned.before), []).append(one)
    rows: list[CallAsRun] = []
    for stop in stops:
        rows += [_of_passing(one) for one in before.pop((stop.number, stop.station_id), ())]
        rows.append(_of_stop(stop))
    ran = {stop.number for stop in stops}
    rows += [_of_passing(one) for kept in before.values() for one in kept if one.planned.number in ran]
    return make_table("stops", rows)


def _of_stop(stop: StopRecord) -> CallAsRun:
    kind = CallKind.STOP if stop.passengers else CallKind.OPERATIONAL
    planned_s = _float(stop.planned_arrival_s), _float(stop.planned_departure_s)
    return _call(stop, kind, planned_s, (_float(stop.arrival_s), _float(stop.departure_s)), stop.error_m)


def _of_passing(one: Passed) -> CallAsRun:
    return _call(one.planned, CallKind.PASS, (None, one.planned.time_s), (None, one.time_s), None)


def _call(
    of: StopRecord | PlannedPassing, kind: CallKind, planned_s: Times, actual_s: Times, error_m: float | None
) -> CallAsRun:
    late_s = _late(actual_s[0], planned_s[0]), _late(actual_s[1], planned_s[1])
    return CallAsRun(
        of.stock_id,
        of.number,
        of.revenue,
        of.station_id,
        of.track,
        kind,
        *planned_s,
        *actual_s,
        *late_s,
        stop_error_m=error_m,
    )


def _float(value: float | None) -> float | None:
    return None if value is None else float(value)


def _late(actual_s: float | None, planned_s: float | None) -> float | None:
    return None if actual_s is None or planned_s is None else round(actual_s - planned_s, 1)
