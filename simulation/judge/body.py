"""Where a train's body lies, from the edges its front was seen on and the lengths in the net file alone."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final, TypeAlias

from sumo_cfg.truth_map import NetMap

RESOLUTION_M: Final = 1e-3  # less than this over a joint is not yet, or no longer, beyond it
Heights: TypeAlias = Mapping[str, Sequence[tuple[float, float]]]  # by edge: where along it, how high; m

MISSED_EDGES_MAX: Final = 4  # edges a front may have crossed between two observations


@dataclass(slots=True)
class Body:
    """One train. `path` runs in the direction of travel from the edge under the rear to that under the front.

    Nothing changes while the front stays on `edge_id` between `front_m` and `still_to_m`: the fast case.
    `left` are edges that the rear has run off since the last look, in the direction of travel, `fresh` those run onto
    but not yet touched. `excepted` are sections it may occupy without holding them: where it was put on the line (None
    until it is first seen). `overrun` are those that it came into outside the design (`judge.rail`).
    """

    unit_id: str
    length_m: float
    path: list[str]
    front_m: float = math.nan
    speed_mps: float = 0.0
    seen_s: float = -math.inf
    acceleration_mps2: float = 0.0  # between the last two looks
    behind_m: float = 0.0  # run before the edge under the front, and what it lay lower than that edge begins
    below_m: float = 0.0
    edge_id: str = ""
    still_to_m: float = -math.inf
    turned_from: str | None = None
    pieces: tuple[str, ...] = ()
    sections: frozenset[str] = frozenset()
    excepted: frozenset[str] | None = None
    overrun: frozenset[str] = frozenset()
    left: list[str] = field(default_factory=list)
    fresh: list[str] = field(default_factory=list)

    @property
    def run_m(self) -> float:
        """How far the front has run, m; from where it was first seen, but for a constant."""
        return self.behind_m + self.front_m


class NetTrack:
    """The net, for following bodies along it."""

    def __init__(self, net: NetMap, heights: Heights) -> None:
        self._edges = net.edges
        self._heights = heights

    def has(self, edge_id: str) -> bool:
        """Whether the net has this edge."""
        return edge_id in self._edges

    def piece_of(self, edge_id: str) -> str:
        """Piece that an edge belongs to; KeyError for an edge that is not in the net."""
        return self._edges[edge_id].piece_id

    def follow(self, body: Body, edge_id: str, front_m: float) -> bool:
        """Bring the front to where it was seen; False if no train can have run there from where it was.

        After a change of ends the new front may be on any edge that the body lies on.
        """
        if body.turned_from is not None:
            body.turned_from = None
            if edge_id in body.path:
                del body.path[body.path.index(edge_id) + 1 :]
                body.front_m = front_m
        if edge_id == body.path[-1]:
            continuous = not front_m < body.front_m - RESOLUTION_M
        else:
            way = self._way(body.path[-1], edge_id)
            continuous = bool(way)
            for left_id, onto_id in pairwise((body.path[-1], *(way or (edge_id,)))):
                left_m = self._edges[left_id].length_m
                body.behind_m += left_m
                body.below_m += self._height_m(left_id, left_m) - self._height_m(onto_id, 0.0)
            if way:
                body.path.extend(way)
            else:
                body.path = [edge_id]
            body.fresh.extend(way or (edge_id,))
        body.edge_id = edge_id
        body.front_m = front_m
        self._spread(body)
        return continuous

    def height_m(self, body: Body) -> float:
        """How high the track under the front lies, m; from where it was first seen, but for a constant."""
        return body.below_m + self._height_m(body.path[-1], body.front_m)

    def _height_m(self, edge_id: str, at_m: float) -> float:
        """Height at a place on an edge; level where nothing is told of it."""
        row = self._heights.get(edge_id)
        if row is None:
            return 0.0
        high = min(max(bisect_right(row, (at_m, math.inf)), 1), len(row) - 1)
        (from_m, below_m), (to_m, above_m) = row[high - 1], row[high]
        return below_m + (above_m - below_m) * (at_m - from_m) / (to_m - from_m)

    def touched(self, body: Body) -> tuple[str, ...]:
        """Pieces that the front has come onto since the last call, in order of travel."""
        pending = body.edge_id if body.front_m <= RESOLUTION_M else ""
        pieces = tuple(self._edges[edge_id].piece_id for edge_id in body.fresh if edge_id != pending)
        body.fresh = [edge_id for edge_id in body.fresh if edge_id == pending]
        return pieces

    def turn(self, body: Body) -> None:
        """The rear becomes the front, in place. SUMO shows it a step later, so the old edge is kept."""
        edges = self._edges
        beyond_first_m = sum(edges[edge_id].length_m for edge_id in body.path[1:])
        near_m = body.front_m - edges[body.path[-1]].length_m + beyond_first_m
        body.turned_from = body.path[-1]
        body.front_m = min(body.length_m - near_m, edges[body.path[0]].length_m)
        body.path = [edges[edge_id].bidi_edge_id for edge_id in reversed(body.path)]
        body.fresh.clear()
        body.edge_id = ""
        body.still_to_m = -math.inf

    def _way(self, origin: str, target: str) -> tuple[str, ...]:
        """Shortest sequence of edges from behind `origin` to `target`; empty if there is none so near."""
        ways: list[tuple[str, ...]] = [(origin,)]
        for _ in range(MISSED_EDGES_MAX + 1):
            ways = [(*way, onward) for way in ways for onward in self._edges[way[-1]].next_edge_ids]
            for way in ways:
                if way[-1] == target:
                    return way[1:]
        return ()

    def _spread(self, body: Body) -> None:
        """Lay the body back from its front and forget the edges behind its rear."""
        edges, path = self._edges, body.path
        first = len(path) - 1
        under = [edges[path[first]]] if body.front_m > RESOLUTION_M else []
        near_m = 0.0
        far_m = body.front_m
        while first > 0 and body.length_m - far_m > RESOLUTION_M:
            first -= 1
            edge = edges[path[first]]
            under.append(edge)
            near_m, far_m = far_m, far_m + edge.length_m
        body.still_to_m = math.inf
        if first < len(path) - 1:
            body.still_to_m = body.front_m + body.length_m - near_m - RESOLUTION_M
        if body.front_m <= RESOLUTION_M:
            body.still_to_m = min(body.still_to_m, RESOLUTION_M)
        body.left = path[:first]
        del path[:first]
        body.pieces = tuple(edge.piece_id for edge in under)
        body.sections = frozenset(edge.section_id for edge in under)
