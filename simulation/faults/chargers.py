"""Faults of chargers (充電設備) at stations, for sets with batteries.

All crews are told at once when a charger fails or is repaired, and units plan with that; a set that was charging keeps
its charge.
"""

from __future__ import annotations

from simulation.faults.fault import Fault, Names


class ChargerFault(Fault[bool]):
    """Whether the charger of a station works; `target` is the station."""

    aims_at = "charger"
    changes = "charger"
    target: str

    @classmethod
    def targets(cls, names: Names) -> tuple[str, ...]:
        return names.chargers

    def base(self) -> bool:
        return True


class ChargerDead(ChargerFault):
    """The charger of a station gives no power."""

    kind = "charger_dead"

    def over(self, _works: bool) -> bool:
        return False
