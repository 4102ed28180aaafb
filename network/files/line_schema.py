"""The line file's tables as they are written: kilometres, km/h and permille, keys that end in their unit.

Only shape, type and sign are checked here; what needs the whole line is checked in `network.files.line_file`.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import Field

from network.files.crossing_road import CrossingRoad
from network.files.kinds import ROWS_MAX, TABLES_MAX, TEXTS_MAX, about
from network.files.names import Identifier, Prose, Title
from network.files.quantities import (
    BatteryPowerKw,
    Bearing,
    BlockCount,
    CantMm,
    Coordinate,
    CrossingWidth,
    CurrentA,
    Distance,
    GradientPermille,
    Height,
    Kilometrage,
    Offset,
    OverlapM,
    PositionBound,
    Radius,
    SpeedKmh,
    TagId,
    ThrowTime,
    Transition,
    VoltageV,
    Wait,
)
from network.files.toml_input import Record
from network.model import Direction

DirectionName = Literal["down", "up"]

DIRECTIONS: Final[dict[str, Direction]] = {"down": Direction.DOWN, "up": Direction.UP}


class LineTable(Record):
    """`[line]`."""

    id: Annotated[Identifier, about("name of the line")]
    name: Annotated[Title, about("display name")]
    name_ja: Annotated[Title, about("the same in Japanese")] = ""
    max_speed_kmh: Annotated[SpeedKmh, about("maximum speed of the line")]
    sources: Annotated[list[Prose], Field(max_length=TEXTS_MAX), about("where its figures come from")] = (
        Field(default_factory=list)
    )
    assumed: Annotated[
        list[Prose],
        Field(max_length=TEXTS_MAX),
        about("what has no published source, in sentences for the report"),
    ] = Field(default_factory=list)
    overlap_m: Annotated[
        OverlapM,
        about(
            "how far beyond its stop the way must be clear while a train comes in (過走余裕); 0: opposing trains may"
            " come in at once",
            "assumed: 0, as supervision guarantees the stop before the points",
        ),
    ] = 0.0


class RangeTable(Record):
    """Anything between two kilometrages."""

    from_km: Annotated[Kilometrage, about("where it begins")]
    to_km: Annotated[Kilometrage, about("where it ends")]


class GradientTable(RangeTable):
    """`alignments.gradients`: positive where DOWN climbs."""

    permille: Annotated[GradientPermille, about("positive where down trains climb")]


class CurveTable(RangeTable):
    """`alignments.curves`: `radius_m` positive to the right going down."""

    radius_m: Annotated[Radius, about("positive to the right going down")]
    transition_m: Annotated[Transition, about("length of each transition")]
    cant_mm: Annotated[CantMm, about("cant of the outer rail")]


class LimitTable(RangeTable):
    """`alignments.limits`."""

    speed_kmh: Annotated[SpeedKmh, about("limit")]
    directions: Annotated[list[DirectionName], about("directions for which it holds")] = Field(
        default=["down", "up"], min_length=1, max_length=2
    )


class AlignmentTable(RangeTable):
    """`[[alignments]]`."""

    id: Annotated[Identifier, about("name of the axis")]
    x_m: Annotated[Coordinate, about("east coordinate of its beginning")] = 0.0
    y_m: Annotated[Coordinate, about("north coordinate of its beginning")] = 0.0
    bearing_deg: Annotated[Bearing, about("bearing at its beginning, from north")] = 0.0
    elevation_m: Annotated[Height, about("height of its beginning")] = 0.0
    gradients: Annotated[
        list[GradientTable], Field(max_length=ROWS_MAX), about("gradients from end to end, without gaps")
    ]
    curves: Annotated[
        list[CurveTable],
        Field(max_length=ROWS_MAX),
        about("sorted, without overlap; between them it is straight"),
    ] = Field(default_factory=list)
    limits: Annotated[list[LimitTable], Field(max_length=ROWS_MAX), about("speed limits")] = Field(
        default_factory=list
    )
    coverage: Annotated[list[RangeTable], Field(max_length=ROWS_MAX), about("where the radio reaches")] = (
        Field(default_factory=list)
    )
    second_coverage: Annotated[
        list[RangeTable],
        Field(max_length=ROWS_MAX),
        about("where a second network reaches, in scenarios with `[second_air]`"),
    ] = Field(default_factory=list)
    tunnels: Annotated[
        list[RangeTable], Field(max_length=ROWS_MAX), about("tunnels, where no satellites are received")
    ] = Field(default_factory=list)
    obstructed: Annotated[
        list[RangeTable],
        Field(max_length=ROWS_MAX),
        about("where slopes, trees or houses hide low satellites and reflect their signals"),
    ] = Field(default_factory=list)


class SectionTable(Record):
    """`[[sections]]`: a points section has neither range nor offset, its points give them."""

    id: Annotated[Identifier, about("name of the section (閉そく区間)")]
    kind: Annotated[
        Literal["track", "points", "between", "portal"],
        about("platform track, points, between stations, or portal to another line"),
    ]
    alignment: Annotated[str | None, about("its axis; left out: the first")] = None
    from_km: Annotated[Kilometrage | None, about("where it begins; not for points")] = None
    to_km: Annotated[Kilometrage | None, about("where it ends; not for points")] = None
    offset_m: Annotated[Offset, about("lateral, to the right going down")] = 0.0
    virtual_blocks: Annotated[
        BlockCount,
        about(
            "between stations: cut into so many sections of equal length, which are called `ID_1` and so on"
        ),
    ] = 1


class PointsTable(Record):
    """`[[points]]`: stem between the toe and the end the facing train comes from, legs on the other side."""

    id: Annotated[Identifier, about("name of the points (転てつ器)")]
    section: Annotated[str, about("points section they lie in")]
    terminal: Annotated[Identifier, about("terminal that drives them")]
    alignment: Annotated[str | None, about("its axis; left out: the first")] = None
    from_km: Annotated[Kilometrage, about("low end")]
    toe_km: Annotated[Kilometrage, about("where the legs part")]
    to_km: Annotated[Kilometrage, about("high end")]
    faces: Annotated[DirectionName, about("direction of the trains that meet the toe first")]
    stem: Annotated[str, about("section or piece before the toe")]
    normal: Annotated[str, about("where the normal leg leads")]
    reverse: Annotated[str, about("where the reverse leg leads")]
    throw_time_s: Annotated[ThrowTime, about("throw time from end to end")]
    diverging_limit_kmh: Annotated[SpeedKmh, about("limit on the reverse leg")]
    offset_m: Annotated[
        Offset | None, about("lateral offset of the stem; left out: that of the section before it")
    ] = None
    initial: Annotated[Literal["normal", "reverse"], about("position at the beginning")] = "normal"


class JointTable(Record):
    """`[[joints]]`: the high end of `low` meets the low end of `high`."""

    low: Annotated[str, about("section whose high end meets the other")]
    high: Annotated[str, about("section whose low end it meets")]


class PlatformTable(Record):
    """`stations.tracks`: a track of a station; without a platform, as at a signal station (信号場), for trains only."""

    name: Annotated[Title, Field(min_length=1), about("number of the track")]
    section: Annotated[str, about("section it lies in")]
    platform_from_km: Annotated[
        Kilometrage | None, about("platform, low end; left out with the other end: no platform")
    ] = None
    platform_to_km: Annotated[Kilometrage | None, about("platform, high end")] = None
    mark_down_km: Annotated[Kilometrage | None, about("stopping mark for down trains")] = None
    mark_up_km: Annotated[Kilometrage | None, about("stopping mark for up trains")] = None
    directions: Annotated[
        list[DirectionName] | None,
        about("directions that usually use this track; left out: all that have a mark"),
    ] = None
    overlap_down_m: Annotated[
        OverlapM | None, about("overlap for down trains, 0 with a safety siding; left out: that of the line")
    ] = None
    overlap_up_m: Annotated[OverlapM | None, about("overlap for up trains")] = None


class StationTable(Record):
    """`[[stations]]`."""

    id: Annotated[Identifier, about("name of the station")]
    name: Annotated[Title, about("display name")]
    name_ja: Annotated[Title, about("the same in Japanese")] = ""
    km: Annotated[Kilometrage, about("kilometrage")]
    halt: Annotated[bool, about("on a section between stations, no track of its own")] = False
    tracks: Annotated[
        list[PlatformTable], Field(min_length=1, max_length=TEXTS_MAX), about("platform tracks")
    ]


class ChargerTable(Record):
    """`[[chargers]]`: at a station, where sets charge their batteries; what it gives is the least of both limits."""

    station: Annotated[str, about("station id")]
    tracks: Annotated[
        list[str] | None, Field(min_length=1), about("names of the tracks; left out: all of the station")
    ] = None
    power_kw: Annotated[BatteryPowerKw, about("greatest power to a train, behind its converter")]
    voltage_v: Annotated[VoltageV, about("voltage of the bar or wire")]
    current_max_a: Annotated[
        CurrentA | None, about("greatest current to a standing train; left out: what the power requires")
    ] = None
    connect_s: Annotated[Wait, about("time from standing to the first current", "assumed: pantograph up")] = (
        20.0
    )
    disconnect_s: Annotated[
        Wait, about("time from the last current to the start", "assumed: pantograph down")
    ] = 15.0
    origin: Annotated[Prose, Field(min_length=1), about('source of its figures, or "assumed: why"')]


class OnTrackTable(Record):
    """Anything that lies at one place: in `section` when that is a single piece, else on `piece`."""

    section: Annotated[str | None, about("its section, if that is one piece")] = None
    piece: Annotated[str | None, about("its piece, if it lies among points")] = None
    km: Annotated[Kilometrage, about("kilometrage")]
    directions: Annotated[list[DirectionName], about("directions whose trains use it")] = Field(
        default=["down", "up"], min_length=1, max_length=2
    )


class TagTable(OnTrackTable):
    """`[[tags]]`."""

    id: Annotated[TagId, about("id that the tag (地上子) sends")]
    purpose: Annotated[
        Literal["arrival", "control_start", "departed", "approach", "position", "portal"],
        about("purpose, after table 3 of the paper"),
    ]


class BeaconTable(OnTrackTable):
    """`[[beacons]]`: of the train stop; trains that carry a beacon receiver notice them."""

    id: Annotated[TagId, about("its number")]
    tells_id: Annotated[bool, about("whether trains read its number, as with ATS-P")] = False
    used: Annotated[bool, about("whether on-board databases use it (使用地上子)")] = True
    window_m: Annotated[
        PositionBound | None,
        about("it is searched this far in both directions (検出範囲); left out: by the rule of [beacons]"),
    ] = None


class MarkersTable(OnTrackTable):
    """`[[markers]]`: reflective markers in a pattern, for trains with a LiDAR; `km` is the row that they meet first."""

    id: Annotated[TagId, about("its number")]
    pattern: Annotated[TagId, about("which pattern the markers lie in")]
    directions: Annotated[
        list[DirectionName], about("direction whose trains use it; a pattern faces one way")
    ] = Field(min_length=1, max_length=1)


class CrossingTable(OnTrackTable):
    """`[[crossings]]`: level crossings; `km` is the middle of the road, which crosses one track."""

    directions: Annotated[list[DirectionName], about("both: trains of either direction cross the road")] = (
        Field(default=["down", "up"], min_length=2, max_length=2)
    )
    id: Annotated[Identifier, about("name of the crossing (踏切), and of the device at it")]
    name: Annotated[Title, about("display name")] = ""
    width_m: Annotated[CrossingWidth, about("extent along the track", "assumed: a road of two lanes")] = 6.0
    kind: Annotated[
        Literal["1", "3", "4"],
        about(
            "class: with barriers, with a warning alone, without any device", "most crossings are of class 1"
        ),
    ] = "1"
    control: Annotated[
        Literal["radio", "contacts"],
        about("what starts the warning: the units' telegrams, or contacts that trains pass"),
    ] = "radio"
    lowering_s: Annotated[Wait, about("time that the barriers take from end to end", "assumed: 遮断機")] = 8.0
    closing_s: Annotated[
        Wait | None,
        about("with barriers, from the start of the warning to closed", "interpretation of article 62: 15 s"),
    ] = None
    closed_s: Annotated[
        Wait | None,
        about(
            "from closed to the train, without barriers from the start of the warning",
            "interpretation of article 62: 20 s, without barriers 30 s",
        ),
    ] = None
    start_down_km: Annotated[Kilometrage | None, about("contact that down trains start it by")] = None
    start_up_km: Annotated[Kilometrage | None, about("contact that up trains start it by")] = None
    end_down_km: Annotated[
        Kilometrage | None,
        about("contact that down trains end it by; left out: the edge that they leave last"),
    ] = None
    end_up_km: Annotated[
        Kilometrage | None, about("contact that up trains end it by; left out: likewise")
    ] = None
    sight_m: Annotated[
        Distance | None, about("without a device, from how far its users see a train; left out: nobody knows")
    ] = None
    detector: Annotated[
        bool,
        about("with barriers, whether a detector (障害物検知装置) sees what stands on it while it is closed"),
    ] = False
    protection: Annotated[
        bool,
        about(
            "by contacts, whether units hear by radio that nobody has pressed its button and nothing is on it"
            " (特殊信号発光機), and stop before it where they do not"
        ),
    ] = False
    departures: Annotated[
        bool,
        about(
            "by contacts, whether a train that begins beyond the first contact starts the warning by its departure:"
            " its unit asks by radio, and leaves as late as the road needs"
        ),
    ] = False
    road: Annotated[
        CrossingRoad | None, about("the road, which SUMO carries; left out: nothing drives over it")
    ] = None


class LineFile(Record):
    """A whole line file."""

    line: LineTable
    alignments: Annotated[list[AlignmentTable], Field(min_length=1, max_length=TEXTS_MAX), about("axes")]
    sections: Annotated[list[SectionTable], Field(min_length=1, max_length=TABLES_MAX), about("sections")]
    points: Annotated[list[PointsTable], Field(max_length=TABLES_MAX), about("points")] = Field(
        default_factory=list
    )
    joints: Annotated[
        list[JointTable], Field(max_length=TABLES_MAX), about("plain joints between sections")
    ] = Field(default_factory=list)
    stations: Annotated[list[StationTable], Field(max_length=TABLES_MAX), about("stations and halts")] = (
        Field(default_factory=list)
    )
    tags: Annotated[
        list[TagTable],
        Field(max_length=ROWS_MAX),
        about("tags, by the rule of network.tag_layout or by hand"),
    ] = Field(default_factory=list)
    chargers: Annotated[
        list[ChargerTable], Field(max_length=TABLES_MAX), about("where batteries are charged")
    ] = Field(default_factory=list)
    beacons: Annotated[list[BeaconTable], Field(max_length=ROWS_MAX), about("beacons of the train stop")] = (
        Field(default_factory=list)
    )
    markers: Annotated[
        list[MarkersTable], Field(max_length=ROWS_MAX), about("groups of reflective markers")
    ] = Field(default_factory=list)
    crossings: Annotated[
        list[CrossingTable], Field(max_length=TABLES_MAX), about("level crossings (踏切)")
    ] = Field(default_factory=list)
