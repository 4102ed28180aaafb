"""The line as a graph of sections and track pieces (線区モデル, Sugiyama et al. 2017, section 4.1.1, figure 3).

A *piece* is a stretch of one physical track with a kilometrage at either end; a *section* (閉そく区間) is what
trains hold exclusively and owns one or more pieces. A platform track, the line between stations and a portal
own one piece each; a points section owns the stem and the two legs of each of its points. Every joint between
pieces is a node, so a third track or a junction is data, not code.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum, IntEnum


class Direction(IntEnum):
    """Direction of travel: DOWN (下り) is increasing kilometrage, UP (上り) decreasing."""

    DOWN = 1
    UP = -1

    @property
    def opposite(self) -> Direction:
        """The other direction."""
        return Direction(-self.value)


class SectionKind(Enum):
    """What a section is in figure 3 of the paper; PORTAL is where trains enter from and leave for other lines."""

    TRACK = "track"
    POINTS = "points"
    BETWEEN = "between"
    PORTAL = "portal"


class Position(Enum):
    """Position of a set of points (転てつ機): 定位 and 反位."""

    NORMAL = "normal"
    REVERSE = "reverse"


class PointsLeg(Enum):
    """The three ends of a set of points, seen from the toe."""

    STEM = "stem"
    NORMAL = "normal"
    REVERSE = "reverse"


class TagPurpose(Enum):
    """Why a tag (地上子) lies where it does; numbers ① to ④ are those of figure 3 and table 3."""

    ARRIVAL = "arrival"  # ①: on the arrival track, behind the rear points: triggers the release
    CONTROL_START = "control_start"  # ②: at the stopping mark: triggers the route request
    DEPARTED = "departed"  # ③: between stations, beyond the departure points
    APPROACH = "approach"  # ④: before the arrival points: triggers the throw
    POSITION = "position"  # fixes the position only
    PORTAL = "portal"  # on a portal: a train entering the line learns where it is


@dataclass(frozen=True, slots=True)
class Piece:
    """A stretch of one track. `low_node` lies at `from_m`, `high_node` at `to_m` (kilometrage, m, from_m < to_m)."""

    id: str
    section_id: str
    alignment_id: str
    from_m: float
    to_m: float
    low_node: str
    high_node: str
    offset_m: float = 0.0  # lateral offset from the alignment, positive to the right of DOWN
    points_id: str | None = None
    leg: PointsLeg | None = None

    @property
    def length_m(self) -> float:
        """Length along the alignment, m."""
        return self.to_m - self.from_m


@dataclass(frozen=True, slots=True)
class Section:
    """What one train at a time may hold (閉そく区間)."""

    id: str
    kind: SectionKind
    piece_ids: tuple[str, ...]
    station_id: str | None = None
    track: str | None = None


@dataclass(frozen=True, slots=True)
class Points:
    """A set of points (転てつ機) and the terminal (制御端末装置) that throws it.

    A train travelling in direction `faces` meets the toe first and is sent by the position; in the other
    direction it trails through.
    """

    id: str
    section_id: str
    terminal_id: str
    node_id: str
    faces: Direction
    stem_piece: str
    normal_piece: str
    reverse_piece: str
    throw_time_s: float
    diverging_limit_mps: float
    initial: Position = Position.NORMAL


@dataclass(frozen=True, slots=True)
class PlatformTrack:
    """A place where trains stand. At a halt (停留所) `section_id` is the section between stations.

    `platform_m` are the kilometrages (m) of the platform's low and high end; None on a track that has none, as at a
    signal station (信号場). `marks_m` gives by direction of travel the kilometrage (m) at which the front stops,
    `overlaps_m` how far (m) beyond its stop the way must be clear of others while a train comes in (過走余裕).
    """

    station_id: str
    name: str
    section_id: str
    piece_id: str
    platform_m: tuple[float, float] | None
    marks_m: Mapping[Direction, float]
    directions: tuple[Direction, ...]  # directions for which this track is the usual one
    overlaps_m: Mapping[Direction, float] = field(default_factory=dict[Direction, float])


@dataclass(frozen=True, slots=True)
class Station:
    """A station with tracks, or a halt; `position_m` is its official kilometrage, m."""

    id: str
    name: str
    name_ja: str
    position_m: float
    tracks: tuple[PlatformTrack, ...]
    is_halt: bool

    @property
    def is_signal_station(self) -> bool:
        """Whether no track has a platform (信号場): trains meet or stand here, nobody gets on."""
        return all(track.platform_m is None for track in self.tracks)


@dataclass(frozen=True, slots=True)
class Charger:
    """Where sets with a battery charge (充電設備): a station, the names of its tracks, and what it gives at most, W.

    `connect_s` is from a stand to the first current (pantograph up, checks), `disconnect_s` from the last to a start.
    """

    station_id: str
    tracks: tuple[str, ...]
    power_w: float
    connect_s: float
    disconnect_s: float


@dataclass(frozen=True, slots=True)
class Tag:
    """A tag on the track (地上子), read by trains of any direction named in `directions`."""

    id: int
    piece_id: str
    position_m: float
    purpose: TagPurpose
    directions: tuple[Direction, ...]


@dataclass(frozen=True, slots=True)
class Beacon:
    """A beacon of the train stop (ATS地上子): a passage is noticed, and its number only where `tells_id`.

    `used`: one of those that an on-board database goes by (使用地上子). `window_m`: it is looked for this far either
    way (検出範囲); None: by a rule.
    """

    id: int
    piece_id: str
    position_m: float
    directions: tuple[Direction, ...]
    tells_id: bool = False
    used: bool = True
    window_m: float | None = None


@dataclass(frozen=True, slots=True)
class MarkerGroup:
    """Reflective markers (ターゲットマーカ) laid in a pattern between the rails, for trains with a LiDAR.

    `position_m` is the kilometrage (m) of the row that trains of `directions` meet first.
    """

    id: int
    pattern: int
    piece_id: str
    position_m: float
    directions: tuple[Direction, ...]


class CrossingClass(Enum):
    """Class of a level crossing (踏切種別): with barriers, with a warning alone, without a device; 第2種 is no more."""

    BARRIERS = "1"
    WARNING = "3"
    NO_DEVICE = "4"


class CrossingControl(Enum):
    """What starts the warning at a level crossing: the unit's telegrams, or contacts that trains pass (踏切制御子)."""

    RADIO = "radio"
    CONTACTS = "contacts"


