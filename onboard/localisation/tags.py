"""How far tags and tachometer are trusted: the bounds after a tag, calibration, doubt after a position fault.

Invariant: of the tags read one after another at most `tags_wrong_together` give a wrong place (a wrong id, a tag of
another track, a moved one), or the wrong places lie on both sides of the train (two swapped tags). So the bounds span
one tag more than that number: the newest tag fully, and the earlier ones, carried on by the wheels, as far as the
bounds before allow. No such tag can move the bounds off the truth. A tag that agrees neither with the last trusted tag
nor with a doubted one since, within the error of the wheels, is doubted: it may widen the bounds, but neither moves
the estimate nor counts as passed, until a later tag shows which was wrong.

After a position fault a tag fixes the position only if no other tag is possible within the tachometer's
error, or if it agrees with the tag read before it (地上子位置との照合, Sugiyama, table 5). If only tags showed the
fault, the old bounds may be right and the tags wrong, so the old bounds are spanned too. They stay wide
until the distance between two tags is as the tachometer says. Wheels are not doubted for what they cannot
explain: a tag that is not on the path, or one further from another sensor's fix than wheels could err
since then. The former knowledge of the wheels is restored when two known places, by a trusted tag or a fix
of an absolute sensor, the first even before the fault, confirm it: then the tag was wrong.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from enum import Enum
from typing import Final

from onboard.localisation.axles import forget_axles
from onboard.localisation.fix import Fix, FixSource, TakenFix, bring_within, missed_by_m, take_interval
from onboard.localisation.tachometer import calibrated_scale
from onboard.localisation.wheel_scale import (
    LEARNED_OVER_M,
    PLACES_KEPT,
    FrontAtCount,
    Scales,
    WheelScale,
    carried_interval,
    front_interval,
    narrowest,
    way_between,
)
from onboard.mission import PathTag
from onboard.records import UnitRow
from onboard.unit_records import UnitParameters
from vehicle.compiled import compiled


@compiled
def front_by_tag(
    row: UnitRow, tag_m: float, odometer_at_tag_m: float, accuracy_m: float
) -> tuple[float, float]:
    """Where the front is now (m) by a tag at `tag_m`, and within what (m either way); see `tag_fix`."""
    since_m = (row.odometer_m - odometer_at_tag_m) * row.odometer_scale
    return tag_m + since_m, accuracy_m + row.pulse_m + abs(since_m) * row.bound_growth


def tag_fix(row: UnitRow, tag_m: float, odometer_at_tag_m: float, accuracy_m: float) -> Fix:
    """What a tag at path coordinate `tag_m` says, read in the last step, when the tachometer stood at
    `odometer_at_tag_m`.
    """
    position_m, bound_m = front_by_tag(row, tag_m, odometer_at_tag_m, accuracy_m)
    return Fix(
        float(position_m), float(bound_m + row.step_long_m), float(bound_m + row.step_short_m), FixSource.TAG
    )


def bounds_of(row: UnitRow) -> tuple[float, float]:
    """The stated interval of the front, m."""
    return float(row.position_m - row.bound_behind_m), float(row.position_m + row.bound_ahead_m)


class TagOutcome(Enum):
    """What came of a tag that was read."""

    OUT = "out"  # it misses the bounds
    DOUBTED = "doubted"  # it is not believed yet
    BELIEVED = "believed"


class Wheels(Enum):
    """What a position fault says of the tachometer."""

    SOUND = "sound"  # however wrong it were, it would not explain what was read
    DOUBTED = "doubted"
    FALSE = "false"  # it shows what no slide explains


class TagDoubt:
    """What one unit remembers of the tags it has read; reads and sets localisation in its row."""

    def __init__(self, row: UnitRow, parameters: UnitParameters, record: UnitRow | None = None) -> None:
        self._row: Final = row
        self._record: Final = row if record is None else record  # the same memory, as compiled code takes it
        self._parameters: Final = parameters
        self._tags: tuple[PathTag, ...] = ()
        self._last: tuple[PathTag, float] | None = None  # the last tag believed, and the tachometer there, m
        self._suspect: tuple[PathTag, float] | None = None  # one read in doubt
        self._doubting = False
        self._anchor_m = 0.0  # path coordinate where the tachometer was last known to be right
        self._wheel: Final = WheelScale(row, parameters)
        self._wide = False  # the tachometer may be out of order
        together = parameters.tags_wrong_together
        # Where tags believed, and fixes, had the front.
        self._told: Final[deque[FrontAtCount]] = deque(maxlen=PLACES_KEPT)
        self._known: Scales | None = None  # what wheels were worth before they were doubted
        self._measured_m = -math.inf  # the tachometer at the last fix that measured the wheels
        # What tags said, the newest last; and the bounds before a position fault for which they alone spoke.
        self._read: Final[deque[FrontAtCount]] = deque(maxlen=2 * together + 2)
        self._before: FrontAtCount | None = None
        self._doubted = 0  # read since the last that was believed
        forget_axles(row)

    @property
    def row(self) -> UnitRow:
        """The unit's row that it sets."""
        return self._row

    def position_told(self) -> None:
        """The crew has told where the train stands, or that the unit has just started."""
        forget_axles(self._row)
        self._read.clear()
        self._told.clear()
        self._before = None
        self._wide = False
        self._wheel.forget_places()
        self._wheel.apply(self._row.odometer_scale)

    def leave_path(self, *, turned: bool) -> list[FrontAtCount]:
        """What tags said, as intervals about the front, or about the rear where the train has `turned`; m."""
        row = self._row
        kept: list[FrontAtCount] = []
        for low_m, high_m in (self._now(one) for one in self._read):
            behind_m, ahead_m = row.position_m - low_m, high_m - row.position_m
            kept.append(
                front_interval(row, -ahead_m, behind_m) if turned else front_interval(row, -behind_m, ahead_m)
            )
        return kept

    def new_path(self, tags: tuple[PathTag, ...], kept: Sequence[FrontAtCount] = ()) -> None:
        """Another mission, from where the train stands: coordinates are those of its path."""
        here_m = self._row.position_m
        self._tags = tags
        self._anchor_m = here_m
        self._last = self._suspect = None
        self._read.clear()
        self._read.extend(one._replace(low_m=one.low_m + here_m, high_m=one.high_m + here_m) for one in kept)
        self._before = None
        self._told.clear()
        self._wheel.forget_places()

    def begin_doubt(self, wheels: Wheels = Wheels.DOUBTED) -> None:
        """A position fault: what was run since the last tag, or since the mission began, may be false.

        Where the wheels are sound it is the tag that is false, or the place: bounds grow as before.
        """
        row, share = self._row, self._parameters.doubt_error_share
        if wheels is Wheels.FALSE:
            self._before = None
        elif row.position_known and self._parameters.tags_wrong_together:
            self._before = front_interval(row, *bounds_of(row))
        elif self._read:  # a tag was read since the fault before: one of the two is right
            self._before = self._read[-1]
        self._doubting = self._doubting or bool(row.position_known)
        self._doubted = 0
        self._read.clear()
        self._last = self._suspect = None
        if wheels is Wheels.SOUND:
            return
        if row.position_known:
            since_m = max(row.position_m - self._right_at_m, 0.0)
            row.bound_ahead_m += share * since_m
            row.bound_behind_m += share * since_m
        if wheels is Wheels.FALSE:
            self._known = None
            self._told.clear()
        elif not self._wide:
            self._known = self._wheel.worth
            # A way that began before the last would say less of what has been run since.
            while len(self._told) > 1:
                self._told.popleft()
        self._wide = True
        self._wheel.forget()
        row.bound_growth = share

    def wheels_by_tag(self, tag: PathTag, odometer_m: float) -> Wheels:
        """What a tag read where none can be says of the wheels.

        They are doubted where they could be wrong enough, since an absolute sensor last told the position, for the
        tag to be right.
        """
        low_m, high_m = self._since_fix_m()
        fix = tag_fix(self._record, tag.position_m, odometer_m, self._parameters.tag_accuracy_m)
        explains = fix.position_m - fix.behind_m <= high_m and fix.position_m + fix.ahead_m >= low_m
        return Wheels.DOUBTED if explains else Wheels.SOUND

    def wheels_by_overdue(self, expected_m: float) -> Wheels:
        """The same of a tag (path coordinate, m) that was not read: whether the front may be short of it."""
        return Wheels.SOUND if self._since_fix_m()[0] > expected_m else Wheels.DOUBTED

    def _since_fix_m(self) -> tuple[float, float]:
        """Where the front is by the last fix of an absolute sensor (m), had the wheels been out of order since."""
        row, share = self._row, self._parameters.doubt_error_share
        if not math.isfinite(row.fix_at_m) or row.missed_fixes or not self._read:
            return -math.inf, math.inf
        fix = self._read[-1]._replace(
            low_m=row.fix_low_m, high_m=row.fix_high_m, odometer_m=row.fix_odometer_m
        )
        return carried_interval(row, fix, Scales(row.odometer_scale - share, row.odometer_scale + share))

    def release_margin_m(self, *, standing: bool) -> float:
        """How much a tachometer out of order may have shown too much since the last tag, m: nothing is freed on it.

        None for a train that `standing` at a mark: its driver sees where it is.
        """
        since_m = 0.0 if standing else max(self._row.position_m - self._right_at_m, 0.0)
        return self._parameters.doubt_error_share * since_m

    @property
    def _right_at_m(self) -> float:
        """Path coordinate where a tag, or a fix of an absolute sensor, last told the position."""
        return max(self._anchor_m, float(self._row.fix_at_m))

    def release_trigger_m(self, end_m: float, length_m: float) -> float:
        """Where the safe rear (m) must be for a section that ends at `end_m` to be freed, by `release_margin_m`."""
        row, share = self._row, self._parameters.doubt_error_share
        front_m = end_m + length_m + row.bound_behind_m
        beyond_m = max(front_m - self._right_at_m, 0.0)
        return end_m + share * beyond_m / (1.0 - share)

    def believes(self, tag: PathTag, odometer_m: float) -> bool:
        """Whether a tag read at this tachometer reading (m) may fix the position; if not, it is remembered."""
        row, accuracy_m = self._row, self._parameters.tag_accuracy_m
        if row.position_known:
            return self._fits(tag, odometer_m)
        if not self._doubting:
            return True
        estimate_m = row.position_m - (row.odometer_m - odometer_m) * row.odometer_scale
        low_m = estimate_m - row.bound_behind_m - accuracy_m
        high_m = estimate_m + row.bound_ahead_m + accuracy_m
        possible = [other for other in self._tags if low_m <= other.position_m <= high_m]
        agrees = self._suspect is not None and self._agree(self._suspect, tag, odometer_m)
        self._doubting = not (possible == [tag] or agrees)
        self._suspect = (tag, odometer_m) if self._doubting else None
        return not self._doubting

    def tag_read(self, tag: PathTag, odometer_m: float) -> tuple[TagOutcome, float]:
        """A tag was read when the tachometer stood at `odometer_m`: position, bounds and wheels by it.

        Returns what came of it, and by how much it moved the estimate, m.
        """
        row, record = self._row, self._record
        fix = tag_fix(record, tag.position_m, odometer_m, self._parameters.tag_accuracy_m)
        if missed_by_m(record, fix) > 0.0:
            return TagOutcome.OUT, 0.0
        believed, span_m = self.believes(tag, odometer_m), self.span_m(fix)
        if not believed:
            if row.position_known:
                bring_within(row, *span_m)
            self._doubted += 1
            self.remember_fix(fix)
            return TagOutcome.DOUBTED, 0.0
        self._place_told(front_interval(row, fix.position_m - fix.behind_m, fix.position_m + fix.ahead_m))
        self.believe_tag(tag, odometer_m)
        self._doubted = 0
        taken = take_interval(record, fix, span_m)
        self.remember_fix(fix)
        return TagOutcome.BELIEVED, taken.correction_m if isinstance(taken, TakenFix) else 0.0

    def span_m(self, fix: Fix) -> tuple[float, float]:
        """What the bounds are to span after this tag's fix, which meets them, m: see above."""
        row, together = self._row, self._parameters.tags_wrong_together
        low_m, high_m = fix.position_m - fix.behind_m, fix.position_m + fix.ahead_m
        if not together:
            return low_m, high_m
        earlier = [self._now(one) for one in self._read]
        if self._before is not None:
            earlier.insert(0, carried_interval(row, self._before, self._wheel.scales))
        least_m, most_m = bounds_of(row) if row.position_known else (-math.inf, math.inf)
        if row.position_known and len(earlier) < together:
            earlier.append((least_m, most_m))
        for lower_m, upper_m in earlier[-together:]:
            if lower_m <= most_m and upper_m >= least_m:
                low_m, high_m = min(low_m, max(lower_m, least_m)), max(high_m, min(upper_m, most_m))
        return low_m, high_m

    def believe_tag(self, tag: PathTag, odometer_m: float) -> None:
        """A tag is believed: calibrate the tachometer over the way since the last one."""
        row, parameters = self._row, self._parameters
        scale = row.odometer_scale
        if self._last is not None and row.position_known:
            scale = calibrated_scale(
                scale,
                tag.position_m - self._last[0].position_m,
                odometer_m - self._last[1],
                parameters.wheel_scale_limit,
                parameters.tag_accuracy_m,
            )
        if self._last is not None and self._agree(self._last, tag, odometer_m):
            self._wide = False
        row.odometer_scale = scale
        if not self._wide:
            self._wheel.apply(scale)
        self._last = (tag, odometer_m)
        self._anchor_m = tag.position_m

    def remember_fix(self, fix: Fix) -> None:
        """A tag was read, believed or not, and the bounds have taken it up."""
        row = self._row
        self._read.append(front_interval(row, fix.position_m - fix.behind_m, fix.position_m + fix.ahead_m))
        if self._before is not None and len(self._read) >= self._parameters.tags_wrong_together:
            self._before = None
        if row.position_known and not self._wide:
            self._wheel.tag_read(self._read[-1])
            self._wheel.learn(front_interval(row, *bounds_of(row)))
            self._wheel.apply(row.odometer_scale)

    def _now(self, one: FrontAtCount) -> tuple[float, float]:
        """Where the front is by what a tag said then, m; were the wheels out of order, the newest tag would be true."""
        return carried_interval(self._row, one, self._wheel.scales)

    def _fits(self, tag: PathTag, odometer_m: float) -> bool:
        """Whether the last tag believed, or one doubted since, agrees with this one as far as the wheels are known."""
        if not self._parameters.tags_wrong_together or not self._read:
            return True
        fix = tag_fix(self._record, tag.position_m, odometer_m, self._parameters.tag_accuracy_m)
        low_m, high_m = fix.position_m - fix.behind_m, fix.position_m + fix.ahead_m
        share, scale = self._parameters.doubt_error_share, self._row.odometer_scale
        scales = Scales(scale - share, scale + share) if self._wide else self._wheel.scales
        earlier = (carried_interval(self._row, one, scales) for one in list(self._read)[-1 - self._doubted :])
        return any(lower_m <= high_m and upper_m >= low_m for lower_m, upper_m in earlier)

    def watch(self) -> None:
        """Have the tick report the next fix of an absolute sensor that lies far enough on to measure the wheels."""
        self._row.place_trigger_m = float(self._row.sure_m) + LEARNED_OVER_M

    def fix_came(self) -> None:
        """An absolute sensor has told where the front is: what that says of the wheels."""
        row = self._row
        here = narrowest(row)
        tells_over_m = (here.high_m - here.low_m) / self._parameters.wheel_error_share
        if here.odometer_m - self._measured_m >= tells_over_m:
            self._measured_m = here.odometer_m
            self._place_told(here)
            if row.position_known and not self._wide:
                self._wheel.learn(here)
                if self._wheel.growth < row.bound_growth:
                    self._wheel.apply(self._wheel.middle)
        self.watch()

    def _place_told(self, here: FrontAtCount) -> None:
        """A tag believed or a fix has the front here: wheels in doubt are believed again if places before it say so."""
        scales = self._wheel.scales if self._known is None else self._wheel.varied(self._known)
        if self._wide and any(self._answers(way_between(before, here), scales) for before in self._told):
            self._wide = False
            if self._known is not None:
                self._wheel.recall(self._known)
            self._wheel.apply(self._row.odometer_scale)
        self._told.append(here)

    def _answers(self, way: Scales, scales: Scales) -> bool:
        """Whether a way tells what wheels are worth as finely as that is stated, and it is within these scales."""
        fine = way.high - way.low <= 2.0 * self._parameters.wheel_error_share
        return fine and way.low <= scales.high and way.high >= scales.low

    def _agree(self, before: tuple[PathTag, float], tag: PathTag, odometer_m: float) -> bool:
        """Whether the way between two tags is as the tachometer says, within what wheels wear."""
        parameters = self._parameters
        run_m = tag.position_m - before[0].position_m
        error_m = abs((odometer_m - before[1]) * self._row.odometer_scale - run_m)
        return run_m > 0.0 and error_m <= parameters.wheel_error_share * run_m + parameters.tag_accuracy_m
