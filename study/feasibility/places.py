"""Names of places for people, and the remedies that a line offers."""

from __future__ import annotations

from collections.abc import Mapping

from network.graph import find_route
from network.model import Line, SectionKind, Station
from study.feasibility.holdings import Hold, HoldingConflict


def station_of(line: Line, section_id: str) -> Station | None:
    """The station whose track a section is, or whose points; None for any other section."""
    return line.stations.get(line.sections[section_id].station_id or "")


def track_place(line: Line, section_id: str) -> tuple[str, str]:
    """Id of the place of a section, and its name with the track: `track 1 at Mori`, or `section MRI.W`."""
    section = line.sections[section_id]
    station = station_of(line, section_id) if section.kind is SectionKind.TRACK else None
    if station is None:
        kind = "portal" if section.kind is SectionKind.PORTAL else "section"
        return section_id, f"{kind} {section_id}"
    track = next(t.name for t in station.tracks if t.section_id == section_id)
    return station.id, f"track {track} at {station.name}"


def has_two_tracks(station: Station) -> bool:
    """Whether trains can pass each other there."""
    return not station.is_halt and len({track.section_id for track in station.tracks}) > 1


def is_end(line: Line, station_id: str) -> bool:
    """Whether no station lies beyond this one, on one side of it at least."""
    order = sorted(line.stations.values(), key=lambda station: station.position_m)
    return station_id in {station.id for station in (order[0], order[-1])}


def where_to_pass(line: Line, position_m: float, but: str | None) -> str:
    """The nearest station with two tracks, in words, other than the one where the trains would meet."""
    passing = [s for s in line.stations.values() if has_two_tracks(s) and s.id != but]
    nearest = min(passing, key=lambda s: abs(s.position_m - position_m), default=None)
    other = "" if but is None else "other "
    if nearest is None:
        return f"no {other}station has two tracks"
    return f"the nearest {other}station with two tracks is {nearest.name}"


def free_track(line: Line, clash: HoldingConflict, by_section: Mapping[str, list[Hold]]) -> str | None:
    """A track of the same station that the second train can reach and that nobody else holds then; None without.

    With a platform where its passengers get on or off.
    """
    second = clash.second
    train = second.trains[0]
    station = station_of(line, clash.section_id)
    before = next((r.from_section for r in train.routes if r.to_section == clash.section_id), None)
    if station is None or before is None:
        return None
    stops = [
        node.target for one in second.trains for node in one.nodes if node.section_id == clash.section_id
    ]
    passengers = any(target is not None and target.passengers for target in stops)
    for track in station.tracks:
        if track.section_id == clash.section_id or train.direction not in track.marks_m:
            continue
        if passengers and track.platform_m is None:
            continue
        others = by_section.get(track.section_id, [])
        occupied = any(
            hold.stock_id != second.stock_id and hold.from_s < second.to_s and second.from_s < hold.to_s
            for hold in others
        )
        if not occupied and find_route(line, before, track.section_id, train.direction) is not None:
            return track.name
    return None
