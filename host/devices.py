"""The wayside devices among the parties of a run: what they are told and say, and what starts them.

Points stand in the simulated world; a terminal drives them by outputs and sees them by inputs, as a real one
does by relays (転てつ機制御出力・表示入力, table 4 of Sugiyama et al. 2017).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import msgspec

from host.parties import Parties
from host.party import Codec, PartySpec, Role
from radio.keys import key_ring
from wayside.config import CrossingConfig, ManagerConfig, OrderRule, TerminalConfig, encode_config
from wayside.said import Input, Note, Output


class DeviceTold(msgspec.Struct, frozen=True, array_like=True):
    """What a device is told besides telegrams."""

    inputs: tuple[Input, ...] = ()


class DeviceSaid(msgspec.Struct, frozen=True, array_like=True):
    """What a device says besides telegrams."""

    outputs: tuple[Output, ...] = ()
    notes: tuple[Note, ...] = ()


CODEC: Final = Codec(DeviceTold, DeviceSaid)


class DeviceAdvance(msgspec.Struct, frozen=True):
    """What a device did when advanced: telegrams as (destination, bytes), relay outputs, when to be asked
    next.
    """

    telegrams: tuple[tuple[str, bytes], ...]
    outputs: tuple[Output, ...]
    wake_at_s: float | None
    notes: tuple[Note, ...]


class Devices:
    """The door to the devices among `parties`: their records instead of bytes."""

    def __init__(self, parties: Parties) -> None:
        self._parties = parties

    def advance(
        self, device_id: str, now_s: float, telegrams: Sequence[bytes], inputs: Sequence[Input] = ()
    ) -> DeviceAdvance:
        """Let a device act at `now_s`. PartyError if it is down."""
        told = CODEC.encode(DeviceTold(tuple(inputs)))
        done = self._parties.advance(device_id, now_s, telegrams, told)
        said = CODEC.decode_said(done.said)
        return DeviceAdvance(done.telegrams, said.outputs, done.wake_at_s, said.notes)


def device_specs(
    manager: ManagerConfig,
    terminals: Sequence[TerminalConfig],
    master_key: bytes,
    crossings: Sequence[CrossingConfig] = (),
) -> tuple[PartySpec, ...]:
    """What is needed to start all devices: each with the keys of its own pairs only."""
    ids = [terminal.device_id for terminal in terminals]
    ring = key_ring(master_key, manager.device_id, manager.unit_ids, ids)
    own = encode_config(manager)
    solves = manager.dispatch.order is OrderRule.OPTIMAL
    specs = [PartySpec(manager.line_id, manager.device_id, Role.BLOCK_MANAGER, own, ring, solves)]
    for terminal in terminals:
        ring = key_ring(master_key, terminal.device_id, manager.unit_ids, [terminal.device_id])
        own = encode_config(terminal)
        specs.append(PartySpec(terminal.line_id, terminal.device_id, Role.POINT_TERMINAL, own, ring))
    for crossing in crossings:
        ring = key_ring(master_key, crossing.device_id, manager.unit_ids)
        own = encode_config(crossing)
        specs.append(PartySpec(crossing.line_id, crossing.device_id, Role.LEVEL_CROSSING, own, ring))
    return tuple(specs)
