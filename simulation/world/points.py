"""The wayside as the world sees it: devices behind the fleet, the air, and the point machines on the track."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable
from typing import Final

import msgspec

from host.devices import Advance, Fleet
from network.model import Line, Position
from radio.air import Air, Delivery
from radio.envelope import Envelope
from radio.keys import MAC_BYTES
from radio.messages import AnyMessage
from simulation.agenda import Agenda, Due
from simulation.journal import Journal
from simulation.setup import STEP_S, STEPS_PER_S
from simulation.vocabulary import device_word
from simulation.world import point_machine
from simulation.world.point_machine import PointMachine, Repaired
from wayside.config import MANAGER_ID
from wayside.said import Input, Note, NoteKind, Output

Disturb = Callable[[int, str, str, tuple[Delivery, ...]], tuple[Delivery, ...]]
_HEADER: Final = msgspec.msgpack.Decoder(Envelope)
_PAYLOAD: Final = msgspec.msgpack.Decoder(AnyMessage)


def kind_of(data: bytes) -> str:
    """Kind of the message in a telegram, for the journal; '?' if unreadable. Nobody acts on this."""
    try:
        return type(_PAYLOAD.decode(_HEADER.decode(data[:-MAC_BYTES]).payload)).__name__
    except (msgspec.MsgspecError, UnicodeDecodeError):
        return "?"


def header_of(data: bytes) -> Envelope | None:
    """Header of a telegram, for the journal; None if it is unreadable. Nobody acts on this."""
    try:
        return _HEADER.decode(data[:-MAC_BYTES])
    except (msgspec.MsgspecError, UnicodeDecodeError):
        return None


class WaysideWorld:
    """Routes telegrams through the air, advances devices when they have something due, moves the points."""

    def __init__(
        self,
        line: Line,
        fleet: Fleet,
        air: Air,
        agenda: Agenda,
        journal: Journal,
        covered: Callable[[str], bool],
        registered: tuple[str, ...],
    ) -> None:
        self.machines: dict[str, PointMachine] = {
            points.id: point_machine.machine_of(points) for points in line.points.values()
        }
        self.telegrams: dict[tuple[str, str, str], Counter[str]] = defaultdict(Counter)
        self.section_ids: Final = tuple(line.sections)
        self._terminal_of: Final = {points.id: points.terminal_id for points in line.points.values()}
        self._device_ids: Final = (MANAGER_ID, *sorted({p.terminal_id for p in line.points.values()}))
        self._fleet = fleet
        self._air = air
        self._agenda = agenda
        self._journal = journal
        self._covered = covered
        self._registered = registered
        self._inputs: dict[str, list[Input]] = defaultdict(list)
        self._wakes: dict[str, int] = {}
        self._down: set[str] = set()
        self._frozen: dict[str, list[bytes]] = {}
        self.disturb: Disturb = lambda _step, _source, _destination, deliveries: deliveries

    def start(self, step: int) -> None:
        """Power on: every terminal sees its points."""
        for machine in self.machines.values():
            self.input(step, self._terminal_of[machine.points_id], point_machine.detection(machine))
        self._agenda.put(step, Due.TO_DEVICE, MANAGER_ID)

    def input(self, step: int, device_id: str, value: Input) -> None:
        """Something a device senses, or an operator enters, at `step`."""
        self._inputs[device_id].append(value)
        self._agenda.put(step, Due.TO_DEVICE, device_id)

    def transmit(self, step: int, source: str, destination: str, data: bytes, kind: str) -> None:
        """Send a telegram through the air."""
        unit_id = destination if source in self._device_ids else source
        deliveries = self._air.transmit(step, source, destination, data, self._covered(unit_id))
        deliveries = self.disturb(step, source, destination, deliveries)
        count = self.telegrams[source, destination, kind]
        count["sent"] += 1
        count["bytes"] += len(data)
        count["delivered"] += len(deliveries)
        count["lost"] += 0 if deliveries else 1
        self._journal.write(
            step / STEPS_PER_S,
            source,
            "sent",
            to=destination,
            kind=kind,
            bytes=len(data),
            arrives=[round(delivery.step / STEPS_PER_S, 1) for delivery in deliveries],
        )
        due = Due.TO_DEVICE if destination in self._device_ids else Due.TO_UNIT
        for delivery in deliveries:
            self._agenda.put(delivery.step, due, destination, delivery.data)

    def advance(self, step: int, device_id: str, telegrams: list[bytes]) -> None:
        """Let a device act on what has come. A dead one loses it, a frozen one finds it later."""
        if device_id in self._down:
            if telegrams:
                self._journal.write(step / STEPS_PER_S, "world", "lost_at_dead_device", device=device_id)
            self._inputs.pop(device_id, None)
            return
        if device_id in self._frozen:
            self._frozen[device_id].extend(telegrams)
            return
        inputs = self._inputs.pop(device_id, [])
        done = self._fleet.advance(device_id, step / STEPS_PER_S, telegrams, inputs)
        for data in telegrams:
            header = header_of(data)
            self._journal.write(
                step / STEPS_PER_S,
                device_id,
                "heard",
                source="?" if header is None else header.source,
                kind=kind_of(data),
                sequence=None if header is None else header.sequence,
            )
        self._take(step, device_id, done)

    def points_due(self, step: int, points_id: str) -> None:
        """A point machine's motor may have reached its end."""
        self._moved(step, point_machine.advance(self.machines[points_id], step / STEPS_PER_S))

    def force(self, step: int, points_id: str) -> None:
        """A train has run through points set against it."""
        forced = point_machine.step(self.machines[points_id], point_machine.Forced(), step / STEPS_PER_S)
        self._journal.write(step / STEPS_PER_S, "world", "points_forced", points=points_id)
        self._moved(step, forced)

    def position_of(self, points_id: str) -> Position | None:
        """Where the blades really are."""
        return self.machines[points_id].position

    def _take(self, step: int, device_id: str, done: Advance) -> None:
        for note in done.notes:
            self._note(step, device_id, note)
        for output in done.outputs:
            self._output(step, output)
        for destination, data in done.telegrams:
            self.transmit(step, device_id, destination, data, kind_of(data))
        if done.wake_at_s is not None:
            wake_step = max(math.ceil(done.wake_at_s / STEP_S - 1e-6), step + 1)
            if self._wakes.get(device_id) != wake_step:
                self._wakes[device_id] = wake_step
                self._agenda.put(wake_step, Due.TO_DEVICE, device_id)

    def _note(self, step: int, device_id: str, note: Note) -> None:
        what = device_word(note.kind)
        data: dict[str, object] = {}
        if note.unit_id:
            data["unit"] = note.unit_id
        if note.section_ids:
            data["sections"] = list(note.section_ids)
        if note.token:
            data["token"] = note.token
        if note.other_id:
            data["other"] = note.other_id
        if note.detail:
            data["route" if note.kind is NoteKind.GRANTED else "detail"] = note.detail
        if note.kind is NoteKind.STARTED:
            data["epoch"] = note.token
            data["registered"] = list(self._registered)
        self._journal.write(step / STEPS_PER_S, device_id, what, **data)

    def _output(self, step: int, output: Output) -> None:
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
            self._journal.write(step / STEPS_PER_S, "world", "points_unlocked", points=points)
        if machine.target is not None and machine.target is not before.target:
            self._journal.write(
                step / STEPS_PER_S, "world", "points_moving", points=points, target=machine.target.value
            )
        settled = not before.locked or machine.position is not before.position
        if machine.locked and settled and machine.position is not None:
            self._journal.write(
                step / STEPS_PER_S, "world", "points_locked", points=points, position=machine.position.value
            )
        if machine.done_at_s is not None and machine.done_at_s != before.done_at_s:
            done_step = math.ceil(machine.done_at_s / STEP_S - 1e-6)
            self._agenda.put(done_step, Due.POINTS, points)
        shown = point_machine.detection(machine)
        if shown != point_machine.detection(before):
            self.input(step, self._terminal_of[points], shown)

    def set_machine(self, step: int, machine: PointMachine) -> None:
        """Change a machine: a fault comes or goes. A motor that was held on its way may arrive now."""
        self._moved(step, machine)
        if machine.done_at_s is not None:
            self._agenda.put(
                max(math.ceil(machine.done_at_s / STEP_S - 1e-6), step), Due.POINTS, machine.points_id
            )

    def repair(self, step: int, points_id: str, position: Position) -> None:
        """Staff set the points by hand, lock them and take their faults away (手回し)."""
        repaired = point_machine.step(self.machines[points_id], Repaired(position), step / STEPS_PER_S)
        self._journal.write(
            step / STEPS_PER_S, "staff", "points_set_by_hand", points=points_id, position=position.value
        )
        self._moved(step, repaired)

    def power_off(self, step: int, device_id: str) -> None:
        """A device loses its power; with Zenoh its process is killed."""
        if device_id in self._down:
            return
        self._fleet.kill(device_id)
        self._down.add(device_id)
        if device_id in self._frozen:
            self._frozen[device_id].clear()
            self._inputs.pop(device_id, None)
        self._journal.write(step / STEPS_PER_S, "world", "power_off", device=device_id)

    def power_on(self, step: int, device_id: str) -> None:
        """A device boots: a new epoch; terminals are shown their points."""
        if device_id not in self._down:
            return
        self._fleet.restart(device_id)
        self._down.discard(device_id)
        self._journal.write(step / STEPS_PER_S, "world", "power_on", device=device_id)
        for points_id, terminal_id in self._terminal_of.items():
            if terminal_id == device_id:
                self.input(step, device_id, point_machine.detection(self.machines[points_id]))
        self._agenda.put(step, Due.TO_DEVICE, device_id)

    def freeze(self, step: int, device_id: str, *, frozen: bool) -> None:
        """A device stops working without losing anything, or goes on with what has piled up."""
        if frozen:
            self._frozen.setdefault(device_id, [])
            return
        for data in self._frozen.pop(device_id, []):
            self._agenda.put(step, Due.TO_DEVICE, device_id, data)
        self._agenda.put(step, Due.TO_DEVICE, device_id)
