"""What a net says of itself: which section every edge belongs to, for the checkers of truth.

Read from the net file alone, by this module alone: nothing of the line model, the writer or the on-board maps
is used, so that an error in those cannot hide itself here.
"""

from __future__ import annotations

import gzip
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from network.errors import InputError

OF_ROAD: Final = "crossing"  # parameter of the edges of a road, which no train runs on


@dataclass(frozen=True, slots=True)
class NetEdge:
    """One direction of one piece of track."""

    id: str
    piece_id: str
    section_id: str
    length_m: float
    bidi_edge_id: str
    next_edge_ids: tuple[str, ...]  # without the reversal in place


@dataclass(frozen=True, slots=True)
class NetMap:
    """All edges of a net by id."""

    edges: Mapping[str, NetEdge]

    def sections_under(self, path: Sequence[str], front_m: float, length_m: float) -> tuple[str, ...]:
        """Sections that a train touches, from its front to its rear, each once.

        `path` are the edges travelled up to and with the one under the front, in order of travel (SUMO's
        route up to the route index); `front_m` is the front's position on the last of them. A rear beyond the
        start of the path lies outside the net. Raises KeyError for an edge that is not in the net, ValueError
        for no path.
        """
        if not path:
            raise ValueError("a train on the net stands on an edge")
        found: list[str] = []
        behind_m = front_m
        for count, edge_id in enumerate(reversed(path)):
            edge = self.edges[edge_id]
            behind_m += edge.length_m if count else 0.0
            if edge.section_id not in found:
                found.append(edge.section_id)
            if behind_m >= length_m:
                break
        return tuple(found)


def read_net(path: Path) -> NetMap:
    """Read a net (`.net.xml` or `.net.xml.gz`). Raises InputError for a file that is not one of our nets."""
    try:
        with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
            root = ET.parse(file).getroot()
    except (OSError, ET.ParseError) as error:
        raise InputError(str(path), "", str(error), "a SUMO net") from error
    track = [e for e in root.iterfind("edge") if e.find(f"param[@key='{OF_ROAD}']") is None]
    bidi = {e.attrib["id"]: e.get("bidi", "") for e in track}
    following: dict[str, list[str]] = {edge_id: [] for edge_id in bidi}
    for connection in root.iterfind("connection"):
        origin, target = connection.attrib["from"], connection.attrib["to"]
        if origin in bidi and bidi[origin] != target:
            following[origin].append(target)
    edges = {
        edge_id: _edge(path, element, tuple(sorted(following[edge_id])))
        for edge_id, element in ((e.attrib["id"], e) for e in track)
    }
    if not edges:
        raise InputError(str(path), "edge", None, "a SUMO net with edges")
    return NetMap(edges)


def _edge(path: Path, element: ET.Element, next_edge_ids: tuple[str, ...]) -> NetEdge:
    """One edge with its parameters; raises InputError where the writer's marks are missing."""
    edge_id = element.attrib["id"]
    marks = {param.get("key"): param.get("value") for param in element.iterfind("param")}
    piece_id, section_id = marks.get("piece"), marks.get("section")
    lanes = element.findall("lane")
    bidi_edge_id = element.get("bidi")
    if not piece_id or not section_id or not bidi_edge_id or len(lanes) != 1:
        expected = "one lane, a bidi edge and the parameters piece and section"
        raise InputError(str(path), f"edge {edge_id}", None, expected)
    return NetEdge(
        edge_id, piece_id, section_id, float(lanes[0].attrib["length"]), bidi_edge_id, next_edge_ids
    )
