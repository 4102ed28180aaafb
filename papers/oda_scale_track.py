"""Oda's 1/10 test track (section 3.3): stops at the mark with the rendered camera in the loop, every 100 ms.

The car is a train like any other, in metres on the track: the kernel moves it and ticks its unit, the plain carrier
carries it. Beyond that there is the camera, whose sightings become fixes (`onboard.localisation.vision`), a tag where
the stop begins, and the radio that now and then loses a command. The paper's limit of 0.1 m and its 3 sigma of
0.033 m hold on the tenth scale and stand for 1 m and 0.33 m on a real line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from network.model import Direction
from onboard.localisation.fix import TakenFix, take
from onboard.localisation.tags import tag_fix
from onboard.localisation.vision import (
    SightTable,
    StationSign,
    TargetSighting,
    next_target,
    position_fix,
    search_window,
    sight,
)
from papers.carried_train import CarriedTrain
from papers.parameter_sets import CUMULATIVE_ERROR, TENTH_SCALE
from papers.reproduction import CaseRow, NullMethod, Options, Parameter
from papers.single_run import Rows, new_stops
from papers.single_train import Bench
from papers.specification import Findings, Specification, at_most, none_of
from radio.chance import generator
from simulation.sensors.camera import (
    PAPER_CAMERA,
    PAPER_SIGN,
    PAPER_TABLE_M,
    SIGN_QUARTER,
    Renderer,
    Scene,
    Shot,
    lamplight,
)
from simulation.sensors.sighting_model import record_table
from simulation.setup import STEP_S
from vehicle.train_file import load_train, shipped_train

STEPS_MAX: Final = 300
STOPS_PAPER: Final = 10
STOPS_MANY: Final = 1000
STOPS_QUICK: Final = 50
LIMIT_M: Final = 0.1  # Oda, 3.3.2
THREE_SIGMA_M: Final = 0.033  # Oda, 3.3.4
OF_THE_PAPER: Final = f"{STOPS_PAPER} stops"
THREE_SIGMA: Final = "{}: 3 sigma, m on the track"


@dataclass(frozen=True, slots=True)
class TrackTest:
    """What the paper gives of the test, and what it leaves out; metres and m/s on the track."""

    initial_mps: float = 4.0 / 3.6
    mark_after_m: float = 4.0
    sign_beyond_m: float = 0.5
    tag_accuracy_m: float = TENTH_SCALE.unit.tag_accuracy_m
    wheel_error_max: float = CUMULATIVE_ERROR
    brake_spread: float = 0.02
    lost_command_share: float = 0.02
    processing_s: float = 0.02
    origin_kilometrage_m: float = 1000.0
    sees: bool = True


@dataclass(frozen=True, slots=True)
class ScaleTrackStop:
    """One stop: `error_m` > 0 past the mark, as the paper's text counts (track metres)."""

    direction: Direction
    error_m: float
    first_sight_m: float  # true distance to the mark at the first fix; nan: never
    sightings: int
    misses: int  # frames searched in vain after the first sighting
    out_of_bounds: int  # steps in which the true front lay outside the unit's bounds


def car_bench(test: TrackTest) -> Bench:
    """The car; its unit holds the speed until the stop at the mark takes over, and believes all wheels to be alike."""
    unit = TENTH_SCALE.unit.model_copy(update={"tag_accuracy_m": test.tag_accuracy_m})
    return Bench(load_train(shipped_train("oda_scale_car")), TENTH_SCALE.driving, unit)


def stop_of(test: TrackTest, rng: np.random.Generator) -> Rows:
    """One stop: what the brake, the wheel and the tag (RFID) that begins it are like; shape (1,)."""
    stop = new_stops(1)
    stop["speed_mps"] = stop["cruise_mps"] = test.initial_mps
    stop["start_m"] = test.mark_after_m
    stop["brake_factor"] = rng.normal(1.0, test.brake_spread)
    wheel = 1.0 + rng.uniform(-test.wheel_error_max, test.wheel_error_max)
    stop["wheel_error"] = 1.0 / wheel - 1.0
    stop["fix_error_m"] = rng.uniform(-test.tag_accuracy_m, test.tag_accuracy_m)
    return stop


