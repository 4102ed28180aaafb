"""What railML 2.4 writes: tracks with a beginning and an end, points that lie on one of their three tracks.

Points at an offset of a track cut it in two; at its beginning or end the third track is the one connected there.
Courses and orientations are those seen in the sense of the track that the points lie on (railML wiki, IS:switch and
IS:connection_switch); `side` is turned to be seen from the toe.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
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
from exchange.xml_input import local_name, needed, needed_number, number
from network.errors import InputError

_NS: Final = "{https://www.railml.org/schemas/2018}"
_ORDINARY: Final = frozenset({"ordinarySwitch", "insideCurvedSwitch", "outsideCurvedSwitch", ""})
_TAKEN: Final = frozenset(
    {
        *("track", "trackBegin", "trackEnd", "connection", "openEnd", "bufferStop", "macroscopicNode"),
        *("switch", "crossing", "crossSection", "platformEdge", "signal", "ocp", "mileageChange"),
        *("infrastructure", "infrastructureManager", "state", "alternative", "phase"),
    }
)


@dataclass(slots=True)
class _CutTrack:
    """A track as it is cut at its points and crossings: `offsets_m` from 0 to its length."""

    element: ET.Element
    id: str
    length_m: float
    offsets_m: list[float] = field(default_factory=list)

    def piece(self, number: int) -> str:
        return self.id if len(self.offsets_m) == 2 else f"{self.id}#{number + 1}"

    def at(self, offset_m: float) -> tuple[str, float]:
        """Piece and offset on it; at a cut the piece that begins there."""
        for n in range(len(self.offsets_m) - 2, -1, -1):
            if offset_m >= self.offsets_m[n] - SAME_PLACE_M or n == 0:
                return self.piece(n), max(offset_m - self.offsets_m[n], 0.0)
        raise AssertionError("a track has a piece")


def draft_of_2(file: str, root: ET.Element) -> RailmlDraft:
    """Read the infrastructure of a railML 2.4 document. Raises InputError."""
    infrastructure = root.find(f"{_NS}infrastructure")
    if infrastructure is None:
        raise InputError(file, "infrastructure", None, "this element, which is missing")
    reader = _Railml2Reader(file, infrastructure)
    reader.read_tracks()
    reader.read_points()
    reader.read_stations()
    reader.read_signals()
    draft = reader.draft
    states = infrastructure.iter(f"{_NS}state")
    draft.not_in_use = states_not_in_use(
        (state.get("status", ""), state.get("disabled") == "true") for state in states
    )
    draft.left += left_of(infrastructure.iter(), _TAKEN)
    for part in root:
        name = local_name(part)
        if name in ("timetable", "rollingstock"):
            draft.left.append(f"all of its {name}")
    return draft


class _Railml2Reader:
    def __init__(self, file: str, infrastructure: ET.Element) -> None:
        self.file = file
        self.infrastructure = infrastructure
        self.draft = RailmlDraft(infrastructure.get("name", ""))
        self.cuts: dict[str, _CutTrack] = {}
        self.joined = JoinedEnds()
        self.ends: dict[str, tuple[str, int]] = {}  # by id of a connection at a beginning or an end
        self.node_of: dict[tuple[str, int], str] = {}
        self.ends_at: dict[str, list[tuple[str, int]]] = {}
        self.length_of: dict[str, float] = {}

    def read_tracks(self) -> None:
        """Tracks cut at what lies on them, and joined where their ends are connected."""
        refs: list[tuple[str, str, str]] = []
        for element in self.infrastructure.iterfind(f"{_NS}tracks/{_NS}track"):
            cut = self._cut(element)
            self.cuts[cut.id] = cut
            for n, (low_m, high_m) in enumerate(pairwise(cut.offsets_m)):
                piece_id = cut.piece(n)
                rows = _rows_between(self._kilometrage(cut), low_m, high_m)
                self.draft.pieces.append(
                    LayoutTrack(
                        piece_id,
                        element.get("name", ""),
                        element.get("type", ""),
                        piece_id + "<",
                        piece_id + ">",
                        round(high_m - low_m, 6),
                        (),
                        rows,
                    )
                )
                if n:
                    self.joined.join((cut.piece(n - 1), 1), (piece_id, 0))
            refs += self._read_ends(cut)
        for _owner, connection, ref in refs:
            if ref in self.ends:
                self.joined.join(self.ends[connection], self.ends[ref])

    def _cut(self, element: ET.Element) -> _CutTrack:
        track_id = needed(self.file, element, "id")
        if track_id in self.cuts:
            raise InputError(self.file, f"track {track_id}", None, "an id of its own")
        ends = [element.find(f"{_NS}trackTopology/{_NS}{name}") for name in ("trackBegin", "trackEnd")]
        begin, end = ends
        if begin is None or end is None:
            raise InputError(self.file, f"track {track_id}", None, "a track with trackBegin and trackEnd")
        begin_m, end_m = (needed_number(self.file, place, "pos") for place in (begin, end))
        if begin_m != 0 or end_m <= 0:
            expected = "a track that begins at pos 0 and ends beyond it"
            raise InputError(self.file, f"track {track_id}", [begin_m, end_m], expected)
        cut = _CutTrack(element, track_id, end_m, [0.0, end_m])
        for device in self._devices(cut):
            pos_m = self._pos(device, cut)
            if all(abs(pos_m - known) > SAME_PLACE_M for known in cut.offsets_m):
                cut.offsets_m.append(pos_m)
        cut.offsets_m.sort()
        return cut

    def _devices(self, cut: _CutTrack) -> Iterator[ET.Element]:
        found = cut.element.find(f"{_NS}trackTopology/{_NS}connections")
        for device in found if found is not None else ():
            if local_name(device) in ("switch", "crossing"):
                yield device

    def _pos(self, element: ET.Element, cut: _CutTrack) -> float:
        pos_m = needed_number(self.file, element, "pos")
        if not -SAME_PLACE_M <= pos_m <= cut.length_m + SAME_PLACE_M:
            key = f"{local_name(element)} {element.get('id', '')}: pos"
            raise InputError(self.file, key, pos_m, f"a place on track {cut.id}, 0 to {cut.length_m:g} m")
        return min(max(pos_m, 0.0), cut.length_m)

    def _read_ends(self, cut: _CutTrack) -> Iterator[tuple[str, str, str]]:
        for side, name in enumerate(("trackBegin", "trackEnd")):
            place = cut.element.find(f"{_NS}trackTopology/{_NS}{name}")
            end = (cut.piece(0 if side == 0 else len(cut.offsets_m) - 2), side)
            for what in place if place is not None else ():
                kind = local_name(what)
                if kind == "connection":
                    connection = needed(self.file, what, "id")
                    self.ends[connection] = end
                    yield cut.id, connection, needed(self.file, what, "ref")
                elif kind == "bufferStop":
                    self.draft.kinds["".join((end[0], "<>"[end[1]]))] = NodeKind.BUFFER

    def _kilometrage(self, cut: _CutTrack) -> tuple[tuple[float, float], ...]:
        known: list[tuple[float, float]] = []
        jumps: list[tuple[float, float, float]] = []
        for element in cut.element.iter():
            pos_m, absolute_m = number(self.file, element, "pos"), number(self.file, element, "absPos")
            if pos_m is None or absolute_m is None:
                continue
            before_m = number(self.file, element, "absPosIn")
            if local_name(element) == "mileageChange" and before_m is not None:
                jumps.append((pos_m, before_m, absolute_m))
            elif local_name(element) in ("trackBegin", "trackEnd"):
                known.append((pos_m, absolute_m))
        if not known and not jumps:  # the ends say nothing: then what lies between
            for element in cut.element.iter():
                pos_m, absolute_m = number(self.file, element, "pos"), number(self.file, element, "absPos")
                if pos_m is not None and absolute_m is not None:
                    known.append((pos_m, absolute_m))
        return km_rows(cut.length_m, known, jumps)

    def read_points(self) -> None:
        """Ordinary points with their three tracks; what is no ordinary set of points is said."""
        for cut in self.cuts.values():
            for device in self._devices(cut):
                for connection in device.iterfind(f"{_NS}connection"):
                    ref = connection.get("ref", "")
                    if ref in self.ends:
                        self.joined.join(self._node_end(cut, device), self.ends[ref])
        self._name_nodes()
        for cut in self.cuts.values():
            for device in self._devices(cut):
                self._read_device(cut, device)

    def _node_end(self, cut: _CutTrack, device: ET.Element) -> tuple[str, int]:
        piece_id, inner_m = cut.at(self._pos(device, cut))
        return piece_id, 0 if inner_m < SAME_PLACE_M else 1

    def _name_nodes(self) -> None:
        """Every piece gets the names of the nodes that joining has made."""
        names: dict[tuple[str, int], str] = {}
        pieces: list[LayoutTrack] = []
        kinds: dict[str, NodeKind] = {}
        for piece in self.draft.pieces:
            low, high = (
                names.setdefault(self.joined.of((piece.id, side)), f"n{len(names) + 1}") for side in (0, 1)
            )
            for old, new in ((piece.low_node, low), (piece.high_node, high)):
                if old in self.draft.kinds:
                    kinds[new] = self.draft.kinds[old]
            pieces.append(
                LayoutTrack(
                    piece.id, piece.name, piece.kind, low, high, piece.length_m, (), piece.kilometrage
                )
            )
            for side, node in enumerate((low, high)):
                self.node_of[piece.id, side] = node
                self.ends_at.setdefault(node, []).append((piece.id, side))
            self.length_of[piece.id] = piece.length_m
        self.draft.pieces, self.draft.kinds = pieces, kinds

    def _read_device(self, cut: _CutTrack, device: ET.Element) -> None:
        node = self.node_of[self._node_end(cut, device)]
        meeting = self.ends_at[node]
        name = device.get("name") or device.get("id") or ""
        kind = device.get("type", "")
        connections = device.findall(f"{_NS}connection")
        if local_name(device) == "crossing" or kind not in _ORDINARY:
            word = kind or "crossing"
            self.draft.crossings[node] = f"{word} {name}, at which {len(meeting)} tracks meet"
            return
        branch = self.ends.get(connections[0].get("ref", "")) if len(connections) == 1 else None
        outgoing = connections[0].get("orientation") == "outgoing" if connections else True
        own = [end for end in meeting if end != branch]
        if branch is None or branch not in meeting or len(own) != 2:
            self.draft.left.append(
                f"not among points: {name}, at which {len(meeting)} tracks meet and {len(connections)} branch off"
            )
            return
        after, before = self._after_and_before(cut, device, own)
        stem, normal = (before, after) if outgoing else (after, before)
        self.draft.points.append(
            LayoutPoints(
                needed(self.file, device, "id"),
                name,
                node,
                stem[0],
                normal[0],
                branch[0],
                _side(device, connections[0], outgoing=outgoing),
                number(self.file, connections[0], "maxSpeed"),
            )
        )

    def _after_and_before(
        self, cut: _CutTrack, device: ET.Element, own: list[tuple[str, int]]
    ) -> tuple[tuple[str, int], tuple[str, int]]:
        """Of the two ends that carry the track on: the one that lies on in its sense, and the one before."""
        piece_id, inner_m = cut.at(self._pos(device, cut))
        if inner_m < SAME_PLACE_M:  # the piece begins here
            after = (piece_id, 0)
            before = next(end for end in own if end != after)
        else:
            before = (piece_id, 1)
            after = next(end for end in own if end != before)
        return after, before

    def read_stations(self) -> None:
        """Operation control points with their cross sections and platform edges."""
        spots: dict[str, list[Spot]] = {}
        platforms: dict[str, list[Platform]] = {}
        homeless = 0
        for cut in self.cuts.values():
            for element in cut.element.iter():
                name, owner = local_name(element), element.get("ocpRef", "")
                if name == "crossSection" and owner:
                    piece_id, offset_m = cut.at(self._pos(element, cut))
                    spots.setdefault(owner, []).append(Spot(piece_id, offset_m, cut.element.get("name", "")))
                elif name == "platformEdge":
                    homeless += not owner
                    platforms.setdefault(owner, []).append(self._platform(cut, element))
        for ocp in self.infrastructure.iterfind(f"{_NS}operationControlPoints/{_NS}ocp"):
            key = needed(self.file, ocp, "id")
            designator = ocp.find(f"{_NS}designator")
            code = "" if designator is None else designator.get("entry", "")
            self.draft.stations.append(
                LayoutStation(
                    key,
                    code or ocp.get("code", ""),
                    ocp.get("name", ""),
                    None,
                    tuple(spots.get(key, ())),
                    tuple(platforms.get(key, ())),
                )
            )
        if homeless:
            self.draft.left.append(f"{homeless} platforms that name no station")

    def _platform(self, cut: _CutTrack, element: ET.Element) -> Platform:
        from_m = self._pos(element, cut)
        length_m = number(self.file, element, "length") or 0.0
        piece_id, inner_m = cut.at(from_m)
        # What reaches over points is cut there: a train that stands beyond stands on another track.
        to_m = min(inner_m + length_m, self.length_of[piece_id])
        return Platform(piece_id, inner_m, round(to_m, 6), element.get("name", ""))

    def read_signals(self) -> None:
        """Signals with their place and the direction they speak to."""
        for cut in self.cuts.values():
            for element in cut.element.iter(f"{_NS}signal"):
                piece_id, offset_m = cut.at(self._pos(element, cut))
                forward = element.get("dir", "up") != "down"
                self.draft.signals.append(
                    LayoutSignal(element.get("name", ""), piece_id, round(offset_m, 6), forward)
                )


def _side(device: ET.Element, connection: ET.Element, *, outgoing: bool) -> TurnoutSide | None:
    """To which side the branch leads off, seen from the toe."""
    course = connection.get("course", "")
    turned = not outgoing
    if course == "straight":  # then it is the track itself that bends away
        course = device.get("trackContinueCourse", "")
        turned = not turned
    if course not in ("left", "right"):
        return None
    side = TurnoutSide(course)
    return side if not turned else (TurnoutSide.LEFT if side is TurnoutSide.RIGHT else TurnoutSide.RIGHT)


def _rows_between(
    rows: tuple[tuple[float, float], ...], low_m: float, high_m: float
) -> tuple[tuple[float, float], ...]:
    """Rows of a whole track cut to one piece of it, offsets from its beginning."""
    if not rows:
        return ()
    whole = LayoutTrack("", "", "", "", "", rows[-1][0], (), rows)
    inside = [(offset_m, km_m) for offset_m, km_m in rows if low_m < offset_m < high_m]
    first_m, last_m = whole.km_m(low_m + 1e-9), whole.km_m(high_m)
    assert first_m is not None and last_m is not None
    found = [(low_m, first_m), *inside, (high_m, last_m)]
    return tuple((round(offset_m - low_m, 6), round(km_m, 6)) for offset_m, km_m in found)
