"""Carries out a script: makes things fail, lets them heal, and does what people do, at the time or event given."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from network.model import Position
from radio.air import Delivery
from radio.chance import generator
from simulation.agenda import Agenda, Due
from simulation.faults.script import Act, ActKind, Fault, FaultKind, Script, Trigger, Watch
from simulation.journal import Journal
from simulation.setup import STEPS_PER_S
from wayside.config import MANAGER_ID
from wayside.said import AcceptPicture, ConfirmHolding, ConfirmOutside, EnterSection, Input

if TYPE_CHECKING:
    from simulation.world.points import WaysideWorld
    from simulation.world.trains import Trains

BOTH_WAYS: Final = " <-> "
ONE_WAY: Final = " -> "
ANY: Final = "*"
NOT_FROZEN: Final = -1.0

Power = Callable[[str, bool], None]  # stock id, on
GiveBack = Callable[[str, float], None]  # stock id, s until the next request


def link_ends(target: str) -> tuple[tuple[str, str], ...]:
    """Directed links of 'A -> B' or 'A <-> B'; an end may be '*'. Empty if the words are not of that form."""
    if BOTH_WAYS in target:
        one, other = target.split(BOTH_WAYS, 1)
        return ((one, other), (other, one))
    if ONE_WAY in target:
        one, other = target.split(ONE_WAY, 1)
        return ((one, other),)
    return ()


class Injector:
    """The script of one run; the loop hands it each script item that has come due."""

    def __init__(
        self,
        script: Script,
        seed: int,
        trains: Trains,
        wayside: WaysideWorld,
        journal: Journal,
        agenda: Agenda,
        unit_power: Power,
        give_back: GiveBack,
    ) -> None:
        self._script = script
        self._trains = trains
        self._wayside = wayside
        self._journal = journal
        self._agenda = agenda
        self._unit_power = unit_power
        self._give_back = give_back
        self._step = 0
        self._words: list[Input] = []  # what people are about to enter
        self._disturbed: dict[int, Fault] = {}  # link faults in force, by number
        self._chance = [generator(seed, "fault", str(i)) for i in range(len(script.faults))]
        triggers = {i: fault.trigger for i, fault in enumerate(script.faults)}
        first_act = len(script.faults)
        triggers |= {first_act + i: act.trigger for i, act in enumerate(script.acts)}
        self._triggers: dict[int, Trigger] = triggers
        self._watch = Watch(triggers, self._come_due)
        journal.watch(self._watch.see)
        wayside.disturb = self._disturb

    def start(self, step: int) -> None:
        """Put everything that has a time on the agenda."""
        self._step = step
        for key, trigger in self._triggers.items():
            if trigger.at_s is not None:
                self._come_due(key, trigger.at_s + trigger.after_s)

    def _come_due(self, key: int, at_s: float) -> None:
        step = max(math.ceil(at_s * STEPS_PER_S - 1e-6), self._step)
        self._agenda.put(step, Due.SCRIPT, f"begin {key}")

    def due(self, step: int, subject: str) -> None:
        """A script item has come due."""
        self._step = step
        what, number = subject.split()
        key = int(number)
        if what == "word":
            self._wayside.input(step, MANAGER_ID, self._words[key])
            return
        if key >= len(self._script.faults):
            self._act(self._script.acts[key - len(self._script.faults)])
            return
        fault = self._script.faults[key]
        begins = what == "begin"
        data = {"kind": fault.kind.value, "target": fault.target, **fault.parameters}
        self._journal.write(step / STEPS_PER_S, "world", "fault" if begins else "fault_over", **data)
        _EFFECTS[fault.kind](self, key, fault, begins)
        if begins and fault.duration_s is not None:
            self._agenda.put(step + round(fault.duration_s * STEPS_PER_S), Due.SCRIPT, f"end {key}")

    # devices ------------------------------------------------------------------------------------------------

    def _power(self, _key: int, fault: Fault, begins: bool) -> None:
        self._switch(fault.target, on=not begins)

    def _restart(self, _key: int, fault: Fault, begins: bool) -> None:
        if begins:
            self._switch(fault.target, on=False)
            self._switch(fault.target, on=True)

    def _switch(self, target: str, *, on: bool) -> None:
        if target in self._trains.slot_of:
            self._unit_power(target, on)
        elif on:
            self._wayside.power_on(self._step, target)
        else:
            self._wayside.power_off(self._step, target)

    def _freeze(self, _key: int, fault: Fault, begins: bool) -> None:
        self._wayside.freeze(self._step, fault.target, frozen=begins)

    # links --------------------------------------------------------------------------------------------------

    def _link(self, key: int, fault: Fault, begins: bool) -> None:
        if begins:
            self._disturbed[key] = fault
        else:
            self._disturbed.pop(key, None)

    def _disturb(
        self, _step: int, source: str, destination: str, deliveries: tuple[Delivery, ...]
    ) -> tuple[Delivery, ...]:
        """What the link faults in force make of a telegram on its way."""
        for key, fault in self._disturbed.items():
            ends = link_ends(fault.target)
            if any(a in (ANY, source) and b in (ANY, destination) for a, b in ends):
                deliveries = self._disturb_one(key, fault, deliveries)
        return deliveries

    def _disturb_one(self, key: int, fault: Fault, deliveries: tuple[Delivery, ...]) -> tuple[Delivery, ...]:
        chance = self._chance[key]
        p = fault.parameters.get("p", 1.0)
        later = round(fault.parameters.get("seconds", 1.0) * STEPS_PER_S)
        changed: list[Delivery] = []
        for delivery in deliveries:
            hit = chance.random() < p
            match fault.kind:
                case FaultKind.CUT | FaultKind.LOSS:
                    changed += [] if hit else [delivery]
                case FaultKind.DELAY | FaultKind.REORDER:
                    changed.append(replace(delivery, step=delivery.step + later) if hit else delivery)
                case FaultKind.DUPLICATE:
                    changed += [delivery, replace(delivery, step=delivery.step + 1)] if hit else [delivery]
                case _:
                    changed.append(_flipped(delivery, chance) if hit else delivery)
        return tuple(changed)

    # sensors, tags, points ----------------------------------------------------------------------------------

    def _tachometer(self, _key: int, fault: Fault, begins: bool) -> None:
        tachometer = self._trains.tachometers[self._trains.slot_of[fault.target]]
        gain = {FaultKind.SCALE: fault.parameters.get("factor", 1.0), FaultKind.NO_OUTPUT: 0.0}
        tachometer.gain = gain.get(fault.kind, 1.0) if begins else 1.0
        plant = self._trains.plants[self._trains.slot_of[fault.target]]
        stuck = begins and fault.kind is FaultKind.STUCK_OUTPUT
        self._trains.tachometer_faults[self._trains.slot_of[fault.target]] = begins
        tachometer.frozen_mps = plant.wheel_speed_mps if stuck else NOT_FROZEN

    def _rail(self, _key: int, fault: Fault, begins: bool) -> None:
        plant = self._trains.plants[self._trains.slot_of[fault.target]]
        plant.adhesion_factor = fault.parameters["factor"] if begins else 1.0

    def _tag(self, _key: int, fault: Fault, begins: bool) -> None:
        tag_id = int(fault.target)
        if not begins:
            self._trains.tag_faults.pop(tag_id, None)
        elif fault.kind is FaultKind.MISS:
            self._trains.tag_faults[tag_id] = None
        else:
            self._trains.tag_faults[tag_id] = int(fault.parameters["id"])

    def _points(self, _key: int, fault: Fault, begins: bool) -> None:
        machine = self._wayside.machines[fault.target]
        match fault.kind:
            case FaultKind.STUCK:
                changed = replace(machine, stuck=begins)
            case FaultKind.NO_DETECTION:
                changed = replace(machine, detection_fault=begins)
            case _:
                factor = fault.parameters["factor"]
                slower = machine.throw_time_s * (factor if begins else 1.0 / factor)
                changed = replace(machine, throw_time_s=slower)
        self._wayside.set_machine(self._step, changed)

    # people -------------------------------------------------------------------------------------------------

    def _act(self, act: Act) -> None:
        data = {"act": act.kind.value, "target": act.target, "sections": list(act.sections)}
        self._journal.write(self._step / STEPS_PER_S, act.person, "act", **data)
        match act.kind:
            case ActKind.CONFIRM_OUTSIDE:
                self._wayside.input(self._step, MANAGER_ID, ConfirmOutside(act.target, act.person))
            case ActKind.CONFIRM_HOLDING:
                entry = ConfirmHolding(act.target, act.sections, act.person)
                self._wayside.input(self._step, MANAGER_ID, entry)
            case ActKind.POWER_ON:
                self._switch(act.target, on=True)
            case ActKind.REPAIR_POINTS:
                self._wayside.repair(self._step, act.target, Position(act.position))
            case ActKind.GIVE_BACK:
                self._give_back(act.target, act.hold_s)
            case ActKind.ACCEPT_PICTURE | ActKind.REENTER_ASSISTED:
                self._enter([AcceptPicture(act.person)], act.pace_s)
            case ActKind.ENTER_SECTION:
                for section_id in act.sections:
                    word = EnterSection(section_id, act.target or None, act.person)
                    self._wayside.input(self._step, MANAGER_ID, word)
            case ActKind.REENTER_BY_HAND:
                self._reenter(act)

    def _reenter(self, act: Act) -> None:
        """Every section of the line by what the crews say they hold, then the whole picture (手動入力)."""
        holder = {
            section_id: unit.facts.unit_id
            for unit in self._trains.on_board
            if unit.authority.on_line  # who has not been accepted holds nothing yet, whatever it wishes
            for section_id in unit.authority.section_ids()
        }
        entries = [EnterSection(s, holder.get(s), act.person) for s in self._wayside.section_ids]
        self._enter([*entries, AcceptPicture(act.person)], act.pace_s)

    def _enter(self, words: Sequence[Input], pace_s: float) -> None:
        """A person enters words one after the other, `pace_s` for each."""
        for count, word in enumerate(words, 1):
            step = self._step + round(count * pace_s * STEPS_PER_S)
            self._words.append(word)
            self._agenda.put(step, Due.SCRIPT, f"word {len(self._words) - 1}")


def _flipped(delivery: Delivery, chance: np.random.Generator) -> Delivery:
    """The telegram with one bit turned."""
    data = bytearray(delivery.data)
    bit = int(chance.integers(8 * len(data)))
    data[bit // 8] ^= 1 << bit % 8
    return replace(delivery, data=bytes(data))


_EFFECTS: Final[dict[FaultKind, Callable[[Injector, int, Fault, bool], None]]] = {
    FaultKind.POWER_OFF: Injector._power,
    FaultKind.RESTART: Injector._restart,
    FaultKind.FROZEN: Injector._freeze,
    FaultKind.CUT: Injector._link,
    FaultKind.LOSS: Injector._link,
    FaultKind.DELAY: Injector._link,
    FaultKind.DUPLICATE: Injector._link,
    FaultKind.REORDER: Injector._link,
    FaultKind.FLIP: Injector._link,
    FaultKind.SCALE: Injector._tachometer,
    FaultKind.STUCK_OUTPUT: Injector._tachometer,
    FaultKind.NO_OUTPUT: Injector._tachometer,
    FaultKind.SLIPPERY: Injector._rail,
    FaultKind.MISS: Injector._tag,
    FaultKind.WRONG_ID: Injector._tag,
    FaultKind.STUCK: Injector._points,
    FaultKind.NO_DETECTION: Injector._points,
    FaultKind.SLOW: Injector._points,
}
