"""Faults of devices and on-board units: no power, a restart, loss of the durable state, frozen.

Power is off while one of these is in force; a person who switches the device on ends it. A party that has lost its
durable state does not start by itself when power returns: people must commission it (`commission`). A frozen party
does nothing, and later handles the telegrams received meanwhile; its last command stays in force, but a level crossing
closes: a watchdog lets its relays fall. A train whose unit is frozen runs on with the last command, and its supervision
holds it to its stop limit. A party without power loses the telegrams received; one that boots while frozen goes on only
afterwards.
"""

from __future__ import annotations

from typing import ClassVar

from simulation.faults.fault import Fault, SwitchedFault


class DeviceFault(Fault[bool]):
    """What fails in the block manager, a terminal or an on-board unit."""

    aims_at = "device"
    target: str


class PowerFault(SwitchedFault, DeviceFault):
    """Whether a device has power."""

    changes = "power"
    in_order = True


class PowerCut(PowerFault):
    """The device is off, until the duration is over; without a duration it stays off."""

    kind = "power_off"


class LostStore(PowerFault):
    """The device is off and loses its durable state; after the duration it waits to be commissioned."""

    kind = "lost_store"


class Restart(PowerFault):
    """The device is switched off and on at once."""

    kind = "restart"
    momentary: ClassVar[bool] = True


class Frozen(SwitchedFault, DeviceFault):
    """The device does nothing, then handles what it has received meanwhile."""

    kind = "frozen"
    changes = "frozen"
    in_order = False
