"""What of a line, its plan, its faults and its substitute working a seat is told once, as parts of `welcome`."""

from __future__ import annotations

from typing import Any

import msgspec


class SectionDrawn(msgspec.Struct, frozen=True, kw_only=True):
    """A section of the schematic: kilometrages of its ends, and which track of how many it is there."""

    id: str
    kind: str
    from_m: float
    to_m: float
    lane: float
    station: str = ""


class StationDrawn(msgspec.Struct, frozen=True, kw_only=True):
    """A station of the line, with its kilometrage."""

    id: str
    name: str
    name_ja: str
    at_m: float


class PointsDrawn(msgspec.Struct, frozen=True, kw_only=True):
    """Points of the line, with the terminal that works them."""

    id: str
    section: str
    terminal: str
    at_m: float


class CrossingDrawn(msgspec.Struct, frozen=True, kw_only=True):
    """A level crossing (踏切) of the line: in which section, at which kilometrage. Without a `has_device` nothing warns
    its users; `by_radio`: units ask it to close, else contacts close it.
    """

    id: str
    name: str
    section: str
    at_m: float
    has_device: bool
    by_radio: bool


class TrainOnPlan(msgspec.Struct, frozen=True, kw_only=True):
    """A train of the timetable: unit, and times (s) and kilometrages (m) of its calls."""

    train: str
    unit: str
    times_s: tuple[float, ...]
    at_m: tuple[float, ...]


class FaultKind(msgspec.Struct, frozen=True, kw_only=True):
    """A kind of fault that can be begun: what it may aim at, and the JSON Schema of its keys."""

    kind: str
    name: str
    name_ja: str
    aims_at: str
    targets: tuple[str, ...]
    schema: dict[str, Any]
    momentary: bool


class StepDrawn(msgspec.Struct, frozen=True, kw_only=True):
    """A step of substitute working as the table of a section or station has it; `{train}` stands for a train's number.

    `part`: when it is due; `post`: the kind of role whose it is.
    """

    step: str
    post: str
    name_ja: str
    part: str
    who: str
    who_ja: str
    to: str
    to_ja: str
    says: str
    says_ja: str
    needs: tuple[str, ...]
    waits: str
    waits_ja: str


class WorkDrawn(msgspec.Struct, frozen=True, kw_only=True):
    """A section between stations, or a station, in substitute working: by which regime and table, with which trains."""

    block: str
    regime: str
    rows: tuple[StepDrawn, ...]
    trains: tuple[str, ...]


class PostDrawn(msgspec.Struct, frozen=True, kw_only=True):
    """A role of substitute working at its place, which the holder of this seat may take."""

    post: str
    name_ja: str
