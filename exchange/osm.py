"""Import a track layout from OpenStreetMap (an .osm file: nodes and ways as XML).

Ways that are rails are cut where more or fewer than two of them meet, and joined again where just two of one name and
kind do. Nodes at which three meet are points where their directions allow it; the tag `railway=switch` is compared,
not trusted. Kilometrage comes from milestones (`railway:position`). What the tags mean: OpenStreetMap wiki,
OpenRailwayMap/Tagging.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from exchange.geometry import plane_projection
from exchange.layout import (
    ForeignLayout,
    KmRow,
    LayoutCrossing,
    LayoutNode,
    LayoutPoints,
    LayoutSignal,
    LayoutStation,
    LayoutTrack,
    Milestone,
    NodeKind,
    Place,
    Spot,
    TurnoutSide,
    count_text,
)
from exchange.layout_draft import JoinedEnds, Merged, carried_kilometrage, km_rows, merged_pieces
from exchange.layout_geometry import direction_from, length_of_m, nearest_spot, stem_and_legs
from exchange.osm_roads import ROAD_TAGS, protection_of
from exchange.xml_input import local_name, needed_attribute, needed_number, read_xml
from network.errors import InputError

RAILS: Final = frozenset({"rail", "narrow_gauge", "light_rail"})
STATION_TAGS: Final = frozenset({"station", "halt", "stop", "tram_stop"})
NEAR_M: Final = 150.0  # of a station's node from its track, where no stop lies on one
SPREAD_M: Final = 1000.0  # of the stops of one station, assumed: its tracks reach no further
EXTENT_DEG_MAX: Final = 3.0  # of the cut: beyond, one plane is no longer true to scale


@dataclass(frozen=True, slots=True)
class _OsmNode:
    id: str
    place: Place
    tags: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class _OsmWay:
    id: str
    nodes: tuple[str, ...]
    tags: Mapping[str, str]


@dataclass(slots=True)
class _Source:
    """The file, its rails only. `places_of` are pieces of track and offsets at which a node lies on them."""

    file: str
    origin_deg: Place
    nodes: dict[str, _OsmNode]
    same: JoinedEnds  # nodes that a way has one upon the other
    ways: list[_OsmWay]
    cut: int = 0
    left: Counter[str] = field(default_factory=Counter)
    places_of: dict[str, list[tuple[str, float]]] = field(default_factory=lambda: defaultdict(list))


def read_osm(path: Path) -> ForeignLayout:
    """The layout of an OpenStreetMap file. Raises InputError for another form, or a file without rails."""
    source = _read(path)
    pieces = list(_pieces(source))
    meeting = _meeting(pieces)
    fixed = frozenset(node for node, ends in meeting.items() if len(ends) != 2)
    done = merged_pieces(pieces, fixed)
    meeting = _meeting(done.tracks)
    points, slips, odd = _points(source, meeting)
    milestones = tuple(_milestones(source, done))
    measured, unused = _measured(done.tracks, milestones)
    tracks, given = carried_kilometrage(measured, points, names_are_lines=True)
    stations, homeless = _stations(source, done, tracks)
    signals = tuple(_signals(source, done))
    crossings = tuple(_level_crossings(source, done))
    nodes = tuple(_node(source, node, ends, slips) for node, ends in meeting.items())
    used = _used(source, tracks, points, stations, signals, milestones)
    used += [count_text(len(crossings), "level crossing")] if crossings else []
    assumed = _assumed(source, points, given, tracks)
    unsaid = sum(crossing.kind is None for crossing in crossings)
    if unsaid:
        assumed.append(
            f"{count_text(unsaid, 'level crossing')}: barriers, as the map does not say what there is"
        )
    left = [*odd, *unused, *homeless, *_left(source)]
    without = sum(not track.kilometrage for track in tracks)
    if without:
        left.append(
            f"no kilometrage: {count_text(without, 'track')}, with no milestones on them or on those they continue"
        )
    return ForeignLayout(
        path.name.partition(".")[0],
        f"OpenStreetMap contributors (ODbL 1.0), {path.name}",
        nodes,
        tuple(tracks),
        tuple(points),
        tuple(stations),
        signals,
        milestones,
        tuple(used),
        tuple(assumed),
        tuple(left),
        source.origin_deg,
        crossings,
    )


def _read(path: Path) -> _Source:
    file = str(path)
    root = read_xml(path)
    if local_name(root) != "osm":
        raise InputError(
            file, "", None, f"OpenStreetMap XML, but the outermost element is {local_name(root)}"
        )
    left = Counter[str]()
    ways = _ways(file, root, left)
    for element in root.iterfind("relation"):
        if "railway" in (tags := _tags(element)) or tags.get("route") in ("railway", "train", "tracks"):
            left["relation"] += 1
    if not ways:
        raise InputError(file, "", None, f"ways with railway={' or '.join(sorted(RAILS))}")
    wanted = {ref for way in ways for ref in way.nodes}
    found: dict[str, tuple[float, float, dict[str, str]]] = {}
    for element in root.iterfind("node"):
        node_id, tags = needed_attribute(file, element, "id"), _tags(element)
        if node_id in wanted or "railway" in tags:
            lon, lat = (needed_number(file, element, name) for name in ("lon", "lat"))
            if abs(lat) > 89 or abs(lon) > 180:
                raise InputError(file, f"node {node_id}", [lon, lat], "longitude and latitude in degrees")
            found[node_id] = lon, lat, tags
    on_rails = np.array([found[ref][:2] for ref in wanted if ref in found], dtype=np.float64)
    if not len(on_rails):
        raise InputError(file, "", None, "the nodes of its ways, none of which is in the file")
    (low_lon, low_lat), (high_lon, high_lat) = on_rails.min(axis=0), on_rails.max(axis=0)
    if max(high_lon - low_lon, high_lat - low_lat) > EXTENT_DEG_MAX:
        raise InputError(file, "", None, f"a cut of at most {EXTENT_DEG_MAX:g} degrees")
    lon0, lat0 = round(float(low_lon + high_lon) / 2.0, 4), round(float(low_lat + high_lat) / 2.0, 4)
    project = plane_projection(path, lat0, lon0)
    places = project(np.array([(lon, lat) for lon, lat, _ in found.values()], dtype=np.float64))
    nodes = {
        node_id: _OsmNode(node_id, (round(float(x), 3), round(float(y), 3)), tags)
        for (node_id, (_, _, tags)), (x, y) in zip(found.items(), places, strict=True)
    }
    source = _Source(file, (lon0, lat0), nodes, _same_nodes(nodes, ways), [], left=left)
    source.ways = list(_whole(source, ways))
    return source


def _ways(file: str, root: ET.Element, left: Counter[str]) -> list[_OsmWay]:
    """Ways that are rails; of two extracts put together, one that both have counts once."""
    by_id: dict[str, _OsmWay] = {}
    for element in root.iterfind("way"):
        tags = _tags(element)
        kind = tags.get("railway", "")
        if kind in RAILS and tags.get("area") != "yes":
            refs = tuple(needed_attribute(file, nd, "ref") for nd in element.iterfind("nd"))
            way = _OsmWay(needed_attribute(file, element, "id"), refs, tags)
            if by_id.setdefault(way.id, way) != way:
                raise InputError(file, f"way {way.id}", None, "an id of its own")
        elif kind:
            left[f"way of railway={kind}"] += 1
    return list(by_id.values())


def _same_nodes(nodes: Mapping[str, _OsmNode], ways: Iterable[_OsmWay]) -> JoinedEnds:
    """Nodes that a way has one upon the other: what goes on at one of them goes on at all."""
    same = JoinedEnds()
    for one, other in (pair for way in ways for pair in pairwise(way.nodes)):
        if one in nodes and other in nodes and nodes[one].place == nodes[other].place:
            same.join((one, 0), (other, 0))
    return same


def _tags(element: ET.Element) -> dict[str, str]:
    return {tag.get("k", ""): tag.get("v", "") for tag in element.iterfind("tag")}


def _whole(source: _Source, ways: Iterable[_OsmWay]) -> Iterator[_OsmWay]:
    """Ways without the nodes that the cut has left out; one that it parts becomes several."""
    for way in ways:
        parts: list[list[str]] = [[]]
        for ref in way.nodes:
            node, _ = source.same.node_end((ref, 0))
            if node not in source.nodes:
                parts.append([])
            elif parts[-1][-1:] != [node]:
                parts[-1].append(node)
        source.cut += len(parts) > 1
        for number, part in enumerate(part for part in parts if len(part) > 1):
            yield replace(way, id=f"{way.id}~{number + 1}" if number else way.id, nodes=tuple(part))


def _pieces(source: _Source) -> Iterator[LayoutTrack]:
    """Ways cut at every node where not just two of them go on."""
    degree: Counter[str] = Counter()
    for way in source.ways:
        degree.update(way.nodes[1:-1])
        degree.update(way.nodes[1:-1])
        degree.update((way.nodes[0], way.nodes[-1]))
    for way in source.ways:
        last_i = len(way.nodes) - 1
        cuts = [0, *(i for i in range(1, last_i) if degree[way.nodes[i]] != 2), last_i]
        for number, (first, last) in enumerate(pairwise(cuts)):
            piece_id = f"{way.id}.{number + 1}" if number else way.id
            shape = tuple(source.nodes[ref].place for ref in way.nodes[first : last + 1])
            for i in range(first, last + 1):
                offset_m = length_of_m(shape[: i - first + 1])
                source.places_of[way.nodes[i]].append((piece_id, round(offset_m, 6)))
            yield LayoutTrack(
                piece_id,
                way.tags.get("railway:track_ref") or way.tags.get("ref") or way.tags.get("name", ""),
                way.tags.get("service") or way.tags.get("usage", ""),
                way.nodes[first],
                way.nodes[last],
                round(length_of_m(shape), 6),
                shape,
            )


def _meeting(tracks: Iterable[LayoutTrack]) -> dict[str, list[tuple[LayoutTrack, bool]]]:
    """At each node the tracks that end there, True where it is their high end."""
    found: dict[str, list[tuple[LayoutTrack, bool]]] = defaultdict(list)
    for track in tracks:
        found[track.low_node].append((track, False))
        found[track.high_node].append((track, True))
    return found


def _points(
    source: _Source, meeting: Mapping[str, list[tuple[LayoutTrack, bool]]]
) -> tuple[list[LayoutPoints], set[str], list[str]]:
    """Points, crossings, and in sentences what the map calls points and is none, or the other way round."""
    points: list[LayoutPoints] = []
    crossings: set[str] = set()
    odd: list[str] = []
    for node, ends in meeting.items():
        if len(ends) == 3:
            found = stem_and_legs([direction_from(track.shape, from_high=high) for track, high in ends])
            if found is None:
                crossings.add(node)
                odd.append(f"not among points: node {node}, at which three tracks meet as no points do")
                continue
            stem, straight, branch = (ends[i][0] for i in (found.stem, found.straight, found.branch))
            # Where one leg alone bears the stem's name and kind it is the line that goes on, whatever the angles.
            same = [leg for leg in (straight, branch) if (leg.name, leg.kind) == (stem.name, stem.kind)]
            side = found.side
            if same == [branch]:
                straight, branch = branch, straight
                side = TurnoutSide.RIGHT if side is TurnoutSide.LEFT else TurnoutSide.LEFT
            tags = source.nodes[node].tags
            points.append(
                LayoutPoints(node, tags.get("ref", ""), node, stem.id, straight.id, branch.id, side)
            )
        elif len(ends) > 3:
            crossings.add(node)
            odd.append(f"not among points: node {node}, a crossing or slip at which {len(ends)} tracks meet")
    inner = {node for node, tag in source.nodes.items() if tag.tags.get("railway") == "switch"}
    for node in sorted(inner - {entry.id for entry in points} - crossings):
        count = len(meeting.get(node, ())) or 2 * bool(source.places_of.get(node))
        odd.append(
            f"not among points: node {node}, called a switch, but {count_text(count, 'track end')} meet there"
        )
    return points, crossings, odd


def _node(
    source: _Source,
    node: str,
    ends: Sequence[tuple[LayoutTrack, bool]],
    crossings: set[str],
) -> LayoutNode:
    if node in crossings:
        kind = NodeKind.CROSSING
    elif len(ends) == 3:
        kind = NodeKind.POINTS
    elif len(ends) == 2:
        kind = NodeKind.JOINT
    else:
        stop = source.nodes[node].tags.get("railway") == "buffer_stop"
        kind = NodeKind.BUFFER if stop else NodeKind.OPEN
    return LayoutNode(node, kind, source.nodes[node].place)


def _on_track(source: _Source, done: Merged, node: str) -> tuple[str, float, int] | None:
    """Track, offset and sense of the piece at which a node lies; None where it lies on none."""
    for piece_id, offset_m in source.places_of.get(source.same.node_end((node, 0))[0], ()):
        moved = done.moved[piece_id]
        return moved.track_id, moved.offset_m(offset_m), moved.sign
    return None


def _milestones(source: _Source, done: Merged) -> Iterator[Milestone]:
    for node in source.nodes.values():
        if node.tags.get("railway") != "milestone":
            continue
        texts = (node.tags.get(f"railway:position{exact}") for exact in (":exact", ""))
        km = next((km for text in texts if (km := _kilometres(text)) is not None), None)
        here = _on_track(source, done, node.id)
        if km is None or here is None:
            source.left["milestone without a kilometrage or beside the tracks"] += 1
            continue
        yield Milestone(here[0], here[1], round(km * 1000.0, 3))


def _kilometres(text: str | None) -> float | None:
    """`149.2`, `149,2` or the first of several; None for anything else."""
    try:
        value = float((text or "").split(";")[0].replace(",", ".").strip())
    except ValueError:
        return None
    return value if abs(value) < 1e5 else None


def _measured(
    tracks: Sequence[LayoutTrack], milestones: Iterable[Milestone]
) -> tuple[list[LayoutTrack], list[str]]:
    """Tracks with the kilometrage of their milestones, two at least; and what was not used, in sentences."""
    rows: dict[str, list[KmRow]] = defaultdict(list)
    for post in milestones:
        rows[post.track_id].append((post.offset_m, post.position_m))
    measured: list[LayoutTrack] = []
    alone = crossed = 0
    for track in tracks:
        known = sorted(rows.get(track.id, ()))
        steps = {(b[1] > a[1]) - (b[1] < a[1]) for a, b in pairwise(known)} - {0}
        if len(steps) > 1:
            crossed += 1
            known = []
        elif len({km_m for _, km_m in known}) < 2:
            alone += bool(known)
            known = []
        measured.append(replace(track, kilometrage=km_rows(track.length_m, known, ())))
    remarks: list[str] = []
    if alone:
        remarks.append(
            f"{count_text(alone, 'milestone')} alone on a track: which way its kilometrage grows is not said"
        )
    if crossed:
        remarks.append(f"milestones of {count_text(crossed, 'track')}, which are in no order")
    return measured, remarks


def _stations(
    source: _Source, done: Merged, tracks: Sequence[LayoutTrack]
) -> tuple[list[LayoutStation], list[str]]:
    """Stations by name: stops on tracks are their spots; one without any takes the nearest track."""
    named: dict[str, list[_OsmNode]] = defaultdict(list)
    remarks: list[str] = []
    for node in source.nodes.values():
        if node.tags.get("railway") in STATION_TAGS:
            named[node.tags.get("name", "")].append(node)
    if nameless := len(named.pop("", ())):
        remarks.append(f"{count_text(nameless, 'stop')} without a name")
    by_id = {track.id: track for track in tracks}
    stations: list[LayoutStation] = []
    for name, nodes in named.items():
        spots = [
            Spot(here[0], here[1], node.tags.get("local_ref") or node.tags.get("ref", ""))
            for node in nodes
            if (here := _on_track(source, done, node.id)) is not None
        ]
        if not spots and (near := nearest_spot(nodes[0].place, tracks, NEAR_M)) is not None:
            spots = [near]
        if not spots:
            remarks.append(f"no place on the tracks: station {name}")
        known = [km_m for spot in spots if (km_m := by_id[spot.track_id].km_m(spot.offset_m)) is not None]
        code = next((n.tags["railway:ref"] for n in nodes if "railway:ref" in n.tags), "")
        position_m = round(sum(known) / len(known), 3) if known else None
        if known and max(known) - min(known) > SPREAD_M:
            position_m = None
            remarks.append(
                f"no kilometrage: station {name}, whose stops lie at km {min(known) / 1000:.3f} to"
                f" {max(known) / 1000:.3f}: several of a name, or of several lines"
            )
        stations.append(LayoutStation(nodes[0].id, code, name, position_m, tuple(spots)))
    stations.sort(key=lambda entry: (entry.position_m is None, entry.position_m or 0.0))
    return stations, remarks


def _signals(source: _Source, done: Merged) -> Iterator[LayoutSignal]:
    for node in source.nodes.values():
        if node.tags.get("railway") != "signal":
            continue
        here = _on_track(source, done, node.id)
        facing = node.tags.get("railway:signal:direction", "")
        if here is None or facing not in ("forward", "backward"):
            source.left["signal beside the tracks or facing nowhere"] += 1
            continue
        forward = (facing == "forward") == (here[2] > 0)
        yield LayoutSignal(node.tags.get("ref", ""), here[0], here[1], forward)


def _level_crossings(source: _Source, done: Merged) -> Iterator[LayoutCrossing]:
    """Nodes that a road or path shares with a track."""
    for node in source.nodes.values():
        if node.tags.get("railway") not in ROAD_TAGS:
            continue
        here = _on_track(source, done, node.id)
        if here is None:
            source.left["level crossing beside the tracks"] += 1
            continue
        yield LayoutCrossing(node.tags.get("name", ""), here[0], here[1], protection_of(node.tags))


def _used(
    source: _Source,
    tracks: Sequence[LayoutTrack],
    points: Sequence[LayoutPoints],
    stations: Sequence[LayoutStation],
    signals: Sequence[LayoutSignal],
    milestones: Sequence[Milestone],
) -> list[str]:
    service = Counter(way.tags["service"] for way in source.ways if "service" in way.tags)
    spots = sum(len(station.spots) for station in stations)
    ways = count_text(len({way.id.partition("~")[0] for way in source.ways}), "way")
    used = [
        f"{ways} as {count_text(len(tracks), 'track')} of {sum(t.length_m for t in tracks) / 1000:.3f} km in all",
        f"{count_text(len(points), 'set of points', 'sets of points')}",
        f"{count_text(len(stations), 'station')} with {count_text(spots, 'stop')}",
        count_text(len(signals), "signal"),
        count_text(len(milestones), "milestone"),
    ]
    if service:
        kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(service.items()))
        used.insert(1, f"service tracks among them: {kinds}")
    return used


def _assumed(
    source: _Source, points: Sequence[LayoutPoints], given: Sequence[str], tracks: Sequence[LayoutTrack]
) -> list[str]:
    assumed = ["lengths are those of the mapped polylines on a plane (transverse Mercator, GRS80)"]
    unsaid = sum(source.nodes[entry.node_id].tags.get("railway") != "switch" for entry in points)
    if unsaid:
        count = count_text(unsaid, "set of points", "sets of points")
        assumed.append(f"{count}: three tracks meet there, though the map has no railway=switch")
    if points:
        assumed.append(
            "the stem of points is the track that both others run on into; the normal leg is the one of the stem's name"
            " and kind, else the straighter one"
        )
    if source.cut:
        assumed.append(f"{count_text(source.cut, 'way')} reached beyond the file: cut there")
    if given:
        assumed.append(
            f"kilometrage of {count_text(len(given), 'track')} carried over from those they continue"
        )
    if any(track.kilometrage for track in tracks):
        assumed.append("milestones stand where they say, though most show whole hundreds of metres")
    return assumed


def _left(source: _Source) -> list[str]:
    known = STATION_TAGS | {"switch", "signal", "milestone", "buffer_stop"} | ROAD_TAGS
    for node in source.nodes.values():
        kind = node.tags.get("railway", "")
        if kind and kind not in known:
            source.left[f"node of railway={kind}"] += 1
    speeds = sum("maxspeed" in way.tags for way in source.ways)
    if speeds:
        source.left["speed limit of a way"] = speeds
    plurals = {
        "level crossing beside the tracks": "level crossings beside the tracks",
        "speed limit of a way": "speed limits of ways",
        "signal beside the tracks or facing nowhere": "signals beside the tracks or facing nowhere",
        "milestone without a kilometrage or beside the tracks": (
            "milestones without a kilometrage or beside the tracks"
        ),
    }
    return [
        count_text(
            count, what, plurals.get(what, what.replace("node of", "nodes of").replace("way of", "ways of"))
        )
        if " of " in what or what in plurals
        else count_text(count, what)
        for what, count in sorted(source.left.items())
    ]
