"""Truthful staff: people who put right what faults have left, by what is so.

They look round every few seconds of the journal and act through the injector's door, so that what they did can be
written down as acts of a drill. Switching on what is off; putting into service again what has lost its durable state;
winding points that lie in no position, or that do not move, to where no train is in the way; the picture of the line
after the manager's restart, again and again until it is accepted; barring a unit that claims what is not so, and
unbarring it; and for a unit that stays silent, or is barred, two of them enter where its train truly is and what it
shows that it holds.
"""

from __future__ import annotations

from collections import Counter
from typing import Final

from network.model import SectionKind
from simulation.events import Entry, PowerOff, PowerOn, Uncommissioned
from simulation.faults.script import Act, ActKind, Trigger
from simulation.loop import Simulation
from simulation.mad_units import MadUnits
from simulation.pauses import Pauses
from simulation.people import Pause
from simulation.setup import STEP_S
from simulation.world.point_machine import MachineState, PointMachine
from tests.system.chaos.case import Manner
from tests.system.chaos.draw import Draw
from wayside.config import MANAGER_ID, ReentryMode
from wayside.register import Stage
from wayside.said import Accepted, Barred, ConfirmedByHand, Outside, PictureChanged, Started

LOOKS_EVERY_S: Final = 7.3
AGAIN_S: Final = 40.0
TIRED_AFTER: Final = 8  # each try waits longer than the one before, up to so many times
CONTROLLER, STAFF = "controller", "staff"


