"""The line file's tables as they are written: kilometres, km/h and permille, keys that end in their unit.

Only shape, type and sign are checked here; what needs the whole line is checked in `network.files.line_file`.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import Field

from network.files.toml_input import Record
from network.model import Direction

# Ids become SUMO ids and Zenoh key expressions, which both reserve most other characters.
Id = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$")]
Positive = Annotated[float, Field(gt=0)]
DirectionName = Literal["down", "up"]

DIRECTIONS: Final[dict[str, Direction]] = {"down": Direction.DOWN, "up": Direction.UP}
TAG_ID_MAX: Final = 0xFFFF  # section 6.1.3: 24 bits hold a tag's id and its CRC-8


class LineTable(Record):
    """`[line]`."""

    id: Id
    name: str
    name_ja: str = ""
    max_speed_kmh: Positive
    sources: list[str] = Field(default_factory=list)
    assumed: list[str] = Field(default_factory=list)


class RangeTable(Record):
    """Anything between two kilometrages."""

    from_km: float
    to_km: float


class GradientTable(RangeTable):
    """`alignments.gradients`: positive where DOWN climbs."""

    permille: float = Field(gt=-150, lt=150)


class CurveTable(RangeTable):
    """`alignments.curves`: `radius_m` positive to the right going down."""

    radius_m: float
    transition_m: float = Field(ge=0)
    cant_mm: float = Field(ge=0, le=200)


class LimitTable(RangeTable):
    """`alignments.limits`."""

    speed_kmh: Positive
    directions: list[DirectionName] = Field(default=["down", "up"], min_length=1)


class AlignmentTable(RangeTable):
    """`[[alignments]]`."""

    id: Id
    x_m: float = 0.0
    y_m: float = 0.0
    bearing_deg: float = 0.0
    elevation_m: float = 0.0
    gradients: list[GradientTable]
    curves: list[CurveTable] = Field(default_factory=list)
    limits: list[LimitTable] = Field(default_factory=list)
    coverage: list[RangeTable] = Field(default_factory=list)


class SectionTable(Record):
    """`[[sections]]`: a points section has neither range nor offset, its points give them."""

    id: Id
    kind: Literal["track", "points", "between", "portal"]
    alignment: str | None = None
    from_km: float | None = None
    to_km: float | None = None
    offset_m: float = 0.0


class PointsTable(Record):
    """`[[points]]`: stem between the toe and the end the facing train comes from, legs on the other side."""

    id: Id
    section: str
    terminal: Id
    alignment: str | None = None
    from_km: float
    toe_km: float
    to_km: float
    faces: DirectionName
    stem: str
    normal: str
    reverse: str
    throw_time_s: Positive
    diverging_limit_kmh: Positive
    offset_m: float | None = None
    initial: Literal["normal", "reverse"] = "normal"


class JointTable(Record):
    """`[[joints]]`: the high end of `low` meets the low end of `high`."""

    low: str
    high: str


class PlatformTable(Record):
    """`stations.tracks`."""

    name: Annotated[str, Field(min_length=1)]
    section: str
    platform_from_km: float
    platform_to_km: float
    mark_down_km: float | None = None
    mark_up_km: float | None = None
    directions: list[DirectionName] | None = None


class StationTable(Record):
    """`[[stations]]`."""

    id: Id
    name: str
    name_ja: str = ""
    km: float
    halt: bool = False
    tracks: Annotated[list[PlatformTable], Field(min_length=1)]


class TagTable(Record):
    """`[[tags]]`: in `section` when that is a single piece, else on `piece`."""

    id: int = Field(ge=1, le=TAG_ID_MAX)
    section: str | None = None
    piece: str | None = None
    km: float
    purpose: Literal["arrival", "control_start", "departed", "approach", "position", "portal"]
    directions: list[DirectionName] = Field(default=["down", "up"], min_length=1)


class LineFile(Record):
    """A whole line file."""

    line: LineTable
    alignments: Annotated[list[AlignmentTable], Field(min_length=1)]
    sections: Annotated[list[SectionTable], Field(min_length=1)]
    points: list[PointsTable] = Field(default_factory=list)
    joints: list[JointTable] = Field(default_factory=list)
    stations: list[StationTable] = Field(default_factory=list)
    tags: list[TagTable] = Field(default_factory=list)