class MotionHistory:
    """What was at the steps so far, and between them: acceleration holds through a step (see `vehicle.dynamics`)."""

    def __init__(self, train: CarriedTrain) -> None:
        self._rows: list[tuple[float, float, float]] = []
        self.keep(train)

    def keep(self, train: CarriedTrain) -> None:
        """Take one more step down."""
        row = train.row
        self._rows.append(
            (
                float(row.plant.travelled_m),
                float(row.plant.speed_mps),
                float(row.sensors.tachometer.odometer_m),
            )
        )

    def _around(self, time_s: float) -> tuple[tuple[float, float, float], tuple[float, float, float], float]:
        before = min(int(time_s / STEP_S), len(self._rows) - 1)
        after = min(before + 1, len(self._rows) - 1)
        return self._rows[before], self._rows[after], time_s / STEP_S - before

    def travelled_m(self, time_s: float) -> float:
        """True distance run."""
        before, after, share = self._around(time_s)
        middle_mps = before[1] + share * (after[1] - before[1]) / 2.0
        return before[0] + middle_mps * share * STEP_S

    def speed_mps(self, time_s: float) -> float:
        """True speed."""
        before, after, share = self._around(time_s)
        return before[1] + share * (after[1] - before[1])

    def odometer_m(self, time_s: float) -> float:
        """What the unit takes its tachometer to have read, by proportion between two readings."""
        before, after, share = self._around(time_s)
        return before[2] + share * (after[2] - before[2])


class _Look(NamedTuple):
    """A frame in which the sign was searched: when it began (s), and what was seen."""

    frame_s: float
    sighting: TargetSighting | None


class _Run:
    """One stop in progress: the car, its camera, and the station database it looks its sign up in."""

    def __init__(self, test: TrackTest, renderer: Renderer, table: SightTable, seed: int, index: int) -> None:
        self.test, self.renderer, self.table = test, renderer, table
        self.rng = generator(seed, "oda-scale-track", "stop", str(index))
        self.direction = Direction.DOWN if index % 2 == 0 else Direction.UP
        stop_m = test.origin_kilometrage_m + self.direction * test.mark_after_m
        beyond = self.direction * test.sign_beyond_m
        signs = [
            StationSign("platform", "1", self.direction, stop_m + beyond, stop_m),
            StationSign("behind", "1", self.direction, stop_m - 9.0 * beyond, stop_m - 10.0 * beyond),
            StationSign("other way", "1", self.direction.opposite, stop_m - 3.0 * beyond, stop_m),
        ]
        sign = next_target(signs, test.origin_kilometrage_m, self.direction)
        assert sign is not None
        self.sign = sign
        self.train = CarriedTrain(car_bench(test), stop_of(test, self.rng))
        self.lighting = lamplight(self.rng)
        self.frame_phase_s = float(self.rng.uniform(0.0, 1.0 / renderer.camera.frame_rate_hz))
        self.history = MotionHistory(self.train)

    def path_m(self, kilometrage_m: float) -> float:
        """Path coordinate of a kilometrage, m."""
        return self.train.begin_m + self.direction * (kilometrage_m - self.test.origin_kilometrage_m)

    def look(self, now_s: float) -> _Look | None:
        """Search the newest finished frame where the sign should be; None while there is nothing to search."""
        camera, unit, test = self.renderer.camera, self.train.row.board.unit, self.test
        ready_s = now_s - camera.readout_s - camera.exposure_s - test.processing_s - self.frame_phase_s
        if ready_s < 0.0:
            return None
        frame_s = self.frame_phase_s + math.floor(ready_s * camera.frame_rate_hz) / camera.frame_rate_hz
        estimate_m = float(unit.position_m) - (float(unit.odometer_m) - self.history.odometer_m(frame_s))
        believed_m = self.path_m(self.sign.position_m) - estimate_m
        bound_m = max(float(unit.bound_ahead_m), float(unit.bound_behind_m))
        window = search_window(self.table, believed_m, bound_m, camera.axis_px, camera.size_px)
        if window is None:
            return None
        speed_mps = self.history.speed_mps(frame_s)
        pitch = float(self.rng.normal(0.0, camera.vibration_rad)) if speed_mps > 0.0 else 0.0
        scene = Scene(PAPER_SIGN, test.mark_after_m + test.sign_beyond_m, lighting=self.lighting)
        shot = Shot(self.history.travelled_m(frame_s), speed_mps, pitch)
        image = self.renderer.render(scene, shot, self.rng, window)
        return _Look(frame_s, sight(image, self.table, camera.axis_px, window.left, window.top))

    def take(self, look: _Look) -> bool:
        """Fix the unit's position by a sighting, if there is one and the train can be where it says."""
        if look.sighting is None:
            return False
        unit, camera = self.train.row.board.unit, self.renderer.camera
        found = position_fix(
            look.sighting, self.sign, self.table, float(unit.train_mps), camera.frame_rate_hz
        )
        odometer_m = self.history.odometer_m(look.frame_s)
        fix = tag_fix(unit, self.path_m(found.kilometrage_m), odometer_m, found.accuracy_m)
        return isinstance(take(unit, fix), TakenFix)

    def step(self) -> None:
        """One control cycle; where the radio loses its command, the car keeps the one before."""
        self.train.step()
        self.history.keep(self.train)
        plant = self.train.row.plant
        if self.rng.random() < self.test.lost_command_share:
            plant.command_notch[plant.command_head] = plant.command_notch[plant.command_head - 1]

    def stop(self) -> ScaleTrackStop:
        """Run until the car stands."""
        unit = self.train.row.board.unit
        first_m, sightings, misses, outside = math.nan, 0, 0, 0
        while not self.train.stands and self.train.steps < STEPS_MAX:
            self.step()
            look = self.look(self.train.steps * STEP_S) if self.test.sees else None
            if look is not None and self.take(look):
                sightings += 1
                if math.isnan(first_m):
                    first_m = -self.train.past_mark_m
            elif look is not None and sightings > 0:
                misses += 1
            error_m = float(self.train.row.truth.position_m) - float(unit.position_m)
            outside += not -float(unit.bound_behind_m) <= error_m <= float(unit.bound_ahead_m)
        return ScaleTrackStop(self.direction, self.train.past_mark_m, first_m, sightings, misses, outside)


