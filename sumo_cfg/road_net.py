"""Roads over level crossings for SUMO: for each way an edge up to the stop line, one over the track, one away from it.

They have no node in common with the track, so the track's edges stay what they are without a road (decision 003). What
stands on the edge over the track stands on the track; the stop line is a junction with a signal, which shows what the
barriers do.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

import numpy as np

from network import alignment
from network.files.crossing_road import LANE_WIDTH_M, CrossingRoad
from network.model import Line
from network.offsets import lateral_m
from sumo_cfg.truth_map import OF_ROAD
from sumo_cfg.writer import PlainXml

AWAY_M: Final = 100.0  # road behind the crossing: in it a lorry that stood is as fast as the others again
CLASSES: Final = "passenger truck"


class RoadWay(Enum):
    """A way over the track: towards the right of DOWN, or towards its left."""

    RIGHT = "right"
    LEFT = "left"

    @property
    def sign(self) -> int:
        """1 towards the right of DOWN: its lanes then lie on the DOWN side of the middle, as one drives on the left."""
        return 1 if self is RoadWay.RIGHT else -1


class RoadPart(Enum):
    """The edges of a way, in order of travel."""

    APPROACH = "approach"
    OVER = "over"
    AWAY = "away"


@dataclass(frozen=True, slots=True)
class RoadAt:
    """A road that crosses a piece of track at a right angle; `position_m` is the kilometrage (m) of its middle.

    `has_detector`: something sees what stands on the crossing while it is closed.
    """

    crossing_id: str
    piece_id: str
    position_m: float
    road: CrossingRoad
    has_detector: bool = False

    @property
    def over_m(self) -> float:
        """From stop line to stop line, m: the track's middle is half way."""
        return 2.0 * self.road.stop_line_m

    @property
    def way_m(self) -> float:
        """All three edges of a way, m."""
        return self.road.approach_m + self.over_m + AWAY_M

    def edge(self, way: RoadWay, part: RoadPart) -> str:
        """SUMO's edge."""
        return f"road.{self.crossing_id}.{way.value}.{part.value}"

    def edges(self, way: RoadWay) -> tuple[str, ...]:
        """SUMO's edges of a way, in order of travel."""
        return tuple(self.edge(way, part) for part in RoadPart)

    def lanes(self, way: RoadWay, part: RoadPart) -> tuple[str, ...]:
        """SUMO's lanes of an edge, from the right of its direction of travel."""
        return tuple(f"{self.edge(way, part)}_{lane}" for lane in range(self.road.lanes))

    def stop_line(self, way: RoadWay) -> str:
        """SUMO's junction, and its signal, at the barrier of a way."""
        return self._node(way, 1)

    def lane_at_m(self, way: RoadWay, lane: int) -> float:
        """Where the middle of a lane meets the track: kilometrage from that of the crossing, m."""
        lanes = self.road.lanes
        return way.sign * LANE_WIDTH_M * (lanes / 2 - ((lanes - 1) / 2 - lane))

    def _node(self, way: RoadWay, index: int) -> str:
        return f"road.{self.crossing_id}.{way.value}.{index}"

    def write(self, line: Line, nodes: ET.Element, edges: ET.Element, connections: ET.Element) -> None:
        """Add both ways to the elements of a line's plain XML."""
        piece = line.pieces[self.piece_id]
        axis, at_m = line.alignments[piece.alignment_id], np.array([self.position_m])
        middle = alignment.positions(axis, at_m, float(lateral_m(line, piece, at_m)[0]))[0]
        right = alignment.positions(axis, at_m, 1.0)[0] - alignment.positions(axis, at_m, 0.0)[0]
        down = np.array([-right[1], right[0], 0.0])
        line_m, lengths_m = self.road.stop_line_m, (self.road.approach_m, self.over_m, AWAY_M)
        ends_m = (-line_m - self.road.approach_m, -line_m, line_m, line_m + AWAY_M)
        for way in RoadWay:
            centre = middle + way.sign * down * self.road.lanes * LANE_WIDTH_M / 2
            for index, beyond_m in enumerate(ends_m):
                x, y, z = (f"{value:.3f}" for value in centre + way.sign * right * beyond_m)
                kind = "traffic_light" if index == 1 else "unregulated"
                ET.SubElement(nodes, "node", id=self._node(way, index), x=x, y=y, z=z, type=kind)
            for index, part in enumerate(RoadPart):
                attributes = {
                    "id": self.edge(way, part),
                    "from": self._node(way, index),
                    "to": self._node(way, index + 1),
                    "numLanes": str(self.road.lanes),
                    "width": f"{LANE_WIDTH_M:g}",
                    "allow": CLASSES,
                    "spreadType": "center",
                    "speed": f"{self.road.speed_mps:.3f}",
                    "length": f"{lengths_m[index]:.3f}",
                }
                edge = ET.SubElement(edges, "edge", attributes)
                ET.SubElement(edge, "param", key=OF_ROAD, value=self.crossing_id)
            for origin, target in ((RoadPart.APPROACH, RoadPart.OVER), (RoadPart.OVER, RoadPart.AWAY)):
                for lane in map(str, range(self.road.lanes)):
                    ends = {"from": self.edge(way, origin), "to": self.edge(way, target)}
                    ET.SubElement(connections, "connection", ends, fromLane=lane, toLane=lane)


def with_roads(plain: PlainXml, line: Line, roads: Sequence[RoadAt]) -> PlainXml:
    """The plain XML of a line with its roads behind it."""
    roots = [ET.fromstring(document) for document in (plain.nodes, plain.edges, plain.connections)]
    for road in roads:
        road.write(line, *roots)
    for root in roots:
        ET.indent(root)
    return PlainXml(*(ET.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n" for root in roots))
