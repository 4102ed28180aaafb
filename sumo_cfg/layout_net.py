"""A track layout that somebody else has drawn as plain XML for netconvert: nodes, edges both ways, connections."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from itertools import combinations
from pathlib import Path
from typing import Final

from exchange.layout import ForeignLayout, LayoutTrack, NodeKind, Place
from exchange.layout_geometry import THROUGH_DEG_MIN, angle_deg, direction_from
from exchange.sumo_net import NORMAL_AT
from network.errors import InputError
from network.files.json_input import write_bytes_aside
from sumo_cfg.build import convert
from sumo_cfg.writer import EDGE_SPEED_MPS, PlainXml, document_of

_UNFIT: Final = re.compile(r"[^A-Za-z0-9._#~-]")


def plain_of(layout: ForeignLayout) -> PlainXml:
    """Plain XML of a layout: a track is `<track>+` from its low node and `<track>-` back, points only stem to leg.

    At crossings tracks go on as straight as they can. Raises InputError for a layout without places.
    """
    places = {node.id: node.place for node in layout.nodes}
    if any(place is None for place in places.values()) or any(
        len(track.shape) < 2 for track in layout.tracks
    ):
        raise InputError(
            layout.source, "", None, "places of its nodes and tracks; without them there is no net"
        )
    nodes, edges, connections = (ET.Element(name) for name in ("nodes", "edges", "connections"))
    for node_id, place in places.items():
        x, y = place or (0.0, 0.0)
        ET.SubElement(nodes, "node", id=sumo_id(node_id), x=f"{x:.3f}", y=f"{y:.3f}", type="unregulated")
    normal_at: dict[str, list[str]] = {track.id: [] for track in layout.tracks}
    for points in layout.points:
        normal_at[points.normal].append(sumo_id(points.node_id))
    for track in layout.tracks:
        for sign, ends, shape in (
            ("+", (track.low_node, track.high_node), track.shape),
            ("-", (track.high_node, track.low_node), track.shape[::-1]),
        ):
            attributes = {
                "id": sumo_id(track.id) + sign,
                "from": sumo_id(ends[0]),
                "to": sumo_id(ends[1]),
                "numLanes": "1",
                "allow": "rail",
                "spreadType": "center",
                "speed": f"{EDGE_SPEED_MPS:.1f}",
                "length": f"{track.length_m:.6f}",
                "shape": " ".join(f"{x:.3f},{y:.3f}" for x, y in shape),
            }
            if track.name:
                attributes["name"] = track.name
            edge = ET.SubElement(edges, "edge", attributes)
            if normal_at[track.id]:
                ET.SubElement(edge, "param", key=NORMAL_AT, value=" ".join(normal_at[track.id]))
    for origin, target in sorted(set(_movements(layout))):
        attributes = {"from": origin, "to": target, "fromLane": "0", "toLane": "0"}
        ET.SubElement(connections, "connection", attributes)
    return PlainXml(*(document_of(root) for root in (nodes, edges, connections)))


def write_layout_net(layout: ForeignLayout, out: Path) -> None:
    """Build the SUMO net of a layout (extra `net`) and write it. Raises InputError as `plain_of` and `convert` do."""
    write_bytes_aside(out, convert(plain_of(layout), layout.name))


def sumo_id(name: str) -> str:
    """A name without what SUMO takes in no id."""
    return _UNFIT.sub("_", name)


def _movements(layout: ForeignLayout) -> Iterator[tuple[str, str]]:
    ends: dict[str, list[tuple[LayoutTrack, bool]]] = {node.id: [] for node in layout.nodes}
    for track in layout.tracks:
        ends[track.low_node].append((track, False))
        ends[track.high_node].append((track, True))
        yield from ((sumo_id(track.id) + a, sumo_id(track.id) + b) for a, b in ("+-", "-+"))
    stems = {points.node_id: points.stem for points in layout.points}
    kinds = {node.id: node.kind for node in layout.nodes}
    for node, there in ends.items():
        for one, other in _pairs(node, there, stems, kinds):
            yield _into(one), _out_of(other)
            yield _into(other), _out_of(one)


def _pairs(
    node: str,
    ends: list[tuple[LayoutTrack, bool]],
    stems: Mapping[str, str],
    kinds: Mapping[str, NodeKind],
) -> Iterator[tuple[tuple[LayoutTrack, bool], tuple[LayoutTrack, bool]]]:
    """Ends between which a train runs over a node."""
    if node in stems:
        stem = next(end for end in ends if end[0].id == stems[node])
        yield from ((stem, leg) for leg in ends if leg is not stem)
    elif kinds[node] is NodeKind.CROSSING:
        taken: set[int] = set()
        directions: list[Place] = [direction_from(track.shape, from_high=high) for track, high in ends]
        pairs = sorted(
            combinations(range(len(ends)), 2),
            key=lambda pair: -angle_deg(directions[pair[0]], directions[pair[1]]),
        )
        for a, b in pairs:
            if not {a, b} & taken and angle_deg(directions[a], directions[b]) >= THROUGH_DEG_MIN:
                taken |= {a, b}
                yield ends[a], ends[b]
    elif len(ends) == 2:
        yield ends[0], ends[1]


def _into(end: tuple[LayoutTrack, bool]) -> str:
    return sumo_id(end[0].id) + ("+" if end[1] else "-")


def _out_of(end: tuple[LayoutTrack, bool]) -> str:
    return sumo_id(end[0].id) + ("-" if end[1] else "+")
