"""The table of stops: every call of every train as planned and as it went, passings by the truth of its trajectory."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import polars as pl
from numpy.typing import NDArray

from network.timetable import CallKind
from onboard.mission import Passing
from simulation.result import StopRecord, TraceSpan
from simulation.setup import STEPS_PER_S
from simulation.world.roster import Duty
from study.record.calls import CallAsRun
from study.record.tables import make_table


def with_passings(
    stops: Sequence[StopRecord], duties: Iterable[Duty], spans: Iterable[tuple[TraceSpan, NDArray[np.void]]]
) -> list[StopRecord]:
    """Each passing of trains that ran before the stop that follows it, or behind all where that never came.

    `spans` are those of `rows_by_span`: a front passes between two rows of its trajectory. A train ordered to go
    another way has one for each.
    """
    by_number: dict[str, list[tuple[TraceSpan, NDArray[np.void]]]] = {}
    for span, rows in spans:
        by_number.setdefault(span.number, []).append((span, rows))
    ahead = {
        (duty.mission.number, target.place_id): [
            _passing(duty, passing, by_number.get(duty.mission.number, ())) for passing in target.passings
        ]
        for duty in duties
        for target in duty.mission.targets
        if target.passings
    }
    records: list[StopRecord] = []
    for stop in stops:
        passings = ahead.pop((stop.number, stop.station_id), ())
        if stop.cancelled:
            passings = [replace(passing, stated_late_s=stop.stated_late_s) for passing in passings]
        records += (*passings, stop)
    ran = {stop.number for stop in stops}
    return records + [passing for kept in ahead.values() for passing in kept if passing.number in ran]


def _passing(duty: Duty, passing: Passing, found: Iterable[tuple[TraceSpan, NDArray[np.void]]]) -> StopRecord:
    mission = duty.mission
    at = mission.path.locate(passing.position_m)
    times_s = (_time_s(*at, *one) for one in found)
    return StopRecord(
        duty.stock_id,
        mission.number,
        mission.revenue,
        passing.station_id,
        passing.track,
        None,
        passing.time_s,
        departure_s=next((time_s for time_s in times_s if time_s is not None), None),
        kind=CallKind.PASS,
    )


def _time_s(piece_id: str, kilometrage_m: float, span: TraceSpan, rows: NDArray[np.void]) -> float | None:
    if piece_id not in span.piece_ids:
        return None
    index = span.piece_ids.index(piece_id)
    at_m = span.starts_m[index] + abs(kilometrage_m - span.entries_m[index])
    front_m, time_s = rows["position_m"], rows["step"] / STEPS_PER_S
    if not front_m[0] <= at_m <= front_m[-1]:
        return None
    return round(float(np.interp(at_m, front_m, time_s)), 1)


def stops_table(calls: Iterable[StopRecord]) -> pl.DataFrame:
    """The table, with how late each call was."""
    return make_table("stops", [_as_run(call) for call in calls])


def _as_run(call: StopRecord) -> CallAsRun:
    return CallAsRun(
        call.stock_id,
        call.number,
        call.revenue,
        call.station_id,
        call.track,
        call.kind,
        _float(call.planned_arrival_s),
        _float(call.planned_departure_s),
        _float(call.arrival_s),
        _float(call.departure_s),
        _late_of(call, call.arrival_s, call.planned_arrival_s),
        _late_of(call, call.departure_s, call.planned_departure_s),
        call.error_m,
        call.cancelled,
    )


def _float(value: float | None) -> float | None:
    return None if value is None else float(value)


def _late_of(call: StopRecord, actual_s: float | None, planned_s: float | None) -> float | None:
    if call.cancelled:
        return None if planned_s is None else call.stated_late_s
    return None if actual_s is None or planned_s is None else round(actual_s - planned_s, 1)
