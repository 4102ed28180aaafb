"""Carries out a script: makes things fail, lets them heal, and does what people do, at the time or event given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Final

from network.model import Position
from radio.chance import generator
from simulation.agenda import AgendaKind
from simulation.cabs import Cabs
from simulation.duties import Duties
from simulation.effects import Effects
from simulation.events import WORLD, Acted, FaultBegan, FaultOver, JournalEntry
from simulation.faults.commissioning import ServiceRecord
from simulation.faults.devices import PowerFault
from simulation.faults.points import PointsFault
from simulation.faults.script import (
    AT_CROSSING,
    BY_ROLE,
    Act,
    ActKind,
    ItemCourse,
    Script,
    ScriptedFault,
    Trigger,
    TriggerWatch,
)
from simulation.pauses import Pauses
from simulation.people import Pause
from simulation.platforms import Platforms
from simulation.setup import STEPS_PER_S, step_not_before
from simulation.world.disorder import fault_onset
from simulation.world.stage import World
from wayside.config import MANAGER_ID
from wayside.crossing_said import NoTrainComes
from wayside.register import ReentryStage
from wayside.said import (
    AcceptPicture,
    BarUnit,
    ConfirmHolding,
    ConfirmOutside,
    EndTrain,
    EnterSection,
    Input,
    LetGo,
    LetWait,
    PictureChanged,
    Started,
    TakeBack,
    UnbarUnit,
)

ACTS: Final = 1_000_000  # what people do is numbered from here on, faults from 0
LOOKS_AGAIN_S: Final = 10.0  # assumed: a controller who waits for a picture to be complete


class Injector:
    """The script of one run; the loop hands it each script item that has come due."""

    def __init__(
        self,
        script: Script,
        world: World,
        cabs: Cabs,
        duties: Duties,
        platforms: Platforms,
        by_role: Callable[[Act, int], None] | None = None,
    ) -> None:
        self._by_role = by_role  # what persons do as those who work a line by substitute working
        self._faults = list(script.faults)
        self._acts = list(script.acts)  # and those added during the run
        self._step = 0  # the present one
        self._seed, self._in_force = world.setup.seed, world.in_force
        self._trains, self._on_board, self._wayside = world.trains, world.on_board, world.wayside
        self._journal, self._agenda, self._charging = world.journal, world.agenda, world.charging
        self._cabs, self._duties = cabs, duties
        self._effects = Effects(world, cabs, duties, platforms)
        self._record = ServiceRecord(world.wayside.points_of)
        self._courses: dict[int, ItemCourse] = {}
        self._looks: dict[
            int, Callable[[], Act | None]
        ] = {}  # by act, of those who look again as they come to do it
        self._words: list[Input] = []  # what people are about to enter
        self._pauses = Pauses(world.setup)
        self._triggers = _triggers_of(script)
        self._watch = TriggerWatch(self._triggers, self._seen)
        self._stage = ReentryStage.DEFINED  # of the re-entry, as the controller's screen shows it
        for see in (self._watch.see, self._see, self._record.see):
            world.journal.watch(see)

    @property
    def courses(self) -> tuple[ItemCourse, ...]:
        """What has begun so far, faults first, each in the order of the script."""
        return tuple(course for _, course in sorted(self._courses.items()))

    def start(self, step: int) -> None:
        """Put everything that has a time on the agenda."""
        self._step = step
        for key, trigger in self._triggers.items():
            if trigger.at_s is not None:
                self._come_due(key, trigger.at_s + trigger.after_s)

    def take_up(self, script: Script, step: int) -> None:
        """A script that has times alone, from now on, behind what there is: ValueError if it waits for events."""
        triggers = _triggers_of(script, len(self._faults), len(self._acts))
        if any(trigger.at_s is None for trigger in triggers.values()):
            raise ValueError("a script is taken up by time")
        self._faults += script.faults
        self._acts += script.acts
        self._step = step
        for key, trigger in triggers.items():
            at_step = max(step_not_before((trigger.at_s or 0.0) + trigger.after_s), step)
            self._agenda.put_first(at_step, AgendaKind.SCRIPT, f"begin {key}")

    def insert(self, item: ScriptedFault | Act, step: int) -> int:
        """Somebody has an item begin at a step to come, as if the script had ended with it; returns its number."""
        timed = replace(item, trigger=Trigger(at_s=step / STEPS_PER_S))
        if isinstance(timed, ScriptedFault):
            self.take_up(Script(faults=(timed,)), self._step)
            return len(self._faults) - 1
        self.take_up(Script(acts=(timed,)), self._step)
        return ACTS + len(self._acts) - 1

    def end_at(self, number: int, step: int) -> None:
        """A fault is over at a step to come, as if that had been its duration from when it began."""
        self._agenda.withdraw(AgendaKind.SCRIPT, f"end {number}")
        self._agenda.put_first(step, AgendaKind.SCRIPT, f"end {number}")

    def in_force(self, number: int) -> bool:
        """Whether a fault has begun and is not over."""
        return number in self._in_force

    def add(self, act: Act, at_s: float, look: Callable[[], Act | None] | None = None) -> None:
        """Somebody has made up their mind during the run; whatever its trigger, the act is due at `at_s`.

        Who looks again then does what `look` gives instead, or, if that is None, nothing.
        """
        self._acts.append(act)
        key = ACTS + len(self._acts) - 1
        if look is not None:
            self._looks[key] = look
        self._come_due(key, at_s)

    def _seen(self, key: int, at_s: float) -> None:
        """What a trigger waited for has come; a person who has said no time acts on it after one of their own."""
        act = None if key < ACTS else self._acts[key - ACTS]
        if act is not None and act.trigger.after_s == 0.0:
            at_s += self._pauses.steps(Pause.WORD, act.person) / STEPS_PER_S
        self._come_due(key, at_s)

    def _come_due(self, key: int, at_s: float) -> None:
        step = max(step_not_before(at_s), self._step)
        self._agenda.put(step, AgendaKind.SCRIPT, f"begin {key}")

    def due(self, step: int, subject: str) -> None:
        """A script item has come due."""
        self._step = step
        what, number = subject.split()
        key = int(number)
        if what == "look":
            self._accept_when_complete(self._acts[key], key)
        elif what == "word":
            self._wayside.input(step, MANAGER_ID, self._words[key])
        elif what == "end":
            self._end(key)
        elif key < ACTS:
            self._begin(key, self._faults[key])
        elif (act := self._looks.pop(key, partial(self._acts.__getitem__, key - ACTS))()) is not None:
            self._acts[key - ACTS] = act
            self._courses[key] = ItemCourse(act, step / STEPS_PER_S)
            self._act(act)

    # faults -------------------------------------------------------------------------------------------------

    def _begin(self, key: int, failure: ScriptedFault) -> None:
        step = self._step
        self._courses[key] = ItemCourse(failure, step / STEPS_PER_S)
        self._write(FaultBegan, failure)
        chance = generator(self._seed, "fault", str(key))
        self._in_force.begin(key, failure.fault, fault_onset(self._trains, step / STEPS_PER_S, chance))
        self._put(failure)
        if failure.fault.momentary:
            self._end(key)
        elif failure.duration_s is not None:
            self._agenda.put(step + round(failure.duration_s * STEPS_PER_S), AgendaKind.SCRIPT, f"end {key}")

    def _end(self, key: int) -> None:
        """A fault is over: its time has come, or a person has ended it before."""
        if key not in self._in_force:
            return
        failure = self._faults[key]
        self._courses[key].over_s = self._step / STEPS_PER_S
        if not failure.fault.momentary:
            self._write(FaultOver, failure)
        self._in_force.end(key)
        self._put(failure)

    def _put(self, changed: ScriptedFault) -> None:
        self._effects.put_effect(changed.fault, self._in_force.value(changed.fault), self._step)

    def _end_all(self, changes: str, target: str) -> None:
        """A person ends all faults of one quantity of a target."""
        for key in self._in_force.at((changes, target)):
            self._end(key)

    def _commission(self, party_id: str) -> None:
        """Staff put into service again what waits for it; anything else they leave alone."""
        slot = self._trains.slot_of.get(party_id)
        if slot is not None and slot in self._on_board.uncommissioned:
            self._duties.commission(slot, self._step, self._record.number(party_id))
        elif party_id in self._wayside.uncommissioned:
            number, vital = self._record.number(party_id), self._record.vital(party_id)
            self._wayside.commission(self._step, party_id, number, vital)

    def _write(self, changed: type[FaultBegan | FaultOver], failure: ScriptedFault) -> None:
        fault = failure.fault
        event = changed(kind=fault.kind, target=str(fault.target), parameters=fault.parameters())
        self._journal.write(self._step / STEPS_PER_S, WORLD, event)

    # people -------------------------------------------------------------------------------------------------

    def _act(self, act: Act) -> None:
        kind, sections = act.kind.value, act.sections
        unsaid = self._unsaid(act) if act.kind in (ActKind.CONFIRM_OUTSIDE, ActKind.CONFIRM_HOLDING) else ()
        acted = Acted(
            act=kind, target=act.target, section_ids=sections, notch=act.notch, unsaid_section_ids=unsaid
        )
        self._journal.write(self._step / STEPS_PER_S, act.person, acted)
        if act.kind in AT_CROSSING:
            self._act_at_crossing(act)
        elif act.kind not in BY_ROLE:
            self._act_at_equipment(act)
        elif self._by_role is not None:
            self._by_role(act, self._step)

    def _unsaid(self, act: Act) -> tuple[str, ...]:
        """What a word about a unit leaves out, along the line; of one without power only where its train stands."""
        slot = self._trains.slot_of[act.target]
        shown = () if slot in self._on_board.unpowered else self._on_board.shown_to_driver(slot).held
        known = {*shown, *self._trains.sections_under().get(act.target, ())}.difference(act.sections)
        return tuple(section_id for section_id in self._wayside.section_ids if section_id in known)

    def _act_at_equipment(self, act: Act) -> None:
        match act.kind:
            case ActKind.BAR_UNIT | ActKind.UNBAR_UNIT:
                said = BarUnit if act.kind is ActKind.BAR_UNIT else UnbarUnit
                self._wayside.input_all(self._step, said(act.target, act.person))
            case ActKind.POWER_ON:
                self._end_all(PowerFault.changes, act.target)
            case ActKind.COMMISSION:
                self._commission(act.target)
            case ActKind.REPAIR_POINTS:
                self._end_all(PointsFault.changes, act.target)
                self._wayside.repair(self._step, act.target, Position(act.position))
            case ActKind.HAUL_AWAY | ActKind.BRING_POWER:
                self._help_out(act.kind, self._trains.slot_of[act.target])
            case ActKind.GIVE_BACK:
                self._cabs.set_back(self._trains.slot_of[act.target], self._step, act.hold_s)
            case ActKind.DRIVE | ActKind.DRIVE_BY_ATO:
                notch = act.notch if act.kind is ActKind.DRIVE else None
                self._trains.drive(self._trains.slot_of[act.target], notch)
            case ActKind.ACCEPT_PICTURE:
                self._enter(act, [AcceptPicture(act.person)])
            case ActKind.REENTER_ASSISTED:
                self._accept_when_complete(act, self._acts.index(act))
            case ActKind.ENTER_SECTION:
                unit_id = act.target or None
                words = [EnterSection(section_id, unit_id, act.person) for section_id in act.sections]
                self._wayside.input(self._step, MANAGER_ID, words[0])
                self._enter(act, words[1:])
            case ActKind.REENTER_BY_HAND:
                self._reenter(act)
            case _:
                self._wayside.input(self._step, MANAGER_ID, _word_on_unit(act))

    def _help_out(self, kind: ActKind, slot: int) -> None:
        """Staff haul a train away, or bring it power."""
        if kind is ActKind.HAUL_AWAY:
            self._duties.haul_away(slot, self._step)
        elif self._charging is not None:
            self._charging.bring_power(slot)

    def _act_at_crossing(self, act: Act) -> None:
        if act.kind is ActKind.FREE_ROAD:
            self._wayside.input(self._step, act.target, NoTrainComes(act.person))
        else:
            there = act.kind is ActKind.GUARD_ROAD
            self._wayside.crossings.guard(self._step, act.target, there=there)

    def _see(self, entry: JournalEntry) -> None:
        """What the block manager shows its controller of a re-entry."""
        match entry.event:
            case PictureChanged(stage=stage):
                self._stage = ReentryStage(stage)
            case Started(epoch=epoch) if entry.who == MANAGER_ID and epoch > 1:
                self._stage = ReentryStage.INCOMPLETE
            case _:
                pass

    def _accept_when_complete(self, act: Act, number: int) -> None:
        """The controller looks at the picture again and again, and accepts it when nothing is missing."""
        if self._stage is ReentryStage.INCOMPLETE:
            again = self._step + round(LOOKS_AGAIN_S * STEPS_PER_S)
            self._agenda.put(again, AgendaKind.SCRIPT, f"look {number}")
        else:
            self._enter(act, [AcceptPicture(act.person)])

    def _reenter(self, act: Act) -> None:
        """Every section of the line by what the crews say they hold and stand in, then the whole picture (手動入力)."""
        holder = {
            section_id: stock_id
            for slot, stock_id in enumerate(self._trains.stock_ids)
            if self._on_board.shown_to_driver(slot).on_line  # who has not been accepted holds nothing yet
            for section_id in self._on_board.shown_to_driver(slot).held
        }
        holder |= {s: stock_id for stock_id, under in self._trains.sections_under().items() for s in under}
        entries = [EnterSection(s, holder.get(s), act.person) for s in self._wayside.section_ids]
        self._enter(act, [*entries, AcceptPicture(act.person)])

    def _enter(self, act: Act, words: Sequence[Input]) -> None:
        """A person enters words one after the other, each after the pace of the act, or a time of their own."""
        step = self._step
        for word in words:
            pace_s = act.pace_s
            step += (
                self._pauses.steps(Pause.WORD, act.person) if pace_s is None else round(pace_s * STEPS_PER_S)
            )
            self._words.append(word)
            self._agenda.put(step, AgendaKind.SCRIPT, f"word {len(self._words) - 1}")


def _word_on_unit(act: Act) -> Input:
    """What a controller enters of one unit at the manager."""
    match act.kind:
        case ActKind.CONFIRM_OUTSIDE:
            return ConfirmOutside(act.target, act.person, act.place)
        case ActKind.CONFIRM_HOLDING:
            return ConfirmHolding(act.target, act.sections, act.person)
        case ActKind.HOLD_TRAIN:
            return LetWait(act.target, act.person, act.hold_s, act.behind, act.place)
        case ActKind.LET_GO:
            return LetGo(act.target, act.person)
        case ActKind.END_TRAIN:
            return EndTrain(act.target, act.person, act.train)
        case _:
            return TakeBack(act.target, act.person)


def _triggers_of(script: Script, faults: int = 0, acts: int = 0) -> dict[int, Trigger]:
    """By number, behind so many faults and acts."""
    of_faults = {i: failure.trigger for i, failure in enumerate(script.faults, faults)}
    return of_faults | {i: act.trigger for i, act in enumerate(script.acts, ACTS + acts)}
