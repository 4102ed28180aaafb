"""Import a track layout from a SUMO net (`.net.xml`, also gzipped), with its stops from an additional file.

Two rail edges that are one another's `bidi` are a track, its low node where the first of them begins; lengths are
those of the lanes. Which of three tracks at a junction is the stem of points, the connections say; which leg is the
normal one only nets of our own say, else it is the straighter one. A parameter `kilometrage_m` of a stop, which our own
export writes, is its kilometrage.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from exchange.layout import (
    ForeignLayout,
    KmRow,
    LayoutNode,
    LayoutPoints,
    LayoutStation,
    LayoutTrack,
    NodeKind,
    Place,
    Platform,
    Spot,
    TurnoutSide,
    count_text,
)
from exchange.layout_draft import carried_kilometrage, km_rows
from exchange.layout_geometry import angle_deg, direction_from, stem_and_legs
from exchange.xml_input import local_name, needed_attribute, needed_number, number, read_xml
from network.errors import InputError

RAIL_CLASSES: Final = frozenset({"rail", "rail_urban", "rail_electric", "rail_fast", "subway", "tram"})
STOP_ELEMENTS: Final = ("trainStop", "busStop")
# Parameters of a stop in our own exports: of its mark, of its station and of its track.
KILOMETRAGE: Final = "kilometrage_m"
STATION: Final = "station"
TRACK: Final = "track"
NORMAL_AT: Final = "normal_at"  # parameter of an edge: junctions at which it is the normal leg
OUR_LEGS: Final = (".normal", ".reverse")  # how edges of our own lines' nets end, before their sign


@dataclass(frozen=True, slots=True)
class _Edge:
    id: str
    from_node: str
    to_node: str
    bidi: str
    length_m: float
    shape: tuple[Place, ...]
    name: str
    kind: str
    normal_at: frozenset[str]


@dataclass(slots=True)
class _NetFile:
    file: str
    edges: dict[str, _Edge] = field(default_factory=dict)
    nodes: dict[str, Place] = field(default_factory=dict)
    following: set[tuple[str, str]] = field(default_factory=set)
    left: Counter[str] = field(default_factory=Counter)


def read_sumo_net(path: Path, additional: Path | None = None) -> ForeignLayout:
    """The layout of a SUMO net, with the stops of an additional file. Raises InputError for other files."""
    net = _read(path)
    tracks, of_edge = _tracks(net)
    meeting: dict[str, list[tuple[LayoutTrack, bool]]] = defaultdict(list)
    for track in tracks:
        meeting[track.low_node].append((track, False))
        meeting[track.high_node].append((track, True))
    points: list[LayoutPoints] = []
    remarks: list[str] = []
    kinds = {node: _kind(net, node, ends, of_edge, points, remarks) for node, ends in meeting.items()}
    stations, known = _stations(net, additional, of_edge)
    rows = (km_rows(track.length_m, known.get(track.id, ()), ()) for track in tracks)
    tracks = [replace(track, kilometrage=row) for track, row in zip(tracks, rows, strict=True)]
    tracks, given = carried_kilometrage(tracks, points)
    by_id = {track.id: track for track in tracks}
    stations = [_placed(station, by_id) for station in stations]
    one_way = sum(not edge.bidi for edge in net.edges.values())
    used = [
        f"{count_text(len(tracks), 'track')} of {sum(track.length_m for track in tracks) / 1000:.3f} km in all",
        count_text(len(points), "set of points", "sets of points"),
        f"{count_text(len(stations), 'station')} with {count_text(sum(len(s.spots) for s in stations), 'stop')}",
    ]
    assumed: list[str] = []
    if points:
        assumed.append("the normal leg of points is the straighter one, where the net does not say")
    if one_way:
        assumed.append(f"{count_text(one_way, 'edge')} without a way back: a track all the same")
    if given:
        assumed.append(
            f"kilometrage of {count_text(len(given), 'track')} carried over from those they continue"
        )
    left = [*remarks, *(count_text(count, what) for what, count in sorted(net.left.items()))]
    without = sum(not track.kilometrage for track in tracks)
    if without:
        left.append(f"no kilometrage: {count_text(without, 'track')}; a net has none of its own")
    nodes = tuple(LayoutNode(node, kind, net.nodes.get(node)) for node, kind in kinds.items())
    return ForeignLayout(
        path.name.partition(".")[0],
        f"SUMO net, {path.name}",
        nodes,
        tuple(tracks),
        tuple(points),
        tuple(stations),
        (),
        (),
        tuple(used),
        tuple(assumed),
        tuple(left),
    )


def _read(path: Path) -> _NetFile:
    net = _NetFile(str(path))
    root = read_xml(path)
    if local_name(root) != "net":
        raise InputError(net.file, "", None, f"a SUMO net, but the outermost element is {local_name(root)}")
    for element in root.iterfind("edge"):
        if element.get("function", "normal") != "normal":
            continue
        lanes = element.findall("lane")
        if not lanes or not RAIL_CLASSES & set(lanes[0].get("allow", "").split()):
            net.left["edge for other traffic than trains"] += 1
            continue
        if len(lanes) > 1:
            net.left["edge with several lanes: the first alone"] += 1
        edge = _edge(net.file, element, lanes[0])
        net.edges[edge.id] = edge
    if not net.edges:
        raise InputError(net.file, "edge", None, "a SUMO net with an edge on which trains are allowed")
    for element in root.iterfind("junction"):
        x, y = (number(net.file, element, name) for name in ("x", "y"))
        if x is not None and y is not None:
            net.nodes[needed_attribute(net.file, element, "id")] = (x, y)
    for element in root.iterfind("connection"):
        origin, target = element.get("from", ""), element.get("to", "")
        if origin in net.edges and target in net.edges and net.edges[origin].bidi != target:
            net.following.add((origin, target))
    signals = sum(logic.get("type", "") == "rail_signal" for logic in root.iterfind("tlLogic"))
    if signals:
        net.left["rail signal"] = signals
    return net


def _edge(file: str, element: ET.Element, lane: ET.Element) -> _Edge:
    edge_id = needed_attribute(file, element, "id")
    length_m = needed_number(file, lane, "length")
    if length_m <= 0:
        raise InputError(file, f"edge {edge_id}: length", length_m, "a length, m")
    marks = {param.get("key"): param.get("value", "") for param in element.iterfind("param")}
    return _Edge(
        edge_id,
        needed_attribute(file, element, "from"),
        needed_attribute(file, element, "to"),
        element.get("bidi", ""),
        length_m,
        _shape(file, edge_id, lane.get("shape") or element.get("shape") or ""),
        element.get("name", "") or marks.get("track_ref", ""),
        element.get("type", ""),
        frozenset((marks.get(NORMAL_AT) or "").split()),
    )


def _shape(file: str, edge_id: str, text: str) -> tuple[Place, ...]:
    try:
        shape = tuple((float(x), float(y)) for x, y, *_ in (point.split(",") for point in text.split()))
    except ValueError as error:
        raise InputError(file, f"edge {edge_id}: shape", text, "points x,y or x,y,z") from error
    if len(shape) < 2:
        raise InputError(file, f"edge {edge_id}: shape", text, "two points at least")
    return shape


def _tracks(net: _NetFile) -> tuple[list[LayoutTrack], dict[str, tuple[LayoutTrack, bool]]]:
    """A track for each pair of edges; and of each edge its track, True where it runs from the low node."""
    tracks: list[LayoutTrack] = []
    of_edge: dict[str, tuple[LayoutTrack, bool]] = {}
    for edge in net.edges.values():
        if edge.id in of_edge:
            continue
        # OpenStreetMap's way back is called -way, ours track-.
        back = net.edges.get(edge.bidi)
        first = back if back is not None and _is_back(edge.id) and not _is_back(back.id) else edge
        track = LayoutTrack(
            first.id.removesuffix("+") if back is not None else first.id,
            first.name,
            first.kind,
            first.from_node,
            first.to_node,
            first.length_m,
            first.shape,
        )
        tracks.append(track)
        of_edge[edge.id] = (track, first is edge)
        if back is not None:
            of_edge[back.id] = (track, first is back)
    return tracks, of_edge


def _is_back(edge_id: str) -> bool:
    return edge_id.startswith("-") or edge_id.endswith("-")


def _kind(
    net: _NetFile,
    node: str,
    ends: Sequence[tuple[LayoutTrack, bool]],
    of_edge: Mapping[str, tuple[LayoutTrack, bool]],
    points: list[LayoutPoints],
    remarks: list[str],
) -> NodeKind:
    """What a junction is; points are added to `points`."""
    if len(ends) <= 2:
        return NodeKind.JOINT if len(ends) == 2 else NodeKind.END
    together = {
        frozenset((of_edge[a][0].id, of_edge[b][0].id))
        for a, b in net.following
        if net.edges[a].to_node == node and net.edges[b].from_node == node
    }
    stems = [t for t, _ in ends if all(frozenset((t.id, o.id)) in together for o, _ in ends if o.id != t.id)]
    if len(ends) != 3 or len(stems) != 1 or len({t.id for t, _ in ends}) != 3:
        remarks.append(
            f"not among points: junction {node}, at which {len(ends)} tracks meet and {len(stems)} lead to all"
        )
        return NodeKind.CROSSING
    stem = stems[0]
    legs = [(track, high) for track, high in ends if track.id != stem.id]
    stem_high = next(high for track, high in ends if track.id == stem.id)
    directions = [direction_from(stem.shape, from_high=stem_high)]
    directions += [direction_from(track.shape, from_high=high) for track, high in legs]
    found = stem_and_legs(directions)
    angles = [angle_deg(directions[0], direction) for direction in directions[1:]]
    first, second = legs[0][0], legs[1][0]
    said_normal = _said_normal(net, node, (first, second), of_edge)
    normal = said_normal or (first if angles[0] >= angles[1] else second)
    reverse = second if normal is first else first
    side = None
    if found is not None and found.stem == 0:
        side = found.side
        if legs[found.branch - 1][0] is not reverse:
            side = TurnoutSide.RIGHT if side is TurnoutSide.LEFT else TurnoutSide.LEFT
    points.append(LayoutPoints(node, "", node, stem.id, normal.id, reverse.id, side))
    return NodeKind.POINTS


def _said_normal(
    net: _NetFile,
    node: str,
    legs: tuple[LayoutTrack, LayoutTrack],
    of_edge: Mapping[str, tuple[LayoutTrack, bool]],
) -> LayoutTrack | None:
    """The leg that the net itself calls the normal one; None where it does not."""
    marked = {of_edge[edge.id][0].id for edge in net.edges.values() if node in edge.normal_at}
    for leg, other in (legs, legs[::-1]):
        if leg.id in marked and other.id not in marked:
            return leg
        if leg.id.endswith(OUR_LEGS[0]) and other.id.endswith(OUR_LEGS[1]):
            return leg
    return None


def _stations(
    net: _NetFile, additional: Path | None, of_edge: Mapping[str, tuple[LayoutTrack, bool]]
) -> tuple[list[LayoutStation], dict[str, list[KmRow]]]:
    """Stations by the names of their stops, and the kilometrages that stops have, by track."""
    if additional is None:
        return [], {}
    file = str(additional)
    root = read_xml(additional)
    if local_name(root) != "additional":
        raise InputError(
            file, "", None, f"a SUMO additional file, but its outermost element is {local_name(root)}"
        )
    spots: dict[str, list[Spot]] = defaultdict(list)
    platforms: dict[str, list[Platform]] = defaultdict(list)
    known: dict[str, list[KmRow]] = defaultdict(list)
    codes: dict[str, str] = {}
    for stop in (element for element in root if local_name(element) in STOP_ELEMENTS):
        stop_id, lane = needed_attribute(file, stop, "id"), needed_attribute(file, stop, "lane")
        edge_id = lane.rpartition("_")[0]
        if edge_id not in of_edge:
            net.left["stop that lies on none of the tracks"] += 1
            continue
        track, along = of_edge[edge_id]
        end_m = _on(track, along, number(file, stop, "endPos"), track.length_m)
        start_m = _on(track, along, number(file, stop, "startPos"), 0.0)
        name = stop.get("name", "") or stop_id
        marks = {param.get("key"): param for param in stop.iterfind("param")}
        spots[name].append(Spot(track.id, end_m, _value(marks, TRACK)))
        low_m, high_m = sorted((start_m, end_m))
        platforms[name].append(Platform(track.id, low_m, high_m, stop_id))
        codes.setdefault(name, _value(marks, STATION))
        if KILOMETRAGE in marks:
            known[track.id].append((end_m, needed_number(file, marks[KILOMETRAGE], "value")))
    found = [
        LayoutStation(name, codes[name], name, None, tuple(spots[name]), tuple(platforms[name]))
        for name in spots
    ]
    return found, known


def _value(marks: Mapping[str | None, ET.Element], key: str) -> str:
    return marks[key].get("value", "") if key in marks else ""


def _on(track: LayoutTrack, along: bool, offset_m: float | None, default_m: float) -> float:
    """Offset from the low node of a place on one of a track's edges; SUMO counts a negative one from the end."""
    at_m = default_m if offset_m is None else offset_m
    at_m = min(max(at_m + track.length_m if at_m < 0 else at_m, 0.0), track.length_m)
    return round(at_m if along else track.length_m - at_m, 6)


def _placed(station: LayoutStation, tracks: Mapping[str, LayoutTrack]) -> LayoutStation:
    known = [tracks[spot.track_id].km_m(spot.offset_m) for spot in station.spots]
    places = [place for place in known if place is not None]
    return replace(station, position_m=round(sum(places) / len(places), 3) if places else None)
