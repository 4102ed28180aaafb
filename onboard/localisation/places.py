"""Virtual tags (仮想地上子): for a train without a reader of tags, their places in the database are passed by fixes.

Invariant: a place counts as passed only once a fix of an absolute sensor has the whole of its own interval beyond it.
What the tachometer says counts nothing there, as at a real tag, which can be read only where it is: so a release that
waits for the place is immune to the tachometer (decisions 011 and 037). Where the front passes a place without a fix,
the next fix beyond it counts for it; where none comes, the driver is asked at the mark.

What only asks for something ahead (throws at ④, the route beyond) goes by the estimate: it frees nothing, and whoever
may be upon points throws none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from network.model import TagPurpose
from onboard.localisation.wheel_scale import (
    FrontAtCount,
    WheelScale,
    carried_interval,
    front_interval,
    narrowest,
)
from onboard.mission import PathTag
from onboard.records import UnitRow
from onboard.unit_records import UnitParameters

AGREES_OVER_M: Final = (
    200.0  # assumed: a way over which two fixes tell a sound tachometer from one out of order
)
ASKS_AHEAD: Final = (TagPurpose.APPROACH, TagPurpose.POSITION)


class Places:
    """What one unit without a reader of tags makes of fixes; reads and sets localisation in its row."""

    def __init__(self, row: UnitRow, parameters: UnitParameters) -> None:
        self._row: Final = row
        self._parameters: Final = parameters
        self._wheel: Final = WheelScale(row, parameters, keeps_first=True)
        self._before: FrontAtCount | None = None  # a fix in doubt, with which the next must agree
        self._tags: tuple[PathTag, ...] = ()
        self._proved = 0  # of the tags, how many by fixes
        self._asked = 0  # and how many by the estimate
        self.forget()

    def forget(self) -> None:
        """No virtual tags, until a path is taken up."""
        row = self._row
        row.sure_m = row.fix_at_m = -math.inf
        row.place_trigger_m = math.inf
        row.missed_fixes = row.narrow = 0
        self._tags, self._before = (), None
        self._wheel.forget_places()

    def take_up(self, tags: tuple[PathTag, ...]) -> None:
        """Another mission, from where the train stands: what lies behind it there is of no interest any more."""
        self.forget()
        self._tags = tags
        here_m = float(self._row.position_m) + 0.1
        self._proved = self._asked = sum(tag.position_m <= here_m for tag in tags)
        self._watch()

    @property
    def ask_m(self) -> float:
        """Where the estimate next has something asked for ahead; +inf: nowhere."""
        ahead = (tag.position_m for tag in self._tags[self._asked :] if tag.purpose in ASKS_AHEAD)
        return next(ahead, math.inf)

    def tags_proved(self) -> Iterator[tuple[int, PathTag]]:
        """The tags whose places fixes prove to be behind the front since the last call, in their order."""
        while self._proved < len(self._tags) and self._tags[self._proved].position_m <= self._row.sure_m:
            yield self._proved, self._tags[self._proved]
            self._proved += 1
        self._measure()
        self._watch()

    def tags_reached(self) -> Iterator[int]:
        """The tags that ask for something ahead, and at whose places the estimate now is."""
        while self._asked < len(self._tags) and self._tags[self._asked].position_m <= self._row.position_m:
            if self._tags[self._asked].purpose in ASKS_AHEAD:
                yield self._asked
            self._asked += 1

    def doubt(self) -> None:
        """A position fault: no way is measured over it."""
        self._before = None
        self._wheel.forget()
        self._row.missed_fixes = self._row.narrow = 0

    def eye(self, front_m: float, within_m: float) -> None:
        """The driver's eye has told where the front is: a fix like that of a sensor."""
        row = self._row
        row.fix_low_m, row.fix_high_m = front_m - within_m, front_m + within_m
        row.narrow = 0
        row.fix_at_m, row.fix_odometer_m = row.position_m, row.odometer_m
        row.sure_m = max(row.sure_m, row.fix_low_m)

    def _watch(self) -> None:
        """Have the tick report the next place; while the tachometer is in doubt, a fix that may clear it too."""
        row = self._row
        following = self._tags[self._proved].position_m if self._proved < len(self._tags) else math.inf
        if self._in_doubt:
            begun_m = row.sure_m if self._before is None else self._before.high_m + AGREES_OVER_M
            following = min(following, begun_m) if math.isfinite(begun_m) else following
        row.place_trigger_m = following

    @property
    def _in_doubt(self) -> bool:
        """Whether bounds grow as after a position fault."""
        return bool(self._row.bound_growth > self._parameters.wheel_error_share)

    def _measure(self) -> None:
        """What the last fix and those before it say of the wheels: what they are worth, whether they can be trusted."""
        row, before = self._row, self._before
        if not math.isfinite(row.fix_at_m):
            return
        here = front_interval(row, float(row.fix_low_m), float(row.fix_high_m))
        if self._in_doubt:
            if before is None:
                self._before = here
                return
            if here.low_m - before.high_m < AGREES_OVER_M:
                return
            self._before = here
            low_m, high_m = carried_interval(row, before, self._wheel.scales)
            if low_m > here.high_m or high_m < here.low_m:
                return
            self._wheel.learn(before)
        # Another sensor may have told the position more closely, not long ago.
        self._wheel.learn(narrowest(row))
        self._wheel.apply(self._wheel.middle)
