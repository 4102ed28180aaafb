"""The level crossing that is explored whole with one train, and how often each thing that is not wished for may happen.

Times are no numbers here. One runs (`RUNS_S`) or has run out (`OUT_S`), and everything that is done is done at 0 s:
what device and unit compare is then the same as at some instants of a run, and which runs out first is left
open, but for what one of them cannot do before the other (`verify.crossing.gate`).
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Final, NamedTuple

from wayside.config import CrossingConfig

CROSSING: Final = "C"
UNIT: Final = "u1"
NOW_S: Final = 0.0
RUNS_S: Final = 1.0  # a time that will run out
OUT_S: Final = -1000.0  # longer ago than any time that counts
CURRENT, BEFORE = 1, 9  # correlation of what the unit has announced now, and of all before
ON_AIR_MAX: Final = 2  # telegrams one way: an older one is lost when another follows


class CrossingTrouble(IntEnum):
    """What is not wished for, each within a budget; `CrossingTrouble.NONE` costs nothing."""

    NONE = 0
    LOSS = 1  # a telegram is lost, overtaken, or older than the age limit
    POWER = 2  # of the unit or the device
    CARRIERS = 3  # both networks are lost for a time
    STORE = 4  # the device loses power and what it had stored
    EQUIPMENT = 5  # barriers stick, lamps are dead, contacts show nothing, for a time
    POSITION = 6  # the unit loses its position


class CrossingBudgets(NamedTuple):
    """How often each may happen."""

    loss: int = 0
    power: int = 0
    carriers: int = 0
    store: int = 0
    equipment: int = 0
    position: int = 0


class ExploredCrossing(NamedTuple):
    """What is explored; `barriers`: of class 1, otherwise a warning alone (class 3)."""

    barriers: bool = True
    budgets: CrossingBudgets = CrossingBudgets()

    @property
    def closing_s(self) -> float:
        """From the start of the warning until it is closed."""
        return 15.0 if self.barriers else 0.0

    @property
    def closed_s(self) -> float:
        """From closed to the train."""
        return 20.0 if self.barriers else 30.0

    @property
    def least_s(self) -> float:
        """From closed to the train at least."""
        return 15.0 if self.barriers else 20.0

    @property
    def config(self) -> CrossingConfig:
        """Fixed data of the device."""
        return CrossingConfig("explored", CROSSING, self.barriers, self.closing_s, self.closed_s)


def since_s(time_s: float) -> float:
    """A time since which something is so: now, long ago, or not at all."""
    return time_s if math.isinf(time_s) else NOW_S if time_s > OUT_S else OUT_S
