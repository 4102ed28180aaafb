"""What the reproductions of Harada and others share: a train on the mountain line, and its error over the way.

One train passes all stations of the line of `mountain_line` and knows where it is by what it carries alone: wheels and
a yaw gyro against a map of curvature (section 3), or wheels and the beacons of the train stop (section 2). Check points
are the places of those beacons; the errors there are what the paper's figure 5 is of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.timetable import Timetable
from onboard import notes
from onboard.localisation.curvature_map import CurvatureMap
from onboard.unit_records import UnitParameters
from simulation.sensor_settings import Beacons, Curvature
from simulation.settings import Carried, Driving, Sensors
from simulation.setup import Setup
from study.papers.mountain_line import STOCK_ID, MountainLine
from study.papers.parameter_sets import LINE
from study.papers.position_run import SLOT, CheckPoint, Moment, PositionResult, PositionRun
from study.papers.reproduction import Parameter
from vehicle.train_file import TrainType, load_train, shipped_train

TRAIN: Final = "br642"
CREEP_SHARE: Final = 0.003
TREAD_CONICITY: Final = 0.05
Floats = NDArray[np.float64]
# Section 2.1: the way is what the wheels count, also while they slide or slip.
WHEELS: Final = LINE.unit.model_copy(update={"believes_wheels": True})


@dataclass(frozen=True, slots=True)
class Trip:
    """What is run: by what the train knows where it is, how fast it is driven, which day and which train of the kind.

    `told`: the timetable that the unit goes by, where the train is sent another way. `wheels`: an interval of the way
    over what they count (`Ride.wheels` of another day).
    """

    place: MountainLine
    carries: tuple[Carried, ...] = (Carried.CURVATURE,)
    seed: int = 1
    day: int = 1
    slower_mps: float = 0.0
    curvature: Curvature = field(default_factory=Curvature)
    curvature_map: CurvatureMap | None = None  # None: that of the design
    beacons: Beacons = field(default_factory=Beacons)
    timetable: Timetable | None = None
    told: Timetable | None = None
    unit: UnitParameters = WHEELS
    locks: bool = False  # the train has no slide protection
    creep_share: float = CREEP_SHARE
    tread_conicity: float = TREAD_CONICITY
    wheels: tuple[float, float] | None = (
        None  # what they are worth, as learned before; None: as stated of any
    )

    @property
    def setup(self) -> Setup:
        """As the kernel and the unit take it."""
        driving = LINE.driving.driving_margin_mps + self.slower_mps
        return Setup(
            name="harada",
            line=self.place.line,
            timetable=self.timetable or self.place.timetable(),
            trains={STOCK_ID: train(locks=self.locks)},
            seed=self.seed,
            day=self.day,
            unit=self.unit,
            driving=Driving(driving_margin_mps=driving),
            sensors=Sensors(
                carries=self.carries, creep_share=self.creep_share, tread_conicity=self.tread_conicity
            ),
            curvature=self.curvature,
            curvature_map=self.curvature_map,
            beacons=self.beacons,
        )

    def run(self, moments: Sequence[Moment] = ()) -> Ride:
        """Run it from the first mark to the last; `moments` by kilometrage (m) of the front."""
        run = PositionRun(self.setup, told=self.told)
        if self.wheels is not None:
            own, unit = run.trains.readers[SLOT].curvature, run.trains.units[SLOT]
            own.scale_low, own.scale_high = self.wheels
            unit.odometer_scale = sum(self.wheels) / 2.0
            unit.bound_growth = (own.scale_high - own.scale_low) / 2.0 + own.varies_share
        base_m = run.true_m - run.duty.mission.path.kilometrage_m(run.true_m)
        run.at([replace(moment, at_m=moment.at_m + base_m) for moment in moments])
        return Ride(self, run.run(), run, base_m)


@dataclass(frozen=True, slots=True)
class Ride:
    """What came of a trip. `base_m`: path coordinate of kilometrage 0."""

    trip: Trip
    result: PositionResult
    run: PositionRun
    base_m: float

    @property
    def check_points(self) -> list[CheckPoint]:
        """Those passed."""
        return self.result.check_points

    @property
    def errors_m(self) -> Floats:
        """Estimate less truth at each check point, m."""
        return np.array([point.error_m for point in self.result.check_points])

    @property
    def wheels(self) -> tuple[float, float]:
        """What the unit has learned of its wheels: way over what they count, at least and at most."""
        own = self.run.trains.readers[SLOT].curvature
        return float(own.scale_low), float(own.scale_high)

    @property
    def kilometrage_m(self) -> Floats:
        """Of the front, each second, m."""
        return np.asarray(self.result.trace["position_m"] - self.base_m, dtype=np.float64)

    def noted(self, *types: type[notes.Note]) -> list[tuple[float, notes.Note]]:
        """Kilometrage (m) and note, of some types."""
        return [(at_m - self.base_m, note) for _, at_m, note in self.result.notes if isinstance(note, types)]


def train(*, locks: bool = False) -> TrainType:
    """The diesel railcar of the experiments; with `locks` its slide protection is taken out: wheels may lock."""
    shipped = load_train(shipped_train(TRAIN))
    if not locks:
        return shipped
    row = shipped.row.copy()
    row["wheel_slide_share_max"] = 1.0
    return replace(shipped, row=row)


def worst_m(errors_m: Floats) -> float:
    """The greatest error either way, m."""
    return float(np.abs(errors_m).max())


def turning() -> tuple[Parameter, ...]:
    """What a turn of the wheels is worth, as the experiments print it: units do not read it, but have an allowance."""
    return (
        Parameter(
            "creep of wheels, at full adhesion",
            CREEP_SHARE,
            "share",
            "2.1 names it; assumed: Kalker's linear theory has 0.001 at an adhesion of 0.25, with the bend thrice that",
        ),
        Parameter(
            "slope of the treads",
            TREAD_CONICITY,
            "",
            "2.1 names it; assumed: a new cone of 1 in 20, leading axle",
        ),
        Parameter(
            "what units allow for both",
            round(WHEELS.wheel_varies_share, 4),
            "share",
            "unit.wheel_error_share less unit.wheel_scale_limit",
        ),
    )
