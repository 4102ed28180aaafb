"""How far tags and tachometer are to be believed: calibration while they agree, doubt after a position fault.

Invariant: after a position fault a tag fixes the position again only if no other tag can be meant, counting all
that the tachometer may be wrong, or if it agrees with the tag read before it. Tags that were swapped, or lie about
themselves, would else give a false position to a unit that has none (地上子位置との照合, Sugiyama, table 5).
The bounds stay wide until the way between two tags is as the tachometer says.
"""

from __future__ import annotations

from typing import Final

from onboard.duty.mission import PathTag
from onboard.localisation.fix import Fix, FixSource
from onboard.localisation.tachometer import calibrated_scale
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
    """What a tag at path coordinate `tag_m` says, read when the tachometer stood at `odometer_at_tag_m`."""
    position_m, bound_m = front_by_tag(row, tag_m, odometer_at_tag_m, accuracy_m)
    return Fix(float(position_m), float(bound_m), float(bound_m), FixSource.TAG)


class TagDoubt:
    """What one unit remembers of the tags it has read; reads and sets localisation in its row."""

    def __init__(self, row: UnitRow, parameters: UnitParameters) -> None:
        self._row: Final = row
        self._parameters: Final = parameters
        self._tags: tuple[PathTag, ...] = ()
        self._last: tuple[PathTag, float] | None = None  # the last tag believed, and the tachometer there, m
        self._suspect: tuple[PathTag, float] | None = None  # one read in doubt
        self._doubting = False
        self._anchor_m = 0.0  # path coordinate where the tachometer was last known to be right

    def new_path(self, tags: tuple[PathTag, ...]) -> None:
        """Another mission, from where the train stands: coordinates are those of its path."""
        self._tags = tags
        self._anchor_m = self._row.position_m
        self._last = self._suspect = None

    def begin(self) -> None:
        """A position fault: what was run since the last tag, or since the mission began, may be false."""
        row, share = self._row, self._parameters.doubt_error_share
        if row.position_known:
            since_m = max(row.position_m - self._right_at_m, 0.0)
            row.bound_ahead_m += share * since_m
            row.bound_behind_m += share * since_m
            self._doubting = True
        row.bound_growth = share
        self._last = self._suspect = None

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
        if not self._doubting or row.position_known:
            return True
        estimate_m = row.position_m - (row.odometer_m - odometer_m) * row.odometer_scale
        low_m = estimate_m - row.bound_behind_m - accuracy_m
        high_m = estimate_m + row.bound_ahead_m + accuracy_m
        possible = [other for other in self._tags if low_m <= other.position_m <= high_m]
        agrees = self._suspect is not None and self._agree(self._suspect, tag, odometer_m)
        self._doubting = not (possible == [tag] or agrees)
        self._suspect = (tag, odometer_m) if self._doubting else None
        return not self._doubting

    def take(self, tag: PathTag, odometer_m: float) -> None:
        """A tag is believed: calibrate the tachometer over the way since the last one."""
        row, parameters = self._row, self._parameters
        if self._last is not None and row.position_known:
            row.odometer_scale = calibrated_scale(
                row.odometer_scale,
                tag.position_m - self._last[0].position_m,
                odometer_m - self._last[1],
                parameters.wheel_scale_limit,
                parameters.tag_accuracy_m,
            )
        if self._last is not None and self._agree(self._last, tag, odometer_m):
            row.bound_growth = parameters.wheel_error_share
        self._last = (tag, odometer_m)
        self._anchor_m = tag.position_m

    def _agree(self, before: tuple[PathTag, float], tag: PathTag, odometer_m: float) -> bool:
        """Whether the way between two tags is as the tachometer says, within what wheels wear."""
        parameters = self._parameters
        run_m = tag.position_m - before[0].position_m
        error_m = abs((odometer_m - before[1]) * self._row.odometer_scale - run_m)
        return run_m > 0.0 and error_m <= parameters.wheel_error_share * run_m + parameters.tag_accuracy_m
