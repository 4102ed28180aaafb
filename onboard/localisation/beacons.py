"""Train-stop beacons (ATS地上子) as fixes of the position, matched by interval and window (Harada, 2.2).

The database has the beacons in use (使用地上子). From a known place on, the unit expects the next one in a
window about its place. Beacons detected before the window are ignored; the first one in it is taken for
the expected one. A window without a beacon is a miss; after `MISSES` in a row localisation by beacons has
failed until the train begins another path. A beacon with a number needs no window.

Invariant (`bounded`): a beacon without a number moves the estimate inside the bounds and never the bounds. It cannot
be distinguished from another one (added, moved, falsely detected; or after wheels slipped), so safety must not depend
on it. A beacon that contradicts the bounds, or the beacons before it, is not taken. A beacon with a number cuts the
bounds: it lies within `placed_within_m` of its place in the database. With `trusts` this is the paper's own method: a
beacon detected in the window sets position and bounds, whatever they were.
"""

from __future__ import annotations

from typing import Annotated, Final, Protocol

from network.files.kinds import about
from network.files.quantities import PositionBound, ShareAbove0
from network.files.toml_input import Record
from onboard.localisation.fix import (
    FOREIGN,
    MISSED,
    NOTHING,
    REFUSED,
    TAKEN,
    fix_by_rule,
    missed_m,
    move_estimate,
    trusted,
)
from onboard.localisation.sighting import carry_slack
from onboard.records import PLACE_BEACON, Chart, UnitRow
from vehicle.compiled import compiled, compiled_when_called

MISSES: Final = 2  # windows in a row without a beacon: localisation has failed (2.3)
NONE: Final = -1


class BeaconReading(Protocol):
    """What the receiver shows."""

    noticed: Annotated[int, "1: a beacon was noticed in this step"]
    odometer_m: Annotated[float, "the tachometer there"]
    told: Annotated[int, "1: it told its number"]
    number: int


class BeaconWindow(Record):
    """Of `[beacons]`, what the unit goes by: where it looks for the next beacon, and how near one is to its place."""

    window_share: Annotated[
        ShareAbove0,
        about(
            "share of the interval in which a beacon is searched, in both directions",
            "Harada, table 1: 40 m of 440",
        ),
    ] = 0.1
    window_least_m: Annotated[
        PositionBound,
        about(
            "least distance in which a beacon is searched, in both directions",
            "Harada, 3.2: some windows can be no wider",
        ),
    ] = 10.0
    accuracy_m: Annotated[
        PositionBound,
        about("half-width of the position's bounds at a detected beacon", "assumed: the receiver's field"),
    ] = 1.0
    placed_within_m: Annotated[
        PositionBound,
        about(
            "greatest distance of a numbered beacon from its place in the database",
            "assumed: kilometrages to the metre; moved beacons are entered in the database",
        ),
    ] = 2.0


class BeaconsRow(Protocol):
    """What the unit keeps of the beacons that it goes by."""

    fitted: Annotated[int, "1: the train has a receiver"]
    trusts: Annotated[int, "1: what is noticed in a window sets the position"]
    settings: BeaconWindow
    path: Annotated[int, "path of these coordinates, counted from 1; 0: none"]
    failed_on: Annotated[int, "the path on which localisation by beacons has failed; 0: none"]
    next: Annotated[int, "row of the unit's places: the next beacon gone by; -1: none ahead"]
    from_m: Annotated[float, "where its interval begins"]
    misses: Annotated[int, "windows in a row without a beacon"]
    slack_m: Annotated[float, "what the estimate may be wrong by if all beacons so far were the right ones"]
    bounds_m: Annotated[float, "half of what the bounds spanned at the last step"]


@compiled
def used_beyond(unit: UnitRow, chart: Chart, first: int, beyond_m: float) -> int:
    """The first beacon gone by, from row `first` of the unit's places on, that lies beyond `beyond_m`."""
    for i in range(first, unit.places_rows):
        place = chart.places[unit.places_offset + i]
        if place.kind == PLACE_BEACON and place.used != 0 and place.position_m > beyond_m:
            return i
    return NONE


@compiled
def used_numbered(unit: UnitRow, chart: Chart, number: int) -> int:
    """The beacon of that number on the path; NONE if the database has none that tells it."""
    for i in range(unit.places_rows):
        place = chart.places[unit.places_offset + i]
        if place.kind == PLACE_BEACON and place.told != 0 and place.number == number:
            return i
    return NONE


@compiled
def half_window_m(own: BeaconsRow, unit: UnitRow, chart: Chart) -> float:
    """How far before and behind its place the next beacon is looked for, m: as the database says, or by the rule."""
    place = chart.places[unit.places_offset + own.next]
    if place.window_m > 0.0:
        return float(place.window_m)
    return float(
        max(own.settings.window_share * (place.position_m - own.from_m), own.settings.window_least_m)
    )


