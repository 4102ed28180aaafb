"""The LiDAR of line runs: distance and pattern of the next markers, five times a step, without computing points.

Mean distances and readable patterns follow figures fitted to a simulated scan (`line_scans`). Within a step the train's
speed changes evenly. The LiDAR sees only the next markers ahead, until the front is over their first row, so groups of
markers must lie further apart than it sees.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Final, Protocol

import numpy as np

from onboard.board import SensedRow
from onboard.localisation.lidar import SETBACK_M, LidarReading, LidarRow
from onboard.localisation.lidar_points import CYCLE_S, FARTHEST_M, KEPT_S, SPOTS
from onboard.localisation.marker_patterns import HALF_M
from simulation.sensor_settings import Lidar
from simulation.sensors.lidar_scan import SIGN_SHEETING
from simulation.sensors.line_scans import (
    COLUMNS,
    PLACES,
    PLACES_M,
    SMEARS,
    SMEARS_M,
    SPEEDS,
    SPEEDS_MPS,
    Scans,
    line_scans,
)
from simulation.sensors.noise import normal, source_of, uniform
from simulation.sensors.scene import SceneRow
from simulation.settings import PositionSensor
from simulation.setup import Setup
from vehicle.compiled import compiled, compiled_when_called
from vehicle.record import put_settings

PLACES_AT: Final = np.array(PLACES_M)
SPEEDS_AT: Final = np.array(SPEEDS_MPS)
SMEARS_AT: Final = np.array(SMEARS_M)
LOOKS_FROM_M: Final = FARTHEST_M + 4.0  # a cycle's points are of a tenth of a second before
NONE_CYCLES: Final = 2  # for so many cycles together no marker is hit
HIT_SHARE: Final = 0.1  # of a beam on a marker: what most points have at the least


class LidarSensorRow(Protocol):
    """One train's LiDAR; its error model speed by speed."""

    fitted: Annotated[int, "1: there is one"]
    blind: Annotated[int, "1: something covers its window"]
    settings: Lidar
    visibility_m: Annotated[float, "of the air about the train now"]
    before_mps: Annotated[float, "speed a step ago"]
    source: Annotated[int, "of the noise of mean distances"]
    none_source: Annotated[int, "of whether any point hits a marker"]
    read_source: Annotated[int, "of what is read"]
    row_source: Annotated[int, "of where the first row is read"]
    laid_source: Annotated[int, "of where markers lie"]
    scans: Scans


def fit(own: LidarSensorRow, setup: Setup, stock_id: str) -> None:
    """A LiDAR where the stock carries one."""
    put_settings(own.settings, setup.lidar)
    own.visibility_m = setup.lidar.visibility_m
    if PositionSensor.LIDAR not in setup.sensors.carried_by(stock_id):
        return
    own.fitted = 1
    own.source = source_of(setup.seed, "lidar", stock_id, *setup.today)
    own.none_source = source_of(setup.seed, "lidar hits none", stock_id, *setup.today)
    own.read_source = source_of(setup.seed, "lidar reads", stock_id, *setup.today)
    own.row_source = source_of(setup.seed, "lidar row", stock_id, *setup.today)
    own.laid_source = source_of(setup.seed, "markers laid")
    figures = line_scans()
    for column in COLUMNS:
        getattr(own.scans, column)[:] = getattr(figures, column).ravel()


def fit_reader(readers: Any, setup: Setup, stock_id: str) -> None:  # noqa: ANN401 - all readers' rows
    """Its unit looks for markers where there is a LiDAR."""
    own: LidarRow = readers.lidar
    own.fitted = int(PositionSensor.LIDAR in setup.sensors.carried_by(stock_id))


@compiled
def reach_m(own: LidarSensorRow) -> float:
    """How far it sees markers, m: to where light there and back leaves them no brighter than white.

    In air of that visibility 5 % are left (Koschmieder); dirt takes its share both ways.
    """
    left = (1.0 - own.settings.dirt_share) * (1.0 - own.settings.dirt_share) * HIT_SHARE * SIGN_SHEETING_GAIN
    if own.blind != 0 or left <= 1.0:
        return 0.0
    return float(math.log(left) / (2.0 * math.log(20.0)) * own.visibility_m)


SIGN_SHEETING_GAIN: Final = SIGN_SHEETING.gain


