"""One rule for every fix of the position, whatever sensor it comes from.

Invariant: an interval that holds the true front, cut with another one that holds it, still does. A fix whose interval
misses the present one is refused: one of the two is wrong, and nobody knows which. A unit without a position takes
the fix as it is.

The new estimate lies between the two, weighted by the squares of what each may be wrong by, inside what is left.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Final, NamedTuple

from onboard.records import UnitRow

STRONGEST_WEIGHT: Final = 1.0  # of a fix that meets an estimate which says nothing


class FixSource(StrEnum):
    """What a fix comes from."""

    TAG = "tag"
    SIGN = "sign"


class Fix(NamedTuple):
    """Where the front is now by one reading: path coordinate, and how far behind and ahead of it it may be, m."""

    position_m: float
    behind_m: float
    ahead_m: float
    source: FixSource


@dataclass(frozen=True, slots=True)
class Taken:
    """The fix holds; it moved the estimate by `correction_m` (0 where there was none)."""

    correction_m: float


@dataclass(frozen=True, slots=True)
class Refused:
    """The fix was not believed, and why."""

    why: str


def missed_by_m(row: UnitRow, fix: Fix) -> float:
    """By how much the fix's interval misses the present one, m; not positive where they meet."""
    if row.position_known == 0:
        return 0.0
    behind_m = row.position_m - row.bound_behind_m - (fix.position_m + fix.ahead_m)
    ahead_m = fix.position_m - fix.behind_m - (row.position_m + row.bound_ahead_m)
    return float(max(behind_m, ahead_m))


def take(row: UnitRow, fix: Fix) -> Taken | Refused:
    """Cut the present interval with the fix's; the row is left alone where the fix is refused."""
    if row.position_known == 0:
        row.position_m, row.bound_behind_m, row.bound_ahead_m = fix.position_m, fix.behind_m, fix.ahead_m
        row.position_known = 1
        return Taken(0.0)
    missed_m = missed_by_m(row, fix)
    if not missed_m <= 0.0:
        return Refused(f"{fix.source} misses the bounds by {missed_m:.3f} m")
    rear_m = max(row.position_m - row.bound_behind_m, fix.position_m - fix.behind_m)
    front_m = min(row.position_m + row.bound_ahead_m, fix.position_m + fix.ahead_m)
    own_m = (row.bound_ahead_m + row.bound_behind_m) / 2.0
    its_m = (fix.ahead_m + fix.behind_m) / 2.0
    both_m2 = own_m**2 + its_m**2
    weight = own_m**2 / both_m2 if both_m2 > 0.0 else STRONGEST_WEIGHT
    before_m = row.position_m
    estimate_m = min(max(before_m + weight * (fix.position_m - before_m), rear_m), front_m)
    row.position_m = estimate_m
    row.bound_ahead_m = front_m - estimate_m
    row.bound_behind_m = estimate_m - rear_m
    row.fix_correction_m += estimate_m - before_m
    return Taken(float(estimate_m - before_m))