@compiled_when_called
def expect_first(own: BeaconsRow, unit: UnitRow, chart: Chart) -> None:
    """At a known place: the next beacon of the path is due."""
    own.path, own.misses, own.from_m = unit.paths_taken_up, 0, unit.position_m
    own.slack_m = own.bounds_m = (unit.bound_ahead_m + unit.bound_behind_m) / 2.0
    own.next = used_beyond(unit, chart, 0, unit.position_m)


@compiled
def go_on(own: BeaconsRow, unit: UnitRow, chart: Chart) -> None:
    """The beacon after the one that was due is due."""
    at_m = chart.places[unit.places_offset + own.next].position_m
    own.from_m = at_m
    own.next = used_beyond(unit, chart, own.next + 1, at_m)


@compiled
def taken_for(own: BeaconsRow, reading: BeaconReading, unit: UnitRow, chart: Chart, row: int) -> int:
    """The beacon noticed is taken for that of a row; what came of it."""
    place = chart.places[unit.places_offset + row]
    since_m = (unit.odometer_m - unit.odometer_off_m - reading.odometer_m) * unit.odometer_scale
    front_m = place.position_m + since_m
    within_m = own.settings.accuracy_m + unit.pulse_m + abs(since_m) * unit.bound_growth
    if own.trusts != 0:
        return trusted(unit, front_m, within_m, within_m)
    if reading.told != 0:
        within_m += own.settings.placed_within_m
        outcome = fix_by_rule(unit, front_m, within_m + unit.step_long_m, within_m + unit.step_short_m)
        carry_slack(own, unit)
        return outcome
    misses = missed_m(unit, front_m, within_m, within_m) > 0.0
    if misses or abs(front_m - unit.position_m) > own.slack_m + within_m:
        return REFUSED
    own.slack_m = move_estimate(unit, own.slack_m, front_m, within_m)
    return TAKEN


@compiled_when_called
def by_number(own: BeaconsRow, reading: BeaconReading, unit: UnitRow, chart: Chart) -> int:
    """A beacon that tells its number."""
    row = used_numbered(unit, chart, reading.number)
    if row == NONE:
        return FOREIGN
    if chart.places[unit.places_offset + row].used == 0:
        return NOTHING
    outcome = taken_for(own, reading, unit, chart, row)
    if outcome == TAKEN:
        own.path, own.misses, own.next = unit.paths_taken_up, 0, row
        go_on(own, unit, chart)
    return outcome


@compiled_when_called
def by_window(own: BeaconsRow, reading: BeaconReading, unit: UnitRow, chart: Chart) -> int:
    """A beacon without a number: the one that is due, if it was noticed in the window of that."""
    place = chart.places[unit.places_offset + own.next]
    since_m = (unit.odometer_m - unit.odometer_off_m - reading.odometer_m) * unit.odometer_scale
    at_m = unit.position_m - since_m
    if place.told != 0 or abs(at_m - place.position_m) > half_window_m(own, unit, chart):
        return NOTHING
    outcome = taken_for(own, reading, unit, chart, own.next)
    if outcome == TAKEN:
        own.misses = 0
        go_on(own, unit, chart)
    return outcome


@compiled_when_called
def windows_passed(own: BeaconsRow, unit: UnitRow, chart: Chart) -> int:
    """MISSED once the window of beacons in a row has been passed without any."""
    while own.next != NONE:
        end_m = chart.places[unit.places_offset + own.next].position_m + half_window_m(own, unit, chart)
        if unit.position_m <= end_m:
            break
        own.misses += 1
        go_on(own, unit, chart)
        if own.misses >= MISSES:
            own.failed_on = unit.paths_taken_up
            return MISSED
    return NOTHING


@compiled
def beacons(own: BeaconsRow, reading: BeaconReading, unit: UnitRow, chart: Chart, _step_s: float) -> int:
    """What was noticed is a fix where it can be one; two windows in a row without any, and it is over on this path."""
    if own.fitted == 0:
        return NOTHING
    if unit.position_known != 0 and own.path == unit.paths_taken_up:
        carry_slack(own, unit)
    if reading.noticed != 0 and reading.told != 0:
        return by_number(own, reading, unit, chart)
    if unit.position_known == 0:
        own.path = 0
        return NOTHING
    if own.path != unit.paths_taken_up:
        expect_first(own, unit, chart)
    if own.failed_on == unit.paths_taken_up:
        return NOTHING
    outcome = NOTHING
    if reading.noticed != 0 and own.next != NONE:
        outcome = by_window(own, reading, unit, chart)
    passed = windows_passed(own, unit, chart)
    return passed if passed == MISSED else outcome
