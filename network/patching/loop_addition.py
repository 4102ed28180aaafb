"""Lay a second track at a halt or between two stations, so that trains can meet there (交換設備の新設, 信号場).

What `network.making.layout` lays for a new line is laid into one that stands: two tracks of 240 m about the halt's
place, with points at both ends that lie normal for left-hand running, which are one terminal each. The section between
stations becomes two, each named for the places at its ends; tags in both and at the station follow the rule of
`network.tag_layout`, and the radio reaches as far about the new station as about a made one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, TypeVar

from network.errors import InputError
from network.files.line_file import line_of
from network.files.line_schema import (
    JointTable,
    LineFile,
    OnTrackTable,
    PlatformTable,
    PointsTable,
    RangeTable,
    SectionTable,
    StationTable,
    TagTable,
)
from network.files.toml_input import one_of
from network.making.layout import COVERED_M, POINTS_M, STEM_M, LayoutRule
from network.making.line_text import DIVERGING_KMH, THROW_TIME_S
from network.model import Direction, Line
from network.tag_layout import TagRule, lay_tags

LaidT = TypeVar("LaidT", bound=OnTrackTable)

OFFSET_M: Final = 4.0  # of either track from the axis: an island platform between them
_TRACKS: Final = (("1", "down", -OFFSET_M), ("2", "up", OFFSET_M))


@dataclass(frozen=True, slots=True)
class _Loop:
    """The halt, the section that it lies on, and where points and tracks are to lie (km)."""

    station: StationTable
    platform: PlatformTable
    section: SectionTable
    half_km: float
    file: str
    key: str

    @property
    def low_km(self) -> float:
        return round(self.station.km - self.half_km - POINTS_M / 1000.0, 3)

    @property
    def high_km(self) -> float:
        return round(self.station.km + self.half_km + POINTS_M / 1000.0, 3)

    @property
    def tracks_km(self) -> tuple[float, float]:
        return round(self.station.km - self.half_km, 3), round(self.station.km + self.half_km, 3)

    @property
    def names(self) -> tuple[str, str]:
        """The sections before and behind it."""
        low, dash, high = self.section.id.partition("-")
        here = self.station.id
        return (
            (f"{low}-{here}", f"{here}-{high}") if dash else (f"{self.section.id}.L", f"{self.section.id}.H")
        )

    def side_of(self, km: float) -> str:
        """The section in which a place of the old one lies now; a place within the loop is an error."""
        if self.low_km <= km <= self.high_km:
            raise self.error(
                f"a halt with nothing else within {1000.0 * (self.half_km + POINTS_M / 1000.0):.0f} m"
            )
        return self.names[0] if km < self.low_km else self.names[1]

    def error(self, expected: str) -> InputError:
        return InputError(self.file, self.key, self.station.id, expected)


def between_id(low_id: str, high_id: str) -> str:
    """What a signal station in the middle between two neighbours is called."""
    return f"{low_id}.{high_id}"


def with_loop(entry: LineFile, station_id: str, file: str, key: str) -> LineFile:
    """The line file with a second track at a halt, or between two neighbours: a signal station (信号場), `A.B`.

    `entry` belongs to a valid line; `file` and `key` say in errors where the loop is asked for. Raises InputError for
    what is no halt, and where there is no room.
    """
    entry = _with_place(entry, station_id)
    loop = _loop(entry, station_id, file, key)
    section = loop.section
    if not (_m(section.from_km) < loop.low_km and loop.high_km < _m(section.to_km)):
        raise loop.error(f"a halt further inside section {section.id}")
    note = (
        f"station {station_id}: a second track, 240 m long, with points and tags as `branchline new line` lays "
        f"them; points {THROW_TIME_S:g} s to throw, {DIVERGING_KMH:g} km/h on the reverse leg; radio 1.5 km either way"
    )
    entry = entry.model_copy(
        update={
            "line": entry.line.model_copy(update={"assumed": [*entry.line.assumed, note]}),
            "alignments": [
                axis.model_copy(update={"coverage": list(_covered(axis.coverage, loop))})
                if axis.id == (section.alignment or entry.alignments[0].id)
                else axis
                for axis in entry.alignments
            ],
            "sections": list(_sections(entry.sections, loop)),
            "points": [*(_joined(points, loop) for points in entry.points), *_points(loop)],
            "joints": [_joint(joint, loop) for joint in entry.joints],
            "stations": [_station(station, loop) for station in entry.stations],
            "beacons": list(_moved(entry.beacons, loop)),
            "markers": list(_moved(entry.markers, loop)),
            "crossings": list(_moved(entry.crossings, loop)),
            "tags": [tag for tag in entry.tags if tag.section != section.id],
        }
    )
    return entry.model_copy(update={"tags": [*entry.tags, *_tags(entry, loop)]})


def _with_place(entry: LineFile, name: str) -> LineFile:
    """The same with a halt without a platform in the middle between two neighbours, where `name` is that of both."""
    in_order = sorted(entry.stations, key=lambda station: station.km)
    pair = next(((a, b) for a, b in pairwise(in_order) if between_id(a.id, b.id) == name), None)
    if pair is None or any(station.id == name for station in entry.stations):
        return entry
    low, high = pair
    axis = {section.id: section.alignment for section in entry.sections}
    km = round((low.km + high.km) / 2.0, 3)
    mark_km = LayoutRule(TagRule().train_length_m, 0.0).mark_m / 1000.0
    here = [
        section
        for section in entry.sections
        if section.kind == "between"
        and section.alignment == axis[low.tracks[0].section] == axis[high.tracks[0].section]
        and _m(section.from_km) < km < _m(section.to_km)
    ]
    added = [
        StationTable(
            id=name,
            name=f"{low.name} - {high.name}",
            name_ja=f"{low.name_ja}・{high.name_ja}" if low.name_ja and high.name_ja else "",
            km=km,
            halt=True,
            tracks=[
                PlatformTable(
                    name="1", section=section.id, mark_down_km=km + mark_km, mark_up_km=km - mark_km
                )
            ],
        )
        for section in here
    ]
    at = entry.stations.index(low) + 1
    return entry.model_copy(update={"stations": [*entry.stations[:at], *added, *entry.stations[at:]]})


def _m(km: float | None) -> float:
    assert km is not None
    return km


def _loop(entry: LineFile, station_id: str, file: str, key: str) -> _Loop:
    halts = [station.id for station in entry.stations if station.halt]
    station = next((station for station in entry.stations if station.id == station_id and station.halt), None)
    if station is None:
        expected = (
            f"a halt, {one_of(halts, station_id)}; or A.B, two neighbours with single track in their middle"
        )
        raise InputError(file, key, station_id, expected)
    section = next(s for s in entry.sections if s.id == station.tracks[0].section)
    rule = LayoutRule(TagRule().train_length_m, entry.line.max_speed_kmh / 3.6)
    return _Loop(station, station.tracks[0], section, rule.track_half_m / 1000.0, file, key)


def _covered(coverage: Iterable[RangeTable], loop: _Loop) -> Iterator[RangeTable]:
    """The radio's stretches with that of the station, those that meet joined."""
    about = RangeTable(
        from_km=round(loop.station.km - COVERED_M / 1000.0, 3),
        to_km=round(loop.station.km + COVERED_M / 1000.0, 3),
    )
    last: RangeTable | None = None
    for stretch in sorted((*coverage, about), key=lambda stretch: stretch.from_km):
        if last is not None and stretch.from_km <= last.to_km:
            last = RangeTable(from_km=last.from_km, to_km=max(last.to_km, stretch.to_km))
            continue
        if last is not None:
            yield last
        last = stretch
    if last is not None:
        yield last


