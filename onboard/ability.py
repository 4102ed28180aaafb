"""Whether the train can reach its next stop from where it stands, by its unit's own model of train and way.

Each examination answers None, or the reason (`onboard.duty.unable`); the first one counts. `onboard.motion` asks
wherever the train stands at a stop and makes `Place.unable` of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.duty.unable import TooSteep, Unable
from onboard.mission import Mission, Target
from onboard.records import BehaviourRow
from onboard.vehicle import VehicleInputs
from vehicle.adhesion import DRY
from vehicle.records import TrainRow
from vehicle.running_time import Conditions, stall_of

PREDICTION_STEP_S: Final = 0.5


@dataclass(frozen=True, slots=True)
class WayAhead:
    """What is before a train that stands at a stop: where its front is, heights and limits by the metre."""

    mission: Mission
    at: int  # the stop where it stands
    front_m: float
    climb_m: NDArray[np.float64]
    limit_mps: NDArray[np.float64]

    @property
    def there(self) -> Target | None:
        """The next stop, if any."""
        return self.mission.targets[self.at + 1] if self.at + 1 < len(self.mission.targets) else None


@dataclass(frozen=True, slots=True)
class Means:
    """What the train has for it, as its unit knows it; `adhesion_factor`: the least that the weather may leave."""

    train: TrainRow
    behaviour: BehaviourRow
    load_share: float
    vehicle: VehicleInputs
    adhesion_factor: float = DRY


def why_not(way: WayAhead, means: Means) -> Unable | None:
    """What keeps the train from its next stop; None: nothing that the unit knows of."""
    return too_steep(way, means)


def too_steep(way: WayAhead, means: Means) -> TooSteep | None:
    """Where the train would stall on a gradient, or could not even start, at full power on the rail as it is told."""
    there, share = way.there, means.vehicle.motors_share
    if there is None:
        return None
    stall = stall_of(
        means.train,
        Conditions(means.load_share, share, means.adhesion_factor),
        way.climb_m,
        way.limit_mps,
        way.front_m,
        there.mark_m,
        means.behaviour.settings.stop_deceleration_mps2,
        PREDICTION_STEP_S,
    )
    if stall is None:
        return None
    piece_id, kilometrage_m = way.mission.path.locate(stall.at_m)
    return TooSteep(
        there.place_id,
        piece_id,
        round(kilometrage_m, 1),
        round(stall.gradient_permille, 2),
        pull_n=round(stall.pull_n),
        needed_n=round(stall.needed_n),
        load_share=means.load_share,
        motors_share=share,
        adhesion_factor=means.adhesion_factor,
    )


class Ability:
    """Remembers the last answer, which holds until way, load or vehicle are others."""

    def __init__(self) -> None:
        self._asked: tuple[object, ...] | None = None
        self._answer: Unable | None = None

    def why_not(self, way: WayAhead, means: Means) -> Unable | None:
        """As the function of this name."""
        has = means.load_share, means.vehicle, means.adhesion_factor
        asked = (way.mission, way.at, round(way.front_m, 1), *has)
        same = self._asked is not None and self._asked[0] is way.mission and self._asked[1:] == asked[1:]
        if not same:
            self._asked, self._answer = asked, why_not(way, means)
        return self._answer
