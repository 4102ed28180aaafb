"""Where stop signs truly stand ahead of each train; only at stations that have them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from onboard.localisation.sighting import SIGN_BEYOND_MARK_M
from simulation.world.trains import Trains


class Signs:
    """The sign that each train comes to next: what its camera may see."""

    def __init__(self, trains: Trains, next_target: Callable[[int], int]) -> None:
        self._trains: Final = trains
        self._next_target: Final = next_target
        self._vision: Final = trains.setup.vision

    def look_ahead(self, slot: int) -> None:
        """Set where the next sign stands."""
        if self._vision.wanted:
            self._trains.truths[slot].sign_m = self._sign_m(slot)

    def _sign_m(self, slot: int) -> float:
        """Path coordinate of the sign of the next mark; +inf without one, or where the train is not going there."""
        duty, following = self._trains.duties[slot], self._next_target(slot)
        if duty is None or following >= len(duty.mission.targets):
            return math.inf
        target = duty.mission.targets[following]
        if not self._vision.has_sign(target.station_id):
            return math.inf
        planned = duty.mission.path.piece_ids
        # The true path goes on beyond it, unless points have sent it elsewhere.
        if self._trains.true_path(slot).piece_ids[: len(planned)] != planned:
            return math.inf
        return target.mark_m + SIGN_BEYOND_MARK_M
