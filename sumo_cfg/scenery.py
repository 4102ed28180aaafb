"""What stands along the track, for sumo-gui and netedit: stops, and points and polygons of all that the line file has.

Points hang on lanes (`lane`, `pos`), so SUMO puts them where a train's front is when it has run as far. Lengths of
edges are those of the kilometrage, so `pos` is the way from where the edge begins.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from exchange.sumo_net import KILOMETRAGE, STATION, TRACK
from network.model import Direction, Line, Piece, PlatformTrack, SectionKind, Station, TagPurpose
from sumo_cfg.writer import edge_id, piece_shapes

ADDITIONAL_XSD: Final = "http://sumo.dlr.de/xsd/additional_file.xsd"
STOP_LENGTH_M: Final = 20.0  # of a stop at a track without a platform
PLATFORM_DISTANCE_M: Final = 2.5  # of a platform's middle from the axis of its track: assumed
PLATFORM_WIDTH_M: Final = 2.0
STOP_LENGTH_M_MIN: Final = 2.0

# RGB. Tags by what they are for, sections by their kind; points and ends of sections have one each.
TAG_COLOURS: Final = {
    TagPurpose.ARRIVAL: "0,140,70",
    TagPurpose.CONTROL_START: "200,0,0",
    TagPurpose.DEPARTED: "0,90,200",
    TagPurpose.APPROACH: "230,140,0",
    TagPurpose.POSITION: "120,120,120",
    TagPurpose.PORTAL: "140,0,160",
}
SECTION_COLOURS: Final = {
    SectionKind.TRACK: "0,140,70",
    SectionKind.POINTS: "230,140,0",
    SectionKind.BETWEEN: "90,130,180",
    SectionKind.PORTAL: "140,0,160",
}
POINTS_COLOUR: Final = "230,60,0"
END_COLOUR: Final = "0,0,0"
MARK_COLOUR: Final = "255,220,0"
PLATFORM_COLOUR: Final = "190,190,190"
_SECTION_LAYER: Final = "-2"
_PLATFORM_LAYER: Final = "-1"
_POINT_LAYER: Final = "5"

Array = NDArray[np.float64]


def stop_id(track: PlatformTrack, direction: Direction) -> str:
    """SUMO's stop of a track in a direction of travel."""
    return f"{track.station_id}.{track.name}{'+' if direction is Direction.DOWN else '-'}"


def scenery_xml(line: Line) -> bytes:
    """The additional file of a line: stops at every mark, tags, points, ends of sections, sections and platforms."""
    root = ET.Element(
        "additional",
        {
            "xmlns:xsi": "http://www.w3.org/2001/XMLSchema-instance",
            "xsi:noNamespaceSchemaLocation": ADDITIONAL_XSD,
        },
    )
    for attributes, marks in _stops(line):
        stop = ET.SubElement(root, "trainStop", attributes)
        for key, value in marks.items():
            ET.SubElement(stop, "param", key=key, value=value)
    shapes = piece_shapes(line)
    for attributes in (*_sections(line, shapes), *_platforms(line, shapes)):
        ET.SubElement(root, "poly", attributes)
    for attributes in (*_tags(line), *_points(line), *_ends(line), *_marks(line)):
        ET.SubElement(root, "poi", attributes)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def along_m(piece: Piece, direction: Direction, kilometrage_m: float) -> float:
    """How far from where `direction` enters a piece a kilometrage lies, m."""
    return kilometrage_m - piece.from_m if direction is Direction.DOWN else piece.to_m - kilometrage_m


def _stops(line: Line) -> Iterator[tuple[dict[str, str], dict[str, str]]]:
    """Attributes of each stop, and its parameters, by which an importer knows it again."""
    for station, track in _tracks(line):
        piece = line.pieces[track.piece_id]
        for direction, mark_m in sorted(track.marks_m.items(), reverse=True):
            end_m = along_m(piece, direction, mark_m)
            start_m = end_m - STOP_LENGTH_M
            if track.platform_m is not None:
                start_m = min(along_m(piece, direction, platform_m) for platform_m in track.platform_m)
            attributes = {
                "id": stop_id(track, direction),
                "lane": edge_id(piece.id, direction) + "_0",
                "startPos": _metres(max(0.0, min(start_m, end_m - STOP_LENGTH_M_MIN))),
                "endPos": _metres(end_m),
                "name": station.name,
            }
            marks = {KILOMETRAGE: _metres(mark_m), STATION: station.id, TRACK: track.name}
            yield attributes, marks


def _tags(line: Line) -> Iterator[dict[str, str]]:
    for tag in line.tags.values():
        piece = line.pieces[tag.piece_id]
        # Drawn beside the lane of the direction that reads it; one that speaks to both stands on the first.
        direction = tag.directions[0] if tag.directions else Direction.DOWN
        about = f"tag {tag.purpose.value}"
        yield _point(f"tag.{tag.id}", about, TAG_COLOURS[tag.purpose], piece, direction, tag.position_m)


