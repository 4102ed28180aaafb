"""Where trains run on less adhesion than the design counts on: what follows from it is outside the design.

The guaranteed brakes hold down to a design adhesion, a share of the dry rail's. A train is outside the design while the
rail under it gives less, and afterwards until it stands, for at most as long as it is guaranteed to stop in from the
speed that it then has. A section that it comes into in that time without holding it, or points without a proof, stay
outside the design until it has left them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from simulation.judge.locking import GuaranteedBrake


@dataclass(slots=True)
class LowAdhesion:
    """One stretch of time in which a train had less than the design adhesion; `least` as a share of the dry rail's."""

    unit_id: str
    from_s: float
    least: float
    to_s: float | None = None  # None: to the end


class RailWatch:
    """The adhesion under each train against that of the design."""

    def __init__(self, design_share: float, brakes: Mapping[str, GuaranteedBrake]) -> None:
        self._design_share = design_share
        self._brakes = brakes
        self._below: dict[str, LowAdhesion] = {}
        self._until_s: dict[str, float] = {}  # units that may still be sliding on from there
        self.stretches: list[LowAdhesion] = []

    def rail(self, t_s: float, unit_id: str, share: float, speed_mps: float) -> None:
        """The adhesion under a train is now this share of the dry rail's, at any speed."""
        below = self._below.get(unit_id)
        if share < self._design_share:
            if below is None:
                below = self._below[unit_id] = LowAdhesion(unit_id, t_s, share)
                self.stretches.append(below)
            below.least = min(below.least, share)
        elif below is not None:
            below.to_s = t_s
            del self._below[unit_id]
            brake = self._brakes.get(unit_id)
            if brake is not None and speed_mps > 0.0:
                self._until_s[unit_id] = t_s + brake.reaction_s + speed_mps / brake.deceleration_mps2

    def train_stood(self, unit_id: str) -> None:
        """The train stands: what it does next it does by the rail as it is then."""
        self._until_s.pop(unit_id, None)

    def outside(self, t_s: float, unit_id: str) -> bool:
        """Whether what the train comes onto now is outside the design."""
        return unit_id in self._below or t_s <= self._until_s.get(unit_id, -math.inf)
