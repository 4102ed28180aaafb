"""The line as a directed graph: what follows a piece, and the routes (進路) from track to track.

Direction makes it directed: a train going DOWN leaves a piece at its high node and goes on along the pieces
whose low node that is. At a toe these are the two legs; trailing, only the stem.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from typing import Final

from network.model import (
    Direction,
    Line,
    Piece,
    PlatformTrack,
    PointsLeg,
    Position,
    Route,
    Section,
    SectionKind,
)

_STOPS: Final = frozenset({SectionKind.TRACK, SectionKind.PORTAL})
_POSITION: Final = {PointsLeg.NORMAL: Position.NORMAL, PointsLeg.REVERSE: Position.REVERSE}
_GRAPHS_MAX: Final = 16
TRAILS_MAX: Final = 10_000  # of routes from one place: with more, nobody laid these points


@dataclass(frozen=True, slots=True)
class Graph:
    """Adjacency of one line, by piece, for both directions."""

    line: Line
    down: dict[str, tuple[str, ...]]
    up: dict[str, tuple[str, ...]]
    # by track and direction of who comes in: `Route.overlap`
    overlaps: dict[tuple[str, Direction], tuple[str, ...]]
    known: dict[tuple[str, Direction], tuple[Route, ...]] = field(
        default_factory=dict[tuple[str, Direction], tuple[Route, ...]]
    )  # routes from a track or portal, as they are asked for

    @staticmethod
    def of_line(line: Line) -> Graph:
        """The graph of `line`, built once for each Line object."""
        graph = _graphs.get(id(line))
        if graph is None or graph.line is not line:
            graph = _build(line)
            if len(_graphs) >= _GRAPHS_MAX:
                del _graphs[next(iter(_graphs))]
            _graphs[id(line)] = graph
        return graph


# A Line holds mappings, so it has no hash; the graph keeps its line alive, so an id here is never reused.
_graphs: dict[int, Graph] = {}


def _build(line: Line) -> Graph:
    from_low: dict[str, list[str]] = {}
    from_high: dict[str, list[str]] = {}
    for piece in sorted(line.pieces.values(), key=lambda piece: piece.leg is PointsLeg.REVERSE):
        from_low.setdefault(piece.low_node, []).append(piece.id)
        from_high.setdefault(piece.high_node, []).append(piece.id)
    down = {piece.id: tuple(from_low.get(piece.high_node, ())) for piece in line.pieces.values()}
    up = {piece.id: tuple(from_high.get(piece.low_node, ())) for piece in line.pieces.values()}
    overlaps = {
        (track.section_id, direction): found
        for station in line.stations.values()
        for track in station.tracks
        for direction, onward, back in ((Direction.DOWN, down, up), (Direction.UP, up, down))
        if back[track.piece_id] and (found := _fouled(line, track, direction, onward))
    }
    return Graph(line, down, up, overlaps)


def _fouled(
    line: Line, track: PlatformTrack, direction: Direction, onward: dict[str, tuple[str, ...]]
) -> tuple[str, ...]:
    """Points sections that begin within the overlap beyond a train's stop on a track, the nearest first.

    It stops at its mark, else before the end of the track. Open line beyond the points is not among them.
    """
    piece, overlap_m = line.pieces[track.piece_id], track.overlaps_m.get(direction, 0.0)
    if overlap_m == 0.0 or line.sections[track.section_id].kind is not SectionKind.TRACK:
        return ()
    end_m = piece.to_m if direction is Direction.DOWN else piece.from_m
    found: dict[str, None] = {}
    ways = [(next_id, abs(end_m - track.marks_m.get(direction, end_m))) for next_id in onward[piece.id]]
    for piece_id, away_m in ways:
        if _section_of(line, piece_id).kind is SectionKind.POINTS and away_m < overlap_m:
            found[line.pieces[piece_id].section_id] = None
            ways += [(next_id, away_m + line.pieces[piece_id].length_m) for next_id in onward[piece_id]]
    return tuple(found)


def overlap_id(section_id: str) -> str:
    """What is one train's at a time where it comes in, or goes out, over points that another could foul."""
    return f"{section_id} overlap"


def fouled_sections(line: Line) -> frozenset[str]:
    """Points sections that lie in the overlap of any track."""
    return frozenset(section_id for found in Graph.of_line(line).overlaps.values() for section_id in found)


def next_pieces(line: Line, piece_id: str, direction: Direction) -> tuple[str, ...]:
    """Pieces that follow `piece_id` in `direction`: two at a toe (normal leg first), none at the end.

    Raises KeyError for an unknown piece.
    """
    graph = Graph.of_line(line)
    return (graph.down if direction is Direction.DOWN else graph.up)[piece_id]


