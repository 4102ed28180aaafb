"""What share of the time a line may be occupied by its compressed timetable before trains are late for each other.

UIC Code 406 (2nd edition, June 2013) recommends occupancy time rates by the kind of traffic, for the peak hour and for
the day; what it calls the additional time rate is the same said the other way round, 100 / rate - 1, rounded there.
For nodes it gives a band. It has no other figures for single track: where trains wait for opposing ones, the lower
end is what planners go by. Recommendations, not results: they stand beside a rate and decide nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Final


class TrafficKind(StrEnum):
    """Kinds of traffic for which there are limits."""

    MIXED = "mixed"
    SUBURBAN = "suburban"
    HIGH_SPEED = "high-speed"


@dataclass(frozen=True, slots=True)
class OccupancyLimit:
    """The share of the peak hour and of the day that may be occupied."""

    peak_share: float
    day_share: float

    def share(self, *, peak: bool) -> float:
        """The one of the two."""
        return self.peak_share if peak else self.day_share


LIMITS: Final[Mapping[TrafficKind, OccupancyLimit]] = MappingProxyType(
    {
        TrafficKind.MIXED: OccupancyLimit(0.75, 0.60),
        TrafficKind.SUBURBAN: OccupancyLimit(0.85, 0.70),
        TrafficKind.HIGH_SPEED: OccupancyLimit(0.75, 0.60),
    }
)
NODE_LIMIT: Final = OccupancyLimit(0.80, 0.60)  # the ends of the band for nodes


def additional_share(limit_share: float) -> float:
    """The additional time rate of a limit: what has to be left free over the occupied time, as a share of that."""
    return 1.0 / limit_share - 1.0


def consumed_share(occupied_s: float, period_s: float, limit_share: float) -> float:
    """Capacity consumption: occupied with additional time, over the period; above 1 there is no room by the limit."""
    return occupied_s * (1.0 + additional_share(limit_share)) / period_s
