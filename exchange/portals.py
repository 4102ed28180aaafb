"""Which portal of a line a train comes in or goes out by: found from the tracks, not from names."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from network.graph import routes_from
from network.model import Direction, Line, SectionKind


@dataclass(frozen=True, slots=True)
class PortalWay:
    """A way between a portal and a place: over how many routes, and where a set that is outside waits.

    `outside` names the station nearest the portal: sets that leave by one of its portals may come back by another.
    `only` is False where nothing tells it from a second portal.
    """

    section_id: str
    routes: int
    outside: str
    only: bool = True


def portal_of(line: Line, station_id: str, direction: Direction, *, entering: bool) -> PortalWay | None:
    """The portal by which a train in `direction` gets to (entering) or from a station; None where there is none.

    The nearest one, by routes; of several as near the left one in the direction of travel, as trains keep to the left
    on the two tracks of a main line; of several in one place the first by name. Raises KeyError for an unknown station.
    """
    wanted = {track.section_id for track in line.stations[station_id].tracks if direction in track.marks_m}
    into = direction if entering else direction.opposite  # a way out is a way in, run the other way
    found: list[tuple[int, float, str, str]] = []
    for section in line.sections.values():
        if section.kind is not SectionKind.PORTAL:
            continue
        ways = _ways_from(line, section.id, into)
        hops = [ways[section_id] for section_id in wanted if section_id in ways]
        if hops:
            offset_m = line.pieces[section.piece_ids[0]].offset_m * direction
            found.append((min(hops), offset_m, section.id, _nearest_station(line, section.id, ways)))
    if not found:
        return None
    nearest = min(found)
    routes, _, section_id, outside = nearest
    return PortalWay(section_id, routes, outside, sum(way[:2] == nearest[:2] for way in found) == 1)


def _ways_from(line: Line, portal: str, direction: Direction) -> dict[str, int]:
    """Sections that a run from a portal gets to, with how many routes it takes; sections between stations too."""
    reached: dict[str, int] = {}
    stops = deque([(portal, 0)])
    while stops:
        at, routes = stops.popleft()
        for route in routes_from(line, at, direction):
            fresh = route.to_section not in reached
            for section_id in route.section_ids:
                reached.setdefault(section_id, routes + 1)
            if fresh:
                stops.append((route.to_section, routes + 1))
    return reached


def _nearest_station(line: Line, portal: str, ways: dict[str, int]) -> str:
    """The station whose track is nearest the portal; the portal itself where no station is beyond it."""
    tracks = [
        (routes, section_id)
        for section_id, routes in ways.items()
        if line.sections[section_id].kind is SectionKind.TRACK
    ]
    nearest = min(tracks, default=(0, portal))[1]
    return line.sections[nearest].station_id or portal