def run_stops(
    renderer: Renderer, table: SightTable, seed: int, count: int, test: TrackTest | None = None
) -> tuple[ScaleTrackStop, ...]:
    """`count` stops, even ones in increasing and odd ones in decreasing kilometrage; each draws from its own source."""
    return tuple(_Run(test or TrackTest(), renderer, table, seed, index).stop() for index in range(count))


def _parameters(test: TrackTest) -> tuple[Parameter, ...]:
    """What the test is made of, with origins."""
    camera = PAPER_CAMERA
    return (
        Parameter("speed where the control starts", 4.0, "km/h", "3.3.2"),
        Parameter("control cycle", STEP_S, "s", "3.3.2"),
        Parameter("sign beyond the mark", test.sign_beyond_m, "m", "3.3.2"),
        Parameter("sign diameter", PAPER_SIGN.diameter_m, "m", "3.3.2"),
        Parameter("image", f"{camera.width_px}x{camera.height_px}", "px", "3.3.2"),
        Parameter("focal length", camera.focal_length_m, "m", "3.2.2"),
        Parameter("frame rate", camera.frame_rate_hz, "1/s", "3.2.2"),
        Parameter(
            "table", "each 0.1 m to 2.8 m before the mark", "", "3.3.3; 4 images a place as in table 2"
        ),
        Parameter("wheel diameter error", test.wheel_error_max, "share, uniform", "3.2.1: +-1 %"),
        Parameter(
            "pattern and gain, where from",
            "assumed",
            "",
            "from 4 km/h within 2.8 m; 0.3 over the reaction time",
        ),
        Parameter(
            "start before the mark", test.mark_after_m, "m", "assumed: braking begins at about 2.8 m of it"
        ),
        Parameter("place known at the start", test.tag_accuracy_m, "m, uniform", "assumed: RFID reader"),
        Parameter("spread of the brake", test.brake_spread, "share, sigma", "assumed: the paper gives none"),
        Parameter(
            "lost commands", test.lost_command_share, "share", "assumed: Wi-Fi; the car keeps the last one"
        ),
        Parameter("image processing", test.processing_s, "s", "assumed: one frame"),
        Parameter("car", "vehicle/trains/oda_scale_car.toml", "", "3.3.2 and the file's provenance"),
    )


