"""A stretch that the kernel has run and the carrier has not, so that it can still be cut shorter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simulation.setup import STEP_S
from simulation.world.kernel import Sheet


class TrainMotion(NamedTuple):
    """Where a train's front is on its path, m, and how fast it runs, m/s."""

    position_m: float
    speed_mps: float


@dataclass(frozen=True, slots=True)
class ForeseenStretch:
    """`before` and `first_row`: the stocks and the use of the trace as it began, so that it can be run anew."""

    done: int  # steps
    movers: int
    first_row: int
    before: NDArray[np.void] | None

    def motion_of(self, slot: int, steps: int, sheet: Sheet) -> TrainMotion:
        """A train after so many steps of the stretch, of which `sheet` tells. ValueError where it is not foreseen."""
        if self.before is None:
            raise ValueError("nobody foresees this stretch")
        begun = self.before[slot]
        position_m, speed_mps = float(begun["truth"]["position_m"]), float(begun["plant"]["speed_mps"])
        movers = sheet.movers[: self.movers].tolist()
        if slot not in movers or steps == 0:
            return TrainMotion(position_m, speed_mps)
        speeds = np.concatenate(([speed_mps], sheet.speeds_mps[movers.index(slot), :steps]))
        run_m = float(np.sum(speeds[:-1] + speeds[1:])) * STEP_S / 2.0
        return TrainMotion(position_m + run_m, float(speeds[-1]))
