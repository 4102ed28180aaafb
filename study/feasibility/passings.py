"""Times at which a train is to run through a station, and cannot be there yet.

Nobody gets on or off in passing: such a time refuses a plan only where it is short by as much as lateness that adds up
may not be. What it delays is found at the next stop and at meets.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from network.clock import clock
from simulation.setup import Setup
from study.feasibility.finding import Finding, FindingKind, minute, severity_of
from study.feasibility.planned import PlannedDay, PlannedTrain
from study.feasibility.timing import NEGLIGIBLE_S


def passings_of(setup: Setup, day: PlannedDay) -> Iterator[Finding]:
    """Every passing of the day whose time is before the train can be there, from the stop before it."""
    for trains in day.trains.values():
        for train in trains:
            yield from _late(setup, day, train)


def _late(setup: Setup, day: PlannedDay, train: PlannedTrain) -> Iterator[Finding]:
    stations, kind = day.line.stations, setup.trains[train.stock_id]
    for before, there in pairwise(train.stands):
        if before.target.station_id is None:
            continue
        for passing, least_s in zip(there.target.passings, there.passes_s, strict=True):
            short_s = before.departs_s + least_s - passing.time_s
            if not math.isfinite(short_s) or short_s < NEGLIGIBLE_S:
                continue  # a train that cannot climb is a finding of its leg
            left, name = stations[before.target.station_id].name, stations[passing.station_id].name
            yield Finding(
                FindingKind.LEG,
                severity_of(short_s, before.target.departure_s, passing.time_s),
                (train.number,),
                f"{before.target.station_id}-{passing.station_id}",
                before.departs_s,
                f"{train.number} leaves {left} at {minute(before.departs_s)} and is to pass {name}"
                f" {passing.time_s - before.departs_s:.0f} s later; {kind.name} needs {least_s:.0f} s as it is driven",
                f"it passes {name} at {clock(math.ceil(before.departs_s + least_s))} at the earliest",
                short_s,
            )
