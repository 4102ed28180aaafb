"""Everything one run is made of, as read from a scenario; the loop takes nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.model import Line
from network.timetable import Timetable
from onboard.driving.tuning import Learned
from onboard.records import BEHAVIOUR
from onboard.unit import UnitParameters
from radio.air import AirParameters
from simulation.faults.script import Script
from simulation.world.scatter import Scatter
from vehicle.train_file import TrainType
from wayside.config import ReentryMode

STEPS_PER_S: Final = 10  # time is step / STEPS_PER_S: exact decimals in every journal
STEP_S: Final = 0.1


@dataclass(frozen=True, slots=True)
class Driving:
    """How units drive and supervise; `assumed`: neither the line nor the paper gives figures."""

    service_guaranteed_share: float = 0.8  # of the strongest service notch: worn pads, wet rail
    emergency_guaranteed_share: float = 0.8
    reaction_reserve_s: float = 0.5  # beyond dead time and lag of the brake
    service_margin_mps: float = 0.6
    release_margin_mps: float = 1.0
    emergency_margin_mps: float = 2.0
    driving_margin_mps: float = 1.2
    stop_deceleration_mps2: float = 0.6
    stop_gain_per_s: float = 0.8
    cruise_gain_per_s: float = 0.3
    notch_hold_s: float = 2.0
    standing_brake_share: float = 0.5


@dataclass(frozen=True, slots=True)
class Sensors:
    """Errors of the sensors, drawn per train or per reading from seeded sources."""

    wheel_factor_sigma: float = 0.003  # real over assumed wheel circumference
    tag_read_sigma_m: float = 0.05
    tag_read_max_m: float = 0.2  # beyond this the reader discards


@dataclass(frozen=True, slots=True)
class Tuning:
    """Self-tuning of TASC: whether trains learn, for how many days in a row, and what they know to begin with."""

    learn: bool = False
    days: int = 1  # the same day that often; the last one is reported
    learned: Mapping[str, Learned] = field(default_factory=dict)  # by stock id


@dataclass(frozen=True, slots=True)
class Vision:
    """Stop signs and the camera that looks for them; no station: the trains have none."""

    stations: frozenset[str] = frozenset()
    rate_hz: float = 5.0  # frames taken up; the camera itself has more, but errors of neighbours are alike


@dataclass(frozen=True, slots=True)
class Belief:
    """What units go by where it is not what is so: the line, and the trains of some stock."""

    line: Line
    trains: Mapping[str, TrainType] = field(default_factory=dict)  # by stock id


@dataclass(frozen=True, slots=True)
class Setup:
    """One run. `trains` gives the kind of train of each stock id."""

    name: str
    line: Line
    timetable: Timetable
    trains: Mapping[str, TrainType]
    seed: int = 1
    belief: Belief | None = None  # None: units believe what is so
    script: Script = field(default_factory=Script)
    air: AirParameters = field(default_factory=AirParameters)
    unit: UnitParameters = field(default_factory=UnitParameters)
    driving: Driving = field(default_factory=Driving)
    laws: Mapping[str, str] = field(
        default_factory=dict
    )  # driving law by stock id; the others hold their speed
    sensors: Sensors = field(default_factory=Sensors)
    scatter: Scatter = field(default_factory=Scatter)
    tuning: Tuning = field(default_factory=Tuning)
    vision: Vision = field(default_factory=Vision)
    day: int = 1  # what passes is drawn anew each day; what belongs to a train is not
    load_share_mean: float = 0.2
    load_share_spread: float = 0.15  # uniform, drawn per train number
    portal_lead_s: float = 210.0  # a train stands at the portal this long before its first departure
    change_ends_s: float = 60.0  # the driver walks to the other end
    reentry: ReentryMode = ReentryMode.ASSISTED  # how the block state comes back after the manager lost it
    time_limit_s: float = 3600.0  # the run ends this long after the last planned time, whatever happens
    stall_limit_s: float = 3600.0  # or when no train has moved for this long although one waits for a section

    @property
    def believed_line(self) -> Line:
        """The line as units believe it to be."""
        return self.line if self.belief is None else self.belief.line

    def believed_train(self, stock_id: str) -> TrainType:
        """A stock as its unit believes it to be."""
        own = {} if self.belief is None else self.belief.trains
        return own.get(stock_id, self.trains[stock_id])

    @property
    def today(self) -> tuple[str, ...]:
        """What sets the day's draws apart from those of the first day."""
        return () if self.day == 1 else (f"day {self.day}",)

    def next_day(self, learned: Mapping[str, Learned]) -> Setup:
        """The same timetable a day later, with what the trains have learned."""
        return replace(self, day=self.day + 1, tuning=replace(self.tuning, learned=learned))


def behaviour_rows(setup: Setup, stocks: tuple[str, ...]) -> NDArray[np.void]:
    """BEHAVIOUR records, one a stock id, from driving parameters and the brakes that units believe in; shape (n,)."""
    rows = np.zeros(len(stocks), dtype=BEHAVIOUR)
    driving = setup.driving
    for index, stock_id in enumerate(stocks):
        train = setup.believed_train(stock_id).row[0]
        row = rows[index]
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
        for name in (
            "service_margin_mps",
            "release_margin_mps",
            "emergency_margin_mps",
            "driving_margin_mps",
            "stop_deceleration_mps2",
            "stop_gain_per_s",
            "cruise_gain_per_s",
            "notch_hold_s",
        ):
            row[name] = getattr(driving, name)
    return rows
