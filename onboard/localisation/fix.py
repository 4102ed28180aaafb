"""One rule for every fix of the position, whatever sensor it comes from.

Invariant: where two intervals both contain the true front, their intersection contains it too. A fix whose interval
does not overlap the bounds is refused, because one of the two is wrong and nobody knows which. A unit without a
position takes the fix as it is.

To `cut` the bounds is to narrow them to their intersection with the fix's interval. The new estimate lies between the
old one and the fix, weighted by the inverse squares of their greatest errors, inside the new bounds. Readers of
`onboard.localisation.table` do this by `taken` in the compiled tick, event-driven ones by `take`. A tag may be wrong,
and so may the tachometer since the tag before, unnoticed: after a tag the bounds span it and what the tags before it
say (`onboard.localisation.tags`). A sensor that can be deceived (a camera) only moves the estimate inside the bounds
(`leant`). The bounds stay as they are, so safety never depends on such a sensor.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Final, NamedTuple

import numpy as np

from onboard.records import EVENT_CONTRADICTED, EVENT_PLACE, UnitRow
from vehicle.compiled import compiled

# what came of a reading, as a reader of the table tells
NOTHING: Final = 0  # it says nothing now
TAKEN: Final = 1
REFUSED: Final = 2
MISSED: Final = 3  # what should have shown itself by now has not
FOREIGN: Final = 4  # what it sees is not what the map has here
OUTCOMES: Final = ("nothing", "taken", "refused", "missed", "foreign")  # the words for them

FIX_CUT: Final = 1  # unit.fix_came
FIX_MISSED: Final = 2
MISSED_MAX: Final = 3  # in a row: one reading may be wrong, three say that the bounds are
STRONGEST_WEIGHT: Final = 1.0  # of a fix that meets an estimate which says nothing


class FixSource(StrEnum):
    """What a fix comes from."""

    TAG = "tag"


class Fix(NamedTuple):
    """Where the front is now by one reading: path coordinate, and how far behind and ahead of it it may be, m."""

    position_m: float
    behind_m: float
    ahead_m: float
    source: FixSource


@dataclass(frozen=True, slots=True)
class TakenFix:
    """The fix holds; it moved the estimate by `correction_m` (0 where there was none)."""

    correction_m: float


@dataclass(frozen=True, slots=True)
class RefusedFix:
    """The fix was not believed, and why."""

    why: str


@compiled
def missed_m(row: UnitRow, position_m: float, behind_m: float, ahead_m: float) -> float:
    """By how much an interval about `position_m` misses the present one, m; not positive where they meet."""
    if row.position_known == 0:
        return 0.0
    below_m = row.position_m - row.bound_behind_m - (position_m + ahead_m)
    above_m = position_m - behind_m - (row.position_m + row.bound_ahead_m)
    return float(max(below_m, above_m))


@compiled
def cut(row: UnitRow, position_m: float, behind_m: float, ahead_m: float) -> float:
    """Cut the present interval with that about `position_m`; returns `missed_m`, the row stays if positive."""
    return float(cut_towards(row, position_m, behind_m, ahead_m, weight_of(row, behind_m, ahead_m)))


@compiled
def weight_of(row: UnitRow, behind_m: float, ahead_m: float) -> float:
    """What share of the way to a fix the estimate moves: by the squares of what both may be wrong by."""
    own_m = (row.bound_ahead_m + row.bound_behind_m) / 2.0
    its_m = (ahead_m + behind_m) / 2.0
    both_m2 = own_m * own_m + its_m * its_m
    return float(own_m * own_m / both_m2) if both_m2 > 0.0 else STRONGEST_WEIGHT


@compiled
def cut_towards(row: UnitRow, position_m: float, behind_m: float, ahead_m: float, weight: float) -> float:
    """`cut`; the estimate moves by that share of the way to `position_m`, inside what is left."""
    if row.position_known == 0:
        row.position_m, row.bound_behind_m, row.bound_ahead_m = position_m, behind_m, ahead_m
        row.position_known = 1
        return 0.0
    away_m = missed_m(row, position_m, behind_m, ahead_m)
    if not away_m <= 0.0:  # what is no number is refused too
        return away_m
    rear_m = max(row.position_m - row.bound_behind_m, position_m - behind_m)
    front_m = min(row.position_m + row.bound_ahead_m, position_m + ahead_m)
    before_m = row.position_m
    estimate_m = min(max(before_m + weight * (position_m - before_m), rear_m), front_m)
    row.position_m = estimate_m
    row.bound_ahead_m = front_m - estimate_m
    row.bound_behind_m = estimate_m - rear_m
    row.fix_correction_m += estimate_m - before_m
    return away_m


@compiled
def taken(row: UnitRow, position_m: float, behind_m: float, ahead_m: float) -> int:
    """A fix from a reader of the table, by the rule; what came of it."""
    return int(taken_towards(row, position_m, behind_m, ahead_m, weight_of(row, behind_m, ahead_m)))


@compiled
def taken_towards(row: UnitRow, position_m: float, behind_m: float, ahead_m: float, weight: float) -> int:
    """The same, with the share of the way to it that the estimate moves, where the reader knows better."""
    if not cut_towards(row, position_m, behind_m, ahead_m, weight) <= 0.0:
        row.fix_came = FIX_MISSED
        return REFUSED
    row.fix_came = FIX_CUT
    row.fix_low_m, row.fix_high_m = position_m - behind_m, position_m + ahead_m
    return TAKEN


@compiled
def trusted(row: UnitRow, position_m: float, behind_m: float, ahead_m: float) -> int:
    """The position is what a reading says, whatever was believed: for methods that know no bounds."""
    if row.position_known != 0:
        row.fix_correction_m += position_m - row.position_m
    row.position_known = 0
    cut(row, position_m, behind_m, ahead_m)
    return TAKEN


@compiled
def keep_narrowest(unit: UnitRow) -> None:
    """Keep the fix just taken to measure the wheels by, unless one before it has the front within less by now."""
    run_m = abs(unit.odometer_m - unit.narrow_odometer_m)
    slid_m = unit.slid_ahead_m - unit.narrow_slid_m + unit.slipped_behind_m - unit.narrow_slipped_m
    kept_m = unit.narrow_high_m - unit.narrow_low_m + 2.0 * unit.bound_growth * run_m + slid_m
    if unit.narrow != 0 and unit.fix_high_m - unit.fix_low_m > kept_m:
        return
    unit.narrow, unit.narrow_low_m, unit.narrow_high_m = 1, unit.fix_low_m, unit.fix_high_m
    unit.narrow_odometer_m = unit.odometer_m
    unit.narrow_slid_m, unit.narrow_slipped_m = unit.slid_ahead_m, unit.slipped_behind_m


@compiled
def told(unit: UnitRow, reader: int) -> int:
    """What a reading of an absolute sensor means for virtual tags; event bits."""
    if unit.fix_came == FIX_CUT:
        unit.missed_fixes = 0
        unit.fix_at_m, unit.fix_odometer_m = unit.position_m, unit.odometer_m
        unit.fix_reader = reader
        unit.sure_m = max(unit.sure_m, unit.fix_low_m)
        keep_narrowest(unit)
        if unit.sure_m >= unit.place_trigger_m:
            unit.place_trigger_m = np.inf
            return EVENT_PLACE
    elif unit.fix_came == FIX_MISSED:
        unit.missed_fixes += 1
        if unit.missed_fixes == MISSED_MAX:
            return EVENT_CONTRADICTED
    return 0


@compiled
def leant(row: UnitRow, slack_m: float, position_m: float, within_m: float) -> float:
    """Move the estimate towards a fix about `position_m` and leave both ends of the bounds where they are.

    `slack_m` and `within_m` say what estimate and fix may be wrong by, m; returns the estimate's afterwards. The two
    intervals must meet: who calls has asked `missed_m`, and whether they do.
    """
    before_m = row.position_m
    rear_m = max(before_m - slack_m, position_m - within_m)
    front_m = min(before_m + slack_m, position_m + within_m)
    both_m2 = slack_m * slack_m + within_m * within_m
    weight = slack_m * slack_m / both_m2 if both_m2 > 0.0 else STRONGEST_WEIGHT
    estimate_m = min(max(before_m + weight * (position_m - before_m), rear_m), front_m)
    least_m, most_m = before_m - row.bound_behind_m, before_m + row.bound_ahead_m
    estimate_m = min(max(estimate_m, least_m), most_m)
    row.position_m = estimate_m
    row.bound_behind_m = estimate_m - least_m
    row.bound_ahead_m = most_m - estimate_m
    row.fix_correction_m += estimate_m - before_m
    return float(max(front_m - estimate_m, estimate_m - rear_m, 0.0))


def missed_by_m(row: UnitRow, fix: Fix) -> float:
    """By how much the fix's interval misses the present one, m; not positive where they meet."""
    return float(missed_m(row, fix.position_m, fix.behind_m, fix.ahead_m))


def within(row: UnitRow, low_m: float, high_m: float) -> None:
    """The front lies in this interval, m, for reasons the row knows nothing of: the estimate only moves into it."""
    estimate_m = min(max(row.position_m, low_m), high_m)
    row.fix_correction_m += estimate_m - row.position_m
    row.position_m = estimate_m
    row.bound_behind_m, row.bound_ahead_m = estimate_m - low_m, high_m - estimate_m


def take(row: UnitRow, fix: Fix, span_m: tuple[float, float] | None = None) -> TakenFix | RefusedFix:
    """Cut the present interval with the fix's; `span_m`: or let the bounds be that, which holds the fix's whole.

    The row is left alone where the fix is refused.
    """
    known, before_m = row.position_known, float(row.position_m)
    away_m = cut(row, fix.position_m, fix.behind_m, fix.ahead_m)
    if not away_m <= 0.0:
        return RefusedFix(f"{fix.source} misses the bounds by {away_m:.3f} m")
    if span_m is not None:
        within(row, *span_m)
    return TakenFix(float(row.position_m) - before_m if known else 0.0)
