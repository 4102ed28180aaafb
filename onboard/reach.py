"""What a set's way to its next charge will take of its battery, by its unit's own prediction (到達判定).

Hop by hop along the train that it runs and those that its set runs after it: `vehicle.running_time.predicted_run` at
the cruising speed that keeps the timetable, and the auxiliaries while it stands. Losses in the battery, and whatever
else a prediction leaves out, are a share on top. A charger that is known to be dead is none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from network.model import Line
from onboard.duty.timekeeping import PREDICTION_STEP_S, cruise_for
from onboard.mission import Mission, Target
from onboard.records import BehaviourRow
from vehicle.battery import SHEDS_S
from vehicle.records import TrainRow
from vehicle.running_time import predicted_run


@dataclass(frozen=True, slots=True)
class Ground:
    """A unit's path database of one mission, by the metre: climb, m, and the speed that driving stays under, m/s."""

    climb_m: NDArray[np.float64]
    driving_mps: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class OffLine:
    """What a set does once it has left the line: what that takes of its battery, J, and whether it charges then."""

    takes_j: float = 0.0
    charges: bool = True


@dataclass(frozen=True, slots=True)
class BatteryHop:
    """From one stop to the next: what the run takes, J at the battery in `run_s`, and then the stand there.

    `charger`: the station whose charger is at the stop where it ends; empty: none. `beyond_j`: what the set then takes
    of its battery off the line, before it charges there (`wire`) or comes back. `saves_j`: what of its stand it can do
    without, since it switches that off.
    """

    number: str
    from_place: str
    to_place: str
    run_s: float
    run_j: float
    stand_j: float
    charger: str = ""
    wire: bool = False
    beyond_j: float = 0.0
    saves_j: float = 0.0


def charger_at(line: Line, target: Target) -> str:
    """The station whose charger a set at this stop can use; empty: none."""
    charger = None if target.station_id is None else line.chargers.get(target.station_id)
    return charger.station_id if charger is not None and target.track in charger.tracks else ""


def run_of(
    train: TrainRow,
    behaviour: BehaviourRow,
    load_share: float,
    ground: Ground,
    ends: tuple[Target, Target],
    dwell_s: float,
    margin_s: float,
) -> tuple[float, float]:
    """Predicted time (s) and energy (J, auxiliaries among it) of a run from stop to stop on time.

    At the limits where no time is.
    """
    here, there = ends
    cruise_mps = np.inf
    arrives_s = there.latest_arrival_s(dwell_s)
    if here.departure_s is not None and arrives_s is not None:
        cruise_mps = cruise_for(
            train,
            load_share,
            ground.climb_m,
            ground.driving_mps,
            here.mark_m,
            there.mark_m,
            arrives_s - here.departure_s - margin_s,
            behaviour.settings.stop_deceleration_mps2,
        )
    return predicted_run(
        train,
        load_share,
        ground.climb_m,
        ground.driving_mps,
        here.mark_m,
        there.mark_m,
        cruise_mps,
        behaviour.settings.stop_deceleration_mps2,
        PREDICTION_STEP_S,
    )


def stands_s(there: Target, following: Target | None, dwell_s: float) -> float:
    """How long a train is to stand at a stop; `following`: the first stop of its set's next train, from there."""
    departs = there if following is None else following
    if there.arrival_s is None or departs.departure_s is None:
        return dwell_s
    return max(departs.departure_s - there.arrival_s, 0.0)


def hops_of(
    line: Line,
    mission: Mission,
    runs: Sequence[tuple[float, float]],
    auxiliary_w: float,
    waits_w: float,
    dwell_s: float,
    following: Mission | None,
    off: OffLine,
) -> tuple[BatteryHop, ...]:
    """The hops of a mission, given the time (s) and energy (J) of each run.

    `waits_w`: what of its auxiliaries can wait. `following`: the set's next, if it stays on the line.
    """
    found: list[BatteryHop] = []
    for (here, there), (time_s, takes_j) in zip(pairwise(mission.targets), runs, strict=True):
        last = there is mission.targets[-1]
        next_first = following.targets[0] if last and following is not None else None
        leaves, stand_s = there.station_id is None, stands_s(there, next_first, dwell_s)
        found.append(
            BatteryHop(
                mission.number,
                here.place_id,
                there.place_id,
                time_s,
                takes_j,
                stand_s * auxiliary_w,
                charger_at(line, there),
                leaves and off.charges,
                off.takes_j if leaves else 0.0,
                max(stand_s - SHEDS_S, 0.0) * waits_w,
            )
        )
    return tuple(found)


@dataclass(frozen=True, slots=True)
class Reach:
    """What is needed to the next charge, J as predicted; `place` None: there is none before the set's day ends.

    `saves_j`: what of that it can do without on its way.
    """

    needed_j: float
    place: str | None
    hops: int
    saves_j: float = 0.0


def to_next_charge(hops: Sequence[BatteryHop], dead: Collection[str]) -> Reach:
    """What the way takes that begins with the first of these hops."""
    needed_j = saves_j = 0.0
    for count, hop in enumerate(hops, 1):
        needed_j += hop.run_j + hop.beyond_j
        if hop.wire or (hop.charger and hop.charger not in dead):
            return Reach(needed_j, hop.to_place, count, saves_j)
        needed_j, saves_j = needed_j + hop.stand_j, saves_j + hop.saves_j
    return Reach(needed_j, None, len(hops), saves_j)


def stretches(hops: Sequence[BatteryHop], dead: Collection[str]) -> Iterator[tuple[int, Reach]]:
    """Every way from charge to charge along some hops: the index of its first hop, and what it takes."""
    at = 0
    while at < len(hops):
        reach = to_next_charge(hops[at:], dead)
        yield at, reach
        at += reach.hops


@dataclass(frozen=True, slots=True)
class SetWays:
    """One set's hops from the beginning of its day to its end; `first` is the index of each train's first hop."""

    hops: tuple[BatteryHop, ...]
    first: Mapping[str, int]

    def ahead(self, number: str, at: int) -> tuple[BatteryHop, ...]:
        """The hops ahead of the set at a stop of one of its trains."""
        return self.hops[self.first[number] + at :]
