"""The run of `position-compare`: sensor sets, what the line has for them, and what fails where.

The run is the Karasuyama line's from Karasuyama to Hoshakuji, 21 km with eight stops. The line has no beacons of a
train stop, no markers, no tunnel and no stretch with a hidden sky in its file: they are laid here by rule and named as
assumed. A fault is one of `simulation.faults.table`, in force between two places; what was moved or added on the track
is so on the line and not in what the unit knows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from network.model import Beacon, Cover, Line, MarkerGroup
from network.path import Path
from onboard.localisation.marker_patterns import PATTERNS
from papers.position_run import Moment, PositionResult, PositionRun
from scenario.scenario import load_scenario
from simulation.faults.fault import InForce
from simulation.faults.table import FAULTS
from simulation.gnss_settings import Correction, Gnss
from simulation.settings import PositionSensor
from simulation.setup import Belief, Setup
from simulation.world.disorder import fault_onset, put_fault
from simulation.world.roster import drawn_up
from simulation.world.trains import Trains

SCENARIO: Final = "karasuyama_weekday"
TUNNEL_M: Final = (9_700.0, 10_300.0)  # assumed, as are the next four: the line has neither
HIDDEN_M: Final = ((3_200.0, 4_200.0), (13_200.0, 14_000.0), (17_400.0, 18_600.0))
BEACONS_EVERY_M: Final = 600.0
MARKERS_EVERY_M: Final = 1_000.0
MOVED_M: Final = 20.0
GNSS: Final = Gnss()  # a scenario without that table


@dataclass(frozen=True, slots=True)
class SensorSet:
    """What a train carries beside its wheels, and which satellite receiver."""

    name: str
    carries: tuple[PositionSensor, ...]
    correction: Correction = Correction.FAIL_SAFE


SETS: Final = (
    SensorSet("tags", (PositionSensor.TAGS,)),
    SensorSet("beacons", (PositionSensor.BEACONS,)),
    SensorSet("curvature", (PositionSensor.CURVATURE,)),
    SensorSet("GNSS, 20 m", (PositionSensor.GNSS,)),
    SensorSet("GNSS, 3 m", (PositionSensor.GNSS,), Correction.AIM),
    SensorSet("LiDAR", (PositionSensor.LIDAR,)),
    SensorSet("all", tuple(PositionSensor)),
)


@dataclass(frozen=True, slots=True)
class Trouble:
    """Something that fails between two places of the way (m), and who is concerned: None, the wheels of every train.

    `kind` is a fault of the table, aimed at the train or at `target`; without one it lies on the track: a tag or a
    beacon that was moved, a beacon that was added, markers that are gone. `held`: inside what the sensors' files say
    may fail, so that the bounds must hold.
    """

    name: str
    concerns: PositionSensor | None
    from_m: float
    to_m: float
    kind: str = ""
    keys: Mapping[str, Any] = field(default_factory=dict[str, Any])
    target: str = ""
    held: bool = True


TROUBLES: Final = (
    Trouble("slip", None, 2_980.0, 3_300.0, "slippery", {"factor": 0.25}),
    Trouble("slide", None, 4_900.0, 5_230.0, "slippery", {"factor": 0.1}),
    Trouble("tag missed", PositionSensor.TAGS, 11_700.0, 11_950.0, "miss", target="406"),
    Trouble("wrong tag", PositionSensor.TAGS, 14_100.0, 14_400.0, "wrong_id", {"id": 305}, target="306"),
    Trouble("tag moved", PositionSensor.TAGS, 16_200.0, 16_400.0),
    Trouble("beacon missed", PositionSensor.BEACONS, 6_500.0, 6_700.0, "no_beacon"),
    Trouble("beacon added", PositionSensor.BEACONS, 8_995.0, 8_996.0, "false_beacon"),
    Trouble("beacon moved", PositionSensor.BEACONS, 15_500.0, 15_700.0),
    Trouble("gyro dead", PositionSensor.CURVATURE, 6_000.0, 7_200.0, "gyro_dead"),
    Trouble("gyro bias", PositionSensor.CURVATURE, 18_800.0, 20_000.0, "gyro_bias", {"jump_degps": 0.5}),
    Trouble("jammed", PositionSensor.GNSS, 5_400.0, 6_600.0, "gnss_jammed"),
    Trouble("reflections", PositionSensor.GNSS, 8_000.0, 9_200.0, "gnss_reflections", {"bias_m": 30.0}),
    Trouble("jump", PositionSensor.GNSS, 11_000.0, 11_900.0, "gnss_jump", {"bias_m": -60.0}),
    Trouble("time tag", PositionSensor.GNSS, 15_000.0, 16_200.0, "gnss_time_tag", {"late_s": 1.0}),
    Trouble("LiDAR blind", PositionSensor.LIDAR, 6_900.0, 9_200.0, "lidar_blind"),
    Trouble("markers gone", PositionSensor.LIDAR, 12_900.0, 13_100.0),
    Trouble(
        "reflections that creep up",
        PositionSensor.GNSS,
        5_400.0,
        9_000.0,
        "gnss_reflections",
        {"bias_m": 40.0, "over_m": 3_000.0},
        held=False,
    ),
)


@dataclass(frozen=True, slots=True)
class SensorSetRun:
    """One run: the set, what failed in it, and what came of it."""

    carried: SensorSet
    troubles: tuple[Trouble, ...]
    result: PositionResult

    @property
    def case(self) -> str:
        """What failed, in words."""
        if len(self.troubles) > 1:
            return "all of these in turn"
        return self.troubles[0].name if self.troubles else "nothing fails"

    @property
    def held(self) -> bool:
        """Whether all that failed is inside what the sensors' files say."""
        return all(trouble.held for trouble in self.troubles)


