"""Times at which a train is to run through a station, and cannot be there yet.

Nobody gets on or off in passing: such a time refuses a plan only where it is short by as much as lateness that adds up
may not be. What it delays is found at the next stop and at meets.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from network.model import Line
from network.timetable import clock
from simulation.setup import Setup
from study.feasibility.finding import LATE_S, Finding, Kind, Severity, minute
from study.feasibility.planned import PlannedDay, PlannedTrain
from study.measures.running_times import Way, least_times_s

NEGLIGIBLE_S = 1.0  # shorter than this, a time is not worth a word


def passings_of(setup: Setup, day: PlannedDay) -> Iterator[Finding]:
    """Every passing of the day whose time is before the train can be there, from the stop before it."""
    known: dict[tuple[object, ...], tuple[float, ...]] = {}
    for trains in day.trains.values():
        for train in trains:
            yield from _late(setup, day.line, train, known)


def _late(
    setup: Setup, line: Line, train: PlannedTrain, known: dict[tuple[object, ...], tuple[float, ...]]
) -> Iterator[Finding]:
    kind, path = setup.trains[train.stock_id], train.duty.mission.path
    for before, there in pairwise(train.stands):
        passings = there.target.passings
        if not passings or before.target.station_id is None:
            continue
        from_m, to_m = before.target.mark_m, there.target.mark_m
        at_m = tuple(passing.position_m for passing in passings)
        key = (kind.id, path.piece_ids, from_m, to_m, at_m)
        if key not in known:
            driving = setup.driving
            known[key] = least_times_s(
                kind,
                Way(setup.believed_line, path, from_m, to_m),
                at_m,
                setup.load.load_share_mean,
                driving.stop_deceleration_mps2,
                driving.driving_margin_mps,
            )
        for passing, least_s in zip(passings, known[key], strict=False):
            short_s = before.departs_s + least_s - passing.time_s
            if not math.isfinite(short_s) or short_s < NEGLIGIBLE_S:
                continue  # a train that cannot climb is told of its leg
            left, name = line.stations[before.target.station_id].name, line.stations[passing.station_id].name
            yield Finding(
                Kind.LEG,
                Severity.IMPOSSIBLE if short_s >= LATE_S else Severity.TIGHT,
                (train.number,),
                f"{before.target.station_id}-{passing.station_id}",
                before.departs_s,
                f"{train.number} leaves {left} at {minute(before.departs_s)} and is to pass {name}"
                f" {passing.time_s - before.departs_s:.0f} s later; {kind.name} needs {least_s:.0f} s as it is driven",
                f"it passes {name} at {clock(math.ceil(before.departs_s + least_s))} at the earliest",
                short_s,
            )
