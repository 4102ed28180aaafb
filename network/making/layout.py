"""Where the sections of a line lie: tracks, points, what is between stations, portals; from stations and a rule.

Every station has its tracks about its place, long enough that a train at the mark is clear of both ends with room to
spare; n tracks come together over n - 1 points, one after another (a ladder), which are one section with one terminal.
Between two stations is one section, with the halts in it. Where stations lie too near for that, their tracks are made
shorter, down to what a train needs; where that is not enough either, the list is refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final

from network.errors import InputError
from network.making.station_list import ListedStation
from network.tag_layout import TagRule

STEM_M: Final = 20.0
LEG_M: Final = 60.0
POINTS_M: Final = STEM_M + LEG_M
PORTAL_M: Final = 800.0
COVERED_M: Final = 1500.0
STUB_SPEED_KMH: Final = 30.0
_ROOM_M: Final = 5.0  # of a platform from the points beside it


@dataclass(frozen=True, slots=True)
class LayoutRule:
    """Lengths (m) of what is laid out, for a longest train and the greatest speed (m/s) of the line."""

    train_length_m: float
    max_speed_mps: float

    @property
    def mark_m(self) -> float:
        """Of a stopping mark from the middle of its platform: a train stands in the middle."""
        return round(self.train_length_m / 2.0)

    @property
    def platform_half_m(self) -> float:
        """Half a platform of a station: the train and 40 m."""
        return self.mark_m + 20.0

    @property
    def halt_half_m(self) -> float:
        """Half a platform of a halt: the train and 25 m."""
        return self.mark_m + 12.5

    @property
    def track_half_m(self) -> float:
        """From the middle of a station to where its shortest track ends."""
        return self.mark_m + 100.0

    @property
    def track_half_min_m(self) -> float:
        """The same where stations are near: the rear is clear at the arrival tag before the front is at the mark."""
        return self.mark_m + 30.0

    @property
    def stub_m(self) -> float:
        """From the middle of a station at the end of the line to the buffers."""
        return self.mark_m + 47.0

    @property
    def tags(self) -> TagRule:
        """The rule of tags that goes with these lengths."""
        length_m = float(math.ceil(self.train_length_m))  # tags are written in whole metres
        return TagRule(
            train_length_m=length_m,
            portal_inset_m=max(60.0, length_m + 20.0),
            short_approach=True,
            approach_to_tracks=True,
        )

    @property
    def approach_m(self) -> float:
        """Of the approach tag from points."""
        return self.tags.approach_m(self.max_speed_mps)

    @property
    def between_min_m(self) -> float:
        """Shortest section between two stations: a train stands in it, clear of both."""
        return math.ceil(self.train_length_m) + 30.0

    @property
    def portal_m(self) -> float:
        """Length of a portal: its tags one behind the other."""
        return max(PORTAL_M, self.approach_m + self.tags.portal_inset_m + 50.0)


@dataclass(frozen=True, slots=True)
class LaidSection:
    """A section with its range (m); a points section has none."""

    id: str
    kind: str
    from_m: float | None = None
    to_m: float | None = None
    offset_m: float = 0.0


@dataclass(frozen=True, slots=True)
class LaidPoints:
    """Points with their range, and what lies at their three ends."""

    id: str
    section: str
    terminal: str
    from_m: float
    toe_m: float
    to_m: float
    faces: str
    stem: str
    normal: str
    reverse: str
    offset_m: float = 0.0  # of the stem


@dataclass(frozen=True, slots=True)
class LaidTrack:
    """A track of a station with the section it lies in, and whose usual one it is."""

    name: str
    section: str
    directions: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LaidStation:
    """A station in its place (m)."""

    listed: ListedStation
    place_m: float
    tracks: tuple[LaidTrack, ...]


@dataclass(slots=True)
class LineLayout:
    """Everything laid out, in order of kilometrage; `assumed` says what was done for want of room."""

    sections: list[LaidSection] = field(default_factory=list[LaidSection])
    points: list[LaidPoints] = field(default_factory=list[LaidPoints])
    joints: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])
    stations: list[LaidStation] = field(default_factory=list[LaidStation])
    stubs: list[tuple[float, float, str]] = field(default_factory=list[tuple[float, float, str]])
    assumed: list[str] = field(default_factory=list[str])

    @property
    def from_m(self) -> float:
        """Where the first section begins."""
        return min(section.from_m for section in self.sections if section.from_m is not None)

    @property
    def to_m(self) -> float:
        """Where the last section ends."""
        return max(section.to_m for section in self.sections if section.to_m is not None)


@dataclass(frozen=True, slots=True)
class _StationExtent:
    """A station with its own tracks: how far these and its points reach, m. `key` is of the list, for errors."""

    listed: ListedStation
    at_m: float
    half_low_m: float
    half_high_m: float

    @property
    def fan_m(self) -> float:
        return POINTS_M * (len(self.listed.tracks) - 1)

    @property
    def tracks_low_m(self) -> float:
        return self.at_m - self.half_low_m

    @property
    def tracks_high_m(self) -> float:
        return self.at_m + self.half_high_m

    @property
    def low_m(self) -> float:
        return self.tracks_low_m - (self.fan_m if self.listed.points_low else 0.0)

    @property
    def high_m(self) -> float:
        return self.tracks_high_m + (self.fan_m if self.listed.points_high else 0.0)


def lay_out(
    file: str, stations: Sequence[ListedStation], places_m: Sequence[float], rule: LayoutRule
) -> LineLayout:
    """Lay out stations at their places (m, ascending). Raises InputError, with `file`, where they are too near."""
    layout = LineLayout()
    own = [(s, at_m) for s, at_m in zip(stations, places_m, strict=True) if not s.is_halt]
    halts = [(s, at_m) for s, at_m in zip(stations, places_m, strict=True) if s.is_halt]
    for (before, before_m), (station, at_m) in pairwise(zip(stations, places_m, strict=True)):
        if before_m >= at_m:
            raise _too_near(file, station, before, at_m - before_m, 1.0)
    places = [_place(s, at_m, rule, first=i == 0, last=i == len(own) - 1) for i, (s, at_m) in enumerate(own)]
    for i in range(len(places) - 1):
        inside = [halt for halt in halts if places[i].at_m < halt[1] < places[i + 1].at_m]
        places[i], places[i + 1] = _fitted(file, places[i], places[i + 1], inside, rule, layout.assumed)
    _check_halts(file, halts, rule)
    _lay_sections(layout, places, halts, rule)
    layout.stations.sort(key=lambda station: station.place_m)
    return layout


def coverage_m(layout: LineLayout, roads: Iterable[tuple[float, float]] = ()) -> list[tuple[float, float]]:
    """Where the radio reaches: around each station with tracks of its own, and over portals; overlaps joined.

    `roads`: places of level crossings that are asked by radio, m, and how far from there.
    """
    reach = [
        (station.place_m - COVERED_M, station.place_m + COVERED_M)
        for station in layout.stations
        if not station.listed.is_halt
    ]
    reach += [(place_m - far_m, place_m + far_m) for place_m, far_m in roads]
    reach += [
        (s.from_m, s.to_m)
        for s in layout.sections
        if s.kind == "portal" and s.from_m is not None and s.to_m is not None
    ]
    ranges: list[tuple[float, float]] = []
    for from_m, to_m in sorted(reach):
        low_m, high_m = max(from_m, layout.from_m), min(to_m, layout.to_m)
        if ranges and low_m <= ranges[-1][1]:
            ranges[-1] = (ranges[-1][0], max(high_m, ranges[-1][1]))
        else:
            ranges.append((low_m, high_m))
    return ranges


def _place(
    station: ListedStation, at_m: float, rule: LayoutRule, *, first: bool, last: bool
) -> _StationExtent:
    stub_low, stub_high = first and not station.portal, last and not station.portal
    return _StationExtent(
        station,
        at_m,
        rule.stub_m if stub_low else rule.track_half_m,
        rule.stub_m if stub_high else rule.track_half_m,
    )


def _fitted(
    file: str,
    low: _StationExtent,
    high: _StationExtent,
    halts: Sequence[tuple[ListedStation, float]],
    rule: LayoutRule,
    assumed: list[str],
) -> tuple[_StationExtent, _StationExtent]:
    """Two neighbours with the tracks between them made shorter where they, or halts between them, are too near."""
    has_points = low.listed.points_high or high.listed.points_low
    wanted_m = rule.tags.train_length_m + 20.0 + (rule.approach_m if has_points else 0.0)
    short_m = max(0.0, (wanted_m - (high.low_m - low.high_m)) / 2.0)
    most_m = rule.track_half_m - rule.track_half_min_m
    low_m = high_m = short_m
    if halts:
        reach_m = rule.halt_half_m + _ROOM_M
        for_low_m = low.high_m + reach_m - halts[0][1]
        for_high_m = halts[-1][1] + reach_m - high.low_m
        for place, halt, more_m in ((low, halts[0], for_low_m), (high, halts[-1], for_high_m)):
            if more_m > most_m:
                apart_m = abs(halt[1] - place.at_m)
                raise _too_near(file, halt[0], place.listed, apart_m, apart_m + more_m - most_m)
        low_m, high_m = max(low_m, for_low_m), max(high_m, for_high_m)
    less_low_m, less_high_m = min(low_m, most_m), min(high_m, most_m)
    low = replace(low, half_high_m=low.half_high_m - less_low_m)
    high = replace(high, half_low_m=high.half_low_m - less_high_m)
    between_m = high.low_m - low.high_m
    if between_m < rule.between_min_m:
        needed_m = high.at_m - low.at_m + rule.between_min_m - between_m
        raise _too_near(file, high.listed, low.listed, high.at_m - low.at_m, needed_m)
    names = f"{low.listed.name} and {high.listed.name}"
    if less_low_m or less_high_m:
        assumed.append(
            f"room: {names} are near each other, so tracks reach {low.half_high_m:.0f} m and {high.half_low_m:.0f} m"
            f" from the middle of the station on the sides between them, not {rule.track_half_m:.0f} m"
        )
    if has_points and between_m <= rule.approach_m:
        assumed.append(
            f"room: {between_m:.0f} m between {names} hold no approach tag {rule.approach_m:.0f} m before points; "
            "it lies where the section begins, so a train that runs through may brake for points that are still thrown"
        )
    return low, high


def _too_near(
    file: str, station: ListedStation, other: ListedStation, apart_m: float, needed_m: float
) -> InputError:
    expected = (
        f"at least {needed_m:.0f} m from {other.name}, not {abs(apart_m):.0f} m: tracks, points and a train between "
        "need that much; fewer tracks, a shorter train, or one station in place of two"
    )
    return InputError(file, f"{station.key}.km", station.name, expected)


def _check_halts(file: str, halts: Sequence[tuple[ListedStation, float]], rule: LayoutRule) -> None:
    for (before, before_m), (halt, halt_m) in pairwise(halts):
        if halt_m - before_m < 2.0 * rule.halt_half_m:
            raise _too_near(file, halt, before, halt_m - before_m, 2.0 * rule.halt_half_m)


def _lay_sections(
    layout: LineLayout,
    places: Sequence[_StationExtent],
    halts: Sequence[tuple[ListedStation, float]],
    rule: LayoutRule,
) -> None:
    first, last = places[0], places[-1]
    before = ""
    if first.listed.portal:
        before = f"{first.listed.id}.P"
        layout.sections.append(LaidSection(before, "portal", first.low_m - rule.portal_m, first.low_m))
    for i, place in enumerate(places):
        after = f"{place.listed.id}-{places[i + 1].listed.id}" if i + 1 < len(places) else ""
        if place is last and place.listed.portal:
            after = f"{place.listed.id}.P"
        _lay_station(layout, place, before, after)
        if i + 1 < len(places):
            following = places[i + 1]
            layout.sections.append(LaidSection(after, "between", place.high_m, following.low_m))
            inside = [halt for halt in halts if place.at_m < halt[1] < following.at_m]
            layout.stations += [
                LaidStation(halt, at_m, (LaidTrack(halt.tracks[0], after, ("down", "up")),))
                for halt, at_m in inside
            ]
        elif after:
            layout.sections.append(LaidSection(after, "portal", place.high_m, place.high_m + rule.portal_m))
        before = after
    if not first.listed.portal:
        layout.stubs.append((first.at_m - rule.stub_m, first.tracks_high_m, "up"))
    if not last.listed.portal:
        layout.stubs.append((last.tracks_low_m, last.at_m + rule.stub_m, "down"))


def _lay_station(layout: LineLayout, place: _StationExtent, before: str, after: str) -> None:
    """Tracks of a station between what lies before and after it, with the points or the joint at either end."""
    station = place.listed
    low_ends_m = dict.fromkeys(station.tracks, place.tracks_low_m)
    high_ends_m = dict.fromkeys(station.tracks, place.tracks_high_m)
    low_points = tuple(_ladder(place, before, "down", low_ends_m)) if station.points_low else ()
    high_points = tuple(_ladder(place, after, "up", high_ends_m)) if station.points_high else ()
    if low_points:
        layout.sections.append(LaidSection(low_points[0].section, "points"))
    for name, offset_m in zip(station.tracks, station.offsets_m, strict=True):
        section_id = f"{station.id}.{name}"
        layout.sections.append(
            LaidSection(section_id, "track", low_ends_m[name], high_ends_m[name], offset_m)
        )
    if high_points:
        layout.sections.append(LaidSection(high_points[0].section, "points"))
    layout.points += (*low_points, *high_points)
    through = f"{station.id}.{station.normal or station.tracks[0]}"
    if before and not low_points:
        layout.joints.append((before, through))
    if after and not high_points:
        layout.joints.append((through, after))
    layout.stations.append(LaidStation(station, place.at_m, tuple(_tracks(station, before, after))))


def _ladder(place: _StationExtent, stem: str, faces: str, ends_m: dict[str, float]) -> Iterator[LaidPoints]:
    """Points from the stem to the tracks, one after another; `ends_m` becomes where each track ends on this side.

    For left-hand running the track that is left for a train that comes in is the normal leg of the first points; with
    a `normal` track it is straight on through all of them, and the outermost others part first. What leads on from
    points lies on the axis, or beside a track that has parted on the axis, between that and the next one.
    """
    station = place.listed
    lies_m = dict(zip(station.tracks, station.offsets_m, strict=True))
    lead_m = 0.0
    down = faces == "down"
    sign, edge_m = (1.0, place.low_m) if down else (-1.0, place.high_m)
    side, number = ("W", 10) if down else ("E", 20)
    waiting = list(station.tracks if down else reversed(station.tracks))
    if station.normal:
        main = station.tracks.index(station.normal)
        others = sorted(waiting, key=lambda name: -abs(station.tracks.index(name) - main))
        waiting = [name for name in others if name != station.normal] + [station.normal]
    for i, name in enumerate(waiting[:-1]):
        from_m = edge_m + sign * POINTS_M * i
        points_id = f"{station.id}.{number + i + 1}"
        beyond = waiting[i + 1] if i == len(waiting) - 2 else None
        onward = f"{station.id}.{beyond}" if beyond else f"{station.id}.{number + i + 2}.stem"
        here = f"{station.id}.{name}"
        straight = bool(station.normal)
        far_m = from_m + sign * POINTS_M
        for track in (name, *((beyond,) if beyond else ())):
            ends_m[track] = far_m
        yield LaidPoints(
            points_id,
            f"{station.id}.{side}",
            f"{station.id}-{side}",
            min(from_m, far_m),
            from_m + sign * STEM_M,
            max(from_m, far_m),
            faces,
            stem=stem,
            normal=onward if straight else here,
            reverse=here if straight else onward,
            offset_m=lead_m,
        )
        if lies_m[name] == lead_m:
            lead_m = (lead_m + lies_m[waiting[i + 1]]) / 2.0
        stem = f"{points_id}.{'normal' if straight else 'reverse'}"


def _tracks(station: ListedStation, before: str, after: str) -> Iterator[LaidTrack]:
    """Trains keep left where both directions run through; at an end of the line any track is usual for both."""
    through = bool(before and after)
    for i, name in enumerate(station.tracks):
        both = ("down", "up")
        if len(station.tracks) == 1 or not through:
            usual: tuple[str, ...] = both
        elif not (station.points_low and station.points_high):
            usual = both if name == station.normal else ()  # the others are for trains that turn back
        else:
            usual = ("down",) * (i == 0) + ("up",) * (i == len(station.tracks) - 1)
        yield LaidTrack(name, f"{station.id}.{name}", usual)
