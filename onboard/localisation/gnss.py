"""The satellite receiver (GNSS): an interval for the train's front from fixes projected onto the path.

Invariant: as long as the receiver errs as stated below, the interval made here contains the front.

Possible errors and their effect (P is the protection level that the receiver states):
- A fix under an open sky errs by no more than P / 4, and with part of the sky hidden by no more than P, unless there
  is a fault.
- A fix with part of the sky hidden only moves the estimate inside the bounds, because reflections are most likely
  there and few satellites reveal them. The same holds for a fix that is not confirmed by `BORNE_OUT` fixes before it.
- A growing fault moves the fixes against the wheels. Within a window they may move by P / 4, by the error of wheels
  (`DRIFT_SHARE`; a window ends where that reaches P / 8), and by slides and slips. A greater movement is an error of
  the receiver, now or before: the interval spans it from then on, until it moves back; on another path its direction
  is no longer known. So a fault that grows by more than 3 % of the distance run is covered: at most 3 P / 8 of it may
  hide at the edges of two windows each, besides the P / 4.
- While wheels slide or slip, a fault may move the fixes by as much in the other direction, unseen. So everything that
  may have slid is in the interval too, ahead of the fix, as in the bounds; everything that slipped, behind it. The
  part of a movement that only a slide or slip explains shifts that allowance: it was one, or an error that appeared
  after it.
- Without a fix under an open sky for more than half a window nothing is compared, and the wheels' error adds up. The
  distance between the fixes on both sides of such a gap is the distance run plus the growth of an error: the part that
  the wheels, as they are known now, do not explain is in the interval. So knowing them better later makes it narrower.
  Of several gaps the greatest counts, until bounds have shown the error: one error appears in one of them.
- Bounds contain the front, whatever made them. A fix further from them than P / 4 plus the known error shows that the
  receiver is wrong, also at the first fix, and the interval spans that error. A nearer one shows how great the error
  can still be: narrow bounds confirm a receiver, and remove what slides had added.
- A receiver that has shown nothing under an open sky for `LOST_S` when a path begins, or the unit, is compared with
  nothing by its first fix there: it may lie by all that the bounds leave then.
- Not covered: a fault that grows by less than 3 % of the distance while bounds are too wide to show it; several faults
  in succession that are too small to be seen. What leaves the bounds is refused by the one rule of fixes.
- A wrong time tag shifts fixes by the speed; it shows, like any other fault, where the speed changes.
- A unit that was switched off does not know what its train has run meanwhile: a fix taken before it was on again is no
  use, and the receiver counts as lost. What is known of its error stays.

A unit without a position takes the interval of a receiver that `FIRST_FIXES` open-sky fixes have confirmed.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

import numpy as np

from onboard.localisation.fix import (
    FIX_MISSED,
    MISSED,
    NOTHING,
    REFUSED,
    TAKEN,
    fix_by_rule,
    missed_m,
    move_estimate,
)
from onboard.records import Chart, UnitRow
from vehicle.compiled import compiled, compiled_when_called

RING: Final = 64  # ticks of which it keeps the way run: more than the oldest fix needs
OLDEST_S: Final = 6.0  # a fix that says it is older is of no use
STEADY_SHARE: Final = 0.25  # of the protection level, by which fixes that err as stated move within a window
WHEELS_SHARE: Final = 0.125  # of it, by which the wheels may be wrong within a window
DRIFT_SHARE: Final = 0.01  # assumed: wheels known to three of their sigma; only suspicion rests on it
GAP_SHARE_MAX: Final = (
    2.0 * DRIFT_SHARE
)  # by which wheels are taken to be wrong in a gap, even while they are doubted
WINDOW_S: Final = 60.0
BORNE_OUT: Final = 5  # fixes in a row that agree, before one cuts the bounds
FIRST_FIXES: Final = 10  # before one gives a unit its position
LOST_S: Final = 10.0  # without a fix, and the receiver counts as lost; of what it shows next nothing is known
HIDDEN_SHARE: Final = (
    0.75  # of the protection level: what it leaves, beside errors as stated, for lies not seen
)


class GnssReading(Protocol):
    """What the receiver shows, put onto the path."""

    taken: Annotated[int, "1: a fix has come in this step"]
    position_m: Annotated[float, "path coordinate of the front when the fix was taken"]
    age_s: Annotated[float, "how long that is ago, by its time tag"]
    protection_m: Annotated[float, "its own statement of what it may err by along the track"]
    open_sky: Annotated[int, "1: it saw all satellites that should be in sight"]


class GnssRow(Protocol):
    """What the unit keeps of its receiver."""

    path: Annotated[int, "which path the coordinates are of"]
    boots: Annotated[int, "how often the unit had been switched on"]
    ticks: Annotated[int, "since it was"]
    odometer_m: Annotated[float, "the tachometer a tick ago"]
    way_m: Annotated[float, "run by the wheels, as calibrated, since the unit began"]
    slid_m: Annotated[float, "by how much it may be short since then, since wheels slid"]
    slipped_m: Annotated[float, "by how much it may be too long, since they slipped"]
    way_then_m: Annotated[list[float], RING]
    doubt_then_m: Annotated[list[float], RING, "what had slid or slipped by then"]
    heard: Annotated[int, "1: it has had a fix"]
    silent_s: Annotated[float, "since the last one"]
    agreeing: Annotated[int, "fixes under an open sky that did not move against the wheels, in a row"]
    unproven: Annotated[int, "1: nothing that it showed before the window tells of its lie"]
    open_ticks: Annotated[int, "the tick of the last fix under an open sky; 0: there was none"]
    open_at_m: Annotated[float, "the last fix under an open sky"]
    open_way_m: Annotated[float, "the way there"]
    open_odometer_m: Annotated[float, "the tachometer there"]
    gap_counted_m: Annotated[float, "what the tachometer counted in the longest gap without one"]
    gap_least_m: Annotated[float, "the fixes have gone on over it by no less, beside what moves as stated"]
    gap_most_m: Annotated[float, "and no more"]
    gap_low_m: Annotated[float, "a lie that came up in another gap is no less"]
    gap_high_m: Annotated[float, "and no more"]
    offset_m: Annotated[float, "a fix less the way, at the window's beginning"]
    window_way_m: Annotated[float, "the way there"]
    window_slid_m: float
    window_slipped_m: float
    window_beyond_m: Annotated[
        float, "by how much only what slid (positive) or slipped explains that fixes have moved since"
    ]
    window_s: Annotated[float, "how long ago that is; negative: there is no window"]
    moved_low_m: Annotated[float, "its lie is no less, as it has moved against the wheels, or may have"]
    moved_high_m: Annotated[float, "and no more"]
    shown_low_m: Annotated[float, "its lie is no less, as bounds have shown that it is no other"]
    shown_high_m: Annotated[float, "and no more"]
    forgives: Annotated[
        int, "1: what may hide in slides and gaps is not in the interval; for experiments alone"
    ]
    slack_m: Annotated[float, "what the estimate may be wrong by if all that it leans on was true"]
    bounds_m: Annotated[float, "half of what the bounds spanned at the last tick"]


@compiled
def keep_way(own: GnssRow, unit: UnitRow, step_s: float) -> None:
    """Count the way of this tick, and what widens the bounds; what cuts them has set the estimate anew."""
    if own.boots != unit.boots:
        own.boots, own.ticks, own.open_ticks, own.unproven = unit.boots, 0, 0, 1
        own.slid_m, own.slipped_m = unit.slid_ahead_m, unit.slipped_behind_m
    run_m = (unit.odometer_m - own.odometer_m) * unit.odometer_scale if own.ticks > 0 else 0.0
    own.odometer_m = unit.odometer_m
    own.way_m += run_m
    if own.heard != 0 and own.forgives == 0:
        may_lie(own, own.slid_m - unit.slid_ahead_m, unit.slipped_behind_m - own.slipped_m)
    own.slid_m, own.slipped_m = unit.slid_ahead_m, unit.slipped_behind_m
    own.ticks += 1
    own.way_then_m[own.ticks % RING], own.doubt_then_m[own.ticks % RING] = (
        own.way_m,
        own.slid_m + own.slipped_m,
    )
    half_m = (unit.bound_ahead_m + unit.bound_behind_m) / 2.0
    wider_m = half_m - own.bounds_m
    own.slack_m = half_m if wider_m < 0.0 else min(own.slack_m + wider_m, half_m)
    own.bounds_m = half_m
    own.silent_s += step_s
    if own.window_s >= 0.0:
        own.window_s += step_s
    if own.path != unit.paths_taken_up or own.ticks == 1:
        own.path, own.window_s, own.agreeing = unit.paths_taken_up, -1.0, 0
        least_m, most_m = lie_m(own, unit)
        either_m = max(-least_m, most_m)  # on another path it may point the other way
        forget_gaps(own)
        own.moved_low_m, own.moved_high_m = -either_m, either_m
        own.shown_low_m = own.shown_high_m = 0.0


@compiled
def may_lie(own: GnssRow, less_m: float, more_m: float) -> None:
    """The lie may be another now: by `less_m` at least and `more_m` at most."""
    own.moved_low_m += less_m
    own.moved_high_m += more_m
    own.shown_low_m += less_m
    own.shown_high_m += more_m


@compiled
def lie_m(own: GnssRow, unit: UnitRow) -> tuple[float, float]:
    """What the fixes are wrong by at least and at most (m), errors as stated apart: now, or only before."""
    low_m, high_m = hidden_in_gaps_m(own, unit)
    return (
        min(own.moved_low_m, own.shown_low_m, 0.0) + low_m,
        max(own.moved_high_m, own.shown_high_m, 0.0) + high_m,
    )


@compiled
def hidden_in_gaps_m(own: GnssRow, unit: UnitRow) -> tuple[float, float]:
    """What a lie that came up in a gap is at least and at most (m), by what is known of the wheels now."""
    low_m, high_m = unseen_m(own.gap_least_m, own.gap_most_m, own.gap_counted_m, unit)
    return min(own.gap_low_m, low_m), max(own.gap_high_m, high_m)


@compiled
def unseen_m(least_m: float, most_m: float, counted_m: float, unit: UnitRow) -> tuple[float, float]:
    """What the wheels leave of fixes that went on by that while the tachometer counted so much, m; 0 is between."""
    within = min(unit.bound_growth, GAP_SHARE_MAX)
    low_m = least_m - counted_m * (unit.odometer_scale + within)
    return min(low_m, 0.0), max(most_m - counted_m * (unit.odometer_scale - within), 0.0)


@compiled
def forget_gaps(own: GnssRow) -> None:
    """Nothing is hidden in a gap, or it is counted elsewhere."""
    own.gap_counted_m = own.gap_least_m = own.gap_most_m = own.gap_low_m = own.gap_high_m = 0.0


@compiled
def front_by_fix(own: GnssRow, reading: GnssReading, unit: UnitRow, step_s: float) -> tuple[float, float]:
    """Where the front is now (m) by a fix and the way since, and what wheels may be wrong by since (m)."""
    back = min(int(reading.age_s / step_s + 0.5), own.ticks - 1, RING - 1)
    then = (own.ticks - back) % RING
    since_m = own.way_m - own.way_then_m[then]
    doubt_m = own.slid_m + own.slipped_m - own.doubt_then_m[then]
    wheels_m = abs(since_m) * unit.bound_growth + doubt_m + unit.pulse_m + 0.5 * step_s * abs(unit.speed_mps)
    return reading.position_m + since_m, wheels_m


@compiled
def keep_gap(own: GnssRow, unit: UnitRow, at_m: float, protection_m: float, counted_m: float) -> None:
    """Keep what a lie may be that came up since the last fix under an open sky, beside `counted_m` of it; m.

    Nothing in half a window. Of what fixes moved there the lie's interval has room for all but 3 P / 8 already.
    """
    if DRIFT_SHARE * abs(own.way_m - own.open_way_m) <= 0.5 * WHEELS_SHARE * protection_m:
        return
    run_m, room_m = own.odometer_m - own.open_odometer_m, (STEADY_SHARE + WHEELS_SHARE) * protection_m
    on_m = at_m - own.open_at_m - counted_m
    longer = run_m > own.gap_counted_m
    if longer:
        own.gap_low_m, own.gap_high_m = hidden_in_gaps_m(own, unit)
        own.gap_counted_m, own.gap_least_m, own.gap_most_m = run_m, on_m + room_m, on_m - room_m
    else:
        low_m, high_m = unseen_m(on_m + room_m, on_m - room_m, run_m, unit)
        own.gap_low_m, own.gap_high_m = min(own.gap_low_m, low_m), max(own.gap_high_m, high_m)


@compiled
def bears_out(own: GnssRow, unit: UnitRow, at_m: float, protection_m: float) -> bool:
    """Whether a fix under an open sky has moved against the wheels by no more than it may; keeps the window."""
    offset_m = at_m - own.way_m
    if own.window_s < 0.0:
        begin_window(own, offset_m)
        own.agreeing = 1
        return True
    moved_m = offset_m - own.offset_m
    wheels_m = DRIFT_SHARE * abs(own.way_m - own.window_way_m)
    steady_m = STEADY_SHARE * protection_m + wheels_m
    most_m = steady_m + own.slid_m - own.window_slid_m
    least_m = -(steady_m + own.slipped_m - own.window_slipped_m)
    if not least_m <= moved_m <= most_m:
        more_m = moved_m - own.window_beyond_m
        may_lie(own, more_m - wheels_m, more_m + wheels_m)
        if own.forgives == 0:
            keep_gap(own, unit, at_m, protection_m, more_m)
        own.agreeing = 0
        begin_window(own, offset_m)
        return False
    if own.forgives == 0:  # what the slide explains may be a lie that came up after it
        beyond_m = moved_m - min(max(moved_m, -steady_m), steady_m)
        more_m = beyond_m - own.window_beyond_m
        may_lie(own, more_m, more_m)
        keep_gap(own, unit, at_m, protection_m, more_m)
        own.window_beyond_m = beyond_m
    own.agreeing += 1
    if wheels_m > WHEELS_SHARE * protection_m or own.window_s > WINDOW_S:
        begin_window(own, offset_m)
    return True


@compiled
def begin_window(own: GnssRow, offset_m: float) -> None:
    """From here on the next fixes are compared with this one."""
    own.offset_m, own.window_s = offset_m, 0.0
    own.window_beyond_m = 0.0
    own.window_way_m, own.window_slid_m, own.window_slipped_m = own.way_m, own.slid_m, own.slipped_m


@compiled
def measure_lie(own: GnssRow, unit: UnitRow, at_m: float, wheels_m: float, protection_m: float) -> bool:
    """Keep what the bounds, which hold the front, leave of the lie; whether the fix meets them as far as it is known.

    Where they leave nothing of it they show another; where what they leave is too small to matter there is none.
    """
    steady_m, hidden_m = STEADY_SHARE * protection_m + wheels_m, HIDDEN_SHARE * protection_m
    low_m = at_m - (unit.position_m + unit.bound_ahead_m) - steady_m
    high_m = at_m - (unit.position_m - unit.bound_behind_m) + steady_m
    gap_low_m, gap_high_m = hidden_in_gaps_m(own, unit)
    least_m, most_m = min(own.moved_low_m, 0.0) + gap_low_m, max(own.moved_high_m, 0.0) + gap_high_m
    meets = low_m <= most_m + hidden_m and high_m >= least_m - hidden_m
    if own.unproven != 0 and meets and own.forgives == 0:
        own.moved_low_m, own.moved_high_m = min(own.moved_low_m, low_m), max(own.moved_high_m, high_m)
    own.unproven = 0
    least_m, most_m = lie_m(own, unit)
    if low_m > least_m or high_m < most_m:
        may_lie(own, gap_low_m, gap_high_m)
        forget_gaps(own)
    if low_m > most_m or high_m < least_m:
        own.shown_low_m, own.shown_high_m = low_m, high_m
    elif -hidden_m <= low_m and high_m <= hidden_m:
        own.moved_low_m = own.moved_high_m = own.shown_low_m = own.shown_high_m = 0.0
        forget_gaps(own)
    else:
        own.shown_low_m = min(max(own.shown_low_m, low_m), high_m)
        own.shown_high_m = min(max(own.shown_high_m, low_m), high_m)
        if meets:
            own.moved_low_m = min(max(own.moved_low_m, low_m), high_m)
            own.moved_high_m = min(max(own.moved_high_m, low_m), high_m)
    return bool(meets)


@compiled
def outcome_of(own: GnssRow, unit: UnitRow, protection_m: float) -> int:
    """What came of a fix that was used: nothing new while the receiver is under suspicion."""
    least_m, most_m = lie_m(own, unit)
    return TAKEN if max(most_m, -least_m) <= STEADY_SHARE * protection_m else NOTHING


@compiled
def move_by_fix(own: GnssRow, unit: UnitRow, at_m: float, within_m: float, protection_m: float) -> int:
    """Lean the estimate on a fix that may not cut; one that misses the bounds is passed over."""
    if unit.position_known == 0 or not missed_m(unit, at_m, within_m, within_m) <= 0.0:
        return NOTHING
    if abs(at_m - unit.position_m) > own.slack_m + within_m:
        return NOTHING
    own.slack_m = move_estimate(unit, own.slack_m, at_m, within_m)
    return outcome_of(own, unit, protection_m)


@compiled_when_called
def use_fix(own: GnssRow, reading: GnssReading, unit: UnitRow, step_s: float) -> int:
    """A fix that is sound: it cuts the bounds under an open sky once borne out, else it leans the estimate."""
    at_m, wheels_m = front_by_fix(own, reading, unit, step_s)
    protection_m, sky_open = reading.protection_m, reading.open_sky != 0
    if sky_open and own.window_s < 0.0 and (own.ticks - own.open_ticks) * step_s > LOST_S:
        own.unproven = 1
    borne_out = not sky_open or bears_out(own, unit, at_m, protection_m)
    if sky_open:
        own.open_ticks = own.ticks
        own.open_at_m, own.open_way_m, own.open_odometer_m = at_m, own.way_m, own.odometer_m
    if not borne_out:
        return REFUSED
    meets = not sky_open or unit.position_known == 0 or measure_lie(own, unit, at_m, wheels_m, protection_m)
    least_m, most_m = lie_m(own, unit)
    within_m = protection_m + wheels_m
    if not sky_open or own.agreeing < (BORNE_OUT if unit.position_known == 1 else FIRST_FIXES):
        return move_by_fix(own, unit, at_m, within_m + max(most_m, -least_m), protection_m)
    if not meets:
        unit.fix_came = FIX_MISSED
        return REFUSED
    came = fix_by_rule(unit, at_m, within_m + most_m, within_m - least_m)
    own.unproven = 0  # a unit without a position takes it on trust
    return outcome_of(own, unit, protection_m) if came == TAKEN else REFUSED


@compiled
def gnss(own: GnssRow, reading: GnssReading, unit: UnitRow, _chart: Chart, step_s: float) -> int:
    """Use a fix that has come; without any for some time the receiver is missed."""
    keep_way(own, unit, step_s)
    if reading.taken == 0:
        if own.heard == 0 or own.silent_s < LOST_S:
            return NOTHING
        own.agreeing = 0
        return MISSED
    own.heard, own.silent_s = 1, 0.0
    sound = np.isfinite(reading.position_m) and reading.protection_m > 0.0
    if not (sound and 0.0 <= reading.age_s <= OLDEST_S):
        return REFUSED
    if own.boots > 0 and int(reading.age_s / step_s + 0.5) >= own.ticks:
        return NOTHING
    return use_fix(own, reading, unit, step_s)
