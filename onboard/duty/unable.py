"""Why a train may not depart now although its time has come: what the way to its next stop asks of it, and what it has.

Pure data, a type a reason, which `onboard.motion` finds and the duty acts on (`onboard.duty.fitness`). Another reason
is another type here, in the union at the end, and one more examination in `onboard.ability`.
"""

from __future__ import annotations

import math

import msgspec

from network.units import J_PER_KWH


class TooSteep(msgspec.Struct, frozen=True, tag=True):
    """The train cannot start, or would come to a stand, on a gradient of its way: it has less pull than that needs.

    `gradient_permille` with its curves and as a mean over the train, whose front is at `kilometrage_m` of `piece_id`.
    """

    station: str
    piece_id: str
    kilometrage_m: float
    gradient_permille: float
    pull_n: float
    needed_n: float
    load_share: float
    motors_share: float
    adhesion_factor: float = 1.0

    @property
    def words(self) -> str:
        """What is missing, in words."""
        rail = (
            "" if self.adhesion_factor >= 1.0 else f", {self.adhesion_factor:.0%} of the dry rail's adhesion"
        )
        return (
            f"a pull of {self.needed_n / 1e3:.1f} kN on {self.gradient_permille:.1f} permille at km"
            f" {self.kilometrage_m / 1e3:.3f}, {self.load_share:.0%} laden: {self.pull_n / 1e3:.1f} kN can be had with"
            f" {self.motors_share:.0%} of the motors{rail}"
        )


class NoCharge(msgspec.Struct, frozen=True, tag=True):
    """The battery does not take the set to its next charge, `station` (empty: none is to come), or is being charged.

    `has_j` as it would leave now, `needed_j` by the unit's prediction with what it keeps back; `charges`: the charger
    here works, and gives it more meanwhile where it is not `full` and its pantograph is `up`; `connected`: there is
    enough, and the pantograph has yet to come down; `stays_up`: it does so once the way is free, charging till then.
    """

    station: str
    has_j: float
    needed_j: float
    charges: bool
    connected: bool = False
    full: bool = False
    up: bool = True
    stays_up: bool = False

    @property
    def words(self) -> str:
        """What is missing, in words."""
        if self.connected:
            return "a lowered pantograph"
        where = f"to {self.station}, where it can charge next" if self.station else "to where its day ends"
        how = "there is no charger here that works"
        if self.charges:
            how = "it is charging" if self.up else "its pantograph is not up"
        if self.full:
            how = "it is full"
        needed_kwh = math.ceil(10.0 * self.needed_j / J_PER_KWH) / 10.0  # never as much as it has
        has_kwh = math.floor(10.0 * self.has_j / J_PER_KWH) / 10.0
        return f"{needed_kwh:.1f} kWh {where}: it has {has_kwh:.1f} kWh, and {how}"


Unable = TooSteep | NoCharge
