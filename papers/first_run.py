"""A map of curvature (マップ曲率データ) for a scenario's trains: from a first run of one of them, or from the design.

The run is that of `papers.position_run`: the train with tags and gyro along its line, in steps of the kernel;
what its gyro and wheels show goes into the map, with the tags and the first mark as the places that are known.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.errors import COMMAND_LINE, InputError
from network.files.toml_input import one_of
from onboard.localisation.curvature_map import CurvatureMap, FirstRunRecord, design_map, measured_map
from onboard.localisation.curvature_map_file import write_map
from papers.position_run import SLOT, PositionRun
from scenario.scenario import load_scenario
from simulation.settings import PositionSensor
from simulation.setup import STEP_S, Setup
from simulation.world.trains import MOUNTING

Floats = NDArray[np.float64]


class MeasuringRun(PositionRun):
    """A run that writes down, step by step, what its gyro and its wheels show, and where it knew to be."""

    def __init__(self, setup: Setup, number: str) -> None:
        super().__init__(setup, number=number, steps_max=1)
        self._tag_m: Final = {tag.tag_id: tag.position_m for tag in self.mission.tags}
        self._shown: list[tuple[float, float, float]] = []
        self._anchors = [(float(self.trains.tachometers[SLOT].odometer_m), self.mission.targets[0].mark_m)]
        self._delay_s: Final = float(self.trains.readers[SLOT].curvature.body_delay_s)

    def _stretch(self) -> None:
        passed = len(self.result.check_points)
        super()._stretch()
        sensed = self.trains.stock["sensed"][SLOT]
        yaw_radps = float(sensed["readings"]["curvature"]["yaw_radps"])
        self._shown.append((float(sensed["odometer_m"]), float(sensed["speed_mps"]), yaw_radps))
        for point in self.result.check_points[passed:]:
            if point.tag_id in self._tag_m:
                latched_m = float(self.trains.tag_readers[SLOT].latched_m)
                self._anchors.append((latched_m, self._tag_m[point.tag_id]))

    def record(self) -> FirstRunRecord:
        """What was shown, the heading without bias: between two stands the bias goes over from one to the other."""
        shown: Floats = np.array(self._shown, dtype=np.float64)
        odometer_m, speed_mps, yaw_radps = shown[:, 0], shown[:, 1], shown[:, 2]
        stands = speed_mps == 0.0
        steps: Floats = np.arange(len(self._shown), dtype=np.float64)
        middles, means = _stands(stands, yaw_radps)
        bias_radps = np.interp(steps, middles, means) if stands.any() else 0.0 * steps
        turned_rad = np.where(stands, 0.0, yaw_radps - bias_radps) * STEP_S
        anchors = tuple(sorted(dict(self._anchors).items()))
        return FirstRunRecord(odometer_m - speed_mps * self._delay_s, np.cumsum(turned_rad), anchors)


def _stands(stands: NDArray[np.bool_], yaw_radps: Floats) -> tuple[Floats, Floats]:
    """The middle step of each stand and the mean of what the gyro showed in it."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], stands, [False]]).astype(int)))
    middles = [(first + end - 1) / 2.0 for first, end in zip(ends[::2], ends[1::2], strict=True)]
    means = [float(yaw_radps[first:end].mean()) for first, end in zip(ends[::2], ends[1::2], strict=True)]
    return np.array(middles), np.array(means)


def map_by_run(setup: Setup, number: str) -> CurvatureMap:
    """The map that a first run of a train makes. InputError for a train that there is not."""
    diagrams = [d for d in setup.timetable.diagrams if number in d.train_numbers]
    if not diagrams:
        numbers = [n for d in setup.timetable.diagrams for n in d.train_numbers]
        raise InputError(
            COMMAND_LINE, "--train", number, f"a train of {setup.name}: {one_of(numbers, number)}"
        )
    others = [d for d in setup.timetable.diagrams if d is not diagrams[0]]
    timetable = replace(setup.timetable, diagrams=(diagrams[0], *others))
    sensors = setup.sensors.model_copy(
        update={"carries": (PositionSensor.TAGS, PositionSensor.CURVATURE), "carries_of": {}}
    )
    run = MeasuringRun(replace(setup, timetable=timetable, sensors=sensors, curvature_map=None), number)
    run.run()
    source = f"{run.duty.mission.number}, seed {setup.seed}"
    line = setup.believed_line
    return measured_map(run.record(), run.mission.path, line, MOUNTING, setup.unit.tag_accuracy_m, source)


def new_curvature_map(scenario: str, out: Path, number: str | None, seed: int | None) -> CurvatureMap:
    """Write the map of a scenario's line: by a first run of a train, or without one from the design."""
    setup = load_scenario(scenario, seed).setup
    curvature_map = design_map(setup.believed_line) if number is None else map_by_run(setup, number)
    write_map(curvature_map, out)
    return curvature_map
