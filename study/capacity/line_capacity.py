"""How much of its time a line is occupied, by part of a cut and period, with the limits in use beside it (UIC 406)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from study.capacity.compression import Compressed, ContradictionError, StandingRule, compressed
from study.capacity.cut import CutPart, LineCut, PartKind
from study.capacity.legs import SetLeg
from study.capacity.limits import (
    LIMITS,
    NODE_LIMIT,
    OccupancyLimit,
    TrafficKind,
    additional_share,
    consumed_share,
)

HOUR_S: Final = 3600.0
PEAK_S: Final = 2.0 * HOUR_S  # assumed: an hour of a branch line holds two or three trains, too few to tell
STEP_S: Final = 900.0  # hours are tried at quarters


@dataclass(frozen=True, slots=True)
class Period:
    """A stretch of the day, s after midnight; `peak`: the limits of the peak hour hold for it."""

    name: str
    from_s: float
    to_s: float
    peak: bool

    @property
    def length_s(self) -> float:
        """How long it is."""
        return self.to_s - self.from_s

    def legs(self, legs: Iterable[SetLeg]) -> tuple[SetLeg, ...]:
        """Those legs that begin in it."""
        return tuple(leg for leg in legs if self.from_s <= leg.departs_s < self.to_s)


@dataclass(frozen=True, slots=True)
class Rate:
    """A part of a cut line in a period: how long its trains take pushed together, and the limits beside that.

    `trains`: passages, a train that comes twice counts twice. `stops`: whether trains stand between legs as planned;
    where that contradicts itself (`contradiction` names the trains) no longer than they must.
    """

    part: CutPart
    period: Period
    trains: int
    compressed: Compressed
    limit: OccupancyLimit
    stops: StandingRule
    contradiction: tuple[str, ...] = ()

    @property
    def occupied_share(self) -> float:
        """Occupancy time rate."""
        return self.compressed.occupied_s / self.period.length_s

    @property
    def limit_share(self) -> float:
        """What is recommended at most."""
        return self.limit.share(peak=self.period.peak)

    @property
    def consumed_share(self) -> float:
        """Capacity consumption: with the additional time of the limit."""
        return consumed_share(self.compressed.occupied_s, self.period.length_s, self.limit_share)

    @property
    def trains_below_limit(self) -> int:
        """How many more of its own mix this part alone could take by the limit; negative: so many too many."""
        if not self.trains:
            return 0
        each_s = self.compressed.occupied_s / self.trains
        return math.floor(
            (self.limit_share * self.period.length_s - self.compressed.occupied_s) / each_s + 1e-9
        )

    def as_dict(self) -> dict[str, Any]:
        """For JSON and CSV."""
        own = self.compressed
        return {
            "part": self.part.name,
            "kind": self.part.kind.value,
            "period": self.period.name,
            "from_s": self.period.from_s,
            "to_s": self.period.to_s,
            "trains": self.trains,
            "occupied_s": round(own.occupied_s, 1),
            "occupancy_percent": round(100.0 * self.occupied_share, 1),
            "limit_percent": round(100.0 * self.limit_share, 1),
            "additional_percent": round(100.0 * additional_share(self.limit_share), 1),
            "consumed_percent": round(100.0 * self.consumed_share, 1),
            "trains_below_limit": self.trains_below_limit,
            "critical_section": own.section_id,
            "critical_section_s": round(own.by_section_s().get(own.section_id, 0.0), 1),
            **{cost.column: round(time_s, 1) for cost, time_s in own.costs_s().items()},
            "stops": self.stops.value,
            "contradiction": " ".join(self.contradiction),
        }


def day_of(legs: Sequence[SetLeg]) -> Period:
    """From the first departure to the last arrival, in whole hours."""
    begin_s = min(leg.departs_s for leg in legs)
    ends = [leg.arrives_s for leg in legs if math.isfinite(leg.arrives_s)]
    return Period(
        "day", math.floor(begin_s / HOUR_S) * HOUR_S, math.ceil(max(ends) / HOUR_S) * HOUR_S, peak=False
    )


def peak_of(legs: Sequence[SetLeg], day: Period, length_s: float = PEAK_S) -> Period:
    """The stretch of that length, from a quarter of an hour on, in which most legs begin; the first of them."""
    starts = [day.from_s + i * STEP_S for i in range(max(1, round((day.length_s - length_s) / STEP_S) + 1))]

    def count(from_s: float) -> int:
        return sum(from_s <= leg.departs_s < from_s + length_s for leg in legs)

    from_s = max(starts, key=lambda start_s: (count(start_s), -start_s))
    return Period("peak", from_s, from_s + length_s, peak=True)


@dataclass(frozen=True, slots=True)
class CompressionTerms:
    """On which terms trains are pushed together: how long they stand, s, and by which limits that is judged."""

    traffic: TrafficKind = TrafficKind.MIXED
    stops: StandingRule = StandingRule.KEPT
    dwell_min_s: float = math.inf


DEFAULT_TERMS: Final = CompressionTerms()


def rate_of(legs: Iterable[SetLeg], part: CutPart, period: Period, terms: CompressionTerms) -> Rate:
    """One part in one period; ContradictionError where not even the shortest stops make sense of the order."""
    limit = NODE_LIMIT if part.kind is PartKind.NODE else LIMITS[terms.traffic]
    stops = terms.stops
    inside, contradiction = period.legs(legs), tuple[str, ...]()
    try:
        found = compressed(inside, part.section_ids, stops, terms.dwell_min_s)
    except ContradictionError as error:
        if stops is StandingRule.LEAST:
            raise
        stops, contradiction = StandingRule.LEAST, error.numbers
        found = compressed(inside, part.section_ids, stops, terms.dwell_min_s)
    trains = len({(leg.stock_id, leg.number) for leg in found.legs})
    return Rate(part, period, trains, found, limit, stops, contradiction)


def rates_of(
    legs: Sequence[SetLeg], cut: LineCut, periods: Sequence[Period], terms: CompressionTerms = DEFAULT_TERMS
) -> tuple[Rate, ...]:
    """Every part of a cut in every period, in the order of the cut."""
    return tuple(rate_of(legs, part, period, terms) for period in periods for part in cut.parts)


def fullest_part(rates: Iterable[Rate], kind: PartKind = PartKind.LINE) -> Rate | None:
    """The part of a kind with the highest rate: by that a line is judged."""
    some = [rate for rate in rates if rate.part.kind is kind and rate.trains]
    return max(some, key=lambda rate: (rate.occupied_share, rate.part.name), default=None)