@dataclass(frozen=True, slots=True)
class LevelCrossing:
    """A level crossing (踏切). `position_m` is the kilometrage (m) of its middle, `width_m` its extent along the track.

    `lowering_s`: that the barriers take; `closing_s`: from the start of the warning to closed, `closed_s`: from closed
    to the train; without barriers it counts as closed once its lamps are lit. `starts_m`, `ends_m`: kilometrages (m) of
    contacts by direction of travel. `sight_m`: from how far (m) its users see a train, if that is known.
    `has_detector`: its device sees what stands on the road while it is closed (障害物検知装置).
    `has_protection`: controlled by contacts, it tells units by radio whether anything is known to be on it.
    `warns_departures`: likewise, units of trains that begin beyond its first contact ask it to close.
    """

    id: str
    name: str
    kind: CrossingClass
    control: CrossingControl
    piece_id: str
    position_m: float
    width_m: float
    lowering_s: float
    closing_s: float
    closed_s: float
    starts_m: Mapping[Direction, float] = field(default_factory=dict[Direction, float])
    ends_m: Mapping[Direction, float] = field(default_factory=dict[Direction, float])
    sight_m: float | None = None
    has_detector: bool = False
    has_protection: bool = False
    warns_departures: bool = False

    @property
    def has_device(self) -> bool:
        """Whether anything warns its users of a train."""
        return self.kind is not CrossingClass.NO_DEVICE

    @property
    def by_radio(self) -> bool:
        """Whether units ask it to close, and may not pass before it has proved closed."""
        return self.has_device and self.control is CrossingControl.RADIO

    @property
    def tells_units(self) -> bool:
        """Whether units may not pass before they have heard from it: closed, or, by contacts, that nothing is on it."""
        return self.by_radio or self.has_protection or self.warns_departures

    @property
    def warning_s(self) -> float:
        """From the start of the warning to the train, s."""
        return self.closing_s + self.closed_s

    def edge_m(self, direction: Direction) -> float:
        """Kilometrage (m) of the edge that trains of this direction meet first."""
        return self.position_m - direction * self.width_m / 2.0

    def contacts_from_road_m(self, direction: Direction) -> tuple[float, float]:
        """How far the first contact lies before the road, and the last one beyond it, m, as trains of this direction
        run; a last contact that is not given lies where the road ends. Raises KeyError where there is no first one.
        """
        leaves_m = self.edge_m(direction.opposite)
        before_m = abs(self.starts_m[direction] - self.edge_m(direction))
        return before_m, abs(self.ends_m.get(direction, leaves_m) - leaves_m)


