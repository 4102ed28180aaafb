"""What a run leaves behind; `study` makes tables and reports of it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.timetable import CallKind, Timetable
from onboard.driving.tuning import Learned, StopDecelerations
from simulation.carriers.road_totals import RoadTotal
from simulation.faults.script import ItemCourse
from simulation.journal import Journal
from simulation.judge.checkers import Violation
from simulation.judge.rail import LowAdhesion
from simulation.motion_digest import motion_digest
from simulation.ride import NO_RIDE, Ride
from vehicle.battery import BatteryFlows
from vehicle.records import PLANT

TRACE_EVERY_STEPS: Final = 10  # a sample a second, and one at every event


class Ending(StrEnum):
    """Why a run ended; what cuts it short makes it no success whatever it reached, but for who asked for a part."""

    FINISHED = "all trains have finished"
    TIME_LIMIT = "the time limit of the run"
    STALLED = "no train can move any more"
    COLLISION = "a collision"
    END_OF_TRACK = "a train ran off the end of the track"
    CANNOT_TURN = "a train overran its track and cannot turn back"
    PART_OVER = "the end of the part of the day that was asked for"
    STOPPED = "it was stopped by a signal"

    @property
    def of_part(self) -> bool:
        """Whether a part of the day was run as asked: who is still on its way is not missing."""
        return self in {Ending.PART_OVER, Ending.STOPPED}


@dataclass(slots=True)
class StopRecord:
    """A call of the timetable as it really went; `error_m` is beyond the mark, by the truth.

    Where a train runs through, `departure_s` is when its front passes the mark, and there is no arrival.
    `stated_late_s`: it was cancelled, and counts as so late; None: it was not.
    """

    stock_id: str
    number: str
    revenue: bool
    station_id: str
    track: str
    planned_arrival_s: float | None
    planned_departure_s: float | None
    arrival_s: float | None = None
    departure_s: float | None = None
    error_m: float | None = None
    kind: CallKind = CallKind.STOP
    stated_late_s: float | None = None

    @property
    def cancelled(self) -> bool:
        """Whether the dispatcher left it out."""
        return self.stated_late_s is not None


class EnergyPhase(StrEnum):
    """What a stock did while it took a part of its energy."""

    RUNNING = "running"
    AT_STOP = "at a stop"  # between the arrival and the departure of one train
    HELD = "held"  # it stood elsewhere: before a stop limit, or in a portal
    LAYOVER = "layover"  # it stood where one train ends and the next begins (折返し)
    STABLED = "stabled"  # it stood after its last train (留置)


COUNTED: Final = tuple(  # what a plant counts of its energy; see `vehicle.records.PlantRow`
    name.removeprefix("energy_").removesuffix("_j")
    for name in PLANT.names or ()
    if name.startswith("energy_")
)
DRAWN: Final = ("traction", "regenerated", "auxiliary")
REJECTED: Final = "rejected"
PARTS: Final = tuple(name for name in COUNTED if name not in (*DRAWN, REJECTED))


@dataclass(frozen=True, slots=True)
class EnergyRecord:
    """Energy of one stock over one phase, J at the wire or battery, and the distance run, m; how a run was driven.

    `counted_j` has each of COUNTED: traction less regenerated went into PARTS, the auxiliaries are apart. What was
    rejected could have been given back, but the source did not take it, so that it is in the friction. `from_id` and
    `to_id` are stations, or portal sections, where the train was to stop; alike where it stood at one.
    """

    stock_id: str
    number: str
    revenue: bool
    phase: EnergyPhase
    from_id: str
    to_id: str
    begin_s: float
    end_s: float
    distance_m: float
    counted_j: Mapping[str, float]
    ride: Ride = NO_RIDE

    @property
    def residual_j(self) -> float:
        """What the parts leave open of what the motors drew and gave back."""
        counted_j = self.counted_j
        parts_j = math.fsum(counted_j[part] for part in PARTS)
        return counted_j["traction"] - counted_j["regenerated"] - parts_j


class BatteryEvent(StrEnum):
    """Why a battery was written down; empty: it was time to."""

    NONE = ""
    ENTERS = "enters"
    DEPARTS = "departs"
    STANDS = "stands"
    CONNECTED = "connected"  # to a charger or wire, from now on
    DISCONNECTED = "disconnected"
    BROUGHT = "power brought"  # by a generator, from now on
    TAKEN_AWAY = "power taken away"
    LEAVES = "leaves"  # the line
    RAN_BEYOND = "ran beyond"  # off the line, on its battery


@dataclass(frozen=True, slots=True)
class BatteryRecord:
    """A battery at one moment: state of charge, energy between empty and that, and what its counters show, J.

    `station`: where it stands; empty elsewhere. `supply_w`: what charger or wire gives at most.
    """

    stock_id: str
    number: str
    t_s: float
    event: BatteryEvent
    station: str
    soc: float
    stored_j: float
    supply_w: float
    flows: BatteryFlows


@dataclass(frozen=True, slots=True)
class Waiting:
    """A train that did not finish: where it is, whether it stands there, and what it waits for."""

    stock_id: str
    number: str
    place: str
    waits_for: str
    stands: bool = True


@dataclass(frozen=True, slots=True)
class TraceSpan:
    """Which train a slot was, from a step on: to read the trace by train number, direction and kilometrage."""

    slot: int
    from_step: int
    number: str
    direction: int
    starts_m: tuple[float, ...]
    piece_ids: tuple[str, ...]
    entries_m: tuple[float, ...]
    load_share: float = 0.0


@dataclass(slots=True)
class RunResult:
    """All of one run."""

    name: str
    seed: int
    link: str
    stock_ids: tuple[str, ...]
    begin_step: int
    end_step: int
    trains_planned: tuple[str, ...]
    trains_arrived: tuple[str, ...]
    empty_planned: tuple[str, ...]
    empty_arrived: tuple[str, ...]
    stops: list[StopRecord]
    energy: list[EnergyRecord]
    waiting: list[Waiting]
    violations: tuple[Violation, ...]
    collisions: tuple[str, ...]
    telegrams: Mapping[tuple[str, str, str], Counter[str]]
    trace: NDArray[np.void]
    spans: list[TraceSpan]
    journal: Journal
    ended_because: Ending
    # Trains that the dispatcher left out or ended early; one that he lets begin later is to arrive.
    cut: tuple[str, ...] = ()
    unfinished: tuple[str, ...] = ()  # stocks that neither left the line nor stand where their last duty ends
    outside_design: tuple[Violation, ...] = ()  # what followed from less adhesion than the design counts on
    slippery: tuple[LowAdhesion, ...] = ()  # when there was less
    uncommissioned: tuple[
        str, ...
    ] = ()  # parties that have lost their durable state and were not commissioned again
    courses: tuple[ItemCourse, ...] = ()  # what became of the script's faults and acts
    # By stock id, empty where no train learned; then the waves of the last stop that counted.
    learned: Mapping[str, Learned] = field(default_factory=dict[str, Learned])
    learned_from: Mapping[str, StopDecelerations] = field(default_factory=dict[str, StopDecelerations])
    # By crossing and hour of the day, where a road was carried.
    road: Mapping[tuple[str, int], RoadTotal] = field(default_factory=dict[tuple[str, int], RoadTotal])
    battery: tuple[BatteryRecord, ...] = ()  # of sets that run on one, in order of time
    # How many fixes each reader of a stock took, by stock id and reader; tags are not among them.
    fixes: Mapping[str, Mapping[str, int]] = field(default_factory=dict[str, Mapping[str, int]])

    @property
    def digest(self) -> str:
        """Digest of the journal and the trajectories."""
        return self.journal.digest()

    @property
    def motion_digest(self) -> str:
        """Digest of the trajectories alone, independent of records and journal: `simulation.motion_digest`."""
        return motion_digest(self.trace, self.stock_ids, TRACE_EVERY_STEPS)


def numbers_due(timetable: Timetable, due_s: float) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Numbers of the trains whose last call is due by then, s since midnight: with passengers, and empty."""
    trains = [train for train in timetable.trains.values() if train.calls[-1].first_s <= due_s]
    return tuple(t.number for t in trains if t.revenue), tuple(t.number for t in trains if not t.revenue)
