"""Least running times (最小運転時分) from stand to stand, beside what a timetable plans."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from network.model import Line
from network.path import Path
from network.profile import profile_of
from onboard.driving.pattern import limit_for_train, lowered_by
from onboard.mission import Mission, Target
from simulation.setup import Setup
from simulation.world.roster import drawn_up
from vehicle.resistance import climb_m
from vehicle.running_time import predicted_run
from vehicle.train_file import TrainType

STEP_S: Final = 0.1


@dataclass(frozen=True, slots=True)
class RunWay:
    """A run from a stand to a stand: the line, a path on it, and path coordinates of the front, m."""

    line: Line
    path: Path
    from_m: float
    to_m: float


def least_running_time_s(
    kind: TrainType, way: RunWay, load_share: float, deceleration_mps2: float, below_limit_mps: float = 0.0
) -> float:
    """Shortest time, s, in which a train of a kind runs from one stand to the next; see `least_times_s`."""
    return least_times_s(kind, way, (), load_share, deceleration_mps2, below_limit_mps)[-1]


def least_times_s(
    kind: TrainType,
    way: RunWay,
    passing_m: Sequence[float],
    load_share: float,
    deceleration_mps2: float,
    below_limit_mps: float = 0.0,
) -> tuple[float, ...]:
    """Shortest times, s, from a stand to where the front passes each of `passing_m`, and to the next stand.

    Full power up to the lowest limit under any part of the train, or `below_limit_mps` below it, and one constant
    deceleration towards lower limits and the stop; gradients and curves as `vehicle.running_time` counts them.
    Infinite where the train cannot climb.
    """
    train = kind.row.view(np.recarray)[0]
    profile = profile_of(way.line, way.path)
    limit_mps = limit_for_train(profile["limit_mps"], train)
    if below_limit_mps > 0.0:
        limit_mps = lowered_by(limit_mps, below_limit_mps)
    climbs_m = climb_m(train, profile["elevation_m"], profile["turn_rad"])
    climbs_m, limit_mps = np.ascontiguousarray(climbs_m), np.ascontiguousarray(limit_mps)
    return tuple(
        float(
            predicted_run(
                kind.row[0],
                load_share,
                climbs_m,
                limit_mps,
                way.from_m,
                way.to_m,
                math.inf,
                deceleration_mps2,
                STEP_S,
                0.0,
                until_m,
            )[0]
        )
        for until_m in (*passing_m, math.inf)
    )


@dataclass(frozen=True, slots=True)
class TrainHop:
    """From one stop of a train at a station to the next, with a time at both ends, s; stations between are passed."""

    stock_id: str
    mission: Mission
    here: Target
    there: Target
    leaves_s: float
    due_s: float  # latest arrival

    def way(self, line: Line) -> RunWay:
        """The run that it is, on a line."""
        return RunWay(line, self.mission.path, self.here.mark_m, self.there.mark_m)


def planned_hops(setup: Setup) -> Iterator[TrainHop]:
    """Every hop of the timetable, by stock and in order of travel."""
    for stock_id, duties in drawn_up(setup, setup.line).items():
        for duty in duties:
            at_stations = (target for target in duty.mission.targets if target.station_id is not None)
            for here, there in pairwise(at_stations):
                due_s = there.latest_arrival_s(setup.timetable.head.dwell_min_s)
                if here.departure_s is not None and due_s is not None:
                    yield TrainHop(stock_id, duty.mission, here, there, here.departure_s, due_s)


@dataclass(frozen=True, slots=True)
class PlannedLeg:
    """One hop of one train as planned, s. `attainable_s` keeps the distance to limits that driving keeps."""

    stock_id: str
    number: str
    revenue: bool
    from_id: str
    to_id: str
    leaves_s: float
    due_s: float
    least_s: float
    attainable_s: float

    @property
    def planned_s(self) -> float:
        """From the departure to the latest arrival that keeps the next departure."""
        return self.due_s - self.leaves_s


def planned_legs(setup: Setup) -> tuple[PlannedLeg, ...]:
    """Every hop of the timetable that has a time at both ends, by stock and in order of travel.

    Trains carry the scenario's mean load and brake as the unit's pattern to a stop does.
    """
    known: dict[tuple[str, tuple[str, ...], float, float], tuple[float, float]] = {}
    return tuple(_leg_of(setup, hop, known) for hop in planned_hops(setup))


def _leg_of(
    setup: Setup, hop: TrainHop, known: dict[tuple[str, tuple[str, ...], float, float], tuple[float, float]]
) -> PlannedLeg:
    """The leg of a hop; a kind of train needs the same time for the same way again."""
    kind, way = setup.trains[hop.stock_id], hop.way(setup.line)
    key = (kind.id, way.path.piece_ids, way.from_m, way.to_m)
    if key not in known:
        load, driving = setup.load.load_share_mean, setup.driving
        known[key] = (
            least_running_time_s(kind, way, load, driving.stop_deceleration_mps2),
            least_running_time_s(kind, way, load, driving.stop_deceleration_mps2, driving.driving_margin_mps),
        )
    return PlannedLeg(
        hop.stock_id,
        hop.mission.number,
        hop.mission.revenue,
        hop.here.station_id or "",
        hop.there.station_id or "",
        hop.leaves_s,
        hop.due_s,
        *known[key],
    )
