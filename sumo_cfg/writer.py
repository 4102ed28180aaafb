"""The line as plain XML for netconvert: nodes, edges, connections.

Every piece becomes two edges, `<piece>+` for DOWN and `<piece>-` for UP, of the same centre line; SUMO pairs
them as one bidirectional track. The edge's `length` is the piece's length in kilometrage, so that a position
in SUMO is a position on the line whatever the polyline measures; the shape only shows where the track lies.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import blake2b
from itertools import pairwise
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from network.errors import InputError
from network.model import Alignment, Direction, Line, Piece
from network.offsets import end_offsets_m, lateral_m

SAMPLE_SPACING_M_MAX: Final = 10.0
BEND_SPACING_M_MAX: Final = 2.5
# netconvert merges shape points closer than 0.1 m.
SAMPLE_SPACING_M_MIN: Final = 0.5
JOINT_MISMATCH_M_MAX: Final = 1.0
# One constant far above any train: SUMO must never limit, and a changed line maximum keeps the same net.
EDGE_SPEED_MPS: Final = 100.0

Array = NDArray[np.float64]


class Positions(Protocol):
    """Where kilometrages of an alignment lie: (n, 3) of x, y, z in m; see `network.alignment.positions`."""

    def __call__(self, alignment: Alignment, kilometrage_m: Array, offset_m: float = 0.0, /) -> Array:
        """Positions, m; `offset_m` to the right of DOWN."""
        ...


@dataclass(frozen=True, slots=True)
class PlainXml:
    """What netconvert reads: three XML documents as UTF-8."""

    nodes: bytes
    edges: bytes
    connections: bytes

    @property
    def digest(self) -> str:
        """blake2b-128 of the three documents, hexadecimal: equal digests mean equal nets."""
        state = blake2b(digest_size=16)
        for document in (self.nodes, self.edges, self.connections):
            state.update(len(document).to_bytes(8, "big") + document)
        return state.hexdigest()


def edge_id(piece_id: str, direction: Direction) -> str:
    """SUMO's edge of a piece in a direction of travel."""
    return f"{piece_id}{'+' if direction is Direction.DOWN else '-'}"


def write_plain(line: Line, positions: Positions | None = None) -> PlainXml:
    """The plain XML of a line; `positions` defaults to `network.alignment.positions`.

    Raises InputError where pieces do not form a track: two ways at a joint without points, or pieces whose
    alignments put their common joint at different places.
    """
    shapes = piece_shapes(line, positions)
    places = _node_places(line, shapes)
    return PlainXml(
        nodes=_nodes_xml(places),
        edges=_edges_xml(line, shapes, places),
        connections=_connections_xml(line),
    )


def piece_shapes(line: Line, positions: Positions | None = None) -> dict[str, Array]:
    """Centre line of every piece in DOWN order, (n, 3), m; by piece id, sorted."""
    if positions is None:
        from network import alignment

        positions = alignment.positions
    return {piece_id: _shape(line, line.pieces[piece_id], positions) for piece_id in sorted(line.pieces)}


def movements(line: Line) -> tuple[tuple[str, str], ...]:
    """All pairs of edges a train may run over in turn, reversals in place included, sorted.

    Through a set of points only stem to leg and leg to stem; never from leg to leg.
    """
    ends: dict[str, tuple[list[str], list[str]]] = defaultdict(lambda: ([], []))
    for piece in line.pieces.values():
        ends[piece.high_node][0].append(piece.id)
        ends[piece.low_node][1].append(piece.id)
    toes = {points.node_id: points for points in line.points.values()}
    pairs: list[tuple[str, str]] = []
    for node_id, (below, above) in ends.items():
        stems, legs = (below, above)
        if node_id in toes:
            points = toes[node_id]
            if points.faces is Direction.UP:
                stems, legs = above, below
            if stems != [points.stem_piece] or set(legs) != {points.normal_piece, points.reverse_piece}:
                raise InputError(line.id, f"points {points.id}", legs, "one stem and its two legs at the toe")
        elif len(below) > 1 or len(above) > 1:
            raise InputError(line.id, f"joint {node_id}", below + above, "points where a track divides")
        for low in below:
            for high in above:
                pairs.append((edge_id(low, Direction.DOWN), edge_id(high, Direction.DOWN)))
                pairs.append((edge_id(high, Direction.UP), edge_id(low, Direction.UP)))
    for piece_id in line.pieces:
        down, up = edge_id(piece_id, Direction.DOWN), edge_id(piece_id, Direction.UP)
        pairs += [(down, up), (up, down)]
    return tuple(sorted(pairs))


