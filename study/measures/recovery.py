"""When a line was late, and how long until no train was any more (遅延の回復).

A train is late from LATE_S after a departure that it should have made, until it leaves a stop less late than that or
has come to its last; one that never comes there is late from the first call that it misses until the run ends whatever
happens, a call that was cancelled for as long as the scenario states. Stretches of such times, of all trains together,
are cut where for a moment no train is late.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from network.clock import first_given
from network.timetable import Timetable
from simulation.result import StopRecord
from simulation.setup import latest_end_s

LATE_S: Final = 60.0  # a departure that much after plan is late, as `study.drilling.scores` has it


@dataclass(frozen=True, slots=True)
class LateStretch:
    """From when to when at least one train was late, s; `over`: the run did not end with it."""

    from_s: float
    to_s: float
    over: bool = True

    @property
    def length_s(self) -> float:
        """How long, s."""
        return self.to_s - self.from_s


def late_stretches(
    stops: Sequence[StopRecord], timetable: Timetable, end_s: float | None = None
) -> tuple[LateStretch, ...]:
    """All of a run's, in order, without overlap. `end_s`: when it ends whatever happens, or how far it has come; None:
    by the usual limit.
    """
    end_s = latest_end_s(timetable) if end_s is None else end_s
    by_train: dict[str, list[StopRecord]] = defaultdict(list)
    for stop in stops:
        if not stop.cancelled:
            by_train[stop.number].append(stop)
    cancelled = [stop for stop in stops if stop.cancelled]
    cut = {(stop.number, stop.station_id) for stop in cancelled}
    found = [
        one
        for number, own in by_train.items()
        for one in _of_train(own, timetable.trains[number].calls[-1].station_id, end_s)
    ]
    for number, train in timetable.trains.items():
        own = by_train.get(number, ())
        came = {s.station_id for s in own if (s.arrival_s, s.departure_s) != (None, None)}
        ahead = max((k for k, call in enumerate(train.calls, 1) if call.station_id in came), default=0)
        missed = next((call for call in train.calls[ahead:] if call.stops), None)
        if missed is None or (number, train.calls[-1].station_id) in cut:
            continue
        if missed.last_s + LATE_S < end_s:
            found.append(LateStretch(missed.last_s + LATE_S, end_s, over=False))
    for stop in cancelled:
        planned_s = first_given(stop.planned_departure_s, stop.planned_arrival_s, 0.0)
        found.append(LateStretch(planned_s + LATE_S, planned_s + (stop.stated_late_s or 0.0) + LATE_S))
    return joined_stretches(found)


def _of_train(stops: Sequence[StopRecord], last_id: str, end_s: float) -> list[LateStretch]:
    """When a train was late: from a departure that it missed to the next one that it made, or to its last stop."""
    found: list[LateStretch] = []
    for stop, following in pairwise([*stops, None]):
        if stop is None or stop.planned_departure_s is None:
            continue
        from_s = stop.planned_departure_s + LATE_S
        if (stop.departure_s if stop.departure_s is not None else end_s) < from_s:
            continue
        if following is None:  # it leaves the line, or never came to where it was to go
            to_s = stop.departure_s if stop.station_id == last_id else None
        elif following.planned_departure_s is not None:
            to_s = following.departure_s
        else:
            to_s = following.arrival_s
        found.append(LateStretch(from_s, end_s if to_s is None else max(to_s, from_s), to_s is not None))
    return found


def joined_stretches(stretches: Iterable[LateStretch]) -> tuple[LateStretch, ...]:
    """Stretches that overlap or meet made one."""
    found: list[LateStretch] = []
    for one in sorted(stretches, key=lambda stretch: stretch.from_s):
        last = found[-1] if found else None
        if last is None or one.from_s > last.to_s:
            found.append(one)
        else:
            found[-1] = LateStretch(last.from_s, max(last.to_s, one.to_s), last.over and one.over)
    return tuple(found)


def recoveries_s(begun_s: Iterable[float], stretches: Sequence[LateStretch]) -> tuple[float, ...]:
    """For each delay, by when it was there: how long until no train was late any more, s; 0 where none was."""
    return tuple(
        next((one.to_s - at_s for one in stretches if one.from_s <= at_s < one.to_s), 0.0) for at_s in begun_s
    )
