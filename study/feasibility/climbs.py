"""Gradients that a train cannot manage: on which it cannot start, comes to a stand, or could not start again.

With its mean load on a dry rail that refuses the plan. With the heaviest load that the scenario may draw, on the worst
rail of its weather at that time, with the motors that its faults leave it, it is tight; so is a place where a train
that had to stop there would stay. The laws are those of the run (`vehicle.running_time`), on the real line.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.path import Path
from network.profile import profile_of
from onboard.driving.pattern import limit_for_train
from simulation.faults.vehicle import Motors
from simulation.setup import Setup
from study.feasibility.finding import Finding, FindingKind, Severity, minute
from study.feasibility.planned import PlannedDay, PlannedStop, PlannedTrain
from study.feasibility.run_times import cut_way
from study.measures.running_times import RunWay
from vehicle.resistance import climb_m
from vehicle.running_time import Conditions, Stall, balance_at, stall_of
from vehicle.train_file import TrainType

STEP_S: Final = 0.5
NEAR_M: Final = 1.0  # stalled this near its mark, a train has not started
REMEDY: Final = "less load, more motors, or another train"


@dataclass(frozen=True, slots=True)
class Climb:
    """Where a train cannot get on, with what it was tried; `stopped`: only if it has to stop there."""

    kilometrage_m: float
    stall: Stall
    conditions: Conditions
    stopped: bool


def climbs_of(setup: Setup, day: PlannedDay) -> Iterator[Finding]:
    """Every hop of the day on which a train cannot get on, or might not."""
    climbs = Climbs(setup)
    for train in day.all():
        for before, there in pairwise(train.stands):
            usual = Conditions(setup.load.load_share_mean)
            worst = worst_conditions(setup, train.stock_id, before.departs_s)
            climb = climbs.on(train, before, there, usual, may_stop=False)
            severity = Severity.TIGHT if climb is None else Severity.IMPOSSIBLE
            climb = climb or climbs.on(train, before, there, worst, may_stop=True)
            if climb is not None:
                yield _finding(setup, day, train, (before, there), climb, severity)


def worst_conditions(setup: Setup, stock_id: str, time_s: float) -> Conditions:
    """The heaviest load that may be drawn, the worst rail of the weather, the motors that faults by the clock leave."""
    load = min(setup.load.load_share_mean + setup.load.load_share_spread, 1.0)
    motors = float(setup.trains[stock_id].row[0]["motors"])
    cut_out = sum(
        failure.fault.cut_out
        for failure in setup.script.faults
        if isinstance(failure.fault, Motors)
        and failure.fault.target == stock_id
        and _in_force(failure.trigger.at_s, failure.duration_s, time_s)
    )
    return Conditions(load, max(motors - cut_out, 0.0) / motors, setup.scatter.adhesion_least(time_s))


def _in_force(from_s: float | None, duration_s: float | None, time_s: float) -> bool:
    """Whether a fault by the clock is there at a time; when one that follows an event comes nobody can say before."""
    return from_s is not None and from_s <= time_s and (duration_s is None or time_s < from_s + duration_s)


class Climbs:
    """Looks at each way once for each kind of train and conditions."""

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._known: dict[tuple[object, ...], Climb | None] = {}
        self._cut: dict[tuple[object, ...], tuple[Path, RunWay]] = {}  # by the path, which is kept for its id
        self._ways: dict[tuple[object, ...], tuple[NDArray[np.float64], NDArray[np.float64]]] = {}

    def on(
        self,
        train: PlannedTrain,
        before: PlannedStop,
        there: PlannedStop,
        conditions: Conditions,
        *,
        may_stop: bool,
    ) -> Climb | None:
        """Where a train cannot get on between two stops; with `may_stop` also where it could not start again."""
        kind, path = self._setup.trains[train.stock_id], train.duty.mission.path
        from_m, to_m = before.target.mark_m, there.target.mark_m
        cut = (kind.id, id(path), round(from_m, 3), round(to_m, 3))
        if cut not in self._cut:
            way = cut_way(self._setup.line, path, from_m, to_m, float(kind.row[0]["length_m"]))
            self._cut[cut] = path, way
        _, way = self._cut[cut]
        # Trains that come from other tracks, or go on to others, have the same way here.
        key = (kind.id, way.path.piece_ids, round(way.from_m, 3), round(way.to_m, 3), conditions, may_stop)
        if key not in self._known:
            self._known[key] = self._look(kind, way, conditions, may_stop=may_stop)
        return self._known[key]

    def _look(
        self,
        kind: TrainType,
        way: RunWay,
        conditions: Conditions,
        *,
        may_stop: bool,
    ) -> Climb | None:
        train = kind.row.view(np.recarray)[0]
        key = kind.id, way.path.piece_ids
        if key not in self._ways:
            profile = profile_of(way.line, way.path)
            self._ways[key] = (
                np.ascontiguousarray(climb_m(train, profile["elevation_m"], profile["turn_rad"])),
                np.ascontiguousarray(limit_for_train(profile["limit_mps"], train)),
            )
        climbs_m, limit_mps = self._ways[key]
        deceleration_mps2 = self._setup.driving.stop_deceleration_mps2
        row = kind.row[0]
        stall = stall_of(
            row, conditions, climbs_m, limit_mps, way.from_m, way.to_m, deceleration_mps2, STEP_S
        )
        if stall is not None:
            return Climb(way.path.kilometrage_m(stall.at_m), stall, conditions, stopped=False)
        if not may_stop:
            return None
        worst = balance_at(row, conditions, climbs_m, _steepest_m(climbs_m, way, float(train.length_m)))
        if worst.pull_n > worst.needed_n:
            return None
        return Climb(way.path.kilometrage_m(worst.at_m), worst, conditions, stopped=True)


def _steepest_m(climbs_m: NDArray[np.float64], way: RunWay, length_m: float) -> float:
    """Where the front of a train is that stands on the steepest climb of its way, m."""
    fronts_m = np.arange(math.ceil(way.from_m), math.floor(way.to_m) + 1, dtype=np.float64)
    grid_m = np.arange(len(climbs_m), dtype=np.float64)
    rises_m = np.interp(fronts_m, grid_m, climbs_m) - np.interp(fronts_m - length_m, grid_m, climbs_m)
    return float(fronts_m[int(np.argmax(rises_m))])


def _finding(
    setup: Setup,
    day: PlannedDay,
    train: PlannedTrain,
    ends: tuple[PlannedStop, PlannedStop],
    climb: Climb,
    severity: Severity,
) -> Finding:
    ids = [stand.target.place_id for stand in ends]
    names = [day.line.stations[i].name if i in day.line.stations else f"portal {i}" for i in ids]
    begins_m = train.duty.mission.path.kilometrage_m(ends[0].target.mark_m)
    stall, kind, leaves_s = climb.stall, setup.trains[train.stock_id], ends[0].departs_s
    if climb.stopped:
        what = "could not start again if it had to stop"
    else:
        what = "cannot start" if abs(climb.kilometrage_m - begins_m) < NEAR_M else "comes to a stand"
    text = (
        f"{train.number}, which leaves {names[0]} at {minute(leaves_s)} for {names[1]}, {what} at km"
        f" {climb.kilometrage_m / 1000.0:.3f}: {stall.gradient_permille:.1f} permille need"
        f" {stall.needed_n / 1e3:.1f} kN, {kind.name} has {stall.pull_n / 1e3:.1f} kN,"
        f" {_with_what(kind, climb.conditions)}"
    )
    return Finding(FindingKind.GRADIENT, severity, (train.number,), "-".join(ids), leaves_s, text, REMEDY)


def _with_what(kind: TrainType, conditions: Conditions) -> str:
    """Load, motors and rail, where they are not as always."""
    motors = float(kind.row[0]["motors"])
    parts = [f"{conditions.load_share:.0%} laden"]
    if conditions.motors_share < 1.0:
        parts.append(f"with {conditions.motors_share * motors:.0f} of {motors:.0f} motors")
    if conditions.adhesion_factor < 1.0:
        parts.append(f"on {conditions.adhesion_factor:.0%} of the dry rail's adhesion")
    return ", ".join(parts)