def _sections(sections: Iterable[SectionTable], loop: _Loop) -> Iterator[SectionTable]:
    old, here = loop.section, loop.station.id
    low_km, high_km = loop.tracks_km
    for section in sections:
        if section.id != old.id:
            yield section
            continue
        yield old.model_copy(update={"id": loop.names[0], "to_km": loop.low_km} | _blocks(loop, loop.low_km))
        yield SectionTable(id=f"{here}.W", kind="points", alignment=old.alignment)
        for name, _, offset_m in _TRACKS:
            yield SectionTable(
                id=f"{here}.{name}",
                kind="track",
                alignment=old.alignment,
                from_km=low_km,
                to_km=high_km,
                offset_m=old.offset_m + offset_m,
            )
        yield SectionTable(id=f"{here}.E", kind="points", alignment=old.alignment)
        yield old.model_copy(
            update={"id": loop.names[1], "from_km": loop.high_km} | _blocks(loop, loop.high_km)
        )


def _blocks(loop: _Loop, cut_km: float) -> dict[str, int]:
    """Of a section in virtual blocks its share of them for the half on either side; nothing for one without."""
    old = loop.section
    if old.virtual_blocks == 1:
        return {}
    from_km, to_km = _m(old.from_km), _m(old.to_km)
    length_km = cut_km - from_km if cut_km == loop.low_km else to_km - cut_km
    return {"virtual_blocks": max(1, round(old.virtual_blocks * length_km / (to_km - from_km)))}