def troubles_concerning(carried: SensorSet, held: bool = True) -> tuple[Trouble, ...]:
    """The troubles that concern a set."""
    return tuple(
        trouble
        for trouble in TROUBLES
        if trouble.held is held and (trouble.concerns is None or trouble.concerns in carried.carries)
    )


def path_of_run(setup: Setup) -> Path:
    """The way of the run."""
    return drawn_up(setup, setup.line)[setup.timetable.diagrams[0].stock_id][0].mission.path


def every_m(path: Path, step_m: float) -> list[float]:
    """Places of a way (m), so far from one another, away from both ends."""
    return [step_m * number for number in range(1, int(path.length_m / step_m))]


def hidden_sky_line(line: Line, path: Path) -> Line:
    """The line with the tunnel and the stretches with a hidden sky, given along the way."""

    def cover(from_m: float, to_m: float) -> Cover:
        return Cover(*sorted((path.locate(from_m)[1], path.locate(to_m)[1])))

    hidden = tuple(sorted((cover(*each) for each in HIDDEN_M), key=lambda each: each.from_m))
    main = next(iter(line.alignments))
    alignment = replace(line.alignments[main], tunnels=(cover(*TUNNEL_M),), obstructed=hidden)
    return replace(line, alignments={**line.alignments, main: alignment})


def furnished_line(line: Line, path: Path) -> Line:
    """The line with beacons and markers along the way."""
    beacons: dict[int, Beacon] = {}
    for number, at_m in enumerate(every_m(path, BEACONS_EVERY_M), start=1):
        piece_id, km_m = path.locate(at_m)
        beacons[number] = Beacon(number, piece_id, km_m, (path.direction,))
    markers: dict[int, MarkerGroup] = {}
    for number, at_m in enumerate(every_m(path, MARKERS_EVERY_M), start=1):
        piece_id, km_m = path.locate(at_m)
        pattern = (number - 1) % PATTERNS + 1  # the same one comes again far beyond any bounds
        markers[number] = MarkerGroup(number, pattern, piece_id, km_m, (path.direction,))
    return replace(hidden_sky_line(line, path), beacons=beacons, markers=markers)


def on_the_track(line: Line, path: Path, troubles: Sequence[Trouble]) -> Line:
    """The line as it is where things were moved, or are gone, that the unit's data still have in their old places."""
    for trouble in troubles:
        if trouble.kind:
            continue
        if trouble.concerns is PositionSensor.TAGS:
            line = replace(line, tags={key: _aside(path, tag, trouble) for key, tag in line.tags.items()})
        elif trouble.concerns is PositionSensor.BEACONS:
            line = replace(
                line, beacons={key: _aside(path, beacon, trouble) for key, beacon in line.beacons.items()}
            )
        else:
            kept = {key: each for key, each in line.markers.items() if not _within(path, each, trouble)}
            line = replace(line, markers=kept)
    return line


def _within(path: Path, mark: Any, trouble: Trouble) -> bool:  # noqa: ANN401 - a tag, a beacon, markers
    if mark.piece_id not in path or path.direction not in mark.directions:
        return False
    return trouble.from_m <= path.to_path_m(mark.piece_id, mark.position_m) <= trouble.to_m


def _aside(path: Path, mark: Any, trouble: Trouble) -> Any:  # noqa: ANN401
    if not _within(path, mark, trouble):
        return mark
    at_m = path.to_path_m(mark.piece_id, mark.position_m) + MOVED_M
    piece_id, km_m = path.locate(at_m)
    return replace(mark, piece_id=piece_id, position_m=km_m)


def moments_of(trouble: Trouble, stock_id: str, key: int, in_force: InForce) -> list[Moment]:
    """What happens to the train at the places between which a fault of the table is in force beside others."""
    if not trouble.kind:
        return []
    fault = FAULTS[trouble.kind](target=trouble.target or stock_id, **trouble.keys)

    def begin(trains: Trains, _slot: int) -> None:
        in_force.begin(key, fault, fault_onset(trains, 0.0, np.random.default_rng()))
        put_fault(fault, trains, in_force.value(fault))

    def end(trains: Trains, _slot: int) -> None:
        in_force.end(key)
        put_fault(fault, trains, in_force.value(fault))

    return [Moment(trouble.from_m, begin), Moment(trouble.to_m, end)]


def setup_of(carried: SensorSet, seed: int) -> Setup:
    """The run's setup without troubles."""
    setup = load_scenario(SCENARIO, seed).setup
    line = furnished_line(setup.line, path_of_run(setup))
    sensors = setup.sensors.model_copy(update={"carries": carried.carries})
    gnss = GNSS.model_copy(update={"correction": carried.correction})
    return replace(setup, line=line, sensors=sensors, gnss=gnss)


def run_with(carried: SensorSet, troubles: Sequence[Trouble], seed: int) -> SensorSetRun:
    """One run of a set with what fails in it."""
    setup = setup_of(carried, seed)
    stock_id, path = setup.timetable.diagrams[0].stock_id, path_of_run(setup)
    so = on_the_track(setup.line, path, troubles)
    if so is not setup.line:
        setup = replace(setup, line=so, belief=Belief(setup.line))
    in_force = InForce()
    moments = [m for key, one in enumerate(troubles) for m in moments_of(one, stock_id, key, in_force)]
    return SensorSetRun(carried, tuple(troubles), PositionRun(setup, moments).run())
