"""A device: envelopes around a protocol machine, its durable state, its journal. The same in any process.

`advance(now_s, telegrams, inputs)` first takes the inputs, then the telegrams in order, then looks at its
timers. `now_s` is what the device's clock shows: telegrams are stamped and judged by it, timers run by what passes of
it. What must outlive a power cut is saved before anything that follows from it leaves the device.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

import msgspec

from host.devices import CODEC, DeviceAdvance, DeviceSaid
from host.order_solver import order_solver
from host.party import Advance, PartySpec
from host.store import Durable, PartyStore, raise_epoch
from network.errors import InputError
from radio.elapsed import Elapsed
from radio.envelope import Dropped, DropReason, Endpoint, Peer, Received
from radio.keys import KeyRing
from radio.messages import CrossingOver, CrossingRequest, PointsCommand, Restarted
from wayside import block_manager, level_crossing, point_terminal, said
from wayside.actions import Action, Drive, Send, Show
from wayside.barring import NO_BARS, bars_kept
from wayside.config import CrossingConfig, DeviceConfig, ManagerConfig, TerminalConfig, decode_config
from wayside.crossing_said import CrossingContact, CrossingDetected, NoTrainComes
from wayside.level_crossing import CrossingDevice, CrossingMemory
from wayside.point_terminal import Commanded, Expired, Terminal, TerminalMemory
from wayside.register import Register
from wayside.register import start as start_register

DeviceState = Register | Terminal | CrossingDevice
PARTS_KEPT = True  # off: a manager that starts again has forgotten who has a part of its way


class _ProtocolMachine(Protocol):
    """What the host needs of a protocol machine: the actions for one event, in order."""

    @property
    def state(self) -> DeviceState: ...

    def take(self, event: said.Input | Received | None, now_s: float) -> Sequence[Action]:
        """An input, a telegram, or None: look at the timers."""
        ...

    def wake_at_s(self) -> float | None: ...

    def kept(self, before: Durable) -> Durable:
        """The durable state, given what was saved last."""
        ...


class _ManagerMemory(msgspec.Struct, frozen=True, array_like=True):
    """What a manager keeps: the units on the line, sections not swept, how many moves of its day each unit has made,
    which of them were granted a part of the next one, which of them end on another track, and from where units went on
    as another train.
    """

    ledger: tuple[str, ...] = ()
    unswept: tuple[str, ...] = ()
    moves_done: dict[str, int] = {}
    on_part: tuple[str, ...] = ()
    tracks: dict[str, dict[int, str]] = {}
    cuts: dict[str, dict[int, str]] = {}


class _Manager:
    def __init__(self, config: ManagerConfig, keys: KeyRing, durable: Durable) -> None:
        kept = _remembered(durable.spare)
        ledger, moves_done = (None, None) if kept is None else (kept.ledger, kept.moves_done)
        unswept, on_part, tracks = (
            ((), (), None) if kept is None else (kept.unswept, kept.on_part, kept.tracks)
        )
        bars = bars_kept(durable.vital)
        self.register = start_register(
            config,
            durable.epoch,
            keys.capabilities,
            ledger,
            unswept,
            moves_done,
            tracks,
            bars,
            order_solver(),
            on_part,
            None if kept is None else kept.cuts,
        )

    @property
    def state(self) -> Register:
        return self.register

    def take(self, event: said.Input | Received | None, now_s: float) -> Sequence[Action]:
        step: block_manager.Event
        match event:
            case None:
                step = block_manager.AskUnits()
            case Received():
                step = block_manager.Heard(
                    event.source, event.epoch, event.fresh, event.correlation, event.message
                )
            case said.PointsDetected() | CrossingDetected() | CrossingContact() | NoTrainComes():
                return _not_for_device(event)
            case _:
                step = event
        self.register, actions = block_manager.step(self.register, step, now_s)
        return actions

    def wake_at_s(self) -> float | None:
        return block_manager.wake_at_s(self.register)

    def kept(self, before: Durable) -> Durable:
        trips = sorted(self.register.trips.items())
        kept = _ManagerMemory(
            tuple(sorted(self.register.ledger)),
            tuple(sorted(self.register.unswept)),
            {unit_id: trip.done for unit_id, trip in trips},
            tuple(unit_id for unit_id, trip in trips if trip.part and PARTS_KEPT),
            {unit_id: dict(ends) for unit_id, ends in sorted(self.register.tracks.items())},
            {unit_id: dict(trains) for unit_id, trains in sorted(self.register.cuts.items())},
        )
        bars = self.register.bars
        vital = b"" if bars == NO_BARS else msgspec.msgpack.encode(bars)
        return msgspec.structs.replace(before, vital=vital, spare=msgspec.msgpack.encode(kept))


class _Terminal:
    def __init__(self, config: TerminalConfig, keys: KeyRing, durable: Durable) -> None:
        self.terminal = point_terminal.start(
            config, keys.capabilities[config.device_id], _memory(durable.vital)
        )

    @property
    def state(self) -> Terminal:
        return self.terminal

    def take(self, event: said.Input | Received | None, now_s: float) -> Sequence[Action]:
        step: point_terminal.TerminalEvent
        match event:
            case None:
                step = Expired()
            case Received(message=PointsCommand() as command):
                step = Commanded(event.source, event.correlation, command)
            case Received():
                why = type(event.message).__name__
                return (Show(said.Refused(unit_id=event.source, why=why)),)
            case said.PointsDetected() | said.BarUnit() | said.UnbarUnit():
                step = event
            case _:
                return _not_for_device(event)
        self.terminal, actions = point_terminal.step(self.terminal, step, now_s)
        return actions

    def wake_at_s(self) -> float | None:
        return point_terminal.wake_at_s(self.terminal)

    def kept(self, before: Durable) -> Durable:
        return msgspec.structs.replace(before, vital=msgspec.msgpack.encode(self.terminal.memory))


class _LevelCrossing:
    def __init__(self, config: CrossingConfig, durable: Durable) -> None:
        kept, lost = durable.vital, not durable.vital and durable.epoch > 1
        try:
            memory = msgspec.msgpack.decode(kept, type=CrossingMemory) if kept else CrossingMemory()
        except msgspec.MsgspecError:
            memory, lost = CrossingMemory(), True
        self.device = level_crossing.start(config, memory, lost=lost, again=durable.epoch > 1)

    @property
    def state(self) -> CrossingDevice:
        return self.device

    def take(self, event: said.Input | Received | None, now_s: float) -> Sequence[Action]:
        step: level_crossing.CrossingEvent
        match event:
            case None:
                step = level_crossing.CrossingTimeDue()
            case Received(message=CrossingRequest() as request):
                step = level_crossing.ClosureAsked(event.source, event.correlation, request)
            case Received(message=CrossingOver() as over):
                step = level_crossing.CrossingLeft(event.source, event.correlation, over)
            case Received():
                return (Show(said.Refused(unit_id=event.source, why=type(event.message).__name__)),)
            case CrossingDetected() | CrossingContact() | NoTrainComes() | said.BarUnit() | said.UnbarUnit():
                step = event
            case _:
                return _not_for_device(event)
        self.device, actions = level_crossing.step(self.device, step, now_s)
        return actions

    def wake_at_s(self) -> float | None:
        return level_crossing.wake_at_s(self.device)

    def kept(self, before: Durable) -> Durable:
        return msgspec.structs.replace(before, vital=msgspec.msgpack.encode(self.device.memory))


def _memory(kept: bytes) -> TerminalMemory:
    """What a terminal must not have forgotten; one that never ran has nothing to remember."""
    try:
        return msgspec.msgpack.decode(kept, type=TerminalMemory) if kept else TerminalMemory()
    except msgspec.MsgspecError as error:
        raise InputError(
            "durable", "memory", f"{len(kept)} bytes", f"a terminal's memory ({error})"
        ) from None


def _remembered(kept: bytes | None) -> _ManagerMemory | None:
    """What the manager had before; nothing of one that never ran. None: lost."""
    if not kept:
        return None if kept is None else _ManagerMemory()
    try:
        return msgspec.msgpack.decode(kept, type=_ManagerMemory)
    except msgspec.MsgspecError:
        return None


def _not_for_device(given: said.Input) -> Sequence[Action]:
    return (Show(said.InputRefused(why=type(given).__name__)),)


class DeviceHost:
    """One running device. Making it is a boot: the epoch is raised and saved first."""

    def __init__(self, config: DeviceConfig, keys: KeyRing, store: PartyStore) -> None:
        if keys.owner != config.device_id:
            raise InputError("keys", "owner", keys.owner, f"the keys of {config.device_id}")
        self._store = store
        self._durable = raise_epoch(store)
        self._endpoint = Endpoint(keys, self._durable.epoch, config.telegram_age_max_s)
        self._machine: _ProtocolMachine
        if isinstance(config, ManagerConfig):
            self._machine = _Manager(config, keys, self._durable)
        elif isinstance(config, CrossingConfig):
            self._machine = _LevelCrossing(config, self._durable)
        else:
            self._machine = _Terminal(config, keys, self._durable)
        self._elapsed = Elapsed()
        self._notes: list[said.Note] = [said.Started(epoch=self._durable.epoch)]

    @property
    def epoch(self) -> int:
        """Number of this boot, from 1."""
        return self._durable.epoch

    @property
    def state(self) -> DeviceState:
        """The state of its protocol machine."""
        return self._machine.state

    def advance(
        self, now_s: float, telegrams: Sequence[bytes], inputs: Sequence[said.Input] = ()
    ) -> DeviceAdvance:
        """Act at `now_s` on inputs, telegrams and timers."""
        sends: list[tuple[Send, int]] = []
        outputs: list[said.Output] = []
        elapsed_s = self._elapsed.at(now_s)
        for given in inputs:
            self._sort(self._machine.take(given, elapsed_s), sends, outputs)
        for data in telegrams:
            opened = self._endpoint.open(data, now_s)
            if isinstance(opened, Dropped):
                self._note_drop(opened, sends)
                continue
            self._notes.append(opened.noted(self._endpoint.owner))
            if not isinstance(opened.message, Restarted):
                self._sort(self._machine.take(opened, elapsed_s), sends, outputs)
        self._sort(self._machine.take(None, elapsed_s), sends, outputs)
        if (durable := self._machine.kept(self._durable)) != self._durable:
            self._durable = durable
            self._store.save(durable)
        sealed = tuple(
            (send.destination, self._endpoint.seal(send.destination, send.message, now_s, send.correlation))
            for send, epoch in sends
            if epoch == self._epoch_of(send.destination)  # an answer to one boot is none to the next
        )
        notes, self._notes = tuple(self._notes), []
        wake_s = self._machine.wake_at_s()
        wake_at_s = None if wake_s is None else self._elapsed.shown_at(wake_s)
        return DeviceAdvance(sealed, tuple(outputs), wake_at_s, notes)

    def _sort(
        self, actions: Iterable[Action], sends: list[tuple[Send, int]], outputs: list[said.Output]
    ) -> None:
        for action in actions:
            match action:
                case Send():
                    sends.append((action, self._epoch_of(action.destination)))
                case Show(note):
                    self._notes.append(note)
                case Drive(output):
                    outputs.append(output)

    def _note_drop(self, dropped: Dropped, sends: list[tuple[Send, int]]) -> None:
        self._notes.append(dropped.noted(self._endpoint.owner))
        # Its sender still speaks to the boot before this one: tell it, so that its next telegram counts.
        if dropped.reason is DropReason.EARLIER_BOOT and dropped.envelope is not None:
            source = dropped.envelope.source
            sends.append((Send(source, Restarted()), self._epoch_of(source)))

    def _epoch_of(self, peer_id: str) -> int:
        """Which boot of a party was heard last; 0: none."""
        return self._endpoint.peers.get(peer_id, Peer()).heard_epoch


class DeviceParty:
    """A device as a party of a run: `host.party.Party` over a `DeviceHost`."""

    def __init__(self, spec: PartySpec, store: PartyStore, file: str) -> None:
        config = decode_config(spec.config, file)
        role = config.__struct_config__.tag
        if (role, config.line_id, config.device_id) != (spec.role.value, spec.line_id, spec.party_id):
            given = f"{spec.role.value} {spec.party_id} of line {spec.line_id}"
            expected = f"{role} {config.device_id} of line {config.line_id}, as it was configured"
            raise InputError(file, "device", given, expected)
        self._host = DeviceHost(config, spec.keys, store)

    @property
    def epoch(self) -> int:
        """Number of this boot, from 1."""
        return self._host.epoch

    @property
    def state(self) -> DeviceState:
        """The state of its protocol machine."""
        return self._host.state

    def advance(self, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Act at `now_s` on inputs, telegrams and timers."""
        done = self._host.advance(now_s, telegrams, CODEC.decode_told(told).inputs)
        return Advance(done.telegrams, CODEC.encode(DeviceSaid(done.outputs, done.notes)), done.wake_at_s)
