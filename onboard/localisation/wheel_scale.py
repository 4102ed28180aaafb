"""What the wheels may be worth: metres of way per metre counted, as an interval that readings at two places narrow.

Invariant: the wheel's own scale lies within the interval as long as wheels are worn by no more than stated, what
changes from place to place (creep, the tread's slope in curves) stays within its share of the stated error, and the
intervals that it was learned from hold the front. Tags alone are worth as much: the ways from each to the next add up
to what lies between two that are right, so one that lies makes the way to it too long by what the next is too short.
Of `2 n + 1` such ways, where no more than n tags lie together, one is right or two are wrong to either side.
What contradicts all that is not learned: it begins anew.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

from onboard.records import UnitRow
from onboard.unit_records import UnitParameters

PLACES_KEPT: Final = 6  # two stations' worth of tags
LEARNED_OVER_M: Final = 100.0  # on less the accuracy of two readings says nothing


class FrontAtCount(NamedTuple):
    """An interval of path coordinates (m) that the front was in when the tachometer stood at `odometer_m`.

    `ahead_m` and `behind_m`: what slides and slips had widened bounds by until then, see `UnitRow`.
    """

    low_m: float
    high_m: float
    odometer_m: float
    ahead_m: float
    behind_m: float


class Scales(NamedTuple):
    """Metres of way per metre counted, at least and at most, anywhere on the way."""

    low: float
    high: float


def held(row: UnitRow, low_m: float, high_m: float) -> FrontAtCount:
    """The front lies in this interval now."""
    return FrontAtCount(low_m, high_m, row.odometer_m, row.slid_ahead_m, row.slipped_behind_m)


def narrowest(row: UnitRow) -> FrontAtCount:
    """The narrowest fix of an absolute sensor since the last that was asked for here; without one the last of all."""
    if not row.narrow:
        return held(row, float(row.fix_low_m), float(row.fix_high_m))
    row.narrow = 0
    return FrontAtCount(
        float(row.narrow_low_m),
        float(row.narrow_high_m),
        float(row.narrow_odometer_m),
        float(row.narrow_slid_m),
        float(row.narrow_slipped_m),
    )


def carried(row: UnitRow, before: FrontAtCount, scales: Scales) -> tuple[float, float]:
    """The interval in which the front lies now, m, if it was in `before` then."""
    run_m = max(row.odometer_m - before.odometer_m, 0.0)
    low_m = before.low_m + run_m * scales.low - (row.slipped_behind_m - before.behind_m)
    return low_m, before.high_m + run_m * scales.high + (row.slid_ahead_m - before.ahead_m)


def way_between(before: FrontAtCount, here: FrontAtCount) -> Scales:
    """What a metre counted was worth from one interval of the front to another; anything where nothing was counted."""
    run_m = here.odometer_m - before.odometer_m
    if run_m <= 0.0:
        return Scales(-math.inf, math.inf)
    slid_m, slipped_m = here.ahead_m - before.ahead_m, here.behind_m - before.behind_m
    low_m, high_m = here.low_m - before.high_m - slid_m, here.high_m - before.low_m + slipped_m
    return Scales(low_m / run_m, high_m / run_m)


class WheelScale:
    """What one unit knows of its wheels; sets `odometer_scale` and `bound_growth` of its row.

    `keeps_first`: the first place of a path stays one of those kept, as the way from it is the longest.
    """

    def __init__(self, row: UnitRow, parameters: UnitParameters, *, keeps_first: bool = False) -> None:
        self._row: Final = row
        self._keeps_first: Final = keeps_first
        self._worn: Final = parameters.wheel_scale_limit
        self._varies: Final = parameters.wheel_varies_share
        self._low, self._high = 1.0 - self._worn, 1.0 + self._worn
        self._places: deque[FrontAtCount] = deque(maxlen=PLACES_KEPT)
        self._tag: FrontAtCount | None = None  # the last that was read
        self._ways: deque[Scales] = deque(maxlen=2 * parameters.tags_wrong_together + 1)

    @property
    def scales(self) -> Scales:
        """What is stated or known now, with what changes from place to place."""
        return self.varied(self.worth)

    @property
    def worth(self) -> Scales:
        """What the wheels themselves are worth."""
        return Scales(self._low, self._high)

    def varied(self, worth: Scales) -> Scales:
        """With what changes from place to place."""
        return Scales(worth.low - self._varies, worth.high + self._varies)

    @property
    def middle(self) -> float:
        """The scale by which bounds grow least."""
        return (self._low + self._high) / 2.0

    @property
    def growth(self) -> float:
        """By what share of the way bounds then grow."""
        return self._varies + (self._high - self._low) / 2.0

    def forget_places(self) -> None:
        """The path coordinates are others now; what the wheels are worth is kept."""
        self._places.clear()
        self._ways.clear()
        self._tag = None

    def forget(self) -> None:
        """Something was false: nothing is known but what is stated."""
        self.forget_places()
        self._low, self._high = 1.0 - self._worn, 1.0 + self._worn

    def recall(self, worth: Scales) -> None:
        """What was known once holds again."""
        self._low, self._high = worth

    def learn(self, here: FrontAtCount) -> None:
        """The front surely is in this interval now: what that says about the way since earlier ones."""
        for before in tuple(self._places):
            if here.odometer_m - before.odometer_m >= LEARNED_OVER_M:
                self._narrow(*way_between(before, here))
        if self._keeps_first and len(self._places) == PLACES_KEPT:
            del self._places[1]
        self._places.append(here)

    def read(self, tag: FrontAtCount) -> None:
        """A tag was read that says the front is in this interval now; it may lie."""
        before, self._tag = self._tag, tag
        if before is not None:
            self._ways.append(way_between(before, tag))
        if len(self._ways) == self._ways.maxlen:
            self._narrow(min(way.low for way in self._ways), max(way.high for way in self._ways))

    def _narrow(self, low: float, high: float) -> None:
        """Over some way a metre counted was worth this, at least and at most."""
        self._low, self._high = max(self._low, low - self._varies), min(self._high, high + self._varies)
        if not self._low <= self._high:
            self.forget()

    def apply(self, scale: float) -> None:
        """Count by this scale from now on, as far as bounds then grow by no more than stated: by what it may be off."""
        half = (self._high - self._low) / 2.0
        off = min(max(scale - self.middle, half - self._worn), self._worn - half)
        self._row.odometer_scale = self.middle + off
        self._row.bound_growth = self._varies + half + abs(off)
