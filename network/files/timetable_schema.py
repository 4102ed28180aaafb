"""The timetable file's tables as they are written; what needs the line is checked in `network.timetable`."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from network.files.kinds import TABLES_MAX, TEXTS_MAX, about
from network.files.line_schema import DirectionName
from network.files.names import Identifier, Prose, Title
from network.files.quantities import Wait
from network.files.toml_input import Record

_CLOCK = "HH:MM or HH:MM:SS, 24:00 and later after midnight"


class HeadTable(Record):
    """`[timetable]`."""

    id: Annotated[Identifier, about("name of the timetable")]
    name: Annotated[Title, about("display name")] = ""
    line: Annotated[str, about("id of the line it belongs to")]
    dwell_min_s: Annotated[Wait, about("shortest stop for passengers", "assumed: a quiet platform")] = 20.0
    turn_min_s: Annotated[
        Wait,
        about(
            "least time from a train's arrival until its set's next train can begin, for crews (折返し); 0: that of the"
            " operation",
            "assumed: none",
        ),
    ] = 0.0
    sources: Annotated[list[Prose], Field(max_length=TEXTS_MAX), about("where its times come from")] = Field(
        default_factory=list
    )
    assumed: Annotated[
        list[Prose],
        Field(max_length=TEXTS_MAX),
        about("what has no published source, in sentences for the report"),
    ] = Field(default_factory=list)


class CallTable(Record):
    """`trains.calls`: a stop (停車) or, with `pass` alone, a passing; only the last may lack a departure."""

    station: Annotated[str, about("id of the station")]
    track: Annotated[str | None, about("its track; left out: the usual one of the direction")] = None
    arrival: Annotated[str | None, about(f"when it arrives, {_CLOCK}")] = None
    departure: Annotated[str | None, about(f"when it leaves, {_CLOCK}")] = None
    passes: Annotated[
        str | None, Field(alias="pass"), about(f"when it runs through (通過), {_CLOCK}; no other time then")
    ] = None
    operational: Annotated[bool, about("true: it stands, but not for passengers (運転停車)")] = False
    inferred: Annotated[bool, about("true: one of its times is not the source's but computed")] = False


class TrainTable(Record):
    """`[[trains]]`: a train (列車) as planned."""

    number: Annotated[Identifier, about("train number")]
    direction: Annotated[DirectionName, about("down or up the kilometrage")]
    revenue: Annotated[bool, about("false: an empty working")] = True
    calls: Annotated[
        list[CallTable], Field(min_length=1, max_length=TEXTS_MAX), about("where it calls, in order")
    ]
    begins: Annotated[str, about("stabled, portal:<section id> or from:<train number>")]
    ends: Annotated[str, about("stabled, portal:<section id> or becomes:<train number>")]


class DiagramTable(Record):
    """`[[diagrams]]`: one train set (編成) and the trains it runs (運用)."""

    stock: Annotated[Identifier, about("id of the set")]
    trains: Annotated[list[str], Field(min_length=1, max_length=TABLES_MAX), about("train numbers, in order")]


class TimetableFile(Record):
    """A whole timetable file; every train is in exactly one diagram."""

    timetable: HeadTable
    trains: Annotated[list[TrainTable], Field(min_length=1, max_length=TABLES_MAX), about("trains")]
    diagrams: Annotated[list[DiagramTable], Field(max_length=TABLES_MAX), about("train sets")] = Field(
        default_factory=list
    )