@compiled
def at_speed(values: Any, width: int, column: int, speed_mps: float) -> float:  # noqa: ANN401 - a field of a row
    """A figure of a column at a speed, by proportion between the rows of SPEEDS_MPS."""
    upper = 1
    while upper < SPEEDS - 1 and SPEEDS_AT[upper] < speed_mps:
        upper += 1
    share = (speed_mps - SPEEDS_AT[upper - 1]) / (SPEEDS_AT[upper] - SPEEDS_AT[upper - 1])
    share = min(max(share, 0.0), 1.0)
    before = values[(upper - 1) * width + column]
    return float(before + share * (values[upper * width + column] - before))


@compiled
def at_place(values: Any, speed_mps: float, place_m: float) -> float:  # noqa: ANN401 - a field of a row
    """A figure at a speed and a distance to the markers' middle."""
    upper = 1
    while upper < PLACES - 1 and PLACES_AT[upper] < place_m:
        upper += 1
    share = (place_m - PLACES_AT[upper - 1]) / (PLACES_AT[upper] - PLACES_AT[upper - 1])
    share = min(max(share, 0.0), 1.0)
    nearer: float = at_speed(values, PLACES, upper - 1, speed_mps)
    return float(nearer + share * (at_speed(values, PLACES, upper, speed_mps) - nearer))


@compiled
def mean_noise(source: int, cycle: int) -> float:
    """Noise of one cycle's mean: points of five cycles are in it, of which the next one keeps four."""
    total = 0.0
    for k in range(SPOTS):
        total += normal(source, cycle - k)
    return total / math.sqrt(SPOTS)


@compiled
def bears_m(own: LidarSensorRow, cycle: int, speed_mps: float) -> float:
    """Up to which spread this cycle's points give their pattern; -1: not at any."""
    chance = uniform(own.read_source, cycle)
    if chance >= at_speed(own.scans.read_share, SMEARS, 0, speed_mps):
        return -1.0
    for k in range(1, SMEARS):
        if chance >= at_speed(own.scans.read_share, SMEARS, k, speed_mps):
            return float(SMEARS_AT[k - 1])
    return float(SMEARS_AT[SMEARS - 1])


@compiled
def lidar(own: LidarSensorRow, _sensors: Any, scene: SceneRow, sensed: SensedRow) -> None:  # noqa: ANN401
    """Look at the next markers while they are near enough, at five moments of the step."""
    shown = sensed.readings.lidar
    shown.looks = 0
    before_mps, own.before_mps = own.before_mps, scene.speed_mps
    if own.fitted == 0 or scene.carries_more == 0 or not scene.markers_ahead_m <= LOOKS_FROM_M:
        return
    shown.looks = 1
    look(own, scene, shown, before_mps)


@compiled_when_called
def look(own: LidarSensorRow, scene: SceneRow, shown: LidarReading, before_mps: float) -> None:
    """Take points on the markers ahead, which are near enough; `before_mps` is the speed of a step ago."""
    shown.pattern = max(scene.markers_number, 0)
    accelerates = (scene.speed_mps - before_mps) / scene.step_s
    aside_m = own.settings.laid_within_m * (2.0 * uniform(own.laid_source, abs(scene.markers_number)) - 1.0)
    sees_m = reach_m(own)
    for k in range(SPOTS):
        ago_s = (SPOTS - 1 - k) * CYCLE_S
        cycle = scene.step * SPOTS + k
        speed_mps = max(scene.speed_mps - accelerates * ago_s, 0.0)
        row_m = (
            scene.markers_ahead_m
            + (scene.speed_mps - 0.5 * accelerates * ago_s) * ago_s
            + SETBACK_M
            + aside_m
        )
        middle_m = row_m + HALF_M
        none = uniform(own.none_source, cycle // NONE_CYCLES) < at_place(
            own.scans.none_share, speed_mps, middle_m
        )
        shown.mean_m[k], shown.row_m[k], shown.bears_m[k] = -1.0, 0.0, -1.0
        shown.run_m[k] = speed_mps * KEPT_S
        if none or middle_m > sees_m:
            continue
        sigma_m = at_place(own.scans.sigma_m, speed_mps, middle_m)
        lag_m = 0.5 * KEPT_S * speed_mps + at_place(own.scans.bias_m, speed_mps, middle_m)
        shown.mean_m[k] = middle_m + lag_m + sigma_m * mean_noise(own.source, cycle)
        row_sigma_m = at_speed(own.scans.row_sigma_m, 1, 0, speed_mps)
        shown.row_m[k] = (
            row_m
            + at_speed(own.scans.row_bias_m, 1, 0, speed_mps)
            + row_sigma_m * normal(own.row_source, cycle)
        )
        shown.bears_m[k] = bears_m(own, cycle, speed_mps)
