"""The on-board units of a run as the simulator sees them: objects here, or parties (`host.unit.PartyUnits`)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

from host.unit import UnitConfig, unit_of
from onboard.unit import Answer, Report, Unit
from radio.keys import KeyRing


class Units(Protocol):
    """The on-board units of one run."""

    def advance(self, unit_id: str, now_s: float, telegrams: Sequence[bytes], report: Report) -> Answer:
        """Let a unit act at `now_s`. KeyError if it is switched off."""
        ...

    def kill(self, unit_id: str) -> None:
        """Power cut: everything but the number of its boot is gone."""
        ...

    def restart(self, unit_id: str) -> None:
        """Power back: a new boot."""
        ...


class LocalUnits:
    """Units in this process."""

    def __init__(self, units: Iterable[tuple[UnitConfig, KeyRing]]) -> None:
        self._known = {config.device_id: (config, keys) for config, keys in units}
        self._boots = dict.fromkeys(self._known, 0)
        self._running: dict[str, Unit] = {}
        for unit_id in self._known:
            self.restart(unit_id)

    def advance(self, unit_id: str, now_s: float, telegrams: Sequence[bytes], report: Report) -> Answer:
        """Let a unit act at `now_s`. KeyError if it is switched off."""
        return self._running[unit_id].advance(now_s, telegrams, report)

    def kill(self, unit_id: str) -> None:
        """Power cut."""
        self._running.pop(unit_id, None)

    def restart(self, unit_id: str) -> None:
        """Power back: a new boot."""
        config, keys = self._known[unit_id]
        self._boots[unit_id] += 1
        self._running[unit_id] = unit_of(config, keys, self._boots[unit_id])
