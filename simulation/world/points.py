"""The wayside as the world sees it: devices among the parties, the air, and the point machines on the track."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable
from typing import Final

from host.devices import DeviceAdvance, Devices
from host.parties import Parties
from host.store import NotCommissioned
from network.model import Line, Position
from radio.envelope import header_of, noted_terms
from radio.messages import RouteRequest
from radio.noted import Lost, LostWhere, Sent
from simulation import events
from simulation.agenda import Agenda, AgendaKind
from simulation.carriers.road import Road
from simulation.clock import RIGHT, Clock
from simulation.journal import Journal
from simulation.setup import STEPS_PER_S, step_not_before
from simulation.world import point_machine
from simulation.world.cable import Cable
from simulation.world.crossings import CrossingsOnTrack
from simulation.world.point_machine import KeyBack, LockedByHand, PointMachine, Repaired
from simulation.world.radio import Radio
from wayside.config import MANAGER_ID
from wayside.crossing_said import CloseCrossing, OpenCrossing
from wayside.said import Input, Output, StartThrow


class WaysideWorld:
    """Routes telegrams through the air, advances devices when they have something due, moves the points."""

    def __init__(
        self,
        line: Line,
        parties: Parties,
        radio: Radio,
        agenda: Agenda,
        journal: Journal,
        cable: Cable,
        place_m: Callable[[str], float],
        road: Road | None = None,
    ) -> None:
        self.machines: dict[str, PointMachine] = {
            points.id: point_machine.machine_of(points) for points in line.points.values()
        }
        self.telegrams: dict[tuple[str, str, str], Counter[str]] = defaultdict(Counter)
        self.section_ids: Final = tuple(line.sections)
        self.points_of: Final = _points_by_terminal(line)
        self._terminal_of: Final = {points.id: points.terminal_id for points in line.points.values()}
        self.device_ids: Final = (MANAGER_ID, *sorted({p.terminal_id for p in line.points.values()}))
        self.crossings: Final = CrossingsOnTrack(line, agenda, journal, self.input, road)
        self.party_ids: Final = (*self.device_ids, *self.crossings.equipment)
        self._parties = parties
        self._devices = Devices(parties)
        self._radio: Final = radio
        self._agenda = agenda
        self._journal = journal
        self.cable: Final = cable
        self._place_m = place_m
        self._inputs: dict[str, list[Input]] = defaultdict(list)
        self._wakes: dict[str, int] = {}
        self.down: Final[set[str]] = set()  # devices without power
        # of these, those that have power and lost their durable state
        self.uncommissioned: Final[set[str]] = set()
        self._frozen: dict[str, list[bytes]] = {}
        self._clocks: dict[str, Clock] = {}

    def start(self, step: int) -> None:
        """Power on: every terminal sees its points."""
        for machine in self.machines.values():
            self.input(step, self._terminal_of[machine.points_id], point_machine.detection(machine))
        self.crossings.start(step)
        self._agenda.put(step, AgendaKind.TO_DEVICE, MANAGER_ID)

    def input(self, step: int, device_id: str, value: Input) -> None:
        """Something a device senses, or an operator enters, at `step`."""
        self._inputs[device_id].append(value)
        self._agenda.put(step, AgendaKind.TO_DEVICE, device_id)

    def input_all(self, step: int, value: Input) -> None:
        """Something an operator enters at every device."""
        for device_id in self.party_ids:
            self.input(step, device_id, value)

    def transmit(self, step: int, source: str, destination: str, data: bytes) -> None:
        """Send a telegram through the air."""
        unit_id, device_id = (destination, source) if source in self.party_ids else (source, destination)
        deliveries, covered = self._radio.transmit(step, source, destination, data, unit_id)
        terms = noted_terms(header_of(data))
        local = not self.cable.severed or device_id in self.crossings.equipment
        whole = local or self.cable.carries(self._place_m(unit_id), device_id)
        if not whole:
            asks_route = terms["kind"] == RouteRequest.__name__
            whole = self.cable.worked_locally(step / STEPS_PER_S, unit_id, asks_route=asks_route)
        deliveries = deliveries if whole else ()
        count = self.telegrams[source, destination, terms["kind"] or "?"]
        count["sent"] += 1
        count["bytes"] += len(data)
        count["delivered"] += len(deliveries)
        count["lost"] += 0 if deliveries else 1
        sent = Sent(
            source=source,
            receiver=destination,
            size_bytes=len(data),
            arrives_s=tuple([delivery.step / STEPS_PER_S for delivery in deliveries]),
            **terms,
        )
        self._journal.write(step / STEPS_PER_S, source, sent)
        if not deliveries:
            of_air = LostWhere.AIR if covered else LostWhere.NO_COVERAGE
            self.lost(step, destination, data, of_air if whole or not covered else LostWhere.CABLE)
        due = AgendaKind.TO_DEVICE if destination in self.party_ids else AgendaKind.TO_UNIT
        for delivery in deliveries:
            self._agenda.put(delivery.step, due, destination, delivery.data)

    def lost(self, step: int, receiver: str, data: bytes, where: LostWhere) -> None:
        """Write down that a telegram does not reach its receiver."""
        header = header_of(data)
        lost = Lost(
            source=None if header is None else header.source,
            receiver=receiver,
            where=where,
            **noted_terms(header),
        )
        self._journal.write(step / STEPS_PER_S, events.WORLD, lost)

    def advance(self, step: int, device_id: str, telegrams: list[bytes]) -> None:
        """Let a device act on what has come. A dead one loses it, a frozen one finds it later."""
        if device_id in self.down:
            for data in telegrams:
                self.lost(step, device_id, data, LostWhere.RECEIVER_OFF)
            self._inputs.pop(device_id, None)
            return
        if device_id in self._frozen:
            self._frozen[device_id].extend(telegrams)
            return
        inputs = self._inputs.pop(device_id, [])
        own_s = self._clocks.get(device_id, RIGHT).shows(step / STEPS_PER_S)
        self._take(step, device_id, self._devices.advance(device_id, own_s, telegrams, inputs))

    def points_due(self, step: int, points_id: str) -> None:
        """A point machine's motor, or the barriers of a crossing, may have reached their end."""
        if points_id in self.crossings.equipment:
            self.crossings.barriers_due(step, points_id)
            return
        self._moved(step, point_machine.advance(self.machines[points_id], step / STEPS_PER_S))

    def force(self, step: int, points_id: str) -> None:
        """A train has run through points set against it."""
        forced = point_machine.step(self.machines[points_id], point_machine.Forced(), step / STEPS_PER_S)
        self._journal.write(step / STEPS_PER_S, events.WORLD, events.PointsForced(points_id=points_id))
        self._moved(step, forced)

    def position_of(self, points_id: str) -> Position | None:
        """Where the blades really are."""
        return self.machines[points_id].position

    def _take(self, step: int, device_id: str, done: DeviceAdvance) -> None:
        for note in done.notes:
            self._journal.write(step / STEPS_PER_S, device_id, note)
        for output in done.outputs:
            self._output(step, output)
        for destination, data in done.telegrams:
            self.transmit(step, device_id, destination, data)
        wake_step, was_step = None, self._wakes.get(device_id, step)
        if done.wake_at_s is not None:
            wake_at_s = self._clocks.get(device_id, RIGHT).true_s(done.wake_at_s)
            wake_step = max(step_not_before(wake_at_s), step + 1)
        if was_step == wake_step:
            return
        if device_id in self.crossings.equipment and was_step > step:
            self._agenda.withdraw(AgendaKind.TO_DEVICE, device_id, step)
            del self._wakes[device_id]
        if wake_step is not None:
            self._wakes[device_id] = wake_step
            self._agenda.put(wake_step, AgendaKind.TO_DEVICE, device_id)

    def _output(self, step: int, output: Output) -> None:
        if isinstance(output, CloseCrossing | OpenCrossing):
            self.crossings.take(step, output.crossing_id, output)
            return
        machine = self.machines[output.points_id]
        self._moved(step, point_machine.step(machine, output, step / STEPS_PER_S))

    def _moved(self, step: int, machine: PointMachine) -> None:
        """Write down what changed on the track, show it to the terminal, and remember when the motor is done."""
        before = self.machines[machine.points_id]
        if machine == before:
            return
        self.machines[machine.points_id] = machine
        points = machine.points_id
        if before.locked and not machine.locked:
            self._journal.write(step / STEPS_PER_S, events.WORLD, events.PointsUnlocked(points_id=points))
        if machine.key and machine.key != before.key:
            taken = events.PointsLockedByHand(points_id=points, unit_id=machine.key)
            self._journal.write(step / STEPS_PER_S, events.WORLD, taken)
        if before.key and not machine.key:
            back = events.PointsKeyBack(points_id=points, unit_id=before.key)
            self._journal.write(step / STEPS_PER_S, events.WORLD, back)
        if machine.target is not None and machine.target is not before.target:
            moving = events.PointsMoving(points_id=points, target=machine.target)
            self._journal.write(step / STEPS_PER_S, events.WORLD, moving)
        settled = not before.locked or machine.position is not before.position
        if machine.locked and settled and machine.position is not None:
            locked = events.PointsLocked(points_id=points, position=machine.position)
            self._journal.write(step / STEPS_PER_S, events.WORLD, locked)
        if machine.done_at_s is not None and machine.done_at_s != before.done_at_s:
            self._agenda.put(step_not_before(machine.done_at_s), AgendaKind.POINTS, points)
        shown = point_machine.detection(machine)
        if shown != point_machine.detection(before):
            self.input(step, self._terminal_of[points], shown)

    def set_machine(self, step: int, machine: PointMachine) -> None:
        """Change a machine: a fault comes or goes. A motor that was held on its way may arrive now."""
        self._moved(step, machine)
        if machine.done_at_s is not None:
            self._agenda.put(
                max(step_not_before(machine.done_at_s), step), AgendaKind.POINTS, machine.points_id
            )

    def lock_by_hand(self, step: int, points_id: str, unit_id: str) -> None:
        """The crew of a train locks points on the spot and takes the key; the terminal sees it."""
        locked = point_machine.step(self.machines[points_id], LockedByHand(unit_id), step / STEPS_PER_S)
        self._moved(step, locked)

    def give_key_back(self, step: int, points_id: str, unit_id: str) -> None:
        """The crew gives the key of points back."""
        back = point_machine.step(self.machines[points_id], KeyBack(unit_id), step / STEPS_PER_S)
        self._moved(step, back)

    def throw(self, step: int, points_id: str, position: Position) -> None:
        """The interlocking of line signals throws the points, past their terminal."""
        self._output(step, StartThrow(points_id, position))

    def repair(self, step: int, points_id: str, position: Position) -> None:
        """Staff set the points by hand, lock them and take their faults away (手回し)."""
        repaired = point_machine.step(self.machines[points_id], Repaired(position), step / STEPS_PER_S)
        by_hand = events.PointsSetByHand(points_id=points_id, position=position)
        self._journal.write(step / STEPS_PER_S, "staff", by_hand)
        self._moved(step, repaired)

    def power_off(self, step: int, device_id: str) -> None:
        """A device loses its power; with Zenoh its process is killed."""
        if device_id in self.down:
            self.uncommissioned.discard(device_id)
            return
        self._parties.kill(device_id)
        self.down.add(device_id)
        if device_id in self._frozen:
            self._frozen[device_id].clear()
            self._inputs.pop(device_id, None)
        self._journal.write(step / STEPS_PER_S, events.WORLD, events.PowerOff(device_id=device_id))
        self.crossings.relays_fall(step, device_id)

    def power_on(self, step: int, device_id: str) -> None:
        """A device boots: a new epoch; terminals are shown their points. It stays down if it lost its durable state."""
        if device_id not in self.down:
            return
        try:
            self._parties.restart(device_id)
        except NotCommissioned:
            self.uncommissioned.add(device_id)
            self._journal.write(step / STEPS_PER_S, events.WORLD, events.Uncommissioned(device_id=device_id))
            return
        self.down.discard(device_id)
        self._journal.write(step / STEPS_PER_S, events.WORLD, events.PowerOn(device_id=device_id))
        for points_id, terminal_id in self._terminal_of.items():
            if terminal_id == device_id:
                self.input(step, device_id, point_machine.detection(self.machines[points_id]))
        self.crossings.show(step, device_id)
        self._agenda.put(step, AgendaKind.TO_DEVICE, device_id)

    def lose_store(self, device_id: str) -> None:
        """The durable state of a device that is down is gone."""
        self._parties.lose(device_id)

    def commission(self, step: int, device_id: str, number: int, vital: bytes) -> None:
        """People put a device into service again that waits for it: it boots."""
        self.uncommissioned.discard(device_id)
        self._parties.commission(device_id, number, vital)
        commissioned = events.Commissioned(device_id=device_id, number=number)
        self._journal.write(step / STEPS_PER_S, events.WORLD, commissioned)
        self.power_on(step, device_id)

    def set_clock(self, step: int, device_id: str, clock: Clock) -> None:
        """The clock of a device shows another time from now on; its timers may have run out by it."""
        self._clocks[device_id] = clock
        self._agenda.put(step, AgendaKind.TO_DEVICE, device_id)

    def freeze(self, step: int, device_id: str, *, frozen: bool) -> None:
        """A device stops working without losing anything, or goes on with what has piled up and is shown now."""
        if frozen:
            self._frozen.setdefault(device_id, [])
            self.crossings.relays_fall(step, device_id)
            return
        self.crossings.show(step, device_id)
        for data in self._frozen.pop(device_id, []):
            self._agenda.put(step, AgendaKind.TO_DEVICE, device_id, data)
        self._agenda.put(step, AgendaKind.TO_DEVICE, device_id)


def _points_by_terminal(line: Line) -> dict[str, dict[str, str]]:
    """By terminal: the section of each of its points."""
    found: dict[str, dict[str, str]] = defaultdict(dict)
    for points in line.points.values():
        found[points.terminal_id][points.id] = points.section_id
    return dict(found)
