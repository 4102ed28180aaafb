"""What the reproductions of Harada and others share: a train on the mountain line, and its error over the way.

One train passes all stations of the line of `mountain_line` and knows where it is by what it carries alone: wheels and
a yaw gyro against a map of curvature (section 3), or wheels and the beacons of the train stop (section 2). Check points
are the places of those beacons; the errors there are what the paper's figure 5 is of. A `Watch` looks every few metres
at what a unit that collates curvature shows, for figures 4 and 6.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from network.timetable import Timetable
from onboard import notes
from onboard.driving_settings import Driving
from onboard.localisation.curvature_map import CurvatureMap
from onboard.localisation.curvature_row import WINDOW_MAX
from onboard.localisation.table import READER_NAMES
from onboard.unit_records import UnitParameters
from papers.charts import BLUE, Band, ChartPage, Panel, Plottable, Plotted, Ruled, Shaded
from papers.mountain_line import ASSUMED, STOCK_ID, MountainLine
from papers.parameter_sets import LINE
from papers.position_run import (
    SLOT,
    CheckPoint,
    Moment,
    PositionResult,
    PositionRun,
    unprotected,
)
from papers.reproduction import CaseRow, Parameter
from simulation.sensor_settings import Beacons, Curvature
from simulation.settings import PositionSensor, Sensors
from simulation.setup import Setup
from simulation.world.trains import Trains
from study.report.style import RED
from vehicle.train_file import TrainType, load_train, shipped_train

TRAIN: Final = "br642"
CREEP_SHARE: Final = 0.003
TREAD_CONICITY: Final = 0.05
EVERY_M: Final = 10.0
Floats = NDArray[np.float64]
# Section 2.1: the way is what the wheels count, also while they slide or slip.
WHEELS: Final = LINE.unit.model_copy(update={"believes_wheels": True})


@dataclass(frozen=True, slots=True)
class PlannedTrip:
    """What is run: by what the train knows where it is, how fast it is driven, which day and which train of the kind.

    `unit_timetable`: the one that the unit goes by, where the train is sent another way. `wheels`: an interval of the
    way over what they count (`Ride.wheels` of another day).
    """

    place: MountainLine
    carries: tuple[PositionSensor, ...] = (PositionSensor.CURVATURE,)
    seed: int = 1
    day: int = 1
    slower_mps: float = 0.0
    curvature: Curvature = field(default_factory=Curvature)
    curvature_map: CurvatureMap | None = None  # None: that of the design
    beacons: Beacons = field(default_factory=Beacons)
    timetable: Timetable | None = None
    unit_timetable: Timetable | None = None
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

    def run(self, moments: Sequence[Moment] = ()) -> TripRun:
        """Run it from the first mark to the last; `moments` by kilometrage (m) of the front."""
        run = PositionRun(self.setup, unit_timetable=self.unit_timetable)
        if self.wheels is not None:
            own, unit = run.trains.readers[SLOT].curvature, run.trains.units[SLOT]
            own.scale_low, own.scale_high = self.wheels
            unit.odometer_scale = sum(self.wheels) / 2.0
            unit.bound_growth = (own.scale_high - own.scale_low) / 2.0 + own.varies_share
        base_m = run.true_m - run.duty.mission.path.kilometrage_m(run.true_m)
        run.at([replace(moment, at_m=moment.at_m + base_m) for moment in moments])
        return TripRun(self, run.run(), run, base_m)


@dataclass(frozen=True, slots=True)
class TripRun:
    """What came of a trip. `base_m`: path coordinate of kilometrage 0."""

    trip: PlannedTrip
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

    def notes_of(self, *types: type[notes.Note]) -> list[tuple[float, notes.Note]]:
        """Kilometrage (m) and note, of some types."""
        return [(at_m - self.base_m, note) for _, at_m, note in self.result.notes if isinstance(note, types)]

    def foreign_at_m(self, from_m: float, to_m: float) -> list[float]:
        """Where between two kilometrages the track was noted to be foreign (m)."""
        return [at_m for at_m, _ in self.notes_of(notes.ForeignTrack) if from_m <= at_m <= to_m]


def train(*, locks: bool = False) -> TrainType:
    """The diesel railcar of the experiments; with `locks` its slide protection is taken out: wheels may lock."""
    shipped = load_train(shipped_train(TRAIN))
    return unprotected(shipped) if locks else shipped


def worst_m(errors_m: Floats) -> float:
    """The greatest error either way, m."""
    return float(np.abs(errors_m).max())


def bounds_row(rides: Iterable[TripRun], criterion: str = "never, in any step") -> CaseRow:
    """Whether the truth was within what units state."""
    results = [ride.result for ride in rides]
    held = all(result.held for result in results)
    return CaseRow("truth out of the stated bounds", None, worst_out_m(results), held, criterion)


def worst_out_m(results: Iterable[PositionResult]) -> float:
    """By how much the truth was out in the worst of these runs, m; nan where any of them says nothing of it."""
    return round(float(np.max([result.out_m for result in results])), 3)


@dataclass(slots=True)
class Watch:
    """Looks at a train every `EVERY_M` while its front is between two kilometrages (m)."""

    from_m: float
    to_m: float
    threshold_per_m: float
    _seen: list[dict[str, float]] = field(default_factory=list[dict[str, float]])

    def moments(self) -> list[Moment]:
        """To be given to a run."""
        return [
            Moment(float(at_m), lambda trains, slot, at_m=at_m: self._look(trains, slot, float(at_m)))  # type: ignore[misc]
            for at_m in np.arange(self.from_m, self.to_m, EVERY_M)
        ]

    @property
    def rows(self) -> NDArray[np.void]:
        """A row a look, its fields those of `_look`."""
        return np.array(
            [tuple(each.values()) for each in self._seen], dtype=[(n, "f8") for n in self._seen[0]]
        )

    def moments_between(self, from_m: float, to_m: float) -> NDArray[np.void]:
        """Those of a stretch."""
        rows = self.rows
        return rows[(rows["true_m"] >= from_m) & (rows["true_m"] < to_m)]

    def worst_m(self, from_m: float, to_m: float) -> float:
        """Greatest error of a stretch, m."""
        return worst_m(self.moments_between(from_m, to_m)["error_m"])

    def within_from_m(self, from_m: float, within_m: float) -> float:
        """From where on behind `from_m` the estimate stays within so much of the truth (m); infinite: never."""
        rows = self.moments_between(from_m, self.to_m)
        off = np.flatnonzero(np.abs(rows["error_m"]) > within_m)
        if off.size == 0:
            return from_m
        return float(rows["true_m"][off[-1] + 1]) if off[-1] + 1 < rows.size else float("inf")

    def _look(self, trains: Trains, slot: int, at_m: float) -> None:
        unit, plant, truth = trains.units[slot], trains.plants[slot], trains.truths[slot]
        own: Any = trains.readers[slot].curvature
        row = min(max(round(float(unit.position_m)), 0), int(unit.path_rows) - 1) + int(unit.path_offset)
        self._seen.append(
            {
                "true_m": at_m,  # kilometrage
                "speed_mps": float(plant.speed_mps),
                "wheel_mps": float(unit.speed_mps),
                "map_per_m": float(
                    trains.pool.pattern["curvature_per_m"][row]
                ),  # where the unit believes to be
                "run_per_m": float(own.bent_per_m[(int(own.at) - 1) % WINDOW_MAX]),
                "mismatch_per_m": float(own.mismatch_per_m),
                "outcome": int(trains.readers[slot].outcome[READER_NAMES.index("curvature")]),
                "error_m": float(unit.position_m - truth.position_m),
                "behind_m": float(unit.bound_behind_m),
                "ahead_m": float(unit.bound_ahead_m),
                "slid_m": float(plant.travelled_m - plant.wheel_travelled_m),  # since the run began
            }
        )

    def chart(self, name: str, title: str, *marks: tuple[float, float, str]) -> ChartPage:
        """Figures 4 and 6: speeds, curvature of map and run, mismatch, error; `marks` are stretches (m) with words."""
        rows = self.rows
        km, error_m = rows["true_m"] / 1000.0, rows["error_m"]
        panels: dict[str, list[Plottable]] = {
            "speed, km/h": [
                Plotted(km, rows["wheel_mps"] * 3.6, "shown by the wheels", RED),
                Plotted(km, rows["speed_mps"] * 3.6, "the train's"),
            ],
            "curvature, 1/km": [
                Plotted(
                    km, rows["map_per_m"] * 1e3, "map, where the unit believes to be", "#d98b2b", width=1.0
                ),
                Plotted(km, rows["run_per_m"] * 1e3, "run", BLUE),
            ],
            "1/km": [
                Plotted(km, rows["mismatch_per_m"] * 1e3, "mismatch (root of the mean square)", BLUE),
                Ruled(y=[self.threshold_per_m * 1e3], label="threshold", colour=RED),
            ],
            "m": [
                Band(km, error_m - rows["behind_m"], error_m + rows["ahead_m"], "bounds"),
                Plotted(km, error_m, "estimate less truth"),
                Ruled(y=[0.0], style="-", width=0.6),
            ],
        }
        last = list(panels)[-1]
        shown = [
            Panel(
                "kilometrage, km" if y == last else "",
                y,
                [*lines, *(Shaded(a / 1e3, b / 1e3, words if i == 0 else "") for a, b, words in marks)],
            )
            for i, (y, lines) in enumerate(panels.items())
        ]
        return ChartPage(name, (9.0, 9.0), [[panel] for panel in shown], title)


# what a turn of the wheels is worth (units do not read it, but have an allowance), the line, and the driving
SHARED: Final = (
    *ASSUMED,
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
