"""The wayside devices as the simulator sees them: advance one to a time, with telegrams and inputs, take
what it says.

Two implementations give the same bytes: `host.local.LocalFleet` in this process, and
`host.over_zenoh.ZenohFleet` with a process per device over Zenoh. Points stand in the simulated world; a
terminal drives them by outputs and sees them by inputs, as a real one does by relays
(転てつ機制御出力・表示入力, table 4 of Sugiyama et al. 2017).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from types import TracebackType
from typing import Protocol, Self

import msgspec

from radio.keys import KeyRing, key_ring
from wayside.config import ManagerConfig, TerminalConfig, encode_config
from wayside.said import Input, Note, Output


class Role(Enum):
    """What a device is; the value is the subcommand of `python -m host.serve`."""

    BLOCK_MANAGER = "block-manager"
    POINT_TERMINAL = "point-terminal"


class Advance(msgspec.Struct, frozen=True):
    """What a device did when advanced: telegrams as (destination, bytes), relay outputs, when to be asked
    next.
    """

    telegrams: tuple[tuple[str, bytes], ...]
    outputs: tuple[Output, ...]
    wake_at_s: float | None
    notes: tuple[Note, ...]


class DeviceSpec(msgspec.Struct, frozen=True):
    """What a fleet needs to start a device; `config_json` is a `wayside.config` record."""

    device_id: str
    role: Role
    config_json: bytes
    keys: KeyRing


class FleetError(RuntimeError):
    """A device is down, or did not answer: the run cannot go on."""


class Fleet(Protocol):
    """The devices of one run. Leaving the context ends them all, whatever happened."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def advance(
        self, device_id: str, now_s: float, telegrams: Sequence[bytes], inputs: Sequence[Input] = ()
    ) -> Advance:
        """Let a device act at `now_s`. FleetError if it is down; ask `alive` first."""
        ...

    def alive(self, device_id: str) -> bool:
        """Whether the device runs."""
        ...

    def kill(self, device_id: str) -> None:
        """Power cut: everything but the durable state is gone. Nothing happens if it is down."""
        ...

    def restart(self, device_id: str) -> None:
        """Power back: a new boot epoch. The simulator then sends the inputs (detections) anew."""
        ...


def device_specs(
    manager: ManagerConfig, terminals: Sequence[TerminalConfig], master_key: bytes
) -> tuple[DeviceSpec, ...]:
    """What a fleet needs to start all devices: each with the keys of its own pairs only."""
    terminal_ids = [terminal.device_id for terminal in terminals]
    ring = key_ring(master_key, manager.device_id, manager.unit_ids, terminal_ids)
    specs = [DeviceSpec(manager.device_id, Role.BLOCK_MANAGER, encode_config(manager), ring)]
    for terminal in terminals:
        ring = key_ring(master_key, terminal.device_id, manager.unit_ids, [terminal.device_id])
        specs.append(DeviceSpec(terminal.device_id, Role.POINT_TERMINAL, encode_config(terminal), ring))
    return tuple(specs)
