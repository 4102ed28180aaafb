"""Checks of a line file that need more than one table; every one raises `InputError`, the first that fails.

`key` is the key path of the table under test, such as `alignments[0]` or `points[3]`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, pairwise, product
from typing import Final

from network.errors import InputError
from network.files.line_schema import (
    AlignmentTable,
    OnTrackTable,
    PlatformTable,
    PointsTable,
    RangeTable,
    SectionTable,
    StationTable,
)
from network.files.toml_input import one_of
from network.graph import all_routes, fouled_sections
from network.model import Alignment, Direction, Line, Piece, PointsLeg, SectionKind
from network.units import metres

TOLERANCE_M: Final = 0.001
WAITS_WITHIN_M: Final = 100.0  # assumed: who waits before points stands so near to them
PIECE_M_MIN: Final = 1.0  # assumed: shorter than the wheelbase of any vehicle
BETWEEN_TRACKS_M: Final = 2.0  # assumed: narrower than two vehicles of any gauge


def _km(position_m: float) -> str:
    return f"{position_m / 1000:.6f}".rstrip("0").rstrip(".")


def _differ(a_km: float, b_km: float) -> bool:
    return abs(metres(a_km) - metres(b_km)) > TOLERANCE_M


def check_range(file: str, key: str, entry: RangeTable) -> None:
    """`from_km` before `to_km`."""
    if entry.to_km <= entry.from_km:
        raise InputError(file, f"{key}.to_km", entry.to_km, f"more than from_km = {entry.from_km}")


def check_within(file: str, key: str, entries: Sequence[RangeTable], outer: RangeTable) -> None:
    """Each range is one, and lies on the alignment."""
    for i, entry in enumerate(entries):
        check_range(file, f"{key}[{i}]", entry)
        for name, value in (("from_km", entry.from_km), ("to_km", entry.to_km)):
            if not outer.from_km <= value <= outer.to_km:
                expected = f"{outer.from_km} to {outer.to_km}, the alignment's range"
                raise InputError(file, f"{key}[{i}].{name}", value, expected)


def check_sorted(file: str, key: str, entries: Sequence[RangeTable], outer: RangeTable) -> None:
    """Ranges on the alignment, sorted and without overlap."""
    check_within(file, key, entries, outer)
    for i, (before, entry) in enumerate(pairwise(entries), start=1):
        if metres(entry.from_km) < metres(before.to_km) - TOLERANCE_M:
            expected = f"at least {before.to_km}, where {key}[{i - 1}] ends (sorted, without overlap)"
            raise InputError(file, f"{key}[{i}].from_km", entry.from_km, expected)


def check_gradients(file: str, key: str, alignment: AlignmentTable) -> None:
    """The gradient table covers the alignment without gap or overlap."""
    table = f"{key}.gradients"
    expected_km, what = alignment.from_km, "where the alignment begins"
    for i, entry in enumerate(alignment.gradients):
        check_range(file, f"{table}[{i}]", entry)
        if _differ(entry.from_km, expected_km):
            fault = "a gap" if entry.from_km > expected_km else "an overlap"
            expected = f"{expected_km}, {what} (the table has {fault})"
            raise InputError(file, f"{table}[{i}].from_km", entry.from_km, expected)
        expected_km, what = entry.to_km, f"where {table}[{i}] ends"
    if _differ(expected_km, alignment.to_km):
        last = f"{table}[{len(alignment.gradients) - 1}].to_km" if alignment.gradients else table
        value = expected_km if alignment.gradients else "empty"
        raise InputError(file, last, value, f"cover up to {alignment.to_km}, where the alignment ends")


def check_curves(file: str, key: str, alignment: AlignmentTable) -> None:
    """Curves are sorted, do not overlap, and are long enough for both transitions."""
    check_sorted(file, f"{key}.curves", alignment.curves, alignment)
    for i, curve in enumerate(alignment.curves):
        where = f"{key}.curves[{i}]"
        length_m = metres(curve.to_km) - metres(curve.from_km)
        if 2 * curve.transition_m > length_m + TOLERANCE_M:
            expected = f"at most {length_m / 2:.6g}, half the curve's length"
            raise InputError(file, f"{where}.transition_m", curve.transition_m, expected)


def find_alignment(file: str, key: str, name: str | None, alignments: Mapping[str, Alignment]) -> Alignment:
    """The named alignment, or the first when no name is given."""
    if name is None:
        return next(iter(alignments.values()))
    if name not in alignments:
        raise InputError(file, f"{key}.alignment", name, one_of(alignments, name))
    return alignments[name]


def _check_on(file: str, key: str, position_km: float, alignment: Alignment) -> None:
    if not alignment.from_m <= metres(position_km) <= alignment.to_m:
        bounds = f"{_km(alignment.from_m)} to {_km(alignment.to_m)}"
        raise InputError(file, key, position_km, f"{bounds}, the range of alignment {alignment.id}")


def _check_long(file: str, key: str, from_km: float, to_km: float) -> None:
    """A piece of track that is there."""
    if metres(to_km) - metres(from_km) < PIECE_M_MIN - TOLERANCE_M:
        raise InputError(file, key, to_km, f"at least {PIECE_M_MIN:g} m beyond {from_km}")


def check_on_line(file: str, key: str, position_km: float, alignments: Iterable[Alignment]) -> None:
    """A kilometrage that some alignment has."""
    every = tuple(alignments)
    if not any(a.from_m <= metres(position_km) <= a.to_m for a in every):
        _check_on(file, key, position_km, every[0])


def check_beside(file: str, key: str, station: StationTable, tracks: Sequence[Piece]) -> None:
    """A station lies beside one of its tracks."""
    if tracks and not any(piece.from_m <= metres(station.km) <= piece.to_m for piece in tracks):
        ranges = " or ".join(dict.fromkeys(f"{_km(piece.from_m)} to {_km(piece.to_m)}" for piece in tracks))
        raise InputError(file, key, station.km, f"{ranges}, where its tracks lie")


def section_range_m(file: str, key: str, section: SectionTable, alignment: Alignment) -> tuple[float, float]:
    """Kilometrages (m) of a section that is one piece."""
    if section.from_km is None or section.to_km is None:
        missing = "from_km" if section.from_km is None else "to_km"
        raise InputError(file, f"{key}.{missing}", None, "this key, which is missing")
    if section.to_km <= section.from_km:
        raise InputError(file, f"{key}.to_km", section.to_km, f"more than from_km = {section.from_km}")
    _check_on(file, f"{key}.from_km", section.from_km, alignment)
    _check_on(file, f"{key}.to_km", section.to_km, alignment)
    _check_long(file, f"{key}.to_km", section.from_km, section.to_km)
    return metres(section.from_km), metres(section.to_km)


def check_points_section(file: str, key: str, section: SectionTable, points: Iterable[PointsTable]) -> None:
    """A points section has points and no range of its own."""
    for name, value in (("from_km", section.from_km), ("to_km", section.to_km)):
        if value is not None:
            raise InputError(
                file, f"{key}.{name}", value, "no range: a points section is where its points are"
            )
    if all(p.section != section.id for p in points):
        raise InputError(file, f"{key}.id", section.id, "at least one [[points]] with this section")


def check_points_range(file: str, key: str, points: PointsTable, alignment: Alignment) -> None:
    """The toe lies between the ends, on the alignment."""
    if points.to_km <= points.from_km:
        raise InputError(file, f"{key}.to_km", points.to_km, f"more than from_km = {points.from_km}")
    if not points.from_km < points.toe_km < points.to_km:
        expected = f"between from_km = {points.from_km} and to_km = {points.to_km}"
        raise InputError(file, f"{key}.toe_km", points.toe_km, expected)
    _check_on(file, f"{key}.from_km", points.from_km, alignment)
    _check_on(file, f"{key}.to_km", points.to_km, alignment)
    _check_long(file, f"{key}.toe_km", points.from_km, points.toe_km)
    _check_long(file, f"{key}.to_km", points.toe_km, points.to_km)


def check_platform_section(
    file: str, key: str, station: StationTable, track: PlatformTable, kinds: Mapping[str, str]
) -> None:
    """A station's track is a track section, a halt's lies in a section between stations."""
    wanted = "between" if station.halt else "track"
    if kinds.get(track.section) != wanted:
        known = one_of((name for name, kind in kinds.items() if kind == wanted), track.section)
        place = "a halt" if station.halt else "a station"
        raise InputError(file, f"{key}.section", track.section, f"a {wanted!r} section for {place}, {known}")
    if station.halt and track.platform_from_km is None:
        raise InputError(file, f"{key}.platform_from_km", None, "the low end of the platform: it is a halt")


def check_platform(file: str, key: str, entry: PlatformTable, piece: Piece) -> None:
    """Platform inside its section, marks along the platform, a mark for every usual direction."""
    from_km, to_km = entry.platform_from_km, entry.platform_to_km
    ends = [("platform_from_km", from_km), ("platform_to_km", to_km)]
    if (from_km is None) is not (to_km is None):
        missing = next(name for name, value in ends if value is None)
        raise InputError(file, f"{key}.{missing}", None, "both ends of the platform, or neither")
    if from_km is not None and to_km is not None and to_km <= from_km:
        raise InputError(file, f"{key}.platform_to_km", to_km, f"more than platform_from_km = {from_km}")
    for name, value in ends:
        if value is None:
            continue
        if not piece.from_m <= metres(value) <= piece.to_m:
            expected = f"{_km(piece.from_m)} to {_km(piece.to_m)}, the range of section {piece.section_id}"
            raise InputError(file, f"{key}.{name}", value, expected)
    marks = {"down": entry.mark_down_km, "up": entry.mark_up_km}
    if all(mark is None for mark in marks.values()):
        raise InputError(file, f"{key}.mark_down_km", None, "this key or mark_up_km")
    for direction, mark_km in marks.items():
        low_km = piece.from_m / 1000.0 if from_km is None else from_km
        high_km = piece.to_m / 1000.0 if to_km is None else to_km
        if mark_km is not None and not low_km <= mark_km <= high_km:
            along = "the platform" if from_km is not None else f"section {piece.section_id}"
            expected = f"{low_km:g} to {high_km:g}, along {along}"
            raise InputError(file, f"{key}.mark_{direction}_km", mark_km, expected)
        if mark_km is None and entry.directions is not None and direction in entry.directions:
            raise InputError(
                file, f"{key}.mark_{direction}_km", None, f"a mark: {direction} trains call here"
            )


def tag_piece(
    file: str, key: str, tag: OnTrackTable, pieces: Mapping[str, Piece], kinds: Mapping[str, str]
) -> Piece:
    """The piece that a tag, a beacon or a group of markers lies on, with the place inside it."""
    if (tag.section is None) == (tag.piece is None):
        raise InputError(file, f"{key}.section", tag.section, "either section or piece")
    name, used = (tag.piece, "piece") if tag.piece is not None else (tag.section, "section")
    assert name is not None
    if used == "section" and kinds.get(name) == "points":
        own = one_of(piece.id for piece in pieces.values() if piece.section_id == name)
        raise InputError(file, f"{key}.section", name, f"piece = {own}: a points section has several")
    if name not in pieces:
        raise InputError(file, f"{key}.{used}", name, one_of(pieces, name))
    piece = pieces[name]
    if not piece.from_m <= metres(tag.km) <= piece.to_m:
        expected = f"{_km(piece.from_m)} to {_km(piece.to_m)}, the range of {piece.id}"
        raise InputError(file, f"{key}.km", tag.km, expected)
    return piece


def check_overlaps(file: str, line: Line, keys: Mapping[str, str]) -> None:
    """No two pieces lie on the same rails, or nearer than trains can pass; `keys` gives the table of each piece.

    Rails are the same at the same alignment and lateral offset. Legs that run across to another offset lie
    between tracks and are left out, as are the two legs of the same points, which part at the toe.
    """
    tracks: dict[tuple[str, float], list[Piece]] = {}
    for piece in line.pieces.values():
        across = False
        if piece.points_id is not None and piece.leg is not PointsLeg.STEM:
            stem = line.pieces[line.points[piece.points_id].stem_piece]
            across = piece.leg is PointsLeg.REVERSE or piece.offset_m != stem.offset_m
        if not across:
            tracks.setdefault((piece.alignment_id, piece.offset_m), []).append(piece)
    for (axis, offset_m), (other_axis, other_m) in combinations(tracks, 2):
        if axis != other_axis or abs(offset_m - other_m) >= BETWEEN_TRACKS_M:
            continue
        for one, other in product(tracks[axis, offset_m], tracks[axis, other_m]):
            if one.from_m < other.to_m - TOLERANCE_M and other.from_m < one.to_m - TOLERANCE_M:
                expected = f"at least {BETWEEN_TRACKS_M:g} m from {offset_m:g}, that of {one.id}"
                raise InputError(file, f"{keys[other.id]}.offset_m", other_m, expected)
    for pieces in tracks.values():
        pieces.sort(key=lambda piece: piece.from_m)
        furthest = pieces[0]
        for piece in pieces[1:]:
            if piece.from_m < furthest.to_m - TOLERANCE_M:
                expected = f"at least {_km(furthest.to_m)}, where {furthest.id} ends on the same track"
                hint = "or another offset_m if it is another track"
                where = f"{keys[piece.id]}.from_km"
                raise InputError(file, where, piece.from_m / 1000, f"{expected}, {hint}")
            if piece.to_m > furthest.to_m:
                furthest = piece


def check_ends(file: str, line: Line, keys: Mapping[str, str]) -> None:
    """A section between stations is joined at both ends; a portal at exactly one."""
    uses: dict[str, int] = {}
    for piece in line.pieces.values():
        for node in (piece.low_node, piece.high_node):
            uses[node] = uses.get(node, 0) + 1
    for section in line.sections.values():
        piece = line.pieces[section.piece_ids[0]]
        joined = (uses[piece.low_node] > 1) + (uses[piece.high_node] > 1)
        if section.kind is SectionKind.PORTAL and joined != 1:
            expected = f"a portal with one end joined to the line; {joined} of its ends are"
            raise InputError(file, f"{keys[section.id]}.id", section.id, expected)
        if section.kind is SectionKind.BETWEEN and joined == 1:
            end = "high" if uses[piece.high_node] == 1 else "low"
            expected = f"a section joined at both ends; nothing meets its {end} end"
            raise InputError(file, f"{keys[section.id]}.id", section.id, expected)


def check_reachable(file: str, line: Line, keys: Mapping[str, str]) -> None:
    """Every section hangs together with the first."""
    at_node: dict[str, list[Piece]] = {}
    for piece in line.pieces.values():
        at_node.setdefault(piece.low_node, []).append(piece)
        at_node.setdefault(piece.high_node, []).append(piece)
    first = next(iter(line.sections.values()))
    waiting = [line.pieces[first.piece_ids[0]]]
    reached = {piece.id for piece in waiting}
    while waiting:
        piece = waiting.pop()
        for other in at_node[piece.low_node] + at_node[piece.high_node]:
            if other.id not in reached:
                reached.add(other.id)
                waiting.append(other)
    for section in line.sections.values():
        if not reached.intersection(section.piece_ids):
            expected = f"a section joined to the rest of the line; it cannot be reached from {first.id}"
            raise InputError(file, f"{keys[section.id]}.id", section.id, expected)


def check_station_order(file: str, line: Line, keys: Mapping[str, str]) -> None:
    """Stations follow each other by their kilometrages as their marks do: a train calls in this order."""
    furthest: dict[tuple[str, Direction], tuple[float, str]] = {}
    for station in sorted(line.stations.values(), key=lambda station: station.position_m):
        marks = [
            ((line.pieces[track.piece_id].alignment_id, direction), mark_m)
            for track in station.tracks
            for direction, mark_m in track.marks_m.items()
        ]
        for axis, mark_m in marks:
            beyond_m, name = furthest.get(axis, (mark_m, ""))
            if mark_m < beyond_m:
                expected = (
                    f"less than {name}'s, whose mark lies beyond (km {_km(beyond_m)}, not {_km(mark_m)})"
                )
                raise InputError(file, f"{keys[station.id]}.km", station.position_m / 1000.0, expected)
        for axis, mark_m in marks:
            furthest[axis] = max(furthest.get(axis, (mark_m, station.id)), (mark_m, station.id))


def check_entries(file: str, line: Line, keys: Mapping[str, str]) -> None:
    """Where trains need leave to come in, the radio reaches those that wait for it before the points."""
    for route in all_routes(line) if fouled_sections(line) else ():
        if not route.entry:
            continue
        pieces = [line.pieces[piece_id] for piece_id in route.piece_ids]
        before = pieces[next(i for i, p in enumerate(pieces) if p.section_id == route.entry[0]) - 1]
        joint_m = before.to_m if route.direction is Direction.DOWN else before.from_m
        waits_m = joint_m - route.direction * min(WAITS_WITHIN_M, before.length_m)
        low_m, high_m = sorted((joint_m, waits_m))
        reach = line.alignments[before.alignment_id].coverage
        if not any(c.from_m <= low_m and high_m <= c.to_m for c in reach):
            station_id = line.sections[route.to_section].station_id or ""
            expected = (
                f"0 for tracks of {station_id}, or radio from km {_km(low_m)} to {_km(high_m)}, where trains wait for"
                " leave to come in"
            )
            raise InputError(file, f"{keys.get(station_id, 'line')}.tracks.overlap_m", None, expected)
