"""The trains of a run as timetables have them: the day as it was, beside the day as planned."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import polars as pl

from network.timetable import Call, CallKind, Stabled, Timetable, TimetableTrain


def trains_as_run(timetable: Timetable, stops: pl.DataFrame) -> tuple[TimetableTrain, ...]:
    """Trains of a table of stops with their true times, in whole seconds, and the tracks that they stood on.

    A train that never left its first stop is none of them; one that did not come to its end stands where it was last.
    """
    rows: dict[str, list[dict[str, Any]]] = {}
    for row in stops.iter_rows(named=True):
        rows.setdefault(row["train"], []).append(row)
    found: list[TimetableTrain] = []
    for number, train in timetable.trains.items():
        calls = tuple(_call(row) for row in rows.get(number, ()) if _came(row))
        if not calls or (len(calls) == 1 < len(train.calls) and calls[0].departure_s is None):
            continue
        ends = train.ends if calls[-1].station_id == train.calls[-1].station_id else Stabled()
        begins = train.begins if calls[0].station_id == train.calls[0].station_id else Stabled()
        found.append(replace(train, calls=calls, begins=begins, ends=ends))
    return tuple(found)


def _came(row: dict[str, Any]) -> bool:
    return row["arrival_s"] is not None or row["departure_s"] is not None


def _call(row: dict[str, Any]) -> Call:
    kind = CallKind(row["kind"])
    arrival_s = None if row["arrival_s"] is None or kind is CallKind.PASS else round(row["arrival_s"])
    departure_s = None if row["departure_s"] is None else round(row["departure_s"])
    return Call(row["station"], row["track"], arrival_s, departure_s, kind)