def _points(loop: _Loop) -> Iterator[PointsTable]:
    here, stem_km = loop.station.id, STEM_M / 1000.0
    for side, number, faces, stem, normal, reverse in (
        ("W", 11, "down", loop.names[0], "1", "2"),
        ("E", 21, "up", loop.names[1], "2", "1"),
    ):
        outer_km, inner_km = (
            (loop.low_km, loop.tracks_km[0]) if side == "W" else (loop.high_km, loop.tracks_km[1])
        )
        yield PointsTable(
            id=f"{here}.{number}",
            section=f"{here}.{side}",
            terminal=f"{here}-{side}",
            alignment=loop.section.alignment,
            from_km=min(outer_km, inner_km),
            toe_km=round(outer_km + (stem_km if side == "W" else -stem_km), 3),
            to_km=max(outer_km, inner_km),
            faces="down" if faces == "down" else "up",
            stem=stem,
            normal=f"{here}.{normal}",
            reverse=f"{here}.{reverse}",
            throw_time_s=THROW_TIME_S,
            diverging_limit_kmh=DIVERGING_KMH,
        )


def _joined(points: PointsTable, loop: _Loop) -> PointsTable:
    """Other points, with the half of the old section that they now lead to."""
    now = loop.names[0] if points.to_km <= loop.low_km else loop.names[1]
    ends = {end: getattr(points, end) for end in ("stem", "normal", "reverse")}
    return points.model_copy(update={end: now for end, name in ends.items() if name == loop.section.id})


def _joint(joint: JointTable, loop: _Loop) -> JointTable:
    old = loop.section.id
    low = loop.names[1] if joint.low == old else joint.low
    return JointTable(low=low, high=loop.names[0] if joint.high == old else joint.high)


def _station(station: StationTable, loop: _Loop) -> StationTable:
    if station.id == loop.station.id:
        tracks = [
            loop.platform.model_copy(
                update={"name": name, "section": f"{station.id}.{name}", "directions": [direction]}
            )
            for name, direction, _ in _TRACKS
        ]
        return station.model_copy(update={"halt": False, "tracks": tracks})
    tracks = [
        track.model_copy(update={"section": loop.side_of(station.km)})
        if track.section == loop.section.id
        else track
        for track in station.tracks
    ]
    return station.model_copy(update={"tracks": tracks})


def _moved(laid: Iterable[LaidT], loop: _Loop) -> Iterator[LaidT]:
    for one in laid:
        here = one.section == loop.section.id
        yield one.model_copy(update={"section": loop.side_of(one.km)}) if here else one


def _tags(entry: LineFile, loop: _Loop) -> Iterator[TagTable]:
    """Tags of the new sections by the rule, under the rule's numbers where nobody has them."""
    here = loop.station.id
    new = {*loop.names, *(f"{here}.{name}" for name in ("W", "E", "1", "2"))}
    line: Line = line_of(entry, loop.file)
    try:
        laid = lay_tags(line)
    except ValueError as error:
        raise loop.error(f"a halt with room for the tags of a station ({error})") from error
    taken = {tag.id for tag in entry.tags}
    for tag in laid:
        piece = line.pieces[tag.piece_id]
        if piece.section_id not in new:
            continue
        number = next(n for n in range(tag.id, tag.id + len(taken) + 1) if n not in taken)
        taken.add(number)
        single = piece.id == piece.section_id
        yield TagTable(
            id=number,
            section=piece.id if single else None,
            piece=None if single else piece.id,
            km=round(tag.position_m / 1000.0, 3),
            purpose=tag.purpose.value,
            directions=["down" if direction is Direction.DOWN else "up" for direction in tag.directions],
        )