def required_position(line: Line, piece_id: str) -> tuple[str, Position] | None:
    """Points and position that a run over the piece needs, facing or trailing; None unless it is a leg."""
    piece = line.pieces[piece_id]
    if piece.points_id is None or piece.leg is None or piece.leg is PointsLeg.STEM:
        return None
    return piece.points_id, _POSITION[piece.leg]


def required_positions(line: Line, piece_ids: Sequence[str]) -> tuple[tuple[str, Position], ...]:
    """Points and positions that a run over `piece_ids` needs, in order of travel."""
    needed = (required_position(line, piece_id) for piece_id in piece_ids)
    return tuple(item for item in needed if item is not None)


class TooManyRoutesError(ValueError):
    """The ways from one place to the next tracks are too many to be written down."""


def routes_from(line: Line, section_id: str, direction: Direction) -> tuple[Route, ...]:
    """All routes from a track or portal to the next tracks or portals in `direction`, normal legs first.

    A route's id is `from>to`; a second way between the same two has `#2` behind it. Raises KeyError for an
    unknown section, ValueError when the section is neither track nor portal, TooManyRoutesError beyond TRAILS_MAX.
    """
    known = Graph.of_line(line).known
    if (section_id, direction) not in known:
        known[section_id, direction] = _found_from(line, section_id, direction)
    return known[section_id, direction]


def _found_from(line: Line, section_id: str, direction: Direction) -> tuple[Route, ...]:
    section = line.sections[section_id]
    if section.kind not in _STOPS:
        raise ValueError(f"routes begin on a track or portal; {section_id} is {section.kind.value}")
    routes: list[Route] = []
    ways: dict[str, int] = {}
    trails = [list(section.piece_ids)]
    looked = 0
    while trails:
        trail = trails.pop()
        looked += 1
        if looked > TRAILS_MAX:
            raise TooManyRoutesError(section_id)
        if len(trail) > 1 and _section_of(line, trail[-1]).kind in _STOPS:
            name = f"{section_id}>{_section_of(line, trail[-1]).id}"
            ways[name] = ways.get(name, 0) + 1
            suffix = f"#{ways[name]}" if ways[name] > 1 else ""
            routes.append(_route(line, name + suffix, direction, trail))
            continue
        following = next_pieces(line, trail[-1], direction)
        trails.extend([*trail, piece_id] for piece_id in reversed(following) if piece_id not in trail)
    return tuple(routes)


def overlaps_coming_in(line: Line, route: Route) -> tuple[str, ...]:
    """What a train has alone from its leave to come in by a route until it stands (`wayside.entering`)."""
    own = (s for s in route.entry if s in fouled_sections(line))
    return tuple(map(overlap_id, dict.fromkeys((*route.overlap, *own))))


def overlaps_going_out(line: Line, route: Route) -> tuple[str, ...]:
    """What it has alone from the grant of a route until it has given its first points back."""
    fouled = fouled_sections(line).difference(route.entry)
    return tuple(overlap_id(s) for s in route.section_ids if s in fouled)


def all_routes(line: Line) -> tuple[Route, ...]:
    """Every route of the line, both directions, in the order of its sections."""
    return tuple(
        route
        for section in line.sections.values()
        if section.kind in _STOPS
        for direction in Direction
        for route in routes_from(line, section.id, direction)
    )


def find_route(line: Line, from_section: str, to_section: str, direction: Direction) -> Route | None:
    """The route from one track or portal to the next one `to_section`, or None; errors as `routes_from`."""
    for route in routes_from(line, from_section, direction):
        if route.to_section == to_section:
            return route
    return None


def reachable_stops(line: Line, section_id: str, direction: Direction) -> tuple[str, ...]:
    """Tracks and portals that a train from `section_id` can get to in `direction`, nearest first.

    The section itself is not among them. Errors as `routes_from`.
    """
    reached = [section_id]
    for stop in reached:
        for route in routes_from(line, stop, direction):
            if route.to_section not in reached:
                reached.append(route.to_section)
    return tuple(reached[1:])


def _section_of(line: Line, piece_id: str) -> Section:
    return line.sections[line.pieces[piece_id].section_id]


def _route(line: Line, name: str, direction: Direction, trail: list[str]) -> Route:
    pieces: list[Piece] = [line.pieces[piece_id] for piece_id in trail]
    section_ids = tuple(dict.fromkeys(piece.section_id for piece in pieces))
    first, last, points = section_ids[0], section_ids[-1], required_positions(line, trail)
    overlap = Graph.of_line(line).overlaps.get((last, direction), ())
    way = section_ids[1:-1]
    before = takewhile(lambda s: line.sections[s].kind is SectionKind.POINTS, reversed(way))
    entry = tuple(before)[::-1]
    if not overlap and fouled_sections(line).isdisjoint(entry):
        entry = ()
    return Route(name, direction, first, last, section_ids[1:], tuple(trail), points, entry, overlap)
