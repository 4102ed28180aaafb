"""Faults of devices and on-board units: without power, started again, without their durable state, frozen.

Power is off while any of these is in force; a person who switches the device on ends them. A party that has lost its
durable state does not start by itself when it has power again: people must commission it (`commission`). A frozen
party does nothing, and finds later what has come to it meanwhile; what it last commanded stays. A train whose unit is
frozen goes on with the last command: its compiled supervision holds it to the stop limit that it has. Losing its power
a party loses what has piled up, and one that boots while it is frozen goes on only afterwards.
"""

from __future__ import annotations

from typing import ClassVar

from simulation.faults.fault import Fault, Names


class DeviceFault(Fault[bool]):
    """What fails in the block manager, a terminal or an on-board unit."""

    aims_at = "device"
    target: str

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        return *names.devices, *names.units


class PowerFault(DeviceFault):
    """Whether a device has power."""

    changes = "power"

    def base(self) -> bool:
        return True

    def over(self, _on: bool) -> bool:
        return False


class PowerCut(PowerFault):
    """The device is off; on again after the duration, and without one never."""

    kind = "power_off"


class LostStore(PowerFault):
    """The device is off and has lost its durable state; after the duration it waits to be commissioned again."""

    kind = "lost_store"


class Restart(PowerFault):
    """The device goes off and on at once."""

    kind = "restart"
    momentary: ClassVar[bool] = True


class Frozen(DeviceFault):
    """The device does nothing, then goes on with what has piled up."""

    kind = "frozen"
    changes = "frozen"

    def base(self) -> bool:
        return False

    def over(self, _frozen: bool) -> bool:
        return True
