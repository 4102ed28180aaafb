"""The wayside devices in the simulator's own process: the same machines, the same bytes, no Zenoh."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from types import TracebackType
from typing import Self

from host.device import DeviceHost
from host.devices import Advance, DeviceSpec, FleetError
from host.store import MemoryStore
from wayside.config import decode_config
from wayside.said import Input


class LocalFleet:
    """`host.devices.Fleet` without processes. A killed device keeps its durable state only."""

    def __init__(self, specs: Iterable[DeviceSpec]) -> None:
        self._specs = {spec.device_id: spec for spec in specs}
        self._stores = {device_id: MemoryStore() for device_id in self._specs}
        self._hosts: dict[str, DeviceHost] = {}

    def __enter__(self) -> Self:
        for device_id in self._specs:
            self.restart(device_id)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._hosts.clear()

    def advance(
        self, device_id: str, now_s: float, telegrams: Sequence[bytes], inputs: Sequence[Input] = ()
    ) -> Advance:
        """Let a device act at `now_s`. FleetError if it is down."""
        host = self._hosts.get(device_id)
        if host is None:
            raise FleetError(f"device {device_id} is down")
        return host.advance(now_s, telegrams, inputs)

    def alive(self, device_id: str) -> bool:
        """Whether the device runs."""
        return device_id in self._hosts

    def kill(self, device_id: str) -> None:
        """Power cut."""
        self._hosts.pop(device_id, None)

    def restart(self, device_id: str) -> None:
        """Power back: a new boot epoch. FleetError if it runs."""
        if device_id in self._hosts:
            raise FleetError(f"device {device_id} runs already")
        spec = self._specs[device_id]
        self._hosts[device_id] = DeviceHost(
            decode_config(spec.config_json), spec.keys, self._stores[device_id]
        )
