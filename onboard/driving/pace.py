"""How fast a train is to run to its next mark: its cruising speed and, for a law that follows one, its plan.

Chosen at each departure from the time that is left, anew where a new stop limit or a fix changes what is ahead, and for
a plan whenever the train is off it.
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.laws.table import LAWS, LawsRow
from onboard.driving.planner.arrivals import ArrivalAims, TrainOnMap, arrivals_s
from onboard.driving.planner.plan import PlanOnPath, PlanRequest, plan_in_time
from onboard.driving.planner.wish import PLAIN, Planning
from onboard.duty.timekeeping import cruise_for
from onboard.mission import Mission, Passing, Target
from onboard.records import BehaviourRow, UnitRow
from onboard.unit_records import UnitParameters
from vehicle.optimum.journey import WindowMissed
from vehicle.records import TrainRow

AT_MARK_M: Final = 5.0  # so near the mark it has called at, a train that stands is about to leave it


class Pace:
    """The pace of one unit. `row` is its row of UNIT, which the compiled tick shares."""

    def __init__(
        self,
        parameters: UnitParameters,
        row: UnitRow,
        train: TrainRow,
        behaviour: BehaviourRow,
        laws: LawsRow | None = None,
        planning: Planning = PLAIN,
    ) -> None:
        self.timed: Passing | None = None  # where the speed is to bring the train, if not to its stop
        self._parameters: Final = parameters
        self._row: Final = row
        self._train: Final = train
        self._behaviour: Final = behaviour
        law = None if laws is None else LAWS[int(laws.number)]
        self._law: Final = getattr(laws, law.name) if law is not None and law.plans else None
        self._planning: Final = planning
        self._meant: tuple[str, int, float] | None = None  # train, target, and when it means to be there
        self.climb_m: NDArray[np.float64] = np.zeros(1)
        self.driving_mps: NDArray[np.float64] = np.zeros(1)
        self._least_mps = math.inf
        self._laid: PlanOnPath | None = None

    def take_up(self, rows: NDArray[np.void]) -> None:
        """Another path: its rows of PATTERN."""
        self.timed = None
        self.give_up_plan()
        self.climb_m = np.ascontiguousarray(rows["climb_m"])
        self.driving_mps = np.ascontiguousarray(rows["driving_mps"])
        self._least_mps = float(rows["permitted_mps"].min())
        self._row.cruise_mps = math.inf

    @property
    def sight_mps(self) -> float:
        """How fast the train may run on sight, m/s: while it does not know its place, under every limit of its path."""
        limit_mps = math.inf if self._row.position_known else self._least_mps
        return min(self._parameters.restricted_mps, limit_mps)

    def give_up_plan(self) -> None:
        """Follow no plan any more: it was for another way, another speed or another place than the train now has."""
        self._laid = None
        self._row.plan_rows = 0
        self._row.replan_s = math.inf

    def taken_plan(self) -> PlanOnPath | None:
        """The plan made since the last call, to be laid."""
        taken, self._laid = self._laid, None
        return taken

    def next_passing(self, there: Target) -> Passing | None:
        """The next station that the train runs through on its way to a stop."""
        return next((p for p in there.passings if p.position_m > self._row.position_m), None)

    def passed_by(self, there: Target) -> bool:
        """Whether the pace was chosen for a station that the train has run through since."""
        return self.timed is not None and self.timed is not self.next_passing(there)

    def choose(self, mission: Mission, at: int, now_s: float, load_share: float) -> None:
        """Choose the pace for what is left of the way to target `at`, or to the next station before it with a time."""
        row, parameters, there = self._row, self._parameters, mission.targets[at]
        due_s = None if there.arrival_s is None else there.latest_arrival_s(parameters.dwell_min_s)
        row.cruise_mps = math.inf
        self.give_up_plan()
        row.due_s = math.inf if due_s is None else due_s - parameters.time_margin_s
        self.timed = passing = self.next_passing(there)
        until_m = math.inf if passing is None else passing.position_m
        if passing is not None:
            # that keeps a stop's arrival, not a moment in passing
            due_s = passing.time_s + parameters.time_margin_s
        if there.mark_m <= row.position_m:
            return
        if passing is None and self._plan(mission, at, now_s, load_share):
            return
        if due_s is None:
            return
        available_s = due_s - now_s - parameters.time_margin_s
        row.cruise_mps = cruise_for(
            self._train,
            load_share,
            self.climb_m,
            self.driving_mps,
            row.position_m,
            there.mark_m,
            available_s,
            self._behaviour.settings.stop_deceleration_mps2,
            float(row.speed_mps),
            until_m,
        )

    def _plan(self, mission: Mission, at: int, now_s: float, load_share: float) -> bool:
        """Have a plan laid for the way to a target, if the law follows one; False where there is none."""
        if self._law is None or self._row.restricted_mps < math.inf:
            return False
        row, mark_m = self._row, mission.targets[at].mark_m
        row.due_s = self._aimed_s(mission, at, now_s, load_share)
        ahead = PlanRequest(
            self._train,
            load_share,
            self.climb_m,
            self.driving_mps,
            row.position_m,
            mark_m,
            float(row.speed_mps),
            self._behaviour.settings.stop_deceleration_mps2,
            row.due_s - now_s,
            float(self._law.settings.regeneration_share),
        )
        self._laid = found = plan_in_time(ahead, self._planning)
        if found is None:
            return False
        row.plan_due_s = now_s + found.takes_s
        row.replan_s = self._law.settings.replan_after_s
        return True

    def _aimed_s(self, mission: Mission, at: int, now_s: float, load_share: float) -> float:
        """When it means to be at target `at`, as decided at its departure for it; infinite where nobody says when."""
        row, parameters = self._row, self._parameters
        leaves = row.speed_mps == 0.0 and abs(mission.targets[at - 1].mark_m - row.position_m) < AT_MARK_M
        if leaves:
            on_map = TrainOnMap(
                self._train,
                load_share,
                self.climb_m,
                self.driving_mps,
                self._behaviour.settings.stop_deceleration_mps2,
            )
            times = ArrivalAims(parameters.dwell_min_s, parameters.time_margin_s)
            with suppress(ValueError, WindowMissed):
                aimed_s = arrivals_s(self._planning, on_map, mission, at - 1, now_s, times)[0]
                self._meant = (mission.number, at, aimed_s)
        if self._meant is not None and self._meant[:2] == (mission.number, at):
            return self._meant[2]
        latest_s = mission.targets[at].latest_arrival_s(parameters.dwell_min_s)
        return math.inf if latest_s is None else latest_s - parameters.time_margin_s
