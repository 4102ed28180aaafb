"""A track layout as somebody has published it: what every reader of railML, OpenStreetMap and SUMO nets gives.

Nothing here knows a line of ours. Tracks run from node to node; what lies on one has an offset, m, from the track's low
node. Kilometrage is a track's own table of offsets and kilometrages, both m, straight between its rows; where it jumps,
two rows have one offset. A layout says in sentences what it took of its source, what it assumed and what it left.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from itertools import pairwise

from network.model import CrossingClass

Place = tuple[float, float]  # east and north on the plane, m
KmRow = tuple[float, float]  # offset on a track and kilometrage there, both m


class NodeKind(Enum):
    """What tracks end or meet at."""

    BUFFER = "buffer stop"
    OPEN = "open end"  # the source ends here, the track does not
    END = "end"  # of a track, or of the source: which, it does not say
    JOINT = "joint"
    POINTS = "points"
    CROSSING = "crossing"  # tracks that cross, with slips or without: nothing is said of who can go where


class TurnoutSide(Enum):
    """To which side points lead off, seen from their toe."""

    LEFT = "left"
    RIGHT = "right"


@dataclass(frozen=True, slots=True)
class LayoutNode:
    """Where tracks end or meet; `place` where the source says where that is."""

    id: str
    kind: NodeKind
    place: Place | None = None


@dataclass(frozen=True, slots=True)
class LayoutTrack:
    """A track between two nodes. `kind` is the source's word for it (mainTrack, siding, yard, ...); `shape` runs from
    `low_node` to `high_node`, and is empty where the source has no places; `kilometrage` is empty where it has none.
    """

    id: str
    name: str
    kind: str
    low_node: str
    high_node: str
    length_m: float
    shape: tuple[Place, ...] = ()
    kilometrage: tuple[KmRow, ...] = ()

    def km_m(self, offset_m: float) -> float | None:
        """Kilometrage, m, at an offset, m; where it jumps the one that is reached; None where there is none."""
        rows = self.kilometrage
        if len(rows) < 2:
            return None
        for (from_m, from_km_m), (to_m, to_km_m) in pairwise(rows):
            if offset_m <= to_m and to_m > from_m:
                return from_km_m + (offset_m - from_m) * (to_km_m - from_km_m) / (to_m - from_m)
        return rows[-1][1]


@dataclass(frozen=True, slots=True)
class LayoutPoints:
    """Ordinary points (転てつ機): `stem`, `normal` and `reverse` are tracks that meet at `node_id`.

    `normal` is the leg that the source calls the continuation, or the straighter one. `side` is where `reverse` leads,
    None where the source does not say.
    """

    id: str
    name: str
    node_id: str
    stem: str
    normal: str
    reverse: str
    side: TurnoutSide | None = None
    diverging_kmh: float | None = None


@dataclass(frozen=True, slots=True)
class Platform:
    """A platform at a track, between two offsets, m; `name` where it has one."""

    track_id: str
    from_m: float
    to_m: float
    name: str = ""


@dataclass(frozen=True, slots=True)
class Spot:
    """A point on a track, `offset_m` from its low node; `track_name` what the source calls the track there (番線)."""

    track_id: str
    offset_m: float
    track_name: str = ""


@dataclass(frozen=True, slots=True)
class LayoutStation:
    """A station (operation control point, operational point). `position_m` is its kilometrage, m, None where there is
    none; `spots` are where the source puts it on its tracks.
    """

    key: str
    code: str
    name: str
    position_m: float | None
    spots: tuple[Spot, ...] = ()
    platforms: tuple[Platform, ...] = ()

    @property
    def track_ids(self) -> tuple[str, ...]:
        """Tracks with a spot or a platform of this station, each once."""
        found = [spot.track_id for spot in self.spots] + [platform.track_id for platform in self.platforms]
        return tuple(dict.fromkeys(found))


@dataclass(frozen=True, slots=True)
class LayoutSignal:
    """A signal; `forward`: it speaks to trains that run from the track's low node to its high one."""

    name: str
    track_id: str
    offset_m: float
    forward: bool


@dataclass(frozen=True, slots=True)
class Milestone:
    """A post with a kilometrage, m."""

    track_id: str
    offset_m: float
    position_m: float


@dataclass(frozen=True, slots=True)
class LayoutCrossing:
    """A level crossing (踏切) of one track; None where the source does not say with what it is protected."""

    name: str
    track_id: str
    offset_m: float
    kind: CrossingClass | None


@dataclass(frozen=True)
class ForeignLayout:
    """All of a source that is taken. Ids are the source's, each kind in its own order there."""

    name: str
    source: str
    nodes: tuple[LayoutNode, ...]
    tracks: tuple[LayoutTrack, ...]
    points: tuple[LayoutPoints, ...]
    stations: tuple[LayoutStation, ...]
    signals: tuple[LayoutSignal, ...]
    milestones: tuple[Milestone, ...]
    used: tuple[str, ...]
    assumed: tuple[str, ...]
    left: tuple[str, ...]
    origin_deg: Place | None = None  # longitude and latitude of the plane's (0, 0)
    crossings: tuple[LayoutCrossing, ...] = ()

    @cached_property
    def track_of(self) -> Mapping[str, LayoutTrack]:
        """Tracks by id."""
        return {track.id: track for track in self.tracks}

    @cached_property
    def ends_at(self) -> Mapping[str, tuple[str, ...]]:
        """Ids of the tracks that end at each node; a track that ends there twice stands twice."""
        found: dict[str, list[str]] = {node.id: [] for node in self.nodes}
        for track in self.tracks:
            found[track.low_node].append(track.id)
            found[track.high_node].append(track.id)
        return {node_id: tuple(ids) for node_id, ids in found.items()}

    @property
    def length_m(self) -> float:
        """Length of all tracks, m."""
        return sum(track.length_m for track in self.tracks)

    def km_of(self, track_id: str, offset_m: float) -> float | None:
        """Kilometrage, m, of a place on a track."""
        return self.track_of[track_id].km_m(offset_m)


def count_text(count: int, one: str, many: str = "") -> str:
    """`1 signal`, `3 signals`."""
    return f"{count} {one if count == 1 else many or one + 's'}"
