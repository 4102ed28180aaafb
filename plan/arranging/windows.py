"""Within which times a train can be at each of its visits: what its print and its running times alone leave open."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from network.clock import first_given
from plan.arranging.problem import Standing, TrainToArrange, Visit

WAITS_S: Final = 3600  # assumed: a train may wait so long on its way to an end of which no time is printed


def windows_s(train: TrainToArrange, reach_s: int) -> list[tuple[int, int, int]]:
    """Of each visit when a train can come and leave at the earliest, and when it leaves at the latest, s.

    `reach_s`: so much after print; a train of which nothing is printed has all the time in which it may run.
    """
    soonest_s = earliest_s(train)
    latest = _latest_each_s(train, soonest_s, max(reach_s, train.until_s - train.from_s))
    return [(*soon_s, by_then_s) for soon_s, by_then_s in zip(soonest_s, latest, strict=True)]


def earliest_s(train: TrainToArrange) -> list[tuple[int, int]]:
    """When a train can come and leave at the earliest, s, leaving as printed where it can."""
    found: list[tuple[int, int]] = []
    for before, visit in pairwise((None, *train.visits)):
        if visit is None:
            continue
        if before is None:
            arrives_s = _begins_s(train)
        elif visit.run is None:
            raise ValueError(f"{visit.station_id}: no running time")
        else:
            runs_s = [run_s for one, other, run_s in visit.run.ways() if before.can(one) and visit.can(other)]
            arrives_s = found[-1][1] + min(runs_s)
        departs_s = arrives_s + (visit.stay_s if before and visit.standing is Standing.ALWAYS else 0)
        found.append((arrives_s, max(departs_s, first_given(visit.departure_s, departs_s))))
    return found


def _latest_each_s(train: TrainToArrange, soonest_s: Sequence[tuple[int, int]], reach_s: int) -> list[int]:
    """When a train leaves each of its visits at the latest, s: so much after print, and in time for what follows."""
    found: list[int] = []
    follows: Visit | None = None
    for visit, (comes_s, leaves_s) in zip(reversed(train.visits), reversed(soonest_s), strict=True):
        if visit.departure_s is not None:
            by_then_s = leaves_s + reach_s
        elif follows is None or follows.run is None:
            by_then_s = (
                comes_s + WAITS_S if visit.arrival_s is None else max(comes_s, visit.arrival_s)
            ) + reach_s
        else:
            by_then_s = found[-1] - min(run_s for _, _, run_s in follows.run.ways())
        found.append(by_then_s)
        follows = visit
    return found[::-1]


def _begins_s(train: TrainToArrange) -> int:
    first = train.visits[0]
    if first.departure_s is not None:
        return first.departure_s
    printed_s = [s for visit in train.visits for s in (visit.arrival_s, visit.departure_s) if s is not None]
    least_s = sum(visit.run.stop_stop + visit.stay_s for visit in train.visits if visit.run is not None)
    return train.from_s if not printed_s else printed_s[0] - least_s
