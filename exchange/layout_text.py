"""What a layout becomes: a station list that `branchline new line` takes, JSON, and what keeps it from being a line."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, Final

from exchange.layout import (
    ForeignLayout,
    LayoutCrossing,
    LayoutNode,
    LayoutStation,
    LayoutTrack,
    NodeKind,
    count_text,
)
from network.files.names import is_identifier, title_of

SHOWN_MAX: Final = 5  # places that one sentence names
_NO_ID: Final = re.compile(r"[^A-Za-z0-9_-]+")


def stations_in_order(layout: ForeignLayout) -> tuple[LayoutStation, ...]:
    """Stations with a kilometrage, by it; of two at one place or of one name the first alone."""
    found: list[LayoutStation] = []
    for station in layout.stations:
        if station.position_m is not None and station.name.strip():
            found.append(station)
    found.sort(key=_position_m)
    kept: list[LayoutStation] = []
    for station in found:
        if title_of(station.name) in {title_of(other.name) for other in kept}:
            continue
        if not kept or round(_position_m(station) - _position_m(kept[-1]), 3) > 0:
            kept.append(station)
    return tuple(kept)


def obstacles(layout: ForeignLayout) -> tuple[str, ...]:
    """What is in the way of a line file that holds the whole layout, in sentences; single track with loops has none."""
    stations = stations_in_order(layout)
    found: list[str] = []
    if len(stations) < 2:
        found.append(
            f"{count_text(len(stations), 'station')} with a name and a kilometrage: a line has two at least"
        )
    crossings = [node for node in layout.nodes if node.kind is NodeKind.CROSSING]
    if crossings:
        found.append(
            f"{count_text(len(crossings), 'crossing or slip', 'crossings or slips')}"
            f" ({_some_nodes(layout, crossings)}): a line has ordinary points alone"
        )
    for track in layout.tracks:
        if track.low_node == track.high_node:
            found.append(f"track {track.name or track.id} comes back to where it begins: a line has two ends")
        for (offset_m, before_m), (again_m, after_m) in pairwise(track.kilometrage):
            if offset_m == again_m:
                found.append(
                    f"the kilometrage jumps from km {before_m / 1000:.3f} to {after_m / 1000:.3f} on track"
                    f" {track.name or track.id}: an alignment's runs on metre for metre"
                )
    for low, high in pairwise(stations):
        middle_m = (_position_m(low) + _position_m(high)) / 2
        side_by_side = [track for track in layout.tracks if _covers(track, middle_m)]
        if len(side_by_side) > 1:
            found.append(
                f"{len(side_by_side)} tracks side by side between {low.name} and {high.name}, at km"
                f" {middle_m / 1000:.3f}: a line is single between stations"
            )
    return tuple(found)


def station_list_toml(layout: ForeignLayout) -> str:
    """The stations as a list for `branchline new line`: names, kilometrage, tracks with a stop or a platform.

    Tracks of other kinds, where points lie and how long tracks are is not in it; `new line` has rules for that.
    """
    lines = ["# Stations of a layout; branchline new line makes a line of them.", "", "[line]"]
    if name := title_of(layout.name):
        lines.append(f"name = {_text(name)}")
    lines.append(f"sources = [{_text(layout.source)}]")
    assumed = [*layout.assumed, *(f"left out: {text}" for text in (*layout.left, *obstacles(layout)))]
    if assumed:
        lines += ["assumed = [", *(f"  {_text(text)}," for text in assumed), "]"]
    stations = stations_in_order(layout)
    if left := [title_of(s.name) or s.key for s in layout.stations if s not in stations]:
        where = "without a name or kilometrage, or with those of another"
        lines += ["", f"# {count_text(len(left), 'station')} left out, {where}: {title_of(', '.join(left))}"]
    taken: set[str] = set()
    for index, station in enumerate(stations):
        lines += ["", "[[stations]]", f"name = {_text(title_of(station.name))}"]
        code = station.code.strip()
        if is_identifier(code) and len(code) <= 24 and code not in taken:
            taken.add(code)
            lines.append(f"id = {_text(code)}")
        lines.append(f"km = {_position_m(station) / 1000:.6f}".rstrip("0").rstrip("."))
        names = _track_names(layout, station)
        if "." not in lines[-1]:
            lines[-1] += ".0"
        if len(names) > 1:
            lines.append(f"tracks = {len(names)}")
            if all(names) and len(set(names)) == len(names):
                lines.append(f"track_names = {_text(' '.join(names))}")
        if index in (0, len(stations) - 1) and _goes_on(layout, station, first=index == 0):
            lines.append('end = "portal"')
    return "\n".join([*lines, *_crossings(layout)]) + "\n"


def crossings_to_list(layout: ForeignLayout) -> tuple[tuple[float, LayoutCrossing], ...]:
    """Level crossings with a kilometrage, m, by it, between the first station and the last where one track lies."""
    ends_m = [_position_m(station) for station in stations_in_order(layout)]
    found: list[tuple[float, LayoutCrossing]] = []
    for crossing in layout.crossings:
        at_m = layout.km_of(crossing.track_id, crossing.offset_m)
        if at_m is None or not ends_m or not ends_m[0] < at_m < ends_m[-1]:
            continue
        if sum(_covers(track, at_m) for track in layout.tracks) == 1:
            found.append((at_m, crossing))
    return tuple(sorted(found, key=lambda one: one[0]))


def _crossings(layout: ForeignLayout) -> Iterator[str]:
    listed = crossings_to_list(layout)
    left = len(layout.crossings) - len(listed)
    if left:
        yield ""
        where = "beyond the stations, without a kilometrage, or over several tracks"
        yield f"# {count_text(left, 'level crossing')} left out: {where}"
    for at_m, crossing in listed:
        yield from ("", "[[crossings]]")
        yield f"km = {round(at_m / 1000.0, 6)}"
        if name := title_of(crossing.name):
            yield f"name = {_text(name)}"
        if crossing.kind is not None:
            yield f'kind = "{crossing.kind.value}"'


def as_dict(layout: ForeignLayout) -> dict[str, Any]:
    """The whole layout for JSON; lengths and kilometrages in m, places in m on the plane of `origin_deg`."""
    return {
        "name": layout.name,
        "source": layout.source,
        "taken": list(layout.used),
        "assumed": list(layout.assumed),
        "left": list(layout.left),
        "obstacles": list(obstacles(layout)),
        "origin_deg": layout.origin_deg,
        "nodes": [{"id": node.id, "kind": node.kind.value, "place_m": node.place} for node in layout.nodes],
        "tracks": [
            {
                "id": track.id,
                "name": track.name,
                "kind": track.kind,
                "low_node": track.low_node,
                "high_node": track.high_node,
                "length_m": track.length_m,
                "kilometrage_m": track.kilometrage,
            }
            for track in layout.tracks
        ],
        "points": [
            {
                "id": entry.id,
                "name": entry.name,
                "node": entry.node_id,
                "stem": entry.stem,
                "normal": entry.normal,
                "reverse": entry.reverse,
                "side": None if entry.side is None else entry.side.value,
                "diverging_kmh": entry.diverging_kmh,
            }
            for entry in layout.points
        ],
        "stations": [
            {
                "code": station.code,
                "name": station.name,
                "position_m": station.position_m,
                "spots": [[s.track_id, s.offset_m, s.track_name] for s in station.spots],
                "platforms": [[p.track_id, p.from_m, p.to_m, p.name] for p in station.platforms],
            }
            for station in layout.stations
        ],
        "signals": [[s.name, s.track_id, s.offset_m, s.forward] for s in layout.signals],
        "level_crossings": [
            [c.name, c.track_id, c.offset_m, None if c.kind is None else c.kind.value]
            for c in layout.crossings
        ],
        "milestones": [[m.track_id, m.offset_m, m.position_m] for m in layout.milestones],
    }


def _position_m(station: LayoutStation) -> float:
    return station.position_m if station.position_m is not None else 0.0


def _some_nodes(layout: ForeignLayout, nodes: list[LayoutNode]) -> str:
    """Where some nodes are, by kilometrage where there is one."""
    places: list[str] = []
    for node in nodes[:SHOWN_MAX]:
        km_m = next(iter(_km_at(layout, node.id)), None)
        places.append(f"node {node.id}" if km_m is None else f"km {km_m / 1000:.3f}")
    return ", ".join(places) + (", ..." if len(nodes) > SHOWN_MAX else "")


def _km_at(layout: ForeignLayout, node: str) -> Iterator[float]:
    for track_id in layout.ends_at[node]:
        track = layout.track_of[track_id]
        if track.kilometrage:
            yield track.kilometrage[0 if track.low_node == node else -1][1]


def _covers(track: LayoutTrack, km_m: float) -> bool:
    rows = [at_m for _, at_m in track.kilometrage]
    return bool(rows) and min(rows) <= km_m <= max(rows)


def _track_names(layout: ForeignLayout, station: LayoutStation) -> list[str]:
    """Names of a station's tracks as identifiers, in their order; empty where a track has none."""
    track_names = {spot.track_id: spot.track_name for spot in station.spots}
    names: list[str] = []
    for track_id in station.track_ids:
        name = _NO_ID.sub("", track_names.get(track_id, "") or layout.track_of[track_id].name)
        names.append(name if is_identifier(name) and name not in ("P", "W", "E") else "")
    # Sources name them in orders of their own; which side the first lies on is for the planner to say.
    return sorted(names, key=lambda name: (len(name), name))


def _goes_on(layout: ForeignLayout, station: LayoutStation, *, first: bool) -> bool:
    """Whether beyond the first or last station the rails reach an open end and no buffer stop."""
    here_m = _position_m(station)
    beyond = [
        node
        for node in layout.nodes
        for km_m in _km_at(layout, node.id)
        if node.kind in (NodeKind.OPEN, NodeKind.BUFFER) and (km_m < here_m if first else km_m > here_m)
    ]
    farthest = max(
        beyond, key=lambda node: max(abs(km_m - here_m) for km_m in _km_at(layout, node.id)), default=None
    )
    return farthest is not None and farthest.kind is NodeKind.OPEN


def _text(text: str) -> str:
    """A string of TOML."""
    return json.dumps(text.replace("\x7f", ""), ensure_ascii=False)
