"""How much room a train needs before a place where it must stop, by what drives and what supervises it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from onboard.driving.stopping import LIMIT_MARGIN_M
from onboard.driving.supervision import RESERVE_M
from onboard.records import BehaviourRow


@dataclass(frozen=True, slots=True)
class Room:
    """How one train brakes for a stop limit: `reaction_s` of its brake, dead time and lag; `standoff_m` as it aims.

    Gradients are left out: TASC takes them off its command.
    """

    behaviour: BehaviourRow
    reaction_s: float
    standoff_m: float

    def needed_m(self, speed_mps: NDArray[np.float64], bound_m: float) -> NDArray[np.float64]:
        """Where, before a stop limit, a train at each of the speeds begins to brake for it, m; shape (n,).

        By the pattern to a stop (`onboard.driving.stopping`) or by supervision (`onboard.driving.ahead.limit_mps`),
        whichever is further off; `bound_m`: by how much the front may be ahead.
        """
        own = self.behaviour
        stop_m = max(self.standoff_m, bound_m + LIMIT_MARGIN_M)
        by_pattern_m = (
            stop_m + speed_mps * self.reaction_s + speed_mps**2 / (2.0 * own.settings.stop_deceleration_mps2)
        )
        # driving stays so far under what supervision permits
        over_mps = speed_mps + own.settings.service_margin_mps
        guaranteed_m = over_mps * own.service_reaction_s + over_mps**2 / (2.0 * own.service_guaranteed_mps2)
        supervised_m = np.where(speed_mps > 0.0, bound_m + RESERVE_M + guaranteed_m, 0.0)
        return np.asarray(np.maximum(by_pattern_m, supervised_m), dtype=np.float64)
