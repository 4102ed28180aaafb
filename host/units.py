"""The on-board units of a run as the simulator sees them: objects here, or parties (`host.unit.PartyUnits`)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

from host.store import MemoryStore, commission, commissioned
from host.unit import HostedUnit, UnitConfig
from onboard.unit import Report, UnitAnswer
from radio.keys import KeyRing


class Units(Protocol):
    """The on-board units of one run."""

    def advance(self, unit_id: str, now_s: float, telegrams: Sequence[bytes], report: Report) -> UnitAnswer:
        """Let a unit act at `now_s`. KeyError if it is switched off."""
        ...

    def kill(self, unit_id: str) -> None:
        """Power cut: everything but its durable state is gone."""
        ...

    def restart(self, unit_id: str) -> None:
        """Power back: a new boot. Raises NotCommissioned, and it stays down, if its durable state is lost."""
        ...

    def lose(self, unit_id: str) -> None:
        """The durable state of a unit that is down is gone."""
        ...

    def commission(self, unit_id: str, number: int) -> None:
        """People put a unit that is down into service again (see `host.store.commission`), before its next boot."""
        ...


class LocalUnits:
    """Units in this process. Making them is their first commissioning."""

    def __init__(self, units: Iterable[tuple[UnitConfig, KeyRing]]) -> None:
        self._known = {config.device_id: (config, keys) for config, keys in units}
        self._stores = {unit_id: MemoryStore() for unit_id in self._known}
        self._running: dict[str, HostedUnit] = {}
        for unit_id in self._known:
            self.commission(unit_id, 1)
            self.restart(unit_id)

    def advance(self, unit_id: str, now_s: float, telegrams: Sequence[bytes], report: Report) -> UnitAnswer:
        """Let a unit act at `now_s`. KeyError if it is switched off."""
        return self._running[unit_id].advance(now_s, telegrams, report)

    def kill(self, unit_id: str) -> None:
        """Power cut."""
        self._running.pop(unit_id, None)

    def restart(self, unit_id: str) -> None:
        """Power back: a new boot. NotCommissioned if its durable state is lost."""
        store = commissioned(self._stores[unit_id], f"on-board unit {unit_id}")
        self._running[unit_id] = HostedUnit(*self._known[unit_id], store)

    def lose(self, unit_id: str) -> None:
        """Its durable state is gone."""
        self._stores[unit_id] = MemoryStore()

    def commission(self, unit_id: str, number: int) -> None:
        """People put it into service again."""
        commission(self._stores[unit_id], number)
