"""Faults of chargers (充電設備): what a station gives to sets with batteries.

All crews are told at once when a charger fails or is mended, so that units reckon with it; a set that was charging
there keeps what it has.
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
    """The charger of a station gives nothing."""

    kind = "charger_dead"

    def over(self, _works: bool) -> bool:
        return False
