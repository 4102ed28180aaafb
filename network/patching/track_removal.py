"""Take a platform track out of a line file: its points become plain track (棒線化).

The stem and the remaining leg of each set of points that led to the track turn into a `between` section of the
same kilometrage, under the id of the points section (under the points' own id where that section keeps other
points). A stretch between a track and other points is added to the track instead, because the points to throw
for a departure are those directly beyond the track. The diverging limit goes with the points.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final, Literal, TypeVar

from network.errors import InputError
from network.files.chargers import without_track as chargers_without_track
from network.files.line_schema import (
    DirectionName,
    JointTable,
    LineFile,
    OnTrackTable,
    PlatformTable,
    PointsTable,
    SectionTable,
    StationTable,
)
from network.files.toml_input import one_of

LaidT = TypeVar("LaidT", bound=OnTrackTable)

LegName = Literal["stem", "normal", "reverse"]
_LEGS: Final[tuple[LegName, ...]] = ("stem", "normal", "reverse")
_OTHER_LEG: Final[dict[LegName, LegName]] = {"normal": "reverse", "reverse": "normal"}
_DIRECTIONS: Final[tuple[DirectionName, ...]] = ("down", "up")


@dataclass(frozen=True, slots=True)
class _Asked:
    """The track to take out, and the file and key that ask for it."""

    track_id: str
    file: str
    key: str

    def error(self, expected: str) -> InputError:
        return InputError(self.file, self.key, self.track_id, expected)


def without_loop(entry: LineFile, station_id: str, file: str, key: str) -> LineFile:
    """The line file with one track at a station, its first; the others go as `without_track` takes them out.

    Raises InputError for a station with fewer than two.
    """
    own = {section.id for section in entry.sections if section.kind == "track"}
    tracks = {
        station.id: tuple(dict.fromkeys(track.section for track in station.tracks if track.section in own))
        for station in entry.stations
    }
    loops = [name for name, sections in tracks.items() if len(sections) > 1]
    if station_id not in loops:
        raise InputError(
            file, key, station_id, f"a station with two tracks or more, {one_of(loops, station_id)}"
        )
    for track_id in tracks[station_id][1:]:
        entry = without_track(entry, track_id, file, key)
    return entry


def without_track(entry: LineFile, track_id: str, file: str, key: str) -> LineFile:
    """The line file without a platform track and without the points that led to it.

    `entry` belongs to a valid line; `file` and `key` say in errors where the removal is asked for. The other
    tracks of the station become the usual ones of its directions. Raises InputError for a track that does not
    exist, that anything but legs of points leads to, or that its station cannot do without.
    """
    asked = _Asked(track_id, file, key)
    tracks = [section.id for section in entry.sections if section.kind == "track"]
    if track_id not in tracks:
        raise asked.error(f"a platform track, {one_of(tracks, track_id)}")
    stations = [_without_platform(station, asked) for station in entry.stations]
    chargers = entry.chargers
    for station in entry.stations:
        for track in station.tracks:
            if track.section == track_id:
                chargers = chargers_without_track(chargers, station.id, track.name)
    lost_legs = _lost_legs(entry, asked)
    names = " and ".join(lost_legs)
    note = f"track {track_id}: taken out; points {names} became plain track without a limit of their own"
    entry = entry.model_copy(
        update={
            "line": entry.line.model_copy(update={"assumed": [*entry.line.assumed, note]}),
            "sections": [section for section in entry.sections if section.id != track_id],
            "joints": [joint for joint in entry.joints if track_id not in (joint.low, joint.high)],
            "stations": stations,
            "chargers": chargers,
            "tags": [tag for tag in entry.tags if track_id not in (tag.section, tag.piece)],
            "beacons": [b for b in entry.beacons if track_id not in (b.section, b.piece)],
            "markers": [m for m in entry.markers if track_id not in (m.section, m.piece)],
            "crossings": [c for c in entry.crossings if track_id not in (c.section, c.piece)],
        }
    )
    for points_id, lost in lost_legs.items():
        points = next(points for points in entry.points if points.id == points_id)
        entry = _as_plain_track(entry, points, lost, asked)
    return entry


def _lost_legs(entry: LineFile, asked: _Asked) -> dict[str, LegName]:
    """The legs that lead to the track, by points; nothing else may."""
    lost: dict[str, LegName] = {}
    for points in entry.points:
        for leg in _LEGS:
            if getattr(points, leg) == asked.track_id:
                lost[points.id] = leg
    if not lost:
        raise asked.error("a track that points lead to")
    legs = {f"{points_id}.{leg}" for points_id, leg in lost.items() if leg != "stem"}
    others = [f"{points_id}.stem" for points_id, leg in lost.items() if leg == "stem"]
    for joint in entry.joints:
        if asked.track_id in (joint.low, joint.high):
            others += [name for name in (joint.low, joint.high) if name not in legs | {asked.track_id}]
    if others:
        raise asked.error(f"a track between legs of points; this one leads on to {others[0]}, which needs it")
    return lost


def _without_platform(station: StationTable, asked: _Asked) -> StationTable:
    """The station without the track; a direction left without a usual track gets the first one with a mark."""
    gone = next((track for track in station.tracks if track.section == asked.track_id), None)
    if gone is None:
        return station
    rest = [track for track in station.tracks if track is not gone]
    if not rest:
        raise asked.error(f"one of several tracks of its station; {station.name} has no other")
    for direction in _DIRECTIONS:
        marked = [i for i, track in enumerate(rest) if direction in _marked(track)]
        if direction in _marked(gone) and not marked:
            raise asked.error(
                f"a track that {station.name} can do without: no other has a mark for {direction} trains"
            )
        if direction in _usual(gone) and not any(direction in _usual(track) for track in rest):
            track = rest[marked[0]]
            both = [name for name in _DIRECTIONS if name == direction or name in _usual(track)]
            rest[marked[0]] = track.model_copy(update={"directions": both})
    return station.model_copy(update={"tracks": rest})


def _marked(track: PlatformTable) -> tuple[DirectionName, ...]:
    marks = {"down": track.mark_down_km, "up": track.mark_up_km}
    return tuple(direction for direction in _DIRECTIONS if marks[direction] is not None)


def _usual(track: PlatformTable) -> tuple[DirectionName, ...]:
    return _marked(track) if track.directions is None else tuple(track.directions)


def _as_plain_track(entry: LineFile, points: PointsTable, lost: LegName, asked: _Asked) -> LineFile:
    """One set of points replaced by plain track over its stem and the leg that is not `lost`."""
    kept = _OTHER_LEG[lost]
    ends: tuple[str, str] = (points.stem, getattr(points, kept))
    low, high = ends if points.faces == "down" else ends[::-1]
    track = _track_to_extend(entry, points, ends, asked)
    shares = any(p.section == points.section for p in entry.points if p.id != points.id)
    if track is None:
        plain = _plain_section(entry, points, ends, points.id if shares else points.section)
        joints = [JointTable(low=low, high=plain.id), JointTable(low=plain.id, high=high)]
    else:
        plain = _extended(track, points)
        joints = [JointTable(low=low, high=high)]
    now = {f"{points.id}.stem": plain.id, f"{points.id}.{kept}": plain.id}
    others = [p for p in entry.points if p.id != points.id]
    return entry.model_copy(
        update={
            "sections": list(_sections(entry.sections, plain, points, emptied=not shares)),
            "points": [
                p.model_copy(update={leg: now.get(getattr(p, leg), getattr(p, leg)) for leg in _LEGS})
                for p in others
            ],
            "joints": [*_renamed(entry.joints, now), *joints],
            "tags": list(_moved(entry.tags, now, f"{points.id}.{lost}")),
            "beacons": list(_moved(entry.beacons, now, f"{points.id}.{lost}")),
            "markers": list(_moved(entry.markers, now, f"{points.id}.{lost}")),
            "crossings": list(_moved(entry.crossings, now, f"{points.id}.{lost}")),
        }
    )


def _track_to_extend(
    entry: LineFile, points: PointsTable, ends: tuple[str, str], asked: _Asked
) -> SectionTable | None:
    """The track that the stretch is added to; None when it becomes a section of its own."""
    plain = {section.id: section for section in entry.sections if section.kind != "points"}
    beside = [plain[name] for name in ends if name in plain]
    if not beside:
        raise asked.error(
            f"points next to a section that is not points; {points.id} lies between {ends[0]} and {ends[1]}"
        )
    if len(beside) == len(ends) or beside[0].kind != "track":
        return None
    first = entry.alignments[0].id
    if (beside[0].alignment or first) != (points.alignment or first):
        raise asked.error(f"points {points.id} on the alignment of track {beside[0].id} next to them")
    return beside[0]


def _plain_section(
    entry: LineFile, points: PointsTable, ends: tuple[str, str], section_id: str
) -> SectionTable:
    """A section of its own, at the lateral offset that the toe had."""
    offset_m = points.offset_m
    if offset_m is None:
        plain = {section.id: section.offset_m for section in entry.sections if section.kind != "points"}
        offset_m = next(plain[name] for name in ends if name in plain)
    there = points.model_dump(include={"alignment", "from_km", "to_km"})
    return SectionTable(id=section_id, kind="between", offset_m=offset_m, **there)


def _extended(section: SectionTable, points: PointsTable) -> SectionTable:
    """The section with the stretch of the points added at the end where they meet."""
    assert section.from_km is not None
    assert section.to_km is not None
    return section.model_copy(
        update={
            "from_km": min(section.from_km, points.from_km),
            "to_km": max(section.to_km, points.to_km),
        }
    )


def _sections(
    sections: Iterable[SectionTable], plain: SectionTable, points: PointsTable, *, emptied: bool
) -> Iterable[SectionTable]:
    """Sections in their order, with `plain` where its namesake is, or else behind the points section."""
    known = [section.id for section in sections]
    for section in sections:
        if section.id == plain.id:
            yield plain
        elif section.id != points.section or not emptied:
            yield section
        if section.id == points.section and plain.id not in known:
            yield plain


def _renamed(joints: Iterable[JointTable], now: Mapping[str, str]) -> Iterable[JointTable]:
    """Joints by the new names, without those inside the plain track."""
    for joint in joints:
        low, high = now.get(joint.low, joint.low), now.get(joint.high, joint.high)
        if low != high:
            yield JointTable(low=low, high=high)


def _moved(tags: Iterable[LaidT], now: Mapping[str, str], lost: str) -> Iterable[LaidT]:
    """What lies on the points' pieces goes to the plain track, what lies on the lost leg goes altogether."""
    for tag in tags:
        if tag.piece is not None and tag.piece in now:
            yield tag.model_copy(update={"section": now[tag.piece], "piece": None})
        elif tag.piece != lost:
            yield tag
