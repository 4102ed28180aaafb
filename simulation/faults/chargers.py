"""Faults of chargers (充電設備) at stations, for sets with batteries.

All crews are told at once when a charger fails or is repaired, and units plan with that; a set that was charging keeps
its charge.
"""

from __future__ import annotations

from simulation.faults.fault import Fault, SwitchedFault


class ChargerFault(SwitchedFault, Fault[bool]):
    """Whether the charger of a station works; `target` is the station."""

    aims_at = "charger"
    changes = "charger"
    in_order = True
    target: str


class ChargerDead(ChargerFault):
    """The charger of a station gives no power."""

    kind = "charger_dead"
