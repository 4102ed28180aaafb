"""What railML 3.2 writes: a topology of net elements and relations between them, and what lies on them by reference.

Only elements of the micro level count, those with a length of their own; the others are groups of them. A relation says
which ends are one place, whether a train can go over it or not.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterable, Iterator
from typing import Final

from exchange.layout import (
    LayoutPoints,
    LayoutSignal,
    LayoutStation,
    LayoutTrack,
    NodeKind,
    Platform,
    Spot,
    TurnoutSide,
)
from exchange.layout_draft import SAME_PLACE_M, JoinedEnds, km_rows
from exchange.railml_draft import RailmlDraft, left_of, states_not_in_use
from exchange.xml_input import local_name, needed_attribute, needed_number, number
from network.errors import InputError

_NS: Final = "{https://www.railml.org/schemas/3.2}"
_ORDINARY: Final = frozenset({"ordinarySwitch", "insideCurvedSwitch", "outsideCurvedSwitch"})
_PART: Final = "switchCrossingPart"
_TAKEN: Final = frozenset(
    {
        *(
            "infrastructure",
            "netElement",
            "netRelation",
            "network",
            "level",
            "track",
            "bufferStop",
            "switchIS",
        ),
        *("operationalPoint", "platformEdge", "signalIS", "crossing", "mileageChange", "infrastructureState"),
        *("elementState", "spotLocation", "linearLocation", "areaLocation", "associatedPositioningSystem"),
        *("intrinsicCoordinate", "elementCollectionUnordered", "elementCollectionOrdered", "networkLocation"),
        *("linearPositioningSystem", "geometricPositioningSystem"),
    }
)


def draft_of_3(file: str, root: ET.Element) -> RailmlDraft:
    """Read the infrastructure of a railML 3.2 document. Raises InputError."""
    infrastructure = root.find(f"{_NS}infrastructure")
    if infrastructure is None:
        raise InputError(file, "infrastructure", None, "this element, which is missing")
    reader = _Railml3Reader(file, root, infrastructure)
    reader.read_topology()
    reader.read_points()
    reader.read_stations()
    reader.read_signals()
    draft = reader.draft
    states = infrastructure.iter(f"{_NS}elementState")
    draft.not_in_use = states_not_in_use((state.get("value", ""), False) for state in states)
    # An open end is written as a border; as a node it is taken.
    found = (e for e in infrastructure.iter() if not (local_name(e) == "border" and e.get("isOpenEnd")))
    draft.left += left_of(found, _TAKEN)
    for part in root:
        name = local_name(part)
        if name in ("timetable", "rollingstock", "interlocking"):
            draft.left.append(f"all of its {name}")
    return draft


class _Railml3Reader:
    def __init__(self, file: str, root: ET.Element, infrastructure: ET.Element) -> None:
        self.file = file
        self.infrastructure = infrastructure
        title = next((e.text or "" for e in root.iter() if local_name(e) == "title"), "")
        self.draft = RailmlDraft(title)
        self.length_of: dict[str, float] = {}
        self.coarse: set[str] = set()  # net elements of the meso- and macroscopic levels, which are no tracks
        self.joined = JoinedEnds()
        self.node_of: dict[tuple[str, int], str] = {}
        self.ends_at: dict[str, list[tuple[str, int]]] = defaultdict(list)
        self.relations: dict[str, tuple[tuple[str, int], tuple[str, int]]] = {}
        self.track_name: dict[str, tuple[str, str]] = {}

    def _functional(self, group: str, name: str) -> Iterator[ET.Element]:
        yield from self.infrastructure.iterfind(f"{_NS}functionalInfrastructure/{_NS}{group}/{_NS}{name}")

    def read_topology(self) -> None:
        """Net elements as pieces of track, relations as their nodes, tracks as their names."""
        elements: list[ET.Element] = []
        for element in self.infrastructure.iterfind(f"{_NS}topology/{_NS}netElements/{_NS}netElement"):
            element_id = needed_attribute(self.file, element, "id")
            if not _is_micro(element):
                self.coarse.add(element_id)
                continue
            length_m = needed_number(self.file, element, "length")
            if element_id in self.length_of or length_m <= 0:
                raise InputError(
                    self.file, f"netElement {element_id}", length_m, "an id of its own, and a length"
                )
            self.length_of[element_id] = length_m
            elements.append(element)
        for relation in self.infrastructure.iterfind(f"{_NS}topology/{_NS}netRelations/{_NS}netRelation"):
            ends = self._relation(relation)
            if ends is not None:
                self.relations[relation.get("id", "")] = ends
                self.joined.join(*ends)
        self._name_tracks()
        jumps = self._jumps()
        names: dict[tuple[str, int], str] = {}
        for element in elements:
            element_id = element.get("id", "")
            low, high = (
                names.setdefault(self.joined.node_end((element_id, side)), f"n{len(names) + 1}")
                for side in (0, 1)
            )
            for side, node in enumerate((low, high)):
                self.node_of[element_id, side] = node
                self.ends_at[node].append((element_id, side))
            name, kind = self.track_name.get(element_id, ("", ""))
            length_m = self.length_of[element_id]
            rows = km_rows(length_m, self._known(element, length_m), jumps.get(element_id, ()))
            self.draft.pieces.append(LayoutTrack(element_id, name, kind, low, high, length_m, (), rows))
        for stop in self._functional("bufferStops", "bufferStop"):
            for element_id, offset_m in self._spots(stop):
                side = 0 if offset_m < self.length_of[element_id] / 2 else 1
                self.draft.kinds[self.node_of[element_id, side]] = NodeKind.BUFFER

    def _relation(self, relation: ET.Element) -> tuple[tuple[str, int], tuple[str, int]] | None:
        """The two ends that a relation makes one place; None where it is of another level."""
        ends: list[tuple[str, int]] = []
        for name, where in (("elementA", "positionOnA"), ("elementB", "positionOnB")):
            part = relation.find(f"{_NS}{name}")
            if part is None:
                raise InputError(
                    self.file, f"netRelation {relation.get('id', '')}", None, "a relation of two elements"
                )
            ref, place = needed_attribute(self.file, part, "ref"), relation.get(where)
            if ref not in self.length_of:
                return None
            if place not in ("0", "1"):
                raise InputError(
                    self.file, f"netRelation {relation.get('id', '')}: {where}", place, "0 or 1, an end"
                )
            ends.append((ref, int(place)))
        return ends[0], ends[1]

    def _name_tracks(self) -> None:
        for track in self._functional("tracks", "track"):
            for part in track.iter(f"{_NS}associatedNetElement"):
                ref = part.get("netElementRef", "")
                self.track_name.setdefault(ref, (_name(track), track.get("type", "")))

    def _known(self, element: ET.Element, length_m: float) -> list[tuple[float, float]]:
        known: list[tuple[float, float]] = []
        for place in element.iter(f"{_NS}intrinsicCoordinate"):
            coordinate = place.find(f"{_NS}linearCoordinate")
            share = number(self.file, place, "intrinsicCoord")
            measure_m = None if coordinate is None else number(self.file, coordinate, "measure")
            if share is not None and measure_m is not None:
                known.append((share * length_m, measure_m))
        return known

    def _jumps(self) -> dict[str, list[tuple[float, float, float]]]:
        """Changes of kilometrage inside a net element; those between two need no more than their two coordinates."""
        found: dict[str, list[tuple[float, float, float]]] = defaultdict(list)
        for change in self._functional("mileageChanges", "mileageChange"):
            places = [
                (element_id, offset_m, measure_m)
                for element_id, offset_m, measure_m in self._measured(change)
                if measure_m is not None
            ]
            if len(places) == 2 and places[0][0] == places[1][0]:
                found[places[0][0]].append((places[0][1], places[0][2], places[1][2]))
        return found

    def _measured(self, element: ET.Element) -> Iterator[tuple[str, float, float | None]]:
        for spot in self._on_tracks(element):
            coordinate = spot.find(f"{_NS}linearCoordinate")
            measure_m = None if coordinate is None else number(self.file, coordinate, "measure")
            yield self._element_of(spot), self._pos(spot), measure_m

    def _spots(self, element: ET.Element) -> Iterator[tuple[str, float]]:
        """Net elements and offsets of a thing's spots; those of other levels are left."""
        for spot in self._on_tracks(element):
            yield self._element_of(spot), self._pos(spot)

    def _on_tracks(self, element: ET.Element) -> Iterator[ET.Element]:
        spots = element.iterfind(f"{_NS}spotLocation")
        return (spot for spot in spots if spot.get("netElementRef") not in self.coarse)

    def _element_of(self, spot: ET.Element) -> str:
        ref = needed_attribute(self.file, spot, "netElementRef")
        if ref not in self.length_of:
            raise InputError(
                self.file, f"spotLocation {spot.get('id', '')}: netElementRef", ref, "a net element"
            )
        return ref

    def _pos(self, spot: ET.Element) -> float:
        length_m = self.length_of[self._element_of(spot)]
        pos_m = number(self.file, spot, "pos")
        if pos_m is None:
            pos_m = needed_number(self.file, spot, "intrinsicCoord") * length_m
        if not -SAME_PLACE_M <= pos_m <= length_m + SAME_PLACE_M:
            key = f"spotLocation {spot.get('id', '')}: pos"
            raise InputError(self.file, key, pos_m, f"a place on its net element, 0 to {length_m:g} m")
        return min(max(pos_m, 0.0), length_m)

    def read_points(self) -> None:
        """Ordinary points with their three tracks; what is no ordinary set of points is said."""
        for switch in self._functional("switchesIS", "switchIS"):
            kind, name = switch.get("type", ""), _name(switch) or switch.get("id", "")
            if kind == _PART or switch.get("belongsToParent"):
                continue
            if kind in _ORDINARY:
                self._read_switch(switch, name)
                continue
            self._cross(switch, f"{kind or 'switch'} {name}")
        for crossing in self._functional("crossings", "crossing"):
            self._cross(crossing, f"crossing {_name(crossing) or crossing.get('id', '')}")

    def _cross(self, element: ET.Element, called: str) -> None:
        for element_id, offset_m in self._spots(element):
            node = self.node_of[element_id, 0 if offset_m < self.length_of[element_id] / 2 else 1]
            self.draft.crossings[node] = f"{called}, at which {len(self.ends_at[node])} tracks meet"

    def _read_switch(self, switch: ET.Element, name: str) -> None:
        legs: dict[TurnoutSide, tuple[tuple[str, int], tuple[str, int]]] = {}
        speeds: dict[TurnoutSide, float | None] = {}
        for side, element_name in ((TurnoutSide.LEFT, "leftBranch"), (TurnoutSide.RIGHT, "rightBranch")):
            branch = switch.find(f"{_NS}{element_name}")
            ends = None if branch is None else self.relations.get(branch.get("netRelationRef", ""))
            if branch is not None and ends is not None:
                legs[side] = ends
                speeds[side] = number(self.file, branch, "branchingSpeed")
        shared = (
            set(legs[TurnoutSide.LEFT]) & set(legs[TurnoutSide.RIGHT])
            if len(legs) == 2
            else set[tuple[str, int]]()
        )
        if len(shared) != 1:
            self.draft.left.append(f"not among points: {name}, whose branches do not part from one track")
            return
        stem = shared.pop()
        ends_of = {side: next(end for end in pair if end != stem) for side, pair in legs.items()}
        course = switch.get("branchCourse", "")
        side = TurnoutSide(course) if course in ("left", "right") else TurnoutSide.RIGHT
        if course not in ("left", "right"):
            self.draft.assumed.append(f"points {name}: the branch is the right one, as the file does not say")
        other = TurnoutSide.LEFT if side is TurnoutSide.RIGHT else TurnoutSide.RIGHT
        self.draft.points.append(
            LayoutPoints(
                needed_attribute(self.file, switch, "id"),
                name,
                self.node_of[stem],
                stem[0],
                ends_of[other][0],
                ends_of[side][0],
                side,
                speeds[side],
            )
        )

    def read_stations(self) -> None:
        """Operational points with their spots and the platform edges that they own."""
        edges = {edge.get("id", ""): edge for edge in self._functional("platformEdges", "platformEdge")}
        owned: set[str] = set()
        for point in self._functional("operationalPoints", "operationalPoint"):
            platforms: list[Platform] = []
            for owner in point.iter(f"{_NS}ownsPlatform"):
                ref = needed_attribute(self.file, owner, "ref")
                if ref in edges:
                    owned.add(ref)
                    platforms += self._platforms(edges[ref])
            spots = tuple(
                Spot(element_id, offset_m, self.track_name.get(element_id, ("", ""))[0])
                for element_id, offset_m in self._spots(point)
            )
            designator = point.find(f"{_NS}designator")
            self.draft.stations.append(
                LayoutStation(
                    needed_attribute(self.file, point, "id"),
                    "" if designator is None else designator.get("entry", ""),
                    _name(point),
                    None,
                    spots,
                    tuple(platforms),
                )
            )
        homeless = len(edges.keys() - owned)
        if homeless:
            self.draft.left.append(f"{homeless} platforms that belong to no station")

    def _platforms(self, edge: ET.Element) -> Iterator[Platform]:
        parts = list(edge.iter(f"{_NS}associatedNetElement"))
        for part in parts:
            ref = part.get("netElementRef", "")
            if ref not in self.length_of:
                continue
            length_m = self.length_of[ref]
            from_m, to_m = number(self.file, part, "posBegin"), number(self.file, part, "posEnd")
            ends = sorted((from_m if from_m is not None else 0.0, to_m if to_m is not None else length_m))
            low_m, high_m = (min(max(end, 0.0), length_m) for end in ends)
            yield Platform(ref, low_m, high_m, _name(edge))

    def read_signals(self) -> None:
        """Signals with their place and the direction they speak to; a stop post is written as a signal too."""
        for signal in self._functional("signalsIS", "signalIS"):
            if signal.find(f"{_NS}isStopPost") is not None:
                continue
            for spot in self._on_tracks(signal):
                forward = spot.get("applicationDirection", "normal") != "reverse"
                self.draft.signals.append(
                    LayoutSignal(_name(signal), self._element_of(spot), round(self._pos(spot), 6), forward)
                )


def _is_micro(element: ET.Element) -> bool:
    groups = ("elementCollectionUnordered", "elementCollectionOrdered")
    return element.get("length") is not None and all(local_name(child) not in groups for child in element)


def _name(element: ET.Element, languages: Iterable[str] = ("en", "ja")) -> str:
    """The name of a thing: in one of the languages wished for, else the first."""
    names = element.findall(f"{_NS}name")
    for language in languages:
        for name in names:
            if name.get("language") == language:
                return name.get("name", "")
    return names[0].get("name", "") if names else ""
