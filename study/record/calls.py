"""How trains ran: the rows of the tables `trajectory` and `stops`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Final

import polars as pl

from network.timetable import CallKind
from study.record.columns import STATION, Revenue, Train, Unit, Way, clock
from study.record.figure import Figure, Kind, ShownIn
from study.wording.catalogue import phrase

TRACK: Final = Figure(phrase("track"), seen=ShownIn.REPORT, kind=Kind.TEXT)
CALL: Final = Figure(phrase("kind"), seen=ShownIn.REPORT, kind=Kind.CALL)
_WHERE: Final = replace(STATION, seen=ShownIn.REPORT | ShownIn.ROWS_NAMED)
_LISTED: Final = ShownIn.REPORT | ShownIn.ROWS_COMPARED | ShownIn.ROWS_LISTED


@dataclass(frozen=True, slots=True)
class TracePoint:
    """One second of a moving train, and each of its events."""

    t_s: float
    unit: str
    train: str
    direction: Way
    kilometrage_m: Annotated[float, "of the front"]
    piece: str
    speed_mps: float
    acceleration_mps2: float
    notch: Annotated[float, "above 0 power, below 0 brake"]
    permitted_mps: Annotated[float, "by supervision"]
    target_mps: float
    intervention: Annotated[int, pl.Int8, "0: none; otherwise supervision brakes"]
    estimate_error_m: Annotated[float, "where the unit believes its front to be, less where it is"]
    bound_ahead_m: float
    bound_behind_m: float


@dataclass(frozen=True, slots=True)
class CallAsRun:
    """One call of a train, in order of travel, from its first one on.

    Where it passes there is no arrival: it is planned to depart, and departs, when its front passes the mark.
    """

    unit: Unit
    train: Train
    revenue: Revenue
    station: Annotated[str, _WHERE]
    track: Annotated[str, TRACK]
    kind: Annotated[CallKind, CALL]
    planned_arrival_s: Annotated[float | None, clock("planned arrival")]
    planned_departure_s: Annotated[float | None, clock("planned departure")]
    arrival_s: Annotated[float | None, clock("arrival", context="as run")]
    departure_s: Annotated[float | None, clock("departure", context="as run")]
    late_arrival_s: float | None
    late_departure_s: float | None
    stop_error_m: Annotated[
        float | None,
        Figure(
            phrase("error"),
            "m",
            3,
            seen=_LISTED,
            kind=Kind.SIGNED,
        ),
        "front beyond the mark is positive",
    ]
    cancelled: Annotated[
        bool,
        Figure(phrase("cancelled"), seen=ShownIn.REPORT, kind=Kind.TEXT),
        "by the dispatcher; it counts as late as the scenario states",
    ] = False
