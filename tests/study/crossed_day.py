"""A made-up day on a line with a level crossing, whose figures are known."""

from dataclasses import fields, replace
from typing import Final

from network.model import CrossingClass, CrossingControl, LevelCrossing
from study.record.crossings import CrossingHour, CrossingPassage
from study.record.road import RoadHour
from study.record.tables import RunTables, make_table
from study.report.data import ReportedRun

HOURS: Final = (
    CrossingHour("C1", 7, 60.0, 1, 60.0, 1, 30.0, 30.0, 30.0),
    CrossingHour("C1", 8, 180.0, 2, 120.0, 3, 38.0, 34.0, 44.0),
)
PASSAGES: Final = (
    CrossingPassage("C1", "321M", "V1", 25_300.0, 10.0, 30.0, 15.0, 20.0, True),
    *(
        CrossingPassage("C1", "323M", "V2", 29_000.0 + w, 10.0, w, w - 15.0, 99.0, False)
        for w in (34.0, 36.0, 44.0)
    ),
)
VEHICLES: Final = (RoadHour("C1", 8, 40, 0.5, 100.0, 7),)


def with_crossing(run: ReportedRun, *, vehicles: bool = False) -> ReportedRun:
    """The run on a line with crossing C1 at 5 km, closed as HOURS has it, with a road or without."""
    crossing = LevelCrossing(
        "C1",
        "Mill lane",
        CrossingClass.BARRIERS,
        CrossingControl.RADIO,
        next(iter(run.line.pieces)),
        5000.0,
        6.0,
        8.0,
        15.0,
        20.0,
    )
    frames = {field.name: getattr(run.tables, field.name) for field in fields(RunTables)}
    frames |= {"crossings": make_table("crossings", HOURS), "warnings": make_table("warnings", PASSAGES)}
    frames |= {"road": make_table("road", VEHICLES if vehicles else ())}
    line = replace(run.line, crossings={"C1": crossing})
    return ReportedRun(line, run.timetable, RunTables(**frames))
