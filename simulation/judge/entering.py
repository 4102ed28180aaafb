"""No train on points that another would foul which overran its stop, while that one comes in (不同時進入).

By the truth alone: a train comes in from when its front is on the way that leads to a track until it has stood there
with all its length. What it would foul is found on the net: points that begin within so many metres beyond its stop.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple

from simulation.judge.body import Body
from simulation.judge.log import Checker, Log
from sumo_cfg.truth_map import NetEdge, NetMap


class TrackOverlap(NamedTuple):
    """A track in one direction: where along its edge trains stop, and what must be clear beyond that, m."""

    stops_at_m: float
    overlap_m: float


class EntryWatch:
    """`tracks`: by edge; `points_sections`: sections with points."""

    def __init__(
        self, net: NetMap, tracks: Mapping[str, TrackOverlap], points_sections: Collection[str], log: Log
    ) -> None:
        self._log = log
        self._edges = net.edges
        self._points_sections = points_sections
        fouls = {edge_id: self._fouled(net.edges[edge_id], track) for edge_id, track in tracks.items()}
        self._fouls = {edge_id: found for edge_id, found in fouls.items() if found}
        self._leads_to = {
            edge.id: to
            for edge in net.edges.values()
            if edge.section_id in points_sections and (to := self._track_beyond(edge)) is not None
        }
        self._stood: dict[str, str] = {}  # by unit: the section in which it has stood since it came there

    @property
    def watches(self) -> bool:
        """Whether any track has an overlap with points in it."""
        return bool(self._fouls)

    def stands(self, body: Body) -> None:
        """A train stands: it has come in where all of it is in one section."""
        if len(body.sections) == 1:
            (self._stood[body.unit_id],) = body.sections

    def moved(self, t_s: float, body: Body, bodies: Iterable[Body]) -> None:
        """A train has come onto other track than before: judged against all others."""
        if self._stood.get(body.unit_id) not in body.sections:
            self._stood.pop(body.unit_id, None)
        for other in bodies:
            if other is not body:
                self._judge(t_s, body, other)
                self._judge(t_s, other, body)

    def _judge(self, t_s: float, comes: Body, other: Body) -> None:
        front = comes.path[-1]
        track = self._edges[front if front in self._fouls else self._leads_to.get(front, front)]
        if self._stood.get(comes.unit_id) == track.section_id:
            return
        for section_id in sorted(self._fouls.get(track.id, frozenset()) & other.sections):
            text = (
                f"{comes.unit_id} comes into section {track.section_id} with {other.unit_id} in section {section_id},"
                " where it would be if it overran its stop"
            )
            outside = bool(comes.overrun | other.overrun)
            subject = f"{section_id} {comes.unit_id} {other.unit_id}"
            self._log.note(t_s, Checker.ONE_COMES_IN, subject, text, outside=outside)

    def _fouled(self, edge: NetEdge, track: TrackOverlap) -> frozenset[str]:
        found: set[str] = set()
        reach = [(edge, edge.length_m - track.stops_at_m)]
        for here, end_m in reach:  # grows as it goes
            for onward in (self._edges[edge_id] for edge_id in here.next_edge_ids):
                if end_m < track.overlap_m and onward.section_id in self._points_sections:
                    found.add(onward.section_id)
                    reach.append((onward, end_m + onward.length_m))
        return frozenset(found)

    def _track_beyond(self, edge: NetEdge) -> str | None:
        """The track with an overlap to which points lead whichever way they lie."""
        while edge.section_id in self._points_sections:
            if len(edge.next_edge_ids) != 1:
                return None
            edge = self._edges[edge.next_edge_ids[0]]
        return edge.id if edge.id in self._fouls else None