def sample_kilometrages(piece: Piece, alignment: Alignment, spacing_m_max: float) -> Array:
    """Ascending kilometrages (m) of a piece's shape points: its ends, each change of gradient, and between.

    Neighbours are at most `spacing_m_max` apart; a change of gradient within 0.5 m of another is left out.
    """
    breaks = sorted(
        {m for g in alignment.gradients for m in (g.from_m, g.to_m) if piece.from_m < m < piece.to_m}
    )
    knots = [piece.from_m]
    for m in breaks:
        if m - knots[-1] >= SAMPLE_SPACING_M_MIN and piece.to_m - m >= SAMPLE_SPACING_M_MIN:
            knots.append(m)
    knots.append(piece.to_m)
    parts = [
        np.linspace(a, b, max(1, int(np.ceil((b - a) / spacing_m_max - 1e-9))), endpoint=False)
        for a, b in pairwise(knots)
    ]
    return np.concatenate([*parts, np.array([piece.to_m])])


def _shape(line: Line, piece: Piece, positions: Positions) -> Array:
    """Shape points of a piece in DOWN order, (n, 3), m."""
    alignment = line.alignments[piece.alignment_id]
    low_offset_m, high_offset_m = end_offsets_m(line, piece)
    bends = low_offset_m != high_offset_m
    kilometrage_m = sample_kilometrages(
        piece, alignment, BEND_SPACING_M_MAX if bends else SAMPLE_SPACING_M_MAX
    )
    centre = positions(alignment, kilometrage_m, 0.0)
    offset_m = lateral_m(line, piece, kilometrage_m)
    if not offset_m.any():
        return centre
    right = positions(alignment, kilometrage_m, 1.0) - centre
    return np.asarray(centre + right * offset_m[:, None], dtype=np.float64)


def _node_places(line: Line, shapes: Mapping[str, Array]) -> dict[str, Array]:
    """Place of every joint, (3,), m: the mean of the ends that meet there, which must agree."""
    ends: dict[str, list[Array]] = defaultdict(list)
    for piece_id, shape in shapes.items():
        ends[line.pieces[piece_id].low_node].append(shape[0])
        ends[line.pieces[piece_id].high_node].append(shape[-1])
    places: dict[str, Array] = {}
    for node_id in sorted(ends):
        place = np.mean(ends[node_id], axis=0)
        mismatch_m = max(float(np.linalg.norm(end - ends[node_id][0])) for end in ends[node_id])
        if mismatch_m > JOINT_MISMATCH_M_MAX:
            expected = f"alignments that meet within {JOINT_MISMATCH_M_MAX} m"
            raise InputError(line.id, f"joint {node_id}", f"{mismatch_m:.1f} m apart", expected)
        places[node_id] = place
    return places


def _nodes_xml(places: Mapping[str, Array]) -> bytes:
    root = ET.Element("nodes")
    for node_id, place in places.items():
        x, y, z = map(_millimetres, place)
        # Unregulated: authority is the on-board units' alone, SUMO must not make trains yield.
        ET.SubElement(root, "node", id=node_id, x=x, y=y, z=z, type="unregulated")
    return document_of(root)


def _edges_xml(line: Line, shapes: Mapping[str, Array], places: Mapping[str, Array]) -> bytes:
    root = ET.Element("edges")
    for piece_id, shape in shapes.items():
        piece = line.pieces[piece_id]
        down = [places[piece.low_node], *shape[1:-1], places[piece.high_node]]
        for direction, nodes, points in (
            (Direction.DOWN, (piece.low_node, piece.high_node), down),
            (Direction.UP, (piece.high_node, piece.low_node), down[::-1]),
        ):
            attributes = {
                "id": edge_id(piece_id, direction),
                "from": nodes[0],
                "to": nodes[1],
                "numLanes": "1",
                "allow": "rail",
                "spreadType": "center",
                "speed": f"{EDGE_SPEED_MPS:.1f}",
                "length": f"{piece.length_m:.6f}",
                "shape": " ".join(",".join(map(_millimetres, point)) for point in points),
            }
            edge = ET.SubElement(root, "edge", attributes)
            ET.SubElement(edge, "param", key="piece", value=piece_id)
            ET.SubElement(edge, "param", key="section", value=piece.section_id)
    return document_of(root)


def _connections_xml(line: Line) -> bytes:
    root = ET.Element("connections")
    for origin, target in movements(line):
        # Without lanes named, netconvert drops turnarounds that are not at a dead end.
        ET.SubElement(root, "connection", {"from": origin, "to": target, "fromLane": "0", "toLane": "0"})
    return document_of(root)


def _millimetres(coordinate_m: float) -> str:
    """A coordinate rounded to 1 mm, without a negative zero."""
    return f"{round(float(coordinate_m), 3) + 0.0:.3f}"


def document_of(root: ET.Element) -> bytes:
    """An XML file of it, a line for each element."""
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"
