"""A day in a few figures, from the stops as they went: what sweeps compare, and reports give in one line.

Lateness is always against the plan, s; what never came counts as not on time, and by itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

import msgspec
import numpy as np

from simulation.result import StopRecord

LIMITS_S: Final = (
    60.0,
    180.0,
    300.0,
)  # on time to the minute; UIC's and a common limit of punctuality, assumed


class DayFigures(msgspec.Struct, frozen=True):
    """Figures of one day. Lateness of arrivals of trains with passengers, s; None where no arrival was planned.

    `within`: share of the planned arrivals later than plan by less than each of LIMITS_S. `lost_train_minutes`: by how
    much trains came late to their last stop, together; trains that never came there are `missing`.
    """

    planned_trains: int
    arrived_trains: int
    missing: tuple[str, ...]
    planned_arrivals: int
    arrivals: int
    within: tuple[float, ...]
    mean_late_s: float | None
    median_late_s: float | None
    p95_late_s: float | None
    worst_late_s: float | None
    worst_train: str
    worst_station: str
    lost_train_minutes: float


def day_figures(stops: Iterable[StopRecord]) -> DayFigures:
    """The figures of a day's stops."""
    calls = [stop for stop in stops if stop.revenue]
    last = {stop.number: stop for stop in calls}
    missing = tuple(sorted(number for number, stop in last.items() if stop.arrival_s is None))
    planned = [stop for stop in calls if stop.planned_arrival_s is not None]
    came = [stop for stop in planned if stop.arrival_s is not None]
    late = {id(stop): _late_s(stop) for stop in came}
    late_s = np.array([late[id(stop)] for stop in came])
    worst = max(came, key=lambda stop: late[id(stop)], default=None)
    ends = [_late_s(stop) for stop in last.values() if stop.arrival_s is not None]
    return DayFigures(
        planned_trains=len(last),
        arrived_trains=len(last) - len(missing),
        missing=missing,
        planned_arrivals=len(planned),
        arrivals=len(came),
        within=tuple(sum(s < limit_s for s in late.values()) / max(len(planned), 1) for limit_s in LIMITS_S),
        mean_late_s=_rounded(float(late_s.mean())) if came else None,
        median_late_s=_rounded(float(np.median(late_s))) if came else None,
        p95_late_s=_rounded(float(np.quantile(late_s, 0.95))) if came else None,
        worst_late_s=None if worst is None else _rounded(late[id(worst)]),
        worst_train="" if worst is None else worst.number,
        worst_station="" if worst is None else worst.station_id,
        lost_train_minutes=_rounded(math.fsum(max(s, 0.0) for s in ends) / 60.0),
    )


def _late_s(stop: StopRecord) -> float:
    """Of a stop that was reached."""
    if stop.arrival_s is None or stop.planned_arrival_s is None:
        return 0.0
    return stop.arrival_s - stop.planned_arrival_s


def _rounded(value: float) -> float:
    return round(value, 3)
