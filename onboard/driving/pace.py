"""How fast a train is to run to its next mark: its cruising speed and, for a law that follows one, its plan.

Chosen at each departure from the time that is left, anew where a new stop limit or a fix changes what is ahead, and for
a plan whenever the train is off it.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.driving.laws.table import LAWS, LawsRow
from onboard.driving.planner.plan import Ahead, Laid, planned
from onboard.duty.mission import Passing, Target
from onboard.duty.timekeeping import cruise_for
from onboard.records import BehaviourRow, UnitRow
from onboard.unit_records import UnitParameters
from vehicle.records import TrainRow


class Pace:
    """The pace of one unit. `row` is its row of UNIT, which the compiled tick shares."""

    def __init__(
        self,
        parameters: UnitParameters,
        row: UnitRow,
        train: TrainRow,
        behaviour: BehaviourRow,
        laws: LawsRow | None = None,
    ) -> None:
        self.timed: Passing | None = None  # where the speed is to bring the train, if not to its stop
        self._parameters: Final = parameters
        self._row: Final = row
        self._train: Final = train
        self._behaviour: Final = behaviour
        law = None if laws is None else LAWS[int(laws.number)]
        self._planning: Final = getattr(laws, law.name) if law is not None and law.plans else None
        self.climb_m: NDArray[np.float64] = np.zeros(1)
        self.driving_mps: NDArray[np.float64] = np.zeros(1)
        self._laid: Laid | None = None

    def take_up(self, rows: NDArray[np.void]) -> None:
        """Another path: its rows of PATTERN."""
        self.timed = self._laid = None
        self.climb_m = np.ascontiguousarray(rows["climb_m"])
        self.driving_mps = np.ascontiguousarray(rows["driving_mps"])
        self._row.plan_rows = 0  # a plan is of the path it was made for
        self._row.cruise_mps = self._row.replan_s = math.inf

    def taken_plan(self) -> Laid | None:
        """The plan made since the last call, to be laid."""
        taken, self._laid = self._laid, None
        return taken

    def next_passing(self, there: Target) -> Passing | None:
        """The next station that the train runs through on its way to a stop."""
        return next((p for p in there.passings if p.position_m > self._row.position_m), None)

    def passed_by(self, there: Target) -> bool:
        """Whether the pace was chosen for a station that the train has run through since."""
        return self.timed is not None and self.timed is not self.next_passing(there)

    def choose(self, there: Target, now_s: float, load_share: float) -> None:
        """Choose the pace for what is left of the way to the next station where there is a time, and of that time."""
        row, parameters = self._row, self._parameters
        due_s = there.arrival_s
        if due_s is not None and there.departure_s is not None:
            dwell_s = parameters.dwell_min_s if there.passengers else 0.0
            due_s = min(due_s, there.departure_s - dwell_s)
        row.cruise_mps = row.replan_s = math.inf
        row.plan_rows = 0
        row.due_s = math.inf if due_s is None else due_s - parameters.time_margin_s
        self.timed = passing = self.next_passing(there)
        until_m = math.inf if passing is None else passing.position_m
        if passing is not None:
            due_s = (
                passing.time_s + parameters.time_margin_s
            )  # that keeps a stop's arrival, not a moment in passing
        if there.mark_m <= row.position_m:
            return
        available_s = math.inf if due_s is None else due_s - now_s - parameters.time_margin_s
        if passing is None and self._plan(there.mark_m, now_s, available_s, load_share):
            return
        if due_s is None:
            return
        row.cruise_mps = cruise_for(
            self._train,
            load_share,
            self.climb_m,
            self.driving_mps,
            row.position_m,
            there.mark_m,
            available_s,
            self._behaviour.stop_deceleration_mps2,
            float(row.speed_mps),
            until_m,
        )

    def _plan(self, mark_m: float, now_s: float, available_s: float, load_share: float) -> bool:
        """Have a plan laid for the way to the mark, if the law follows one; False where there is none."""
        if self._planning is None:
            return False
        row = self._row
        ahead = Ahead(
            self._train,
            load_share,
            self.climb_m,
            self.driving_mps,
            row.position_m,
            mark_m,
            float(row.speed_mps),
            self._behaviour.stop_deceleration_mps2,
            available_s,
            float(self._planning.regeneration_share),
        )
        self._laid = found = planned(ahead)
        if found is None:
            return False
        row.plan_due_s = now_s + found.takes_s
        row.replan_s = self._planning.replan_after_s
        return True
