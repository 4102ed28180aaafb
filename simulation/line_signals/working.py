"""A day by line signals: people act by the script, contacts see trains pass, drivers run by what they see.

Nothing positions a train but its driver and the physics. What is stated of the equipment: departure points are thrown
when the signal clears, or by hand for a driver who is told to pass it at stop; arrival points when a train comes to
`HOME_M` before them and no signal lets one out over them, and before points that do not lie for it a train is stopped,
as by a home signal. A signal that is automatic is pulled by a train that comes into the section before it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from network.clock import first_given
from network.model import Position, SectionKind
from onboard.mission import Mission
from simulation.agenda import AgendaKind
from simulation.cabs import Cabs
from simulation.duties import Duties
from simulation.events import WORLD, SignalActed, SignalPassed, SignalShows, WrongDeparture
from simulation.faults.script import Act
from simulation.line_signals.machine import Aspect, Contact, SignalMachine, SignalsState
from simulation.line_signals_settings import LineSignal, LineSignals, SignalAct, SignalDeed
from simulation.setup import STEPS_PER_S, step_not_before
from simulation.substitute.by_hand import DrivenTrain, HandDriver
from simulation.world.stage import World

# published: the most over the points beyond a signal passed by that aspect
SUBSTITUTE_MPS: Final = 40.0 / 3.6
HOME_M: Final = 1000.0  # assumed: the contact that throws arrival points, beyond a train's braking distance


class LineSignalWorking:
    """The signals of one run, the people at them and the drivers before them."""

    busy: Final = True  # staff who react to units and managers have nothing to do

    def __init__(self, world: World, cabs: Cabs, duties: Duties, settings: LineSignals) -> None:
        self._trains, self._wayside = world.trains, world.wayside
        self._agenda, self._journal = world.agenda, world.journal
        self._speed_mps: Final = settings.speed_mps(world.setup.line.max_speed_mps)
        dwell_s = world.setup.timetable.head.dwell_min_s
        self._drivers: Final = HandDriver(world, cabs, duties, self._speed_mps, dwell_s)
        self._machine: Final = SignalMachine(settings)
        self._state = SignalsState()
        self._shown: dict[str, Aspect] = {}
        self._acts = sorted(settings.act, key=lambda act: act.at_s)
        self._under: dict[str, set[str]] = {}  # sections under each train when somebody last looked
        self._past: dict[
            tuple[int, str], str
        ] = {}  # the last signal that a train passed at a halt of a section
        self._sent_off: set[tuple[int, str]] = set()
        self._cautious: dict[
            int, set[str]
        ] = {}  # sections that trains leave slowly, past a substitute aspect
        self._routes: dict[str, int] = {}  # points that lie for a train

    def begin(self, step: int) -> None:
        """The line has neither manager nor units: they are off before anything runs. People act in their time."""
        for device_id in self._wayside.device_ids:
            self._wayside.power_off(step, device_id)
        for slot in range(len(self._trains.stock_ids)):
            self._drivers.cut_out(slot, step)
        for act in self._acts:
            self._agenda.put(max(step_not_before(act.at_s), step), AgendaKind.PROCEDURE, act.who)

    def look(self, step: int) -> None:
        """All look round: what is due is done, what contacts see is told, drivers see what signals show."""
        while self._acts and step_not_before(self._acts[0].at_s) <= step:
            self._act(self._acts.pop(0), step)
        self._drivers.look(step)
        self._contacts(step)
        for slot, train in self._drivers.driven.items():
            self._approaches(slot, train, step)
        self._show(step)
        for slot, train in self._drivers.driven.items():
            self._see(slot, train, step)
        self._drivers.look(step)

    def act(self, act: Act, step: int) -> None:
        """Nobody has a role of substitute working here."""

    # people -----------------------------------------------------------------------------------------------------------

    def _act(self, act: SignalAct, step: int) -> None:
        at_lever = act.does in (SignalDeed.LEVER, SignalDeed.RELEASE_LEVER)
        named = {"lever_id" if at_lever else "signal_id": act.target}
        acted = SignalActed(does=act.does.value, **named)
        self._journal.write(step / STEPS_PER_S, act.who, acted)
        if act.does is SignalDeed.SEND_OFF:
            self._send_off(act.target)
        else:
            self._tell(act.does, act.target)

    def _send_off(self, signal_id: str) -> None:
        """The driver who stands at a signal may pass it; for him the points before the section are set by hand."""
        for slot, train in self._drivers.driven.items():
            ahead = next(self._signals_ahead(slot, train), None)
            if ahead is not None and ahead[1].id == signal_id:
                self._sent_off.add((slot, signal_id))
                return

    # equipment --------------------------------------------------------------------------------------------------------

    def _tell(self, event: SignalDeed | Contact, name: str, unit_id: str = "") -> None:
        self._state = self._machine.after(self._state, event, name, unit_id)

    def _contacts(self, step: int) -> None:
        """Fronts that passed a signal at the end of a track, rears that left a section."""
        under = self._trains.sections_under()
        for unit_id in sorted(under):
            slot, before = self._trains.slot_of[unit_id], self._under.get(unit_id, set())
            train = self._drivers.driven.get(slot)
            if train is None or train.duty is None:
                continue
            came, left = under[unit_id] - before, before - under[unit_id]
            for signal in self._machine.signals.values():
                if signal.direction is not train.duty.mission.direction:
                    continue
                if signal.at in before and came.intersection(_beyond(train.duty.mission, signal)):
                    self._pass(slot, signal, step)
                if signal.block in left:
                    self._tell(Contact.COUNTED_OUT, signal.block, unit_id)
                    self._past.pop((slot, signal.block), None)
            for points_id in [p for p, user in self._routes.items() if user == slot]:
                section_id = self._wayside_section(points_id)
                if section_id in left:
                    del self._routes[points_id]
        for slot, train in self._drivers.driven.items():
            self._past_halt(slot, train, step)
            beyond = self._cautious.get(slot, set())
            slow = bool(beyond) and not beyond.isdisjoint(under.get(self._trains.stock_ids[slot], set()))
            self._drivers.ceilings_mps[slot] = SUBSTITUTE_MPS if slow else self._speed_mps
        self._under = under

    def _past_halt(self, slot: int, train: DrivenTrain, step: int) -> None:
        """A train that sets out from a halt passes the signal there."""
        if train.duty is None or not train.runs or self._trains.plants[slot].speed_mps == 0.0:
            return
        place_id = train.duty.mission.targets[train.at].place_id
        for signal in self._machine.signals.values():
            mine = signal.at == place_id and signal.direction is train.duty.mission.direction
            if mine and self._past.get((slot, signal.block)) != signal.id:
                self._past[slot, signal.block] = signal.id
                self._pass(slot, signal, step)

    def _pass(self, slot: int, signal: LineSignal, step: int) -> None:
        unit_id, aspect = self._trains.stock_ids[slot], self._machine.aspect(self._state, signal.id)
        passed = SignalPassed(unit_id=unit_id, signal_id=signal.id, aspect=aspect.value)
        self._journal.write(step / STEPS_PER_S, WORLD, passed)
        detector = self._machine.detector_at(signal.id)
        if aspect is Aspect.STOP and detector is not None:
            wrong = WrongDeparture(
                unit_id=unit_id, signal_id=signal.id, stops=detector.holds, works=detector.works
            )
            self._journal.write(step / STEPS_PER_S, WORLD, wrong)
        duty = self._trains.duties[slot]
        if aspect is Aspect.SUBSTITUTE and duty is not None:
            self._cautious[slot] = _beyond(duty.mission, signal)
        self._tell(Contact.PASSED, signal.id, unit_id)
        self._sent_off.discard((slot, signal.id))

    def _approaches(self, slot: int, train: DrivenTrain, step: int) -> None:
        """A signal that is automatic is pulled by the train that is next before it, once that is ready to leave."""
        ahead = next(self._signals_ahead(slot, train), None)
        if ahead is not None and ahead[1].automatic and self._is_ready(train, step):
            self._tell(SignalDeed.SET, ahead[1].id)

    def _show(self, step: int) -> None:
        for signal_id in self._machine.signals:
            aspect = self._machine.aspect(self._state, signal_id)
            if self._shown.get(signal_id, Aspect.STOP) is not aspect:
                shows = SignalShows(signal_id=signal_id, aspect=aspect.value)
                self._journal.write(step / STEPS_PER_S, WORLD, shows)
            self._shown[signal_id] = aspect

    # drivers ----------------------------------------------------------------------------------------------------------

    def _see(self, slot: int, train: DrivenTrain, step: int) -> None:
        """A driver sees how far he may run, and points are thrown as far as that."""
        if train.duty is None or not self._trains.truths[slot].active:
            return
        mission = train.duty.mission
        ready = self._is_ready(train, step)
        ends, halt = len(mission.spans), len(mission.targets) - 1
        for index, signal in self._signals_ahead(slot, train):
            sees = self._machine.aspect(self._state, signal.id)
            if sees is Aspect.STOP and (slot, signal.id) not in self._sent_off:
                ends, halt = index, self._last_target(mission, index, signal)
                break
        ends = self._throw_to(slot, mission, ends, step)
        if ready:
            self._drivers.permit(slot, max(halt, train.at), ends, step)

    def _is_ready(self, train: DrivenTrain, step: int) -> bool:
        """Whether the time to leave has come, where a train stands."""
        if train.duty is None:
            return False
        if train.runs:
            return True
        due_s = train.duty.mission.targets[train.at].departure_s
        leaves_s = max(train.goes_s, first_given(due_s, train.goes_s))
        if step / STEPS_PER_S < leaves_s:
            self._agenda.put(step_not_before(leaves_s), AgendaKind.PROCEDURE, "driver")
            return False
        return True

    def _signals_ahead(self, slot: int, train: DrivenTrain) -> Iterator[tuple[int, LineSignal]]:
        """Signals before a train, in order, each with the span that it may not enter while that shows stop."""
        if train.duty is None or not self._trains.truths[slot].active:
            return
        mission = train.duty.mission
        here = mission.spans.index(mission.span_at(float(self._trains.truths[slot].position_m)))
        mine = [s for s in self._machine.signals.values() if s.direction is mission.direction]
        for index in range(here, len(mission.spans)):
            span = mission.spans[index]
            for signal in mine:
                at_halt = signal.block == span.section_id and signal.at not in _section_ids(mission)
                if at_halt and self._past.get((slot, signal.block)) != signal.id:
                    yield index + 1, signal
                if signal.at == span.section_id:
                    yield index + 1, signal

    @staticmethod
    def _last_target(mission: Mission, ends: int, signal: LineSignal) -> int:
        """The last target to which a driver runs who stops at a signal: the one there, or the next one beyond it."""
        places = [target.place_id for target in mission.targets]
        if signal.at in places:
            return places.index(signal.at)
        at = [mission.span_index(target.section_id) for target in mission.targets]
        inside = [i for i, span in enumerate(at) if span < ends]
        there = inside[-1]
        stands_there = mission.targets[there].section_id == signal.at
        return there if stands_there else min(there + 1, len(at) - 1)

    def _throw_to(self, slot: int, mission: Mission, ends: int, step: int) -> int:
        """Throw points that are due on the way to `ends`; the first span whose points do not lie for it, or `ends`."""
        front_m = float(self._trains.truths[slot].position_m)
        here = mission.spans.index(mission.span_at(front_m))
        blocks = [i for i in range(here, ends) if mission.spans[i].kind is SectionKind.BETWEEN]
        for index in range(here + 1, ends):
            span = mission.spans[index]
            arrival = bool(blocks) and index > blocks[0]
            due = not arrival or (
                index < (blocks[1] if len(blocks) > 1 else ends)
                and span.start_m - front_m < HOME_M
                and self._lets_none_out(mission, mission.spans[blocks[0]].section_id)
            )
            for points_id, position, _ in span.points:
                if due and self._routes.setdefault(points_id, slot) == slot:
                    self._throw(points_id, position, step)
                machine = self._wayside.machines[points_id]
                mine = self._routes.get(points_id) == slot
                if not (mine and machine.locked and machine.position is position):
                    return index
        return ends

    def _lets_none_out(self, mission: Mission, block: str) -> bool:
        """Whether no signal lets a train into a section against one that comes."""
        return self._state.directions.get(block) in (None, mission.direction)

    def _throw(self, points_id: str, position: Position, step: int) -> None:
        machine = self._wayside.machines[points_id]
        section_id = self._wayside_section(points_id)
        occupied = any(section_id in sections for sections in self._trains.sections_under().values())
        if machine.position is not position and machine.target is not position and not occupied:
            self._wayside.throw(step, points_id, position)

    def _wayside_section(self, points_id: str) -> str:
        return self._trains.setup.line.points[points_id].section_id


def _section_ids(mission: Mission) -> set[str]:
    return {span.section_id for span in mission.spans}


def _beyond(mission: Mission, signal: LineSignal) -> set[str]:
    """The section right beyond a signal at the end of a track."""
    ids = [span.section_id for span in mission.spans]
    at = ids.index(signal.at) if signal.at in ids else len(ids)
    return set(ids[at + 1 : at + 2])
