"""`branchline reproduce trainruns`: running times of another simulator, by its assumptions and by ours.

TrainRuns (railtoolkit) tests itself by running times of trains on paths. Made with its own assumptions
(`trainruns_model`) they come out to a hundredth of a second; beside each stands what our laws give, and the difference
is taken apart, one assumption at a time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from onboard.driving.pattern import limit_for_train, lowered_by
from papers.parameter_sets import LINE
from papers.reference_data import reference_folder
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.single_hop import HopBench, HopWay
from papers.single_run import Rows, new_hops
from papers.single_train import Bench
from papers.specification import Findings, Specification
from papers.trainruns_files import ReferencePath, read_path, read_train
from papers.trainruns_model import REFINED, STEP_M, ReferenceTrain, running_time_s
from vehicle.mass import mass_kg
from vehicle.resistance import KMH_PER_MPS, running_resistance_n
from vehicle.running_time import predicted_run
from vehicle.traction import full_force_n
from vehicle.train_file import TrainType, load_train, shipped_train

FOLDER: Final = "trainruns"
WITHIN_S: Final = 0.02
OURS_STEP_S: Final = 0.02
MODEL_STEP_M: Final = 0.25
FULL: Final = 1.0
DRIVEN_ORDER_S: Final = 1.0  # no train keeps it: it runs as fast as it can
# s, of the project's own tests (snapshots of its version 1); the four of the BR 642 are those that are judged
PUBLISHED: Final = {
    ("local", "const"): 391.615,
    ("local", "slope"): 395.515,
    ("local", "speed"): 523.315,
    ("local", "realworld"): 3437.529,
    ("longdistance", "const"): 330.746,
    ("longdistance", "slope"): 331.609,
    ("longdistance", "speed"): 501.021,
    ("longdistance", "realworld"): 2913.109,
    ("freight", "const"): 745.070,
    ("freight", "slope"): 840.817,
    ("freight", "speed"): 750.453,
    ("freight", "realworld"): 8795.025,
}
OWN: Final = "local"  # the train of which we have a file of our own
OWN_TRAIN: Final = "br642"


@dataclass(frozen=True, slots=True)
class Apart:
    """Running times of one train on one path, s, from that model's to ours, one assumption after the other."""

    published_s: float
    rebuilt_s: float
    fine_s: float  # that model with steps of MODEL_STEP_M
    as_theirs_s: float  # our laws, with its resistance of the empty train alone
    converged_s: float  # our laws
    driven_s: float  # with the pattern and the distance to limits that our units keep
    plant_s: float  # the whole train, through the kernel

    def figures(self, path: str) -> tuple[UnjudgedFigure, ...]:
        """What each assumption is worth."""
        parts = (
            (
                "steps",
                self.fine_s - self.rebuilt_s,
                f"steps of {STEP_M:g} m hold the force of their beginning; {MODEL_STEP_M:g} m instead",
            ),
            (
                "laws",
                self.as_theirs_s - self.fine_s,
                "ours beside its: the train's length lies on the gradient, 9.81 m/s^2 for 9.80665, steps of time",
            ),
            ("load", self.converged_s - self.as_theirs_s, "the load rolls too, not the empty train alone"),
            (
                "driving",
                self.driven_s - self.converged_s,
                f"units stay {LINE.driving.driving_margin_mps:g} m/s under limits and stop by"
                f" {LINE.driving.stop_deceleration_mps2:g} m/s^2",
            ),
            (
                "plant",
                self.plant_s - self.driven_s,
                "dead time, build-up, notches and the stop at the mark; limits held by bounds that grow by"
                f" {LINE.unit.wheel_error_share:.0%} of the way, without a fix; whole steps of the kernel",
            ),
        )
        return tuple(UnjudgedFigure(f"{path}: {name}, s", round(value, 2), why) for name, value, why in parts)


def own_paths(folder: Path) -> Iterator[tuple[str, ReferencePath, float]]:
    """The paths whose running times are judged, with those of the train of which we have a file, s."""
    for (name, path_name), published_s in PUBLISHED.items():
        if name == OWN:
            yield path_name, read_path(folder / "paths" / f"{path_name}.yaml"), published_s


def own_train(folder: Path) -> ReferenceTrain:
    """That train, as the model knows it."""
    return read_train(folder / "trains" / f"{OWN}.yaml")


def time_row(path_name: str, published_s: float, found_s: float, beside: object = None) -> CaseRow:
    """One running time."""
    held = abs(found_s - published_s) <= WITHIN_S
    criterion = f"within {WITHIN_S:g} s"
    return CaseRow(f"BR 642 on {path_name}, s", published_s, round(found_s, 3), held, criterion, beside)


def taken_apart(kind: TrainType, train: ReferenceTrain, path: ReferencePath, published_s: float) -> Apart:
    """One path of a train that we have a file of."""
    sections = path.sections(train)
    way = way_of(path)
    return Apart(
        published_s,
        running_time_s(train, sections),
        running_time_s(train, sections, MODEL_STEP_M, 1),
        converged_s(as_theirs(kind, train), way, train.braking_mps2),
        converged_s(kind.row, way, train.braking_mps2),
        converged_s(kind.row, way, LINE.driving.stop_deceleration_mps2, LINE.driving.driving_margin_mps),
        plant_s(kind, way),
    )


def way_of(path: ReferencePath) -> HopWay:
    """The same way for a train of ours: what its gradients and limits are by the metre."""
    begin_m = path.breaks[0][0]
    return HopWay(
        path.length_m,
        tuple((at_m - begin_m, permille) for at_m, _, permille in path.breaks),
        limits_mps=tuple((at_m - begin_m, kmh / KMH_PER_MPS) for at_m, kmh, _ in path.breaks),
    )