class Staff:
    """The people of one run; `acts` is what they did."""

    def __init__(self, simulation: Simulation, manner: Manner) -> None:
        self.acts: list[Act] = []
        self._simulation = simulation
        self._manner = manner
        self._draw = Draw(manner.seed, ("staff",))
        self._pauses = Pauses(simulation.setup)
        self._next_look_s = 0.0
        self._off_s: dict[str, float] = {}  # since when, by device
        self._broken_s: dict[str, float] = {}  # the same of points
        self._restored_from_s: float | None = None  # the manager's last restart, until the line is defined
        self._watched_from_s: float | None = None  # the one after which the controller looks at the picture
        self._silent_s: dict[str, float] = {}
        self._again_s: dict[str, float] = {}
        self._tries: Counter[str] = Counter()
        self._mad = MadUnits(simulation.trains.slot_of, self._held)
        simulation.journal.watch(self.see)

    def see(self, entry: Entry) -> None:
        """An entry of the journal was written."""
        t_s, event = entry.t_s, entry.event
        self._mad.see(entry)
        match event:
            case PowerOff():
                self._off_s.setdefault(event.device_id, t_s)
            case PowerOn():
                self._off_s.pop(event.device_id, None)
            case Uncommissioned():
                self._act(t_s + self._manner.power_s, ActKind.COMMISSION, event.device_id, STAFF)
            case Started() if entry.who == MANAGER_ID:
                self._silent_s = dict.fromkeys(self._simulation.trains.stock_ids, t_s)
                self._restored_from_s = t_s if event.epoch > 1 else None
                self._again_s.clear()
            case PictureChanged(stage=Stage.DEFINED.value):
                self._restored_from_s = None
            case Barred() if entry.who == MANAGER_ID:
                self._silent_s[event.unit_id] = t_s
            case Accepted() | Outside() | ConfirmedByHand():
                self._silent_s.pop(event.unit_id, None)
            case _:
                pass
        if t_s >= self._next_look_s:
            self._next_look_s = t_s + LOOKS_EVERY_S
            self._look(t_s)

    def _look(self, t_s: float) -> None:
        for device_id, since_s in list(self._off_s.items()):
            if t_s - since_s > self._manner.power_s:
                self._act(t_s, ActKind.POWER_ON, device_id, STAFF)
        for points_id, machine in self._simulation.wayside.machines.items():
            self._see_to_points(t_s, points_id, machine)
        for kind, unit_id in self._mad.due(t_s, self._manner.silent_s):
            for person in (CONTROLLER, STAFF):
                self._act(t_s, kind, unit_id, person)
        if MANAGER_ID in self._off_s:
            return
        restores = self._restored_from_s is not None and t_s - self._restored_from_s > self._manner.picture_s
        by_hand = self._simulation.setup.operation.reentry is ReentryMode.BY_HAND
        if restores and by_hand:
            self._enter_all(t_s)
        elif restores and self._watched_from_s != self._restored_from_s:  # they go on looking by themselves
            self._watched_from_s = self._restored_from_s
            self._act(t_s, ActKind.REENTER_ASSISTED, "", CONTROLLER)
        for unit_id, since_s in list(self._silent_s.items()):
            if t_s - since_s > self._manner.silent_s and not (restores and by_hand):
                self._speak_for(t_s, unit_id)

    def _act(
        self,
        t_s: float,
        kind: ActKind,
        target: str,
        person: str,
        sections: tuple[str, ...] = (),
        position: str = "",
        place: str = "",
    ) -> None:
        """Do it in the next step, and not again at once."""
        key = f"{kind.value} {target} {person}"
        if t_s < self._again_s.get(key, 0.0):
            return
        self._tries[key] += 1
        self._again_s[key] = t_s + AGAIN_S * min(self._tries[key], TIRED_AFTER)
        # Two who say the same say it one after the other.
        at_s = round(t_s + STEP_S + self._pauses.steps(Pause.WORD, person) * STEP_S, 1)
        act = Act(kind, target, Trigger(at_s=at_s), person, sections, position, place=place)
        self.acts.append(act)
        self._simulation.injector.add(act, at_s)

    # points ---------------------------------------------------------------------------------------------------

    def _see_to_points(self, t_s: float, points_id: str, machine: PointMachine) -> None:
        broken = machine.stuck or machine.state is MachineState.BETWEEN
        if not broken:
            self._broken_s.pop(points_id, None)
            return
        position = self._safe_position(points_id, machine)
        if t_s - self._broken_s.setdefault(points_id, t_s) > self._manner.points_s and position:
            self._act(t_s, ActKind.REPAIR_POINTS, points_id, STAFF, position=position)

    def _safe_position(self, points_id: str, machine: PointMachine) -> str:
        """As they lie, or as the train on them needs them; lying nowhere and free, either; empty: wait."""
        if machine.position is not None:
            return machine.position.value
        points = self._simulation.setup.line.points[points_id]
        under = set().union(*map(self._pieces_under, self._simulation.trains.active()))
        legs = {points.normal_piece: "normal", points.reverse_piece: "reverse"}
        taken = [position for piece, position in legs.items() if piece in under]
        if taken:
            return taken[0] if len(taken) == 1 else ""
        return "" if points.stem_piece in under else self._draw.one_of(("normal", "reverse"))

    # the picture of the line -----------------------------------------------------------------------------------

    def _speak_for(self, t_s: float, unit_id: str) -> None:
        """Two persons say of a silent unit what is so."""
        simulation = self._simulation
        slot = simulation.trains.slot_of[unit_id]
        if not simulation.trains.truths[slot].active:
            for person in (CONTROLLER, STAFF):
                self._act(t_s, ActKind.CONFIRM_OUTSIDE, unit_id, person, place=self._portal(slot))
        elif simulation.trains.plants[slot].speed_mps <= 0.0:
            for person in (CONTROLLER, STAFF):
                self._act(t_s, ActKind.CONFIRM_HOLDING, unit_id, person, self._held(slot))

    def _portal(self, slot: int) -> str:
        """The portal before which stock that is not on the line stands."""
        simulation = self._simulation
        duty, line = simulation.trains.duties[slot], simulation.setup.line
        spans = () if duty is None else duty.mission.spans
        portals = [section.id for section in line.sections.values() if section.kind is SectionKind.PORTAL]
        return next((s.section_id for s in reversed(spans) if s.section_id in portals), portals[0])

    def _enter_all(self, t_s: float) -> None:
        """Two persons enter every section of the line, alike; one accepts the picture."""
        simulation = self._simulation
        held = {
            stock_id: self._held(slot)
            for slot, stock_id in enumerate(simulation.trains.stock_ids)
            if simulation.trains.truths[slot].active
        }
        free = tuple(
            s for s in simulation.setup.line.sections if not any(s in mine for mine in held.values())
        )
        for person in (CONTROLLER, STAFF):
            for unit_id, sections in {**held, "": free}.items():
                self._act(t_s, ActKind.ENTER_SECTION, unit_id, person, sections)
        self._act(t_s, ActKind.ACCEPT_PICTURE, "", CONTROLLER)

    def _held(self, slot: int) -> tuple[str, ...]:
        """What the train occupies, and what its unit shows beyond that, in the order of the line."""
        line = self._simulation.setup.line
        held = {line.pieces[piece].section_id for piece in self._pieces_under(slot)}
        held |= set(self._simulation.on_board.shown(slot).held)
        return tuple(section for section in line.sections if section in held)

    def _pieces_under(self, slot: int) -> set[str]:
        trains = self._simulation.trains
        front_m = float(trains.truths[slot].position_m)
        rear_m = front_m - float(trains.bodies[slot].length_m)
        steps = trains.true_path(slot).steps
        return {step.piece_id for step in steps if step.end_m > rear_m and step.start_m < front_m}