def _rows(stops: tuple[ScaleTrackStop, ...], sample: str) -> list[CaseRow]:
    """The paper's three figures for one sample of stops."""
    errors = np.array([stop.error_m for stop in stops])
    within = int(np.sum(np.abs(errors) <= LIMIT_M))
    mean_m, worst_m = float(errors.mean()), float(np.abs(errors).max())
    all_within = within == len(stops)
    return [
        CaseRow(
            f"{sample}: within 0.1 m (1 m full size)",
            "10 of 10",
            f"{within} of {len(stops)}",
            all_within,
            "all",
        ),
        CaseRow(
            f"{sample}: mean, m on the track",
            -0.001,
            round(mean_m, 4),
            abs(mean_m) <= THREE_SIGMA_M,
            "within 0.033 of 0",
        ),
        at_most(THREE_SIGMA.format(sample), THREE_SIGMA_M, 3.0 * float(errors.std(ddof=1)), THREE_SIGMA_M),
        at_most(f"{sample}: farthest from the mark, m", "within 0.1", worst_m, LIMIT_M),
    ]


def stops_of(seed: int, count: int, test: TrackTest) -> tuple[ScaleTrackStop, ...]:
    """Stops of the paper's camera, by the table that it records."""
    renderer = Renderer(PAPER_CAMERA, seed)
    table = record_table(renderer, PAPER_SIGN, PAPER_TABLE_M, seed, window=SIGN_QUARTER)
    return run_stops(renderer, table, seed, count, test)


def experiment(options: Options) -> Findings:
    """10 stops as in the paper, and 1,000."""
    many = STOPS_QUICK if options.quick else STOPS_MANY
    stops = stops_of(options.seed, many, TrackTest())
    rows = _rows(stops[:STOPS_PAPER], OF_THE_PAPER) + _rows(stops, f"{many} stops")
    for direction, name in ((Direction.DOWN, "increasing"), (Direction.UP, "decreasing")):
        worst_m = max(abs(stop.error_m) for stop in stops if stop.direction is direction)
        rows.append(at_most(f"{name} kilometrage: farthest from the mark, m", None, worst_m, LIMIT_M))
    outside = sum(stop.out_of_bounds for stop in stops)
    rows.append(none_of("steps with the true front outside the stated bounds", outside))
    rows.append(none_of("stops without one sighting", sum(stop.sightings == 0 for stop in stops)))
    first = float(np.nanmedian([stop.first_sight_m for stop in stops]))
    frames = sum(stop.sightings + stop.misses for stop in stops)
    missed = sum(stop.misses for stop in stops)
    remarks = [
        "The car runs through the kernel and the tick of a line run, with its law for between stations and its one "
        "stop law. A loop of its own with a second stop law gave a 3 sigma of 0.014 m in 50 stops where this gives "
        "0.021. About half of that comes from the line's least correction of 0.05 m, half of this track's tolerance: "
        "with 0.005 m it would be 0.017. The rest has not been taken apart.",
        "Metres on the track: multiply by 10 for the real line (0.1 m stands for 1 m, 0.033 m for 0.33 m).",
        f"First sighting {first:.2f} m before the mark (median); {missed} of {frames} images after it gave none.",
        "The pattern's deceleration is not to scale (it would be 2.5 m/s2 full size): it is what stops from the "
        "paper's 4 km/h inside the 2.8 m of its table.",
    ]
    return Findings(rows, _parameters(TrackTest()), remarks)


reproduce: Final = Specification(
    "oda-scale-track",
    "Oda 2019, section 3.3: stopping at the mark by camera on the 1/10 track",
    experiment,
    NullMethod(
        "no camera",
        (THREE_SIGMA.format(OF_THE_PAPER),),
        lambda options: _rows(stops_of(options.seed, STOPS_PAPER, TrackTest(sees=False)), OF_THE_PAPER),
    ),
    TENTH_SCALE,
    f"Quick: {STOPS_QUICK} stops instead of {STOPS_MANY}.",
)
