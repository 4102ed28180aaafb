"""Read a line file (TOML, schema in `network.files.line_schema`) into a validated `network.model.Line`.

Lateral offsets: a section has its own; the stem of points lies at the points' offset (by default that of the
section before the stem), and a leg has at its outer end the offset of what it leads to, so that a leg whose
offset is not that of its points runs across from one track to the other.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from network.errors import InputError
from network.files import line_checks as check
from network.files import line_schema as schema
from network.files.chargers import chargers_of
from network.files.crossings import crossings_of
from network.files.joints import Joiner, PieceDraft
from network.files.line_schema import DIRECTIONS, LineFile
from network.files.toml_input import one_of, parse_table, parse_toml, read_text, validate
from network.graph import TooManyRoutesError, all_routes
from network.model import (
    Alignment,
    Beacon,
    Cover,
    Coverage,
    Curve,
    Direction,
    Gradient,
    LevelCrossing,
    Line,
    MarkerGroup,
    Piece,
    PlatformTrack,
    Points,
    PointsLeg,
    Position,
    Section,
    SectionKind,
    SpeedLimit,
    Station,
    Tag,
    TagPurpose,
)
from network.networks import reached
from network.units import metres, mps
from network.virtual_blocks import radio_reaches, with_blocks_of

LaidT = TypeVar("LaidT", bound=schema.OnTrackTable)


def load_line(path: Path) -> Line:
    """Read and validate a line file. Raises InputError for the first thing that is wrong with it."""
    return line_of_tables(parse_table(read_text(path), str(path)), str(path))


def parse_line(text: str, file: str) -> Line:
    """Parse and validate the text of a line file; `file` names it in errors. Raises InputError."""
    return line_of(parse_toml(text, file, LineFile), file)


def line_of_tables(tables: Mapping[str, Any], file: str) -> Line:
    """The line of the tables of a line file; `file` names it in errors. Raises InputError.

    The same tables give the same object, by which it is known what was computed of a line before.
    """
    return _line_of_tables(pickle.dumps(tables), file)


@lru_cache(maxsize=16)
def _line_of_tables(tables: bytes, file: str) -> Line:
    return line_of(validate(pickle.loads(tables), file, LineFile), file)


def line_of(entry: LineFile, file: str) -> Line:
    """The line that the tables of a line file describe; `file` names it in errors. Raises InputError."""
    _unique(file, "alignments", [a.id for a in entry.alignments])
    alignments = {a.id: _alignment(file, i, a) for i, a in enumerate(entry.alignments)}
    drafts = _drafts(file, entry, alignments)
    joiner = Joiner(file, drafts, {s.id for s in entry.sections if s.kind == "points"})
    for i, joint in enumerate(entry.joints):
        joiner.add_joint(f"joints[{i}]", joint.low, joint.high)
    for i, points in enumerate(entry.points):
        joiner.add_points(f"points[{i}]", points)
    pieces = {draft.id: _piece(draft, joiner) for draft in drafts.values()}
    stations = _stations(file, entry, alignments, pieces)
    sections = _sections(entry, pieces, stations)
    line = Line(
        id=entry.line.id,
        name=entry.line.name,
        name_ja=entry.line.name_ja,
        max_speed_mps=mps(entry.line.max_speed_kmh),
        stations=stations,
        alignments=alignments,
        sections=sections,
        pieces=pieces,
        points={p.id: _points(p) for p in entry.points},
        tags=_tags(file, entry, pieces),
        assumed=tuple(entry.line.assumed),
        chargers=chargers_of(file, entry.chargers, stations),
        beacons=_beacons(file, entry, pieces),
        markers=_markers(file, entry, pieces),
        crossings=_crossings(file, entry, pieces),
    )
    keys = {s.id: f"sections[{i}]" for i, s in enumerate(entry.sections)}
    check.check_overlaps(file, line, {draft.id: draft.key for draft in drafts.values()})
    check.check_ends(file, line, keys)
    check.check_reachable(file, line, keys)
    try:
        all_routes(line)
    except TooManyRoutesError as error:
        section_id = str(error)
        expected = "a section with fewer ways from it to the next tracks"
        raise InputError(file, f"{keys[section_id]}.id", section_id, expected) from error
    station_keys = {s.id: f"stations[{i}]" for i, s in enumerate(entry.stations)}
    check.check_station_order(file, line, station_keys)
    check.check_entries(file, line, station_keys)
    return with_blocks_of(line, _blocks(file, entry, line))


def _blocks(file: str, entry: LineFile, line: Line) -> dict[str, int]:
    """Into how many virtual blocks sections are cut, by id."""
    found: dict[str, int] = {}
    for i, section in enumerate(entry.sections):
        if section.virtual_blocks == 1:
            continue
        expected = ""
        if section.kind != "between":
            expected = "1: only sections between stations are cut into blocks"
        elif not radio_reaches(line, line.sections[section.id]):
            expected = "1, or radio from end to end: a train asks for its next block wherever it stands"
        if expected:
            raise InputError(file, f"sections[{i}].virtual_blocks", section.virtual_blocks, expected)
        found[section.id] = section.virtual_blocks
    return found


def _unique(file: str, table: str, ids: Iterable[object], key: str = "id") -> None:
    seen: dict[object, int] = {}
    for i, name in enumerate(ids):
        if name in seen:
            expected = f"an id of its own; {table}[{seen[name]}] has this one"
            raise InputError(file, f"{table}[{i}].{key}", name, expected)
        seen[name] = i


def _directions(names: Iterable[str]) -> tuple[Direction, ...]:
    return tuple(DIRECTIONS[name] for name in names)


def _alignment(file: str, index: int, entry: schema.AlignmentTable) -> Alignment:
    key = f"alignments[{index}]"
    check.check_range(file, key, entry)
    check.check_gradients(file, key, entry)
    check.check_curves(file, key, entry)
    check.check_within(file, f"{key}.limits", entry.limits, entry)
    for name in ("coverage", "second_coverage"):
        check.check_sorted(file, f"{key}.{name}", getattr(entry, name), entry)
    check.check_sorted(file, f"{key}.tunnels", entry.tunnels, entry)
    check.check_sorted(file, f"{key}.obstructed", entry.obstructed, entry)
    limits = (
        SpeedLimit(metres(i.from_km), metres(i.to_km), mps(i.speed_kmh), _directions(i.directions))
        for i in sorted(entry.limits, key=lambda limit: limit.from_km)
    )
    first, second = (
        tuple(Coverage(metres(c.from_km), metres(c.to_km)) for c in reach)
        for reach in (entry.coverage, entry.second_coverage)
    )
    gradients = tuple(Gradient(metres(g.from_km), metres(g.to_km), g.permille) for g in entry.gradients)
    return Alignment(
        entry.id,
        metres(entry.from_km),
        metres(entry.to_km),
        entry.x_m,
        entry.y_m,
        entry.bearing_deg,
        entry.elevation_m,
        gradients,
        curves=tuple(
            Curve(metres(c.from_km), metres(c.to_km), c.radius_m, c.transition_m, c.cant_mm)
            for c in entry.curves
        ),
        limits=tuple(limits),
        coverage=reached(first + second),
        of_networks=(first, second) if second else (),
        tunnels=tuple(Cover(metres(c.from_km), metres(c.to_km)) for c in entry.tunnels),
        obstructed=tuple(Cover(metres(c.from_km), metres(c.to_km)) for c in entry.obstructed),
    )


def _drafts(file: str, entry: LineFile, alignments: Mapping[str, Alignment]) -> dict[str, PieceDraft]:
    """Pieces without their nodes, by id."""
    _unique(file, "sections", [s.id for s in entry.sections])
    _unique(file, "points", [p.id for p in entry.points])
    points_sections = [s.id for s in entry.sections if s.kind == "points"]
    for i, points in enumerate(entry.points):
        if points.section not in points_sections:
            expected = f"a points section, {one_of(points_sections, points.section)}"
            raise InputError(file, f"points[{i}].section", points.section, expected)
    drafts: list[PieceDraft] = []
    for i, section in enumerate(entry.sections):
        key = f"sections[{i}]"
        if section.kind == "points":
            check.check_points_section(file, key, section, entry.points)
            continue
        alignment = check.find_alignment(file, key, section.alignment, alignments)
        from_m, to_m = check.section_range_m(file, key, section, alignment)
        drafts.append(PieceDraft(section.id, key, section.id, alignment.id, from_m, to_m, section.offset_m))
    for i, points in enumerate(entry.points):
        key = f"points[{i}]"
        alignment = check.find_alignment(file, key, points.alignment, alignments)
        check.check_points_range(file, key, points, alignment)
        drafts.extend(_points_drafts(key, points, alignment.id))
    by_id: dict[str, PieceDraft] = {}
    for draft in drafts:
        if draft.id in by_id:
            raise InputError(file, f"{draft.key}.id", draft.id, f"no clash with {by_id[draft.id].key}")
        by_id[draft.id] = draft
    return by_id


def _points_drafts(key: str, points: schema.PointsTable, alignment_id: str) -> list[PieceDraft]:
    faces = DIRECTIONS[points.faces]
    low = (metres(points.from_km), metres(points.toe_km))
    high = (metres(points.toe_km), metres(points.to_km))
    drafts: list[PieceDraft] = []
    for leg in PointsLeg:
        from_m, to_m = low if (leg is PointsLeg.STEM) == (faces is Direction.DOWN) else high
        name = f"{points.id}.{leg.value}"
        drafts.append(
            PieceDraft(
                name, key, points.section, alignment_id, from_m, to_m, points.offset_m, points.id, leg, faces
            )
        )
    return drafts


def _piece(draft: PieceDraft, joiner: Joiner) -> Piece:
    return Piece(
        draft.id,
        draft.section_id,
        draft.alignment_id,
        draft.from_m,
        draft.to_m,
        joiner.node_of(draft, Direction.UP),
        joiner.node_of(draft, Direction.DOWN),
        joiner.offset_of(draft),
        draft.points_id,
        draft.leg,
    )


def _points(entry: schema.PointsTable) -> Points:
    return Points(
        entry.id,
        entry.section,
        entry.terminal,
        entry.id,
        DIRECTIONS[entry.faces],
        f"{entry.id}.stem",
        f"{entry.id}.normal",
        f"{entry.id}.reverse",
        throw_time_s=entry.throw_time_s,
        diverging_limit_mps=mps(entry.diverging_limit_kmh),
        initial=Position(entry.initial),
    )


def _stations(
    file: str, entry: LineFile, alignments: Mapping[str, Alignment], pieces: Mapping[str, Piece]
) -> dict[str, Station]:
    _unique(file, "stations", [s.id for s in entry.stations])
    kinds = _kinds(entry)
    owner: dict[str, str] = {}
    stations: dict[str, Station] = {}
    for i, station in enumerate(entry.stations):
        key = f"stations[{i}]"
        check.check_on_line(file, f"{key}.km", station.km, alignments.values())
        _unique(file, f"{key}.tracks", [t.name for t in station.tracks], "name")
        tracks: list[PlatformTrack] = []
        for j, track in enumerate(station.tracks):
            where = f"{key}.tracks[{j}]"
            check.check_platform_section(file, where, station, track, kinds)
            if not station.halt and owner.setdefault(track.section, where) != where:
                expected = f"a section of its own; {owner[track.section]} has this one"
                raise InputError(file, f"{where}.section", track.section, expected)
            piece, overlap_m = pieces[track.section], entry.line.overlap_m
            tracks.append(_platform(file, where, station.id, track, piece, overlap_m))
        position_m = metres(station.km)
        check.check_beside(file, f"{key}.km", station, [pieces[track.section] for track in station.tracks])
        stations[station.id] = Station(
            station.id, station.name, station.name_ja, position_m, tuple(tracks), station.halt
        )
    for i, section in enumerate(entry.sections):
        if section.kind == "track" and section.id not in owner:
            raise InputError(
                file, f"sections[{i}].id", section.id, "a section that a [[stations]] track names"
            )
    return stations


def _platform(
    file: str, key: str, station_id: str, entry: schema.PlatformTable, piece: Piece, overlap_m: float
) -> PlatformTrack:
    check.check_platform(file, key, entry, piece)
    marks_km = {Direction.DOWN: entry.mark_down_km, Direction.UP: entry.mark_up_km}
    marks_m = {direction: metres(km) for direction, km in marks_km.items() if km is not None}
    usual = tuple(marks_m) if entry.directions is None else _directions(entry.directions)
    own_m = {Direction.DOWN: entry.overlap_down_m, Direction.UP: entry.overlap_up_m}
    overlaps_m = {direction: overlap_m if own is None else own for direction, own in own_m.items()}
    return PlatformTrack(
        station_id, entry.name, entry.section, piece.id, _platform_m(entry), marks_m, usual, overlaps_m
    )


def _platform_m(entry: schema.PlatformTable) -> tuple[float, float] | None:
    if entry.platform_from_km is None or entry.platform_to_km is None:
        return None
    return metres(entry.platform_from_km), metres(entry.platform_to_km)


def _sections(
    entry: LineFile, pieces: Mapping[str, Piece], stations: Mapping[str, Station]
) -> dict[str, Section]:
    owner = {
        track.section_id: (station.id, track.name)
        for station in stations.values()
        for track in station.tracks
        if not station.is_halt
    }
    sections: dict[str, Section] = {}
    for item in entry.sections:
        own = tuple(piece for piece in pieces.values() if piece.section_id == item.id)
        station_id, track = owner.get(item.id, (None, None))
        if item.kind == "points":
            nodes = {node for piece in own for node in (piece.low_node, piece.high_node)}
            near = (p.section_id for p in pieces.values() if {p.low_node, p.high_node} & nodes)
            station_id = next((owner[section_id][0] for section_id in near if section_id in owner), None)
        sections[item.id] = Section(
            item.id, SectionKind(item.kind), tuple(piece.id for piece in own), station_id, track
        )
    return sections


def _laid(
    file: str, table: str, entries: Sequence[LaidT], kinds: Mapping[str, str], pieces: Mapping[str, Piece]
) -> Iterator[tuple[LaidT, str, float, tuple[Direction, ...]]]:
    """Entries of a table of things on the track, each with its piece, kilometrage (m) and directions."""
    for i, entry in enumerate(entries):
        piece = check.tag_piece(file, f"{table}[{i}]", entry, pieces, kinds)
        yield entry, piece.id, metres(entry.km), _directions(entry.directions)


def _tags(file: str, entry: LineFile, pieces: Mapping[str, Piece]) -> dict[int, Tag]:
    _unique(file, "tags", [t.id for t in entry.tags])
    laid = _laid(file, "tags", entry.tags, _kinds(entry), pieces)
    return {
        tag.id: Tag(tag.id, piece_id, at_m, TagPurpose(tag.purpose), to) for tag, piece_id, at_m, to in laid
    }


def _beacons(file: str, entry: LineFile, pieces: Mapping[str, Piece]) -> dict[int, Beacon]:
    _unique(file, "beacons", [b.id for b in entry.beacons])
    laid = _laid(file, "beacons", entry.beacons, _kinds(entry), pieces)
    return {
        beacon.id: Beacon(beacon.id, piece_id, at_m, to, beacon.tells_id, beacon.used, beacon.window_m)
        for beacon, piece_id, at_m, to in laid
    }


def _markers(file: str, entry: LineFile, pieces: Mapping[str, Piece]) -> dict[int, MarkerGroup]:
    _unique(file, "markers", [m.id for m in entry.markers])
    laid = _laid(file, "markers", entry.markers, _kinds(entry), pieces)
    return {
        group.id: MarkerGroup(group.id, group.pattern, piece_id, at_m, to)
        for group, piece_id, at_m, to in laid
    }


def _crossings(file: str, entry: LineFile, pieces: Mapping[str, Piece]) -> dict[str, LevelCrossing]:
    _unique(file, "crossings", [c.id for c in entry.crossings])
    laid = _laid(file, "crossings", entry.crossings, _kinds(entry), pieces)
    return crossings_of(file, [(table, pieces[piece_id]) for table, piece_id, _, _ in laid], entry)


def _kinds(entry: LineFile) -> dict[str, str]:
    """Kind of each section, by id."""
    return {section.id: section.kind for section in entry.sections}
