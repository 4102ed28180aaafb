"""A day in a few figures, from its stops and its journal: what sweeps compare, and reports give in one line.

Lateness is always against the plan, s. What never came is never on time, and counts as if it had come when the run ends
whatever happens: no figure is better for trains that do not come. One pass over stops and journal and no tables: a day
of a sweep takes seconds. Whose fault lateness was is in `study.measures.delays`, when it was over in
`study.measures.recovery`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

import msgspec
import numpy as np

from network.timetable import Timetable
from simulation.events import EventType
from simulation.late_day import counts_of, late_day
from simulation.result import RunResult, StopRecord, numbers_due
from simulation.setup import STEP_S, Setup, latest_end_s
from study.measures import deadlock, delays, road_closures
from study.measures.recovery import LATE_S, late_stretches, recoveries_s

# on time to the minute; UIC's and a common limit of punctuality, assumed
LIMITS_S: Final = (60.0, 180.0, 300.0)
# Of the journal, what figures are made from.
EVENTS: Final[tuple[EventType, ...]] = tuple(
    dict.fromkeys((*delays.READS, *deadlock.READS, *road_closures.READS))
)


class DayFigures(msgspec.Struct, frozen=True):
    """Figures of one day. Lateness of arrivals of trains with passengers, s; None where no arrival was planned.

    `within`: share of the planned arrivals later than plan by less than each of LIMITS_S. `lost_train_minutes`: by how
    much trains came late to their last stop, together; trains that never came there, or never ran, are `missing`. What
    never came is in all of these, as late as `simulation.setup.latest_end_s` makes it. Trains that the dispatcher left
    out are `cancelled`, those that he cut `shortened`; their calls that do not come are as late as the scenario states,
    and a train that was cut counts as lost for that at least, wherever it was. Of a part of a day what is due by its
    end is planned, and no more.

    `primary_s`: by how much lateness grew because of what was drawn or failed, `secondary_s` because a train waited
    for another, `other_s` for neither (driving, minutes of the plan that are too short); together all growth, which
    spare time takes back. `primary_delays` of LATE_S and more; `recovery_mean_s`: from each of those until no train is
    late any more, None on a day without one, `recovery_s`: the longest time without a moment in which none was,
    `late_time_s`: all such time; `recovered`: whether the day ended so. `drawn`: how many things were drawn, by key
    path of their table. `deadlock`: trains that wait for one another in a ring at the end. `mean_delay_s`: as
    `mean_late_s`, what is early as on time.

    `closed_road_min`: minutes in which the roads of level crossings were closed, added up over them, and
    `least_warned_s`: the shortest warning before a front came onto one; None on a line without a crossing that has a
    device. On a day on which a train does not run all of its way all roads count as closed throughout, and one as
    crossed without a warning: roads are open where trains do not come.
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
    primary_s: float = 0.0
    secondary_s: float = 0.0
    other_s: float = 0.0
    primary_delays: int = 0
    recovery_s: float = 0.0
    recovery_mean_s: float | None = None
    late_time_s: float = 0.0
    recovered: bool = True
    drawn: tuple[tuple[str, int], ...] = ()
    deadlock: tuple[str, ...] = ()
    mean_delay_s: float | None = None
    cancelled: tuple[str, ...] = ()
    shortened: tuple[str, ...] = ()
    closed_road_min: float | None = None
    least_warned_s: float | None = None


def day_figures(result: RunResult, setup: Setup) -> DayFigures:
    """The figures of a day that was run."""
    figures = late_figures(result, setup)
    cut = bool(figures.missing or figures.cancelled or figures.shortened)
    closed_min, warned_s = _roads(result, setup, cut=cut)
    return msgspec.structs.replace(figures, closed_road_min=closed_min, least_warned_s=warned_s)


def late_figures(result: RunResult, setup: Setup) -> DayFigures:
    """Those of its trains; of its roads nothing is told."""
    figures = figures_of_stops(result.stops, setup.timetable, setup.latest_end_s)
    grown = delays.delays_of(result, setup)
    end_s = setup.latest_end_s
    stretches = late_stretches(result.stops, setup.timetable, end_s)
    begun = [one for one in grown if one.primary_s >= LATE_S]
    # What never comes counts as there when the run ends, and is late until then.
    never_s = [one.grown_s for one in begun if one.at_s >= end_s]
    recoveries = (*recoveries_s((one.at_s for one in begun if one.at_s < end_s), stretches), *never_s)
    lengths_s = [stretch.length_s for stretch in stretches]
    return msgspec.structs.replace(
        figures,
        primary_s=_sum(grown, "primary_s"),
        secondary_s=_sum(grown, "secondary_s"),
        other_s=_sum(grown, "other_s"),
        primary_delays=len(begun),
        recovery_s=_rounded(max(lengths_s, default=0.0)),
        recovery_mean_s=_rounded(math.fsum(recoveries) / len(recoveries)) if recoveries else None,
        late_time_s=_rounded(math.fsum(lengths_s)),
        recovered=all(stretch.over for stretch in stretches),
        drawn=tuple(counts_of(late_day(setup)).items()),
        deadlock=deadlock.deadlocked(result),
    )