@dataclass(frozen=True, slots=True)
class Gradient:
    """Gradient between two kilometrages, permille, positive where DOWN climbs."""

    from_m: float
    to_m: float
    permille: float


@dataclass(frozen=True, slots=True)
class Curve:
    """A curve with its transitions inside `from_m`..`to_m`; `radius_m` > 0 bends to the right going DOWN."""

    from_m: float
    to_m: float
    radius_m: float
    transition_m: float
    cant_mm: float


@dataclass(frozen=True, slots=True)
class SpeedLimit:
    """A speed limit for trains of `directions` while any part of the train is within."""

    from_m: float
    to_m: float
    speed_mps: float
    directions: tuple[Direction, ...]


@dataclass(frozen=True, slots=True)
class Coverage:
    """A stretch in which a train reaches a radio network (無線)."""

    from_m: float
    to_m: float


@dataclass(frozen=True, slots=True)
class Cover:
    """A stretch in which little or nothing is seen of the sky."""

    from_m: float
    to_m: float


@dataclass(frozen=True, slots=True)
class Alignment:
    """One axis of kilometrage with what belongs to it; all tuples are sorted by `from_m` and do not overlap.

    `coverage` is where any network reaches; `of_networks`: where each of two does, on a line that has a second one.

    `x_m`, `y_m`, `bearing_deg` place the kilometrage `from_m` on the plane (east, north; bearing clockwise from
    north) from where geometry is integrated along the curves.
    """

    id: str
    from_m: float
    to_m: float
    x_m: float
    y_m: float
    bearing_deg: float
    elevation_m: float
    gradients: tuple[Gradient, ...]
    curves: tuple[Curve, ...]
    limits: tuple[SpeedLimit, ...]
    coverage: tuple[Coverage, ...]
    tunnels: tuple[Cover, ...] = ()
    obstructed: tuple[Cover, ...] = ()  # where slopes, trees or houses hide low satellites and reflect them
    of_networks: tuple[tuple[Coverage, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class Route:
    """From one track to the next (進路): granted whole or not at all.

    `section_ids` are those to be obtained, in order of travel, without the one the train stands in, up to and
    with the arrival track; `piece_ids` run from the departure track's piece to the arrival track's piece.
    `overlap`: points sections beyond the arrival track that a train which overran its stop there would foul; `entry`:
    those right before the track, where it needs leave to come in, as its overrun or another's is in the way
    (不同時進入).
    """

    id: str
    direction: Direction
    from_section: str
    to_section: str
    section_ids: tuple[str, ...]
    piece_ids: tuple[str, ...]
    points: tuple[tuple[str, Position], ...]
    entry: tuple[str, ...] = ()
    overlap: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Line:
    """A whole line. Built and validated by `network.files.line_file.load_line`; never by hand except in tests."""

    id: str
    name: str
    name_ja: str
    max_speed_mps: float
    stations: Mapping[str, Station]
    alignments: Mapping[str, Alignment]
    sections: Mapping[str, Section]
    pieces: Mapping[str, Piece]
    points: Mapping[str, Points]
    tags: Mapping[int, Tag]
    assumed: tuple[str, ...]  # what the line file marks as assumed, for reports
    chargers: Mapping[str, Charger] = field(default_factory=dict[str, Charger])  # by station id
    beacons: Mapping[int, Beacon] = field(default_factory=dict[int, Beacon])
    markers: Mapping[int, MarkerGroup] = field(default_factory=dict[int, MarkerGroup])
    crossings: Mapping[str, LevelCrossing] = field(default_factory=dict[str, LevelCrossing])

    def __hash__(self) -> int:
        """What was computed of a line last is kept by it."""
        return hash(self.id)