def as_theirs(kind: TrainType, train: ReferenceTrain) -> Rows:
    """Our train with the resistance of its empty mass whatever its load, as that model has it."""
    row = kind.row.copy()
    share = (train.driving_kg + train.carrying_kg) / mass_kg(kind.row[0], FULL)
    resistance = row["resistance"]
    for field in resistance.dtype.names or ():
        if field.startswith(("motored", "trailer")):
            resistance[field] *= share
    return row


def converged_s(row: Rows, way: HopWay, deceleration_mps2: float, below_limit_mps: float = 0.0) -> float:
    """Least running time by our laws, s: `vehicle.running_time` in steps of OURS_STEP_S, laden."""
    train = row.view(np.recarray)[0]
    begin_m = math.ceil(float(row["length_m"][0])) + 1.0
    limits_mps = limit_for_train(way.limit_mps(begin_m, float(train.speed_max_mps)), train)
    kept_mps = lowered_by(limits_mps, below_limit_mps) if below_limit_mps > 0.0 else limits_mps
    time_s, _ = predicted_run(
        row[0],
        FULL,
        way.elevation_m(begin_m),
        kept_mps,
        begin_m,
        begin_m + way.length_m,
        math.inf,
        deceleration_mps2,
        OURS_STEP_S,
    )
    return float(time_s)


def plant_s(kind: TrainType, way: HopWay) -> float:
    """The running time of the whole train, laden, with its unit and law, through the kernel, s."""
    hops = new_hops([DRIVEN_ORDER_S])
    hops["load_share"] = FULL
    outcomes, _ = HopBench(Bench(kind, LINE.driving, LINE.unit), way).run(hops)
    return float(outcomes["time_s"][0])


def _published_trains(folder: Path) -> Iterator[UnjudgedFigure]:
    """Trains of which we have no file: that model alone."""
    for (name, path_name), published_s in PUBLISHED.items():
        if name == OWN:
            continue
        train = read_train(folder / "trains" / f"{name}.yaml")
        path = read_path(folder / "paths" / f"{path_name}.yaml")
        off_s = running_time_s(train, path.sections(train)) - published_s
        meaning = f"its model less {published_s:g} s, which its tests have"
        yield UnjudgedFigure(f"{name} on {path_name}: off, s", round(off_s, 3), meaning)


def _forces(kind: TrainType, train: ReferenceTrain) -> Iterator[UnjudgedFigure]:
    """How far the forces of our train file lie from those of the reference's, at every km/h."""
    row = kind.row[0]
    speeds_mps = [kmh / KMH_PER_MPS for kmh in range(round(train.limit_mps * KMH_PER_MPS) + 1)]
    pull_n = max(abs(full_force_n(row, FULL, v) - train.pull_n(v)) for v in speeds_mps)
    empty_kg = mass_kg(row, 0.0)
    drag_n = max(abs(running_resistance_n(row, empty_kg, v) - train.resistance_n(v)) for v in speeds_mps)
    yield UnjudgedFigure(
        "traction: ours less its at most, N", round(pull_n, 1), "of the same table, at every km/h"
    )
    meaning = "Wende's formula, expanded in our train file and rounded there; the empty train"
    yield UnjudgedFigure("resistance: ours less its at most, N", round(drag_n, 1), meaning)


def _parameters(kind: TrainType, train: ReferenceTrain) -> tuple[Parameter, ...]:
    file = f"{FOLDER}/trains/{OWN}.yaml"
    return (
        Parameter("step of distance", STEP_M, "m", "TrainRuns: its default"),
        Parameter("steps refined before what ends them", REFINED, "times by 10", "TrainRuns: its default"),
        Parameter("mass", "as a point", "", "TrainRuns: its default"),
        Parameter("mass, laden", train.mass_kg / 1e3, "t", file),
        Parameter("braking", train.braking_mps2, "m/s^2", file),
        Parameter("our train", kind.id, "", "vehicle/trains, the same vehicle"),
        Parameter("our steps", OURS_STEP_S, "s", "assumed: half of it changes less than 0.02 s"),
    )


def experiment(options: Options) -> Findings:
    """The four running times of the BR 642, within 0.02 s, and ours beside them; other trains are reported."""
    folder = reference_folder(options, FOLDER)
    kind, train = load_train(shipped_train(OWN_TRAIN)), own_train(folder)
    rows: list[CaseRow] = []
    figures: list[UnjudgedFigure] = []
    for path_name, path, published_s in own_paths(folder):
        apart = taken_apart(kind, train, path, published_s)
        rows.append(time_row(path_name, published_s, apart.rebuilt_s, round(apart.converged_s, 2)))
        figures += apart.figures(path_name)
    return Findings(
        rows,
        _parameters(kind, train),
        (
            "the model of that simulator is a check, no second physics: nothing else runs by it",
            "'converged' is our least running time with that train's braking; what it differs by is taken apart below",
            "the running times are those of its own tests; the four of the BR 642 are judged, its other trains told",
        ),
        (*figures, *_published_trains(folder), *_forces(kind, train)),
    )


def at_every_limit(options: Options) -> Iterable[CaseRow]:
    """The same running times of a train that has no mass."""
    folder = reference_folder(options, FOLDER)
    train = own_train(folder)
    for path_name, path, published_s in own_paths(folder):
        held_s = sum((part.end_m - part.begin_m) / part.limit_mps for part in path.sections(train))
        yield time_row(path_name, published_s, held_s)


reproduce: Final = Specification(
    "trainruns",
    "Running times of TrainRuns, by its assumptions and by ours",
    experiment,
    NullMethod("every limit held from where it begins", (", s",), at_every_limit),
    LINE,
    beside="converged",
)
