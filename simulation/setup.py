"""Everything one run is made of, as read from a scenario; the loop takes nothing else."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from host.unit import UnitConfig
from network.files.crossing_road import CrossingRoad
from network.model import Line
from network.timetable import Timetable
from onboard.driving.tuning import Learned
from onboard.driving_settings import Driving
from onboard.duty_parameters import ReleaseRule
from onboard.localisation.curvature_map import CurvatureMap
from onboard.records import BEHAVIOUR
from radio import air as radio_air
from radio.keys import KeyRing, key_ring
from simulation.faults.script import Script
from simulation.settings import Limits, Load, Tables
from vehicle.record import put_settings
from vehicle.train_file import TrainType
from wayside.config import MANAGER_ID

STEPS_PER_S: Final = radio_air.STEPS_PER_S  # time is step / STEPS_PER_S: exact decimals in every journal
STEP_S: Final = radio_air.STEP_S


def step_not_before(t_s: float) -> int:
    """The first step at or after a time, s since midnight; a time that is a step's but for rounding is that step."""
    return math.ceil(t_s / STEP_S - 1e-6)


@dataclass(frozen=True, slots=True)
class Belief:
    """What units go by where it is not what is so: the line, and the trains of some stock."""

    line: Line
    trains: Mapping[str, TrainType] = field(default_factory=dict[str, TrainType])  # by stock id


@dataclass(frozen=True, slots=True)
class Setup(Tables):
    """One run: the scenario's tables and what they are of. `trains` gives the kind of train of each stock id."""

    name: str
    line: Line
    timetable: Timetable
    trains: Mapping[str, TrainType]
    seed: int = 1
    belief: Belief | None = None  # None: units believe what is so
    script: Script = field(default_factory=Script)
    # Driving law by stock id; the others hold their speed.
    laws: Mapping[str, str] = field(default_factory=dict[str, str])
    curvature_map: CurvatureMap | None = None  # None: the one that the believed line makes
    # What trains know of their brakes to begin with, by stock id.
    learned: Mapping[str, Learned] = field(default_factory=dict[str, Learned])
    day: int = 1  # what passes is drawn anew each day; what belongs to a train is not
    load: Load = field(default_factory=Load)
    # By crossing, those that something drives over.
    roads: Mapping[str, CrossingRoad] = field(default_factory=dict[str, CrossingRoad])
    until_s: float = math.inf  # only the part of the day before it is run

    @property
    def turn_s(self) -> float:
        """From a train's arrival until its set's next one begins, s: the driver's walk, or crews' least turn."""
        return max(self.operation.change_ends_s, self.timetable.head.turn_min_s)

    @property
    def believed_line(self) -> Line:
        """The line as units believe it to be."""
        return self.line if self.belief is None else self.belief.line

    def believed_train(self, stock_id: str) -> TrainType:
        """A stock as its unit believes it to be."""
        so = self.trains[stock_id]
        return so if self.belief is None else self.belief.trains.get(stock_id, so)

    @property
    def networks(self) -> tuple[str, ...]:
        """The radio networks that trains have a radio of, by name."""
        return radio_air.NETWORKS[: 1 if self.second_air is None else 2]

    @property
    def radio_on_average(self) -> radio_air.OnAverage:
        """A telegram's way and loss where all networks reach."""
        return radio_air.on_average(self.air, self.second_air)

    @property
    def grants_parts(self) -> bool:
        """Whether a train that follows is let onto the part of its way that is free, as all can still finish."""
        return self.operation.release is ReleaseRule.SECTION and self.dispatch.certificate

    @property
    def lengths_m(self) -> dict[str, float]:
        """Length of each stock, m, by its id."""
        return {stock_id: float(kind.row[0]["length_m"]) for stock_id, kind in self.trains.items()}

    @property
    def latest_end_s(self) -> float:
        """When the run ends whatever happens, s: no train comes after that."""
        return min(latest_end_s(self.timetable, self.limits), self.until_s)

    @property
    def today(self) -> tuple[str, ...]:
        """What sets the day's draws apart from those of the first day."""
        return () if self.day == 1 else (f"day {self.day}",)

    def steps_of(self, time_s: float) -> int:
        """The number of steps nearest to a time, at least one."""
        return max(1, round(time_s * STEPS_PER_S))

    def next_day(self, learned: Mapping[str, Learned]) -> Setup:
        """The same timetable a day later, with what the trains have learned."""
        return replace(self, day=self.day + 1, learned=learned)


def latest_end_s(timetable: Timetable, limits: Limits = Limits()) -> float:  # noqa: B008 - it is frozen
    """The last planned time of all trains, and how long the run may last beyond, s; as late counts what never comes."""
    ends_s = (call.last_s for train in timetable.trains.values() for call in train.calls)
    return max(ends_s, default=0) + limits.time_limit_s


def behaviour_row(driving: Driving, train: np.void) -> NDArray[np.void]:
    """A BEHAVIOUR record from driving parameters and the brakes that the unit believes in; shape ()."""
    row = np.zeros((), dtype=BEHAVIOUR)
    strongest = float(train["brake_deceleration_mps2"][int(train["brake_notches"])])
    row["service_guaranteed_mps2"] = driving.service_guaranteed_share * strongest
    row["service_reaction_s"] = (
        float(train["brake_dead_time_s"] + train["brake_lag_s"]) + driving.reaction_reserve_s
    )
    row["emergency_guaranteed_mps2"] = driving.emergency_guaranteed_share * float(
        train["emergency_deceleration_mps2"]
    )
    row["emergency_reaction_s"] = (
        float(train["emergency_dead_time_s"] + train["emergency_lag_s"]) + driving.reaction_reserve_s
    )
    row["standing_brake_notch"] = driving.standing_brake_share * float(train["brake_notches"])
    row["step_s"] = STEP_S
    own: Any = row.view(np.recarray)[()]
    put_settings(own.settings, driving)
    return row


def behaviour_rows(setup: Setup, stocks: tuple[str, ...]) -> NDArray[np.void]:
    """BEHAVIOUR records, one a stock id; shape (n,)."""
    rows = np.zeros(len(stocks), dtype=BEHAVIOUR)
    for index, stock_id in enumerate(stocks):
        rows[index] = behaviour_row(setup.driving, setup.believed_train(stock_id).row[0])
    return rows


def unit_configs(setup: Setup, master_key: bytes) -> tuple[tuple[UnitConfig, KeyRing], ...]:
    """What every on-board unit of the run knows when it is switched on, with the keys of its own pairs."""
    terminals = sorted({points.terminal_id for points in setup.line.points.values()})
    crossings = [crossing.id for crossing in setup.line.crossings.values() if crossing.tells_units]
    duty = msgspec.structs.replace(setup.unit.duty, release=setup.operation.release)
    return tuple(
        (
            UnitConfig(setup.line.id, diagram.stock_id, MANAGER_ID, duty),
            key_ring(master_key, diagram.stock_id, (MANAGER_ID, *terminals, *crossings)),
        )
        for diagram in setup.timetable.diagrams
    )