def figures_of_stops(
    stops: Iterable[StopRecord], timetable: Timetable, end_s: float | None = None
) -> DayFigures:
    """Punctuality of a day's stops against the plan; what needs more than them is left as on a punctual day.

    `end_s`: when the run ends whatever happens; None: as without a limit of its own.
    """
    end_s = latest_end_s(timetable) if end_s is None else end_s
    stops = tuple(stops)
    came_s = {(stop.number, stop.station_id): stop.arrival_s for stop in stops if stop.arrival_s is not None}
    stated_s = {(s.number, s.station_id): s.stated_late_s for s in stops if s.stated_late_s is not None}
    cut = {number: late_s for (number, _), late_s in stated_s.items()}
    ends = [
        (number, timetable.trains[number].calls[-1].station_id) for number in numbers_due(timetable, end_s)[0]
    ]
    ended = {(s.number, s.station_id) for s in stops if (s.arrival_s, s.departure_s) != (None, None)}
    missing = [end[0] for end in ends if end not in ended and end not in stated_s]
    ran = {stop.number for stop in stops if not stop.cancelled}
    planned = {
        (train.number, call.station_id): float(call.arrival_s)
        for train in timetable.trains.values()
        for call in train.calls[1:]
        if train.revenue and call.stops and call.arrival_s is not None
    }
    # Where a train is ended it has come, although it does not leave.
    late = {
        stop: min(came_s[stop], end_s) - at_s if stop in came_s else stated_s.get(stop, end_s - at_s)
        for stop, at_s in planned.items()
        if at_s <= end_s or stop in came_s
    }
    late_s = np.array(list(late.values()))
    worst = max(late, key=lambda stop: late[stop], default=None)
    ends_s = [max(late.get(end, 0.0), cut.get(end[0], 0.0)) for end in ends]
    return DayFigures(
        planned_trains=len(ends),
        arrived_trains=sum(end in ended for end in ends),
        missing=tuple(sorted(missing)),
        planned_arrivals=len(late),
        arrivals=len(late.keys() & came_s.keys()),
        within=tuple(
            sum(s < limit_s for stop, s in late.items() if stop in came_s) / max(len(late), 1)
            for limit_s in LIMITS_S
        ),
        mean_late_s=_rounded(float(late_s.mean())) if late else None,
        median_late_s=_rounded(float(np.median(late_s))) if late else None,
        p95_late_s=_rounded(float(np.quantile(late_s, 0.95))) if late else None,
        worst_late_s=None if worst is None else _rounded(late[worst]),
        worst_train="" if worst is None else worst[0],
        worst_station="" if worst is None else worst[1],
        lost_train_minutes=_rounded(math.fsum(max(s, 0.0) for s in ends_s) / 60.0),
        cancelled=tuple(number for number, _ in ends if number in cut and number not in ran),
        shortened=tuple(number for number, _ in ends if number in cut and number in ran),
        mean_delay_s=_rounded(float(np.maximum(late_s, 0.0).mean())) if late else None,
    )


def _roads(result: RunResult, setup: Setup, *, cut: bool) -> tuple[float | None, float | None]:
    """`closed_road_min` and `least_warned_s`; `cut`: a train did not run all of its way."""
    crossings = sum(crossing.has_device for crossing in setup.line.crossings.values())
    if not crossings:
        return None, None
    if cut:
        return _rounded(crossings * (result.end_step - result.begin_step) * STEP_S / 60.0), 0.0
    roads = road_closures.roads_closed(result.journal.entries, result.end_step * STEP_S)
    return _rounded(roads.closed_s / 60.0), roads.least_warned_s


def _sum(found: Sequence[delays.LatenessGrowth], name: str) -> float:
    return _rounded(math.fsum(getattr(delay, name) for delay in found))


def _rounded(value: float) -> float:
    return round(value, 3)
