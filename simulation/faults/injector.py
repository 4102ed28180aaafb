"""Carries out a script: makes things fail, lets them heal, and does what people do, at the time or event given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from network.model import Position
from radio.air import Delivery
from radio.chance import generator
from simulation.agenda import Agenda, Due
from simulation.events import WORLD, Acted, Entry, FaultBegan, FaultOver
from simulation.faults.commissioning import ServiceRecord
from simulation.faults.devices import PowerFault
from simulation.faults.fault import InForce, VehiclePart, World, fold
from simulation.faults.links import LinkFault
from simulation.faults.points import PointsFault
from simulation.faults.script import Act, ActKind, Course, Failure, Script, Trigger, Watch
from simulation.journal import Journal
from simulation.pauses import Pauses
from simulation.people import Pause
from simulation.setup import STEPS_PER_S, step_not_before
from simulation.world.clock import Clock
from wayside.config import MANAGER_ID
from wayside.register import Stage
from wayside.said import (
    AcceptPicture,
    BarUnit,
    ConfirmHolding,
    ConfirmOutside,
    EnterSection,
    Input,
    PictureChanged,
    Started,
    TakeBack,
    UnbarUnit,
)

if TYPE_CHECKING:
    from simulation.world.on_board import OnBoard
    from simulation.world.points import WaysideWorld
    from simulation.world.trains import Trains

ACTS: Final = 1_000_000  # what people do is numbered from here on, faults from 0
LOOKS_AGAIN_S: Final = 10.0  # assumed: a controller who waits for a picture to be complete
Switch = Callable[[str, bool], None]  # stock id, on
GiveBack = Callable[[str, float], None]  # stock id, s until the next request
HaulAway = Callable[[str], None]  # stock id
SetClock = Callable[[str, Clock], None]  # stock id, its clock from now on
Commission = Callable[[str, int], None]  # stock id, for the so many-th time
ClaimBesides = Callable[[str, tuple[str, ...]], None]  # stock id, sections that it does not hold
ShowVehicle = Callable[[str, VehiclePart, float], None]  # stock id, what shows, and what it shows


class Injector:
    """The script of one run; the loop hands it each script item that has come due."""

    def __init__(
        self,
        script: Script,
        seed: int,
        trains: Trains,
        on_board: OnBoard,
        wayside: WaysideWorld,
        journal: Journal,
        agenda: Agenda,
        unit_power: Switch,
        unit_freeze: Switch,
        give_back: GiveBack,
        haul_away: HaulAway,
        unit_clock: SetClock,
        unit_vehicle: ShowVehicle,
        unit_claims: ClaimBesides,
        unit_commission: Commission,
    ) -> None:
        self._faults = list(script.faults)
        self._acts = list(script.acts)  # and those added during the run
        self._seed = seed
        self._trains = trains
        self._on_board = on_board
        self._wayside = wayside
        self._journal = journal
        self._agenda = agenda
        self._give_back = give_back
        self._haul_away = haul_away
        self._unit_commission = unit_commission
        self._record = ServiceRecord(wayside.sections_of)
        self._world = World(
            trains, wayside, unit_power, unit_freeze, unit_clock, unit_vehicle, unit_claims, self._lose_store
        )
        self._in_force = InForce()
        self._courses: dict[int, Course] = {}
        self._words: list[Input] = []  # what people are about to enter
        self._pauses = Pauses(trains.setup)
        self._triggers = _triggers_of(script)
        self._watch = Watch(self._triggers, self._seen)
        self._stage = Stage.DEFINED  # of the re-entry, as the controller's screen shows it
        journal.watch(self._watch.see)
        journal.watch(self._see)
        journal.watch(self._record.see)
        wayside.disturb = self._disturb

    @property
    def courses(self) -> tuple[Course, ...]:
        """What has begun so far, faults first, each in the order of the script."""
        return tuple(course for _, course in sorted(self._courses.items()))

    def start(self, step: int) -> None:
        """Put everything that has a time on the agenda."""
        self._world.step = step
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
        self._world.step = step
        for key, trigger in triggers.items():
            at_step = max(step_not_before((trigger.at_s or 0.0) + trigger.after_s), step)
            self._agenda.put_first(at_step, Due.SCRIPT, f"begin {key}")

    def add(self, act: Act, at_s: float) -> None:
        """Somebody has made up their mind during the run; whatever its trigger, the act is due at `at_s`."""
        self._acts.append(act)
        self._come_due(ACTS + len(self._acts) - 1, at_s)

    def _seen(self, key: int, at_s: float) -> None:
        """What a trigger waited for has come; a person who has said no time acts on it after one of their own."""
        act = None if key < ACTS else self._acts[key - ACTS]
        if act is not None and act.trigger.after_s == 0.0:
            at_s += self._pauses.steps(Pause.WORD, act.person) / STEPS_PER_S
        self._come_due(key, at_s)

    def _come_due(self, key: int, at_s: float) -> None:
        step = max(step_not_before(at_s), self._world.step)
        self._agenda.put(step, Due.SCRIPT, f"begin {key}")

    def due(self, step: int, subject: str) -> None:
        """A script item has come due."""
        self._world.step = step
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
        else:
            act = self._acts[key - ACTS]
            self._courses[key] = Course(act, step / STEPS_PER_S)
            self._act(act)

    # faults -------------------------------------------------------------------------------------------------

    def _begin(self, key: int, failure: Failure) -> None:
        step = self._world.step
        self._courses[key] = Course(failure, step / STEPS_PER_S)
        self._world.chance = generator(self._seed, "fault", str(key))
        self._write(FaultBegan, failure)
        self._in_force.begin(key, failure.fault, self._world)
        if failure.fault.momentary:
            self._end(key)
        elif failure.duration_s is not None:
            self._agenda.put(step + round(failure.duration_s * STEPS_PER_S), Due.SCRIPT, f"end {key}")

    def _end(self, key: int) -> None:
        """A fault is over: its time has come, or a person has ended it before."""
        if key not in self._in_force:
            return
        failure = self._faults[key]
        self._courses[key].over_s = self._world.step / STEPS_PER_S
        if not failure.fault.momentary:
            self._write(FaultOver, failure)
        self._in_force.end(key, self._world)

    def _end_all(self, changes: str, target: str) -> None:
        """A person ends all faults of one quantity of a target."""
        for key in self._in_force.at((changes, target)):
            self._end(key)

    def _lose_store(self, party_id: str) -> None:
        if party_id in self._trains.slot_of:
            self._on_board.lose_store(self._trains.slot_of[party_id])
        else:
            self._wayside.lose_store(party_id)

    def _commission(self, party_id: str) -> None:
        """Staff put into service again what waits for it; anything else they leave alone."""
        slot = self._trains.slot_of.get(party_id)
        if slot is not None and slot in self._on_board.uncommissioned:
            self._unit_commission(party_id, self._record.number(party_id))
        elif party_id in self._wayside.uncommissioned:
            number, vital = self._record.number(party_id), self._record.vital(party_id)
            self._wayside.commission(self._world.step, party_id, number, vital)

    def _write(self, changed: type[FaultBegan | FaultOver], failure: Failure) -> None:
        fault = failure.fault
        event = changed(kind=fault.kind, target=str(fault.target), parameters=fault.parameters())
        self._journal.write(self._world.step / STEPS_PER_S, WORLD, event)

    def _disturb(
        self, _step: int, source: str, destination: str, deliveries: tuple[Delivery, ...]
    ) -> tuple[Delivery, ...]:
        """What the link faults in force make of a telegram on its way."""
        on_its_way = [f for f in self._in_force.of(LinkFault) if f.target.joins(source, destination)]
        return fold(deliveries, on_its_way)

    # people -------------------------------------------------------------------------------------------------

    def _act(self, act: Act) -> None:
        acted = Acted(act=act.kind.value, target=act.target, section_ids=act.sections)
        self._journal.write(self._world.step / STEPS_PER_S, act.person, acted)
        match act.kind:
            case ActKind.CONFIRM_OUTSIDE | ActKind.CONFIRM_HOLDING | ActKind.TAKE_BACK:
                self._wayside.input(self._world.step, MANAGER_ID, _word_on_unit(act))
            case ActKind.BAR_UNIT | ActKind.UNBAR_UNIT:
                said = BarUnit if act.kind is ActKind.BAR_UNIT else UnbarUnit
                self._wayside.input_all(self._world.step, said(act.target, act.person))
            case ActKind.POWER_ON:
                self._end_all(PowerFault.changes, act.target)
            case ActKind.COMMISSION:
                self._commission(act.target)
            case ActKind.REPAIR_POINTS:
                self._end_all(PointsFault.changes, act.target)
                self._wayside.repair(self._world.step, act.target, Position(act.position))
            case ActKind.HAUL_AWAY:
                self._haul_away(act.target)
            case ActKind.GIVE_BACK:
                self._give_back(act.target, act.hold_s)
            case ActKind.ACCEPT_PICTURE:
                self._enter(act, [AcceptPicture(act.person)])
            case ActKind.REENTER_ASSISTED:
                self._accept_when_complete(act, self._acts.index(act))
            case ActKind.ENTER_SECTION:
                unit_id = act.target or None
                words = [EnterSection(section_id, unit_id, act.person) for section_id in act.sections]
                self._wayside.input(self._world.step, MANAGER_ID, words[0])
                self._enter(act, words[1:])
            case ActKind.REENTER_BY_HAND:
                self._reenter(act)

    def _see(self, entry: Entry) -> None:
        """What the block manager shows its controller of a re-entry."""
        match entry.event:
            case PictureChanged(stage=stage):
                self._stage = Stage(stage)
            case Started(epoch=epoch) if entry.who == MANAGER_ID and epoch > 1:
                self._stage = Stage.INCOMPLETE
            case _:
                pass

    def _accept_when_complete(self, act: Act, number: int) -> None:
        """The controller looks at the picture again and again, and accepts it when nothing is missing."""
        if self._stage is Stage.INCOMPLETE:
            again = self._world.step + round(LOOKS_AGAIN_S * STEPS_PER_S)
            self._agenda.put(again, Due.SCRIPT, f"look {number}")
        else:
            self._enter(act, [AcceptPicture(act.person)])

    def _reenter(self, act: Act) -> None:
        """Every section of the line by what the crews say they hold and stand in, then the whole picture (手動入力)."""
        holder = {
            section_id: stock_id
            for slot, stock_id in enumerate(self._trains.stock_ids)
            if self._on_board.shown(slot).on_line  # who has not been accepted holds nothing yet
            for section_id in self._on_board.shown(slot).held
        }
        holder |= {s: stock_id for stock_id, under in self._trains.sections_under().items() for s in under}
        entries = [EnterSection(s, holder.get(s), act.person) for s in self._wayside.section_ids]
        self._enter(act, [*entries, AcceptPicture(act.person)])

    def _enter(self, act: Act, words: Sequence[Input]) -> None:
        """A person enters words one after the other, each after the pace of the act, or a time of their own."""
        step = self._world.step
        for word in words:
            pace_s = act.pace_s
            step += (
                self._pauses.steps(Pause.WORD, act.person) if pace_s is None else round(pace_s * STEPS_PER_S)
            )
            self._words.append(word)
            self._agenda.put(step, Due.SCRIPT, f"word {len(self._words) - 1}")


def _word_on_unit(act: Act) -> Input:
    """What a controller enters of one unit at the manager."""
    match act.kind:
        case ActKind.CONFIRM_OUTSIDE:
            return ConfirmOutside(act.target, act.person, act.place)
        case ActKind.CONFIRM_HOLDING:
            return ConfirmHolding(act.target, act.sections, act.person)
        case _:
            return TakeBack(act.target, act.person)


def _triggers_of(script: Script, faults: int = 0, acts: int = 0) -> dict[int, Trigger]:
    """By number, behind so many faults and acts."""
    of_faults = {i: failure.trigger for i, failure in enumerate(script.faults, faults)}
    return of_faults | {i: act.trigger for i, act in enumerate(script.acts, ACTS + acts)}
