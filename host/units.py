"""Where on-board units run: in this process, one object a unit; `host` can give each a process of its own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

import msgspec

from onboard.duty.turn import DutyParameters
from onboard.unit import Answer, Report, Unit
from radio.envelope import AGE_MAX_S, Endpoint
from radio.keys import KeyRing


class UnitConfig(msgspec.Struct, frozen=True, tag="unit"):
    """What a unit must know before it is switched on; its line data come with the train number."""

    line_id: str
    device_id: str
    manager_id: str
    parameters: DutyParameters
    telegram_age_max_s: float = AGE_MAX_S


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


def unit_of(config: UnitConfig, keys: KeyRing, epoch: int) -> Unit:
    """A unit that has just been switched on."""
    endpoint = Endpoint(keys, epoch, config.telegram_age_max_s)
    return Unit(config.device_id, config.manager_id, config.parameters, endpoint)