def _points(line: Line) -> Iterator[dict[str, str]]:
    for points in line.points.values():
        piece = line.pieces[points.stem_piece]
        at_m = piece.from_m if piece.low_node == points.node_id else piece.to_m
        yield _point(f"points.{points.id}", "points", POINTS_COLOUR, piece, points.faces, at_m)


def _ends(line: Line) -> Iterator[dict[str, str]]:
    """Where a section ends, each once: at a node, or at several where tracks lie side by side."""
    seen: set[tuple[str, str]] = set()
    for piece in line.pieces.values():
        for node, at_m in ((piece.low_node, piece.from_m), (piece.high_node, piece.to_m)):
            inside = [p for p in line.pieces.values() if node in (p.low_node, p.high_node)]
            if all(p.section_id == piece.section_id for p in inside) and len(inside) > 1:
                continue
            if (piece.section_id, node) in seen:
                continue
            seen.add((piece.section_id, node))
            name = f"end.{piece.section_id}.{node}"
            yield _point(name, f"end of {piece.section_id}", END_COLOUR, piece, Direction.DOWN, at_m)


def _marks(line: Line) -> Iterator[dict[str, str]]:
    for _station, track in _tracks(line):
        for direction, mark_m in track.marks_m.items():
            name = f"mark.{stop_id(track, direction)}"
            piece = line.pieces[track.piece_id]
            yield _point(name, "stopping mark", MARK_COLOUR, piece, direction, mark_m)


def _sections(line: Line, shapes: dict[str, Array]) -> Iterator[dict[str, str]]:
    for section in line.sections.values():
        for piece_id in section.piece_ids:
            yield {
                "id": f"section.{section.id}" + (f".{piece_id}" if len(section.piece_ids) > 1 else ""),
                "type": f"section {section.kind.value}",
                "color": SECTION_COLOURS[section.kind],
                "fill": "0",
                "lineWidth": "4.0",
                "layer": _SECTION_LAYER,
                "shape": _shape_text(shapes[piece_id][:, :2]),
            }


def _platforms(line: Line, shapes: dict[str, Array]) -> Iterator[dict[str, str]]:
    for _station, track in _tracks(line):
        if track.platform_m is None:
            continue
        piece = line.pieces[track.piece_id]
        shares = [along_m(piece, Direction.DOWN, m) / piece.length_m for m in track.platform_m]
        axis = _cut(shapes[piece.id][:, :2], *sorted(shares))
        # On which side it lies is in no line file: away from the axis of the alignment, else to the right.
        side = -1.0 if piece.offset_m < 0 else 1.0
        near_m, far_m = (side * (PLATFORM_DISTANCE_M + half * PLATFORM_WIDTH_M / 2) for half in (-1.0, 1.0))
        ring = np.concatenate([_beside(axis, near_m), _beside(axis, far_m)[::-1]])
        yield {
            "id": f"platform.{track.station_id}.{track.name}",
            "type": "platform",
            "color": PLATFORM_COLOUR,
            "fill": "1",
            "layer": _PLATFORM_LAYER,
            "shape": _shape_text((*ring, ring[0])),
        }


def _tracks(line: Line) -> Iterator[tuple[Station, PlatformTrack]]:
    for station in line.stations.values():
        for track in station.tracks:
            yield station, track


def _point(
    name: str, kind: str, colour: str, piece: Piece, direction: Direction, kilometrage_m: float
) -> dict[str, str]:
    return {
        "id": name,
        "type": kind,
        "color": colour,
        "layer": _POINT_LAYER,
        "lane": edge_id(piece.id, direction) + "_0",
        "pos": _metres(along_m(piece, direction, kilometrage_m)),
    }


def _cut(shape: Array, from_share: float, to_share: float) -> Array:
    """The part of a polyline between two shares of its length, (n, 2)."""
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(shape, axis=0).T))))
    ends = np.array([from_share, to_share]) * along[-1]
    at = np.concatenate(([ends[0]], along[(along > ends[0]) & (along < ends[1])], [ends[1]]))
    return np.column_stack([np.interp(at, along, shape[:, axis]) for axis in (0, 1)])


def _beside(axis: Array, right_m: float) -> Array:
    """A polyline moved to its right, (n, 2)."""
    along = np.gradient(axis, axis=0)
    length = np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9)
    right = np.column_stack([along[:, 1], -along[:, 0]]) / length[:, None]
    moved: Array = axis + right_m * right
    return moved


def _shape_text(points: Iterable[Array]) -> str:
    return " ".join(f"{_metres(float(x))},{_metres(float(y))}" for x, y in points)


def _metres(value: float) -> str:
    return f"{round(value, 3) + 0.0:.3f}"
