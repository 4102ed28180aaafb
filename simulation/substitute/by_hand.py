"""Trains driven by hand, their units cut out (開放): past the missing authority, as far as somebody lets them.

The unit is off, and no authority part restrains the train: its driver uses the driving part as his hands. He knows
where he is by his eye, so its position is set to the truth in each stretch, reads no tags, keeps the line's limits and
his own ceiling, stops at marks, and brakes for a train that he sees. What stops him is the end of what he was told, and
by the rule of substitute working each level crossing that units ask: it cannot hear him.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from network.clock import first_given
from onboard.duty.records import DrivingCommand, DrivingOrder, StopLimit
from onboard.records import NO_INTERVENTION
from simulation.agenda import AgendaKind
from simulation.cabs import Cabs
from simulation.duties import Duties
from simulation.events import WORLD, CutIn, CutOut
from simulation.pauses import Pauses
from simulation.people import Pause
from simulation.setup import STEPS_PER_S
from simulation.world.roster import Duty
from simulation.world.stage import World

BY_EYE_M: Final = 1.0  # to so much a driver knows where his front is
TRIES_AGAIN_S: Final = 10.0  # stood so long short of his mark, he takes power again
FORGETS: Final = True  # off: a unit that is cut in remembers where it was before, and says so (decision 178)
LEAVE_ENDS: Final = "what its driver was told ends here"


@dataclass(slots=True)
class DrivenTrain:
    """One train: the target where it stands or that it left, the last one it may run to, and when it goes on.

    `ends`: index of the first span that it may not enter; None: the one after its last target.
    """

    duty: Duty | None
    at: int = 0
    to: int = 0
    ends: int | None = None
    goes_s: float = -math.inf
    runs: bool = False
    stood_s: float | None = None
    over: bool = False  # its journey is: said once
    leaves_step: int | None = None


class HandDriver:
    """The drivers of all trains whose unit is cut out, by slot."""

    def __init__(
        self,
        world: World,
        cabs: Cabs,
        duties: Duties,
        speed_mps: float,
        dwell_s: float,
        *,
        stops_at_crossings: bool = False,
    ) -> None:
        self._trains, self._on_board, self._books = world.trains, world.on_board, world.books
        self._agenda, self._journal = world.agenda, world.journal
        self._cabs, self._duties = cabs, duties
        self._pauses: Final = Pauses(world.setup)
        self._speed_mps, self._dwell_s = speed_mps, dwell_s
        self._creep_mps: Final = world.setup.unit.restricted_mps
        radio = any(crossing.by_radio for crossing in world.setup.line.crossings.values())
        self._stops_at_crossings: Final = stops_at_crossings and radio
        self.driven: Final[dict[int, DrivenTrain]] = {}
        self.ceilings_mps: Final[dict[int, float]] = {}  # of trains that are to run slower for a while

    def cut_out(self, slot: int, step: int) -> None:
        """The driver cuts the unit out, if it is not; a train outside its portal comes in by it."""
        outside = self._duties.waits_outside(slot)
        if slot in self.driven and not outside:
            return
        if slot not in self.driven:
            self._cabs.power_off(slot, step)
            self._cabs.unit_cut_out(slot, out=True)
            if FORGETS:
                self._on_board.lose_store(slot)
            self._write(step, CutOut(unit_id=self._trains.stock_ids[slot]))
        self.driven[slot] = DrivenTrain(None)
        if outside:
            self._duties.enter_by_hand(slot, step)
        self._take_up(slot)
        if self._duties.is_to_turn(slot):
            self._over(slot, self.driven[slot], step / STEPS_PER_S)

    def cut_in(self, slot: int, step: int) -> None:
        """The driver cuts the unit in again; it has forgotten, and boots once staff have commissioned it."""
        del self.driven[slot]
        self._cabs.drives_by_hand(slot, by_hand=False)
        self._cabs.unit_cut_out(slot, out=False)
        self._trains.truths[slot].powered = 0
        self._write(step, CutIn(unit_id=self._trains.stock_ids[slot]))
        self._duties.power_on(slot, step)

    def let_go(self, slot: int, to: int, step: int) -> bool:
        """The driver may run to a target; False: his unit is not cut out, and does not let him."""
        train = self.driven.get(slot)
        if train is None:
            return False
        train.to, train.goes_s = to, step / STEPS_PER_S
        self._look(slot, train, step)
        return True

    def permit(self, slot: int, to: int, ends: int, step: int) -> None:
        """A driver sees that he may run to a target, and not beyond the span before `ends`."""
        train = self.driven[slot]
        if (to, ends) == (train.to, train.ends):
            return
        train.to, train.ends = to, ends
        if train.runs:
            self._runs(slot, train, step / STEPS_PER_S, on_the_way=True)

    def look(self, step: int) -> None:
        """All drivers look out."""
        for slot, train in list(self.driven.items()):
            self._look(slot, train, step)

    def _look(self, slot: int, train: DrivenTrain, step: int) -> None:
        if train.leaves_step is not None and step >= train.leaves_step:
            train.leaves_step = None
            self._duties.leave_by_hand(slot, step)
        if not self._trains.truths[slot].active:
            train.duty = None
            return
        if train.duty is not self._trains.duties[slot]:
            self._take_up(slot)
        row, now_s = self._trains.units[slot], step / STEPS_PER_S
        row.position_m = self._trains.truths[slot].position_m
        row.bound_ahead_m = row.bound_behind_m = BY_EYE_M
        creeps = self._stops_at_crossings and self._cabs.looks_by_hand(slot, step)
        row.restricted_mps = self._creep_mps if creeps else self.ceilings_mps.get(slot, self._speed_mps)
        stands = self._trains.plants[slot].speed_mps == 0.0
        if stands and train.runs:
            self._stands(slot, train, now_s)
        if not train.runs and train.at < train.to and now_s >= train.goes_s:
            self._runs(slot, train, now_s)

    def _stands(self, slot: int, train: DrivenTrain, now_s: float) -> None:
        """He has arrived, or stands short of his mark because of something, and tries again."""
        at = self._books.next_target(slot) - 1
        if at <= train.at:
            if train.stood_s is None:
                train.stood_s = now_s
            elif now_s - train.stood_s > TRIES_AGAIN_S and self._sees_nothing(slot):
                self._runs(slot, train, now_s)
            return
        train.at, train.runs = at, False
        self._hold(slot, train, now_s)
        duty = self._trains.duties[slot]
        targets = () if duty is None else duty.mission.targets
        if at == len(targets) - 1:
            self._over(slot, train, now_s)
        else:
            train.goes_s = max(now_s + self._dwell_s, first_given(targets[at].departure_s, now_s))
            self._wake(train.goes_s)

    def _over(self, slot: int, train: DrivenTrain, now_s: float) -> None:
        step = round(now_s * STEPS_PER_S)
        train.over = True
        if self._duties.finish_by_hand(slot, step):
            train.leaves_step = step + self._pauses.steps(Pause.LEAVE, self._trains.stock_ids[slot])
            self._wake(train.leaves_step / STEPS_PER_S)

    def _sees_nothing(self, slot: int) -> bool:
        truth = self._trains.truths[slot]
        return bool(truth.sight_m - truth.position_m > self._speed_mps)

    def _take_up(self, slot: int) -> None:
        """He takes up his train, where it stands."""
        duty, train = self._trains.duties[slot], self.driven[slot]
        if duty is None or not self._trains.truths[slot].active:
            return
        train.duty, train.over, train.runs = duty, False, False
        train.at = train.to = self._books.next_target(slot) - 1
        train.ends = None
        self._on_board.take_by_hand(slot, duty)
        self._cabs.drives_by_hand(slot, by_hand=True, stops_at_crossings=self._stops_at_crossings)
        self._hold(slot, train, 0.0)

    def _hold(self, slot: int, train: DrivenTrain, now_s: float) -> None:
        self._obey(slot, DrivingCommand(at_mark=True, at=train.at, on_line=True), now_s)

    def _runs(self, slot: int, train: DrivenTrain, now_s: float, *, on_the_way: bool = False) -> None:
        duty = train.duty
        if duty is None:
            return
        spans, targets = duty.mission.spans, duty.mission.targets
        first, last = (duty.mission.span_index(targets[i].section_id) for i in (train.at, train.to))
        ends = last + 1 if train.ends is None else train.ends
        beyond = spans[ends].section_id if ends < len(spans) else None
        command = DrivingCommand(
            drive=True,
            target=train.at + 1,
            at=train.at,
            limit=StopLimit(ends, beyond, LEAVE_ENDS),
            orders=() if on_the_way else (DrivingOrder.DEPART, DrivingOrder.RELEASE),
            on_line=True,
            held=tuple(span.section_id for span in spans[first:ends]),
            waits_for=f"its run to {targets[train.at + 1].place_id}",
        )
        train.runs, train.stood_s = True, None
        self._obey(slot, command, now_s)

    def _obey(self, slot: int, command: DrivingCommand, now_s: float) -> None:
        row = self._trains.units[slot]
        row.position_m = self._trains.truths[slot].position_m
        self._on_board.drive_by_hand(slot, command, now_s)
        row.intervention = NO_INTERVENTION
        row.restricted_mps = self.ceilings_mps.get(slot, self._speed_mps)

    def _wake(self, at_s: float) -> None:
        self._agenda.put(round(at_s * STEPS_PER_S) + 1, AgendaKind.PROCEDURE, "driver")

    def _write(self, step: int, event: CutOut | CutIn) -> None:
        self._journal.write(step / STEPS_PER_S, WORLD, event)
