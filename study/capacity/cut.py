"""How a line is cut before its timetable is compressed: the answer depends on it, so it is stated with every result.

A part is a set of sections that is compressed by itself: a stretch of line, or a node (the tracks and points of one
station). Points lie in the stretches that lead over them as well as in their node, for a route takes them with both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from types import MappingProxyType
from typing import Final

from network.errors import InputError
from network.files.toml_input import one_of
from network.graph import routes_from
from network.model import Direction, Line, SectionKind, Station


class PartKind(StrEnum):
    """What a part of a cut line is."""

    LINE = "line"
    NODE = "node"


@dataclass(frozen=True, slots=True)
class CutPart:
    """What is compressed by itself: its sections, and the names of the stations at its ends."""

    name: str
    kind: PartKind
    section_ids: frozenset[str]


@dataclass(frozen=True, slots=True)
class LineCut:
    """A line in parts; `how` says in words how it was cut."""

    name: str
    how: str
    parts: tuple[CutPart, ...]


def is_crossing_station(station: Station) -> bool:
    """Whether two trains can be there at once."""
    return not station.is_halt and len(station.tracks) > 1


def _as_one_part(line: Line) -> tuple[CutPart, ...]:
    sections = frozenset(s.id for s in line.sections.values() if s.kind is not SectionKind.PORTAL)
    stations = _stations(line)
    return (CutPart(_name(stations[0], stations[-1]), PartKind.LINE, sections),)


def _crossing(line: Line) -> tuple[CutPart, ...]:
    """From one station where trains can pass each other to the next, or to the end of the line."""
    stations = _stations(line)
    ends = [s for s in stations if is_crossing_station(s) or s in (stations[0], stations[-1])]
    parts: list[CutPart] = []
    for low, high in pairwise(ends):
        inside = [s for s in stations if low.position_m <= s.position_m <= high.position_m]
        sections = {one for a, b in pairwise(inside) for one in _between(line, a, b)}
        single = [s for s in inside if not is_crossing_station(s)]
        sections |= {track.section_id for station in single for track in station.tracks}
        parts.append(CutPart(_name(low, high), PartKind.LINE, frozenset(sections)))
    return tuple(parts)


def _interval(line: Line) -> tuple[CutPart, ...]:
    """From each station to the next without their tracks; then each station as a node."""
    stations = _stations(line)
    lines = (CutPart(_name(a, b), PartKind.LINE, _between(line, a, b)) for a, b in pairwise(stations))
    nodes = (CutPart(station.name, PartKind.NODE, _node(line, station)) for station in stations)
    return (*lines, *nodes)


def _section(line: Line) -> tuple[CutPart, ...]:
    node = {SectionKind.TRACK, SectionKind.POINTS}
    return tuple(
        CutPart(s.id, PartKind.NODE if s.kind in node else PartKind.LINE, frozenset({s.id}))
        for s in line.sections.values()
        if s.kind is not SectionKind.PORTAL
    )


SINGLE_TRACK_CUT: Final = "crossing"
WAYS: Final[Mapping[str, tuple[str, Callable[[Line], tuple[CutPart, ...]]]]] = MappingProxyType(
    {
        "whole": ("the whole line at once: trains keep all their stops and meets", _as_one_part),
        SINGLE_TRACK_CUT: (
            "between stations where trains can pass each other; single tracks and ends of the line belong to it",
            _crossing,
        ),
        "interval": ("between each two stations without their tracks; each station is a node", _interval),
        "section": ("every section by itself", _section),
    }
)


def cut_of(line: Line, name: str) -> LineCut:
    """A line cut in one of the ways; InputError for another."""
    if name not in WAYS:
        raise InputError("command line", "--cut", name, one_of([*WAYS, "all"], name))
    how, parts = WAYS[name]
    return LineCut(name, how, parts(line))


def _stations(line: Line) -> list[Station]:
    return sorted((s for s in line.stations.values() if not s.is_halt), key=lambda s: s.position_m)


def _name(low: Station, high: Station) -> str:
    return f"{low.name} - {high.name}"


def _between(line: Line, low: Station, high: Station) -> frozenset[str]:
    """What lies between two stations: all that routes from one to the other take, but for the tracks at their end."""
    reached = {track.section_id for track in high.tracks}
    routes = (
        route
        for track in low.tracks
        for route in routes_from(line, track.section_id, Direction.DOWN)
        if route.to_section in reached
    )
    return frozenset(one for route in routes for one in route.section_ids[:-1])


def _node(line: Line, station: Station) -> frozenset[str]:
    """Tracks of a station, and the points next to them."""
    tracks = [track.section_id for track in station.tracks]
    found = set(tracks)
    for track_id in tracks:
        for direction in Direction:
            for route in routes_from(line, track_id, direction):
                found |= _until_open(line, route.section_ids)
    return frozenset(found)


def _until_open(line: Line, section_ids: Iterable[str]) -> set[str]:
    """The points that come first on a way out of a station."""
    found: set[str] = set()
    for section_id in section_ids:
        if line.sections[section_id].kind is not SectionKind.POINTS:
            break
        found.add(section_id)
    return found
