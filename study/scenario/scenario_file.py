"""The scenario file's tables: those of a run as they are, and what names the other files."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from network.files.kinds import about
from network.files.toml_input import Record
from onboard.unit_records import UnitParameters
from radio.air import AirParameters
from simulation.settings import (
    NO_TUNING,
    NO_VISION,
    Driving,
    Limits,
    Load,
    Operation,
    Sensors,
    Tuning,
    Vision,
)
from simulation.world.scatter import Scatter
from study.scenario.script_file import ActTable, ExpectTable, FaultTable

Seed = Annotated[int, Field(ge=0)]


class TrainsTable(Load):
    """`[trains]`: which train file each stock runs as, and how full trains are."""

    default: Annotated[
        str, about("train file of every stock that is not named, shipped or beside the scenario")
    ]
    stock: Annotated[dict[str, str], about("train file by stock id")] = Field(default_factory=dict)


class ScenarioFile(Record):
    """A scenario: line, timetable, trains and everything that may differ from run to run.

    A drill is a scenario with faults, acts and expectations.
    """

    id: Annotated[str, about("name of the run and of its directory")]
    name: Annotated[str, about("what people call it")]
    line: Annotated[str, about("line file, shipped or beside the scenario")]
    timetable: Annotated[str, about("timetable file, shipped or beside the scenario")]
    seed: Annotated[
        Seed, about("sets every chance of the run; --seed comes first", "assumed: any will do")
    ] = 1
    assumed: Annotated[list[str], about("what nobody has published, in sentences for the report")] = Field(
        default_factory=list
    )
    trains: TrainsTable
    air: AirParameters = Field(default_factory=AirParameters)
    unit: UnitParameters = Field(default_factory=UnitParameters)
    driving: Driving = Field(default_factory=Driving)
    sensors: Sensors = Field(default_factory=Sensors)
    scatter: Scatter = Field(default_factory=Scatter)
    tuning: Tuning = NO_TUNING
    vision: Vision = NO_VISION
    limits: Limits = Field(default_factory=Limits)
    operation: Operation = Field(default_factory=Operation)
    line_patch: dict[str, Any] = Field(default_factory=dict)
    fault: Annotated[list[FaultTable], about("what fails, and when")] = Field(default_factory=list)
    act: Annotated[list[ActTable], about("what people do about it")] = Field(default_factory=list)
    expect: Annotated[list[ExpectTable], about("what must happen, for a drill to pass")] = Field(
        default_factory=list
    )
