"""Why a train may not depart now although its time has come (temporary until the mechanism is merged)."""

from __future__ import annotations

import msgspec


class NoCharge(msgspec.Struct, frozen=True, tag=True):
    """The battery does not take the set to its next charge, `station` (empty: none is to come), or is being charged.

    `has_j` as it would leave now, `needed_j` by the unit's prediction with what it keeps back; `charges`: a charger
    gives it more meanwhile; `connected`: there is enough, and the pantograph has yet to come down.
    """

    station: str
    has_j: float
    needed_j: float
    charges: bool
    connected: bool = False

    @property
    def words(self) -> str:
        """What is missing, in words."""
        if self.connected:
            return "a lowered pantograph"
        where = f"to {self.station}, where it can charge next" if self.station else "to where its day ends"
        how = "it is charging" if self.charges else "there is no charger here that works"
        return f"{self.needed_j / 3.6e6:.1f} kWh {where}: it has {self.has_j / 3.6e6:.1f} kWh, and {how}"


Unable = NoCharge
