"""The scenario file's tables: those of a run as they are, and what names the other files."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from network.files.edits import Words
from network.files.kinds import TABLES_MAX, TEXTS_MAX, about
from network.files.names import Identifier, Prose, Title
from network.files.patch import LineWords
from network.files.quantities import Seed
from network.files.timetable_patch import TimetableWords
from network.files.toml_input import Record
from onboard.driving.laws.settings import LawTables
from onboard.driving.planner.wish import PLAIN, Planning
from onboard.unit_records import UnitParameters
from radio.air import AirParameters
from simulation.battery_settings import BatterySettings
from simulation.gnss_settings import Gnss
from simulation.late.settings import NO_LATE, Late
from simulation.people import People
from simulation.sensor_settings import Beacons, Curvature, Lidar
from simulation.settings import (
    NO_TUNING,
    NO_VISION,
    Dispatch,
    Driving,
    Limits,
    Load,
    Operation,
    Sensors,
    Tuning,
    Vision,
)
from simulation.world.scatter import Scatter
from study.scenario.belief import BeliefTable
from study.scenario.script_file import ActTable, ExpectTable, FaultTable


class TrainsTable(Load):
    """`[trains]`: which train file each stock runs as, and how full trains are."""

    default: Annotated[
        str, about("train file of every stock that is not named, shipped or beside the scenario")
    ]
    stock: Annotated[dict[str, str], about("train file by stock id")] = Field(default_factory=dict)


class TableWords(Record):
    """A patch of one of the scenario's own tables (`[patch.air]`): on what the extended scenarios say."""

    values: Annotated[dict[str, Any], about("values set, by key path")] = Field(
        default_factory=dict, alias="set"
    )
    times: Annotated[dict[str, float], about("numbers multiplied by a factor, by key path")] = Field(
        default_factory=dict
    )


class ListWords(TableWords):
    """A patch of one of the scenario's own lists (`[patch.fault]`)."""

    remove: Annotated[list[str | int], about("entries taken out, by index")] = Field(default_factory=list)
    add: Annotated[list[dict[str, Any]], about("entries added")] = Field(default_factory=list)


class PatchTable(Record):
    """`[patch]`: a what-if on every file that the scenario names, and on what it takes over from others.

    Patches of scenarios that extend one another are carried out one after the other, the extended one's first.
    """

    line: Annotated[LineWords | None, about("on the line file")] = None
    timetable: Annotated[TimetableWords | None, about("on the timetable file")] = None
    train: Annotated[dict[str, Words], about("on train files, by their name")] = Field(default_factory=dict)
    air: Annotated[TableWords | None, about("on [air]")] = None
    unit: Annotated[TableWords | None, about("on [unit]")] = None
    driving: Annotated[TableWords | None, about("on [driving]")] = None
    law: Annotated[TableWords | None, about("on [law]")] = None
    planning: Annotated[TableWords | None, about("on [planning]")] = None
    sensors: Annotated[TableWords | None, about("on [sensors]")] = None
    gnss: Annotated[TableWords | None, about("on [gnss]")] = None
    beacons: Annotated[TableWords | None, about("on [beacons]")] = None
    lidar: Annotated[TableWords | None, about("on [lidar]")] = None
    curvature: Annotated[TableWords | None, about("on [curvature]")] = None
    scatter: Annotated[TableWords | None, about("on [scatter]")] = None
    trains: Annotated[TableWords | None, about("on [trains]")] = None
    limits: Annotated[TableWords | None, about("on [limits]")] = None
    operation: Annotated[TableWords | None, about("on [operation]")] = None
    dispatch: Annotated[TableWords | None, about("on [dispatch]")] = None
    battery: Annotated[TableWords | None, about("on [battery]")] = None
    people: Annotated[TableWords | None, about("on [people]")] = None
    late: Annotated[TableWords | None, about("on [late]")] = None
    fault: Annotated[ListWords | None, about("on [[fault]]")] = None
    act: Annotated[ListWords | None, about("on [[act]]")] = None
    expect: Annotated[ListWords | None, about("on [[expect]]")] = None


class ScenarioFile(Record):
    """A scenario: line, timetable, trains and everything that may differ from run to run.

    A drill is a scenario with faults, acts and expectations.
    """

    extends: Annotated[str | None, about("scenario whose tables hold wherever this one says nothing")] = None
    id: Annotated[Identifier, about("name of the run and of its directory")]
    name: Annotated[Title, about("what people call it")]
    line: Annotated[str, about("line file, shipped or beside the scenario")]
    timetable: Annotated[str, about("timetable file, shipped or beside the scenario")]
    seed: Annotated[
        Seed, about("sets every chance of the run; --seed comes first", "assumed: any will do")
    ] = 1
    assumed: Annotated[
        list[Prose],
        Field(max_length=TEXTS_MAX),
        about("what nobody has published, in sentences for the report"),
    ] = Field(default_factory=list)
    trains: TrainsTable
    air: AirParameters = Field(default_factory=AirParameters)
    unit: UnitParameters = Field(default_factory=UnitParameters)
    driving: Driving = Field(default_factory=Driving)
    law: LawTables = Field(default_factory=LawTables)
    planning: Planning = PLAIN
    sensors: Sensors = Field(default_factory=Sensors)
    gnss: Gnss = Field(default_factory=Gnss)
    beacons: Beacons = Field(default_factory=Beacons)
    curvature: Curvature = Field(default_factory=Curvature)
    scatter: Scatter = Field(default_factory=Scatter)
    tuning: Tuning = NO_TUNING
    vision: Vision = NO_VISION
    lidar: Lidar = Field(default_factory=Lidar)
    limits: Limits = Field(default_factory=Limits)
    operation: Operation = Field(default_factory=Operation)
    dispatch: Dispatch = Field(default_factory=Dispatch)
    battery: Annotated[
        BatterySettings | None, about("trains that have a battery run on it; left out: all run from a wire")
    ] = None
    people: People = Field(default_factory=People)
    late: Late = NO_LATE
    belief: Annotated[BeliefTable | None, about("what units go by where it is not what is so")] = None
    patch: Annotated[PatchTable, about("what differs from the files named: a what-if")] = Field(
        default_factory=PatchTable
    )
    fault: Annotated[list[FaultTable], Field(max_length=TABLES_MAX), about("what fails, and when")] = Field(
        default_factory=list
    )
    act: Annotated[list[ActTable], Field(max_length=TABLES_MAX), about("what people do about it")] = Field(
        default_factory=list
    )
    expect: Annotated[
        list[ExpectTable], Field(max_length=TABLES_MAX), about("what must happen, for a drill to pass")
    ] = Field(default_factory=list)
