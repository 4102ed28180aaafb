"""What units that carry a yaw gyro know of it, of the rails and of the map, from the settings of a run."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from network.path import Path
from onboard.localisation.curvature_map import SIMPSON, CurvatureMap, Mounting, design_map, laid_per_m
from onboard.localisation.curvature_row import (
    BY_SPACE,
    BY_TIME,
    UNFILTERED,
    CurvatureComparison,
    CurvatureRow,
)
from onboard.localisation.spatial_filter import CORNER_M, delay_m, filter_gain, sections, step_response
from onboard.unit_records import UnitParameters
from simulation.sensor_settings import Curvature, Filter
from simulation.sensors.yaw_gyro import CUT_SIGMAS
from simulation.setup import STEP_S, Setup
from simulation.world.irregularities import heading_density
from vehicle.record import put_settings

Floats = NDArray[np.float64]

FILTERS: Final = {Filter.SPACE: BY_SPACE, Filter.TIME: BY_TIME, Filter.OFF: UNFILTERED}
LONGEST_M: Final = 2000.0  # of the waves that are summed up
SHORTEST_M: Final = 2.0
WAVES: Final = 4000


@dataclass(frozen=True, slots=True)
class LaidCurvatureMap:
    """The map of curvature as units of a run have it, laid along paths."""

    known: CurvatureMap
    mounting: Mounting
    filter: Filter
    _laid: dict[tuple[tuple[str, ...], int], Floats] = field(
        default_factory=dict[tuple[tuple[str, ...], int], Floats]
    )

    def along(self, path: Path) -> Floats:
        """Row i: what the metre up to i shows, 1/m; nan where nothing is known."""
        key = (path.piece_ids, int(path.direction))
        if key not in self._laid:
            numbers = None if self.filter is Filter.OFF else np.array(sections(CORNER_M))
            self._laid[key] = laid_per_m(self.known, path, self.mounting, numbers)
        return self._laid[key]


def map_of_run(setup: Setup, mounting: Mounting) -> LaidCurvatureMap | None:
    """The map of a run; None where no stock carries a gyro."""
    if not setup.sensors.any_gyro:
        return None
    return LaidCurvatureMap(map_of(setup), mounting, setup.curvature.filter)


def map_of(setup: Setup) -> CurvatureMap:
    """The map that units of a run have."""
    return design_map(setup.believed_line) if setup.curvature_map is None else setup.curvature_map


def fit(own: CurvatureRow, setup: Setup, stock_id: str, mounting: Mounting) -> None:
    """Fill what a unit knows beforehand, where its stock carries a gyro."""
    if not setup.sensors.carries_gyro(stock_id):
        return
    given = setup.curvature
    own.fitted = 1
    own.filtered = FILTERS[given.filter]
    corner = CORNER_M / (given.filter_speed_mps * STEP_S) if given.filter is Filter.TIME else CORNER_M
    own.numbers[:] = sections(corner)
    by_space = given.filter is Filter.SPACE
    own.rises[:] = step_response(np.array(sections(corner))) if by_space else np.ones(len(own.rises))
    put_settings(own.settings, given, CurvatureComparison)
    _state_wheels(own, setup.unit)
    own.doubtful_share = setup.unit.wheel_error_share + 1e-9
    own.scale_low, own.scale_high = 1.0 - own.worn_share, 1.0 + own.worn_share
    own.gain_share = CUT_SIGMAS * given.gain_sigma
    own.bias_walk_radps, own.bias_walk_s = math.radians(given.bias_walk_degps), given.bias_walk_s
    own.bias_radps2 = math.radians(given.bias_sigma_degps + given.bias_walk_degps) ** 2
    own.yaw_density = given.stated_sigma_radps(STEP_S) ** 2 * STEP_S
    own.body_delay_s = 2.0 * given.body_damping / (2.0 * math.pi * given.body_frequency_hz)
    own.delay_share = (1.0 + given.body_spread) / (1.0 - given.body_spread) - 1.0
    own.filter_mps = given.filter_speed_mps
    own.filter_delay_m = delay_m() if given.filter is Filter.TIME else 0.0
    own.map_error_m = 0.0 if setup.curvature_map is None else setup.curvature_map.error_m
    _state_rails(own, given, mounting, measured=setup.curvature_map is not None)


def _state_wheels(own: CurvatureRow, unit: UnitParameters) -> None:
    """What wheels may be worn by, and what they vary by on the way: as stated of units, whatever the world has drawn.

    The latter is of the way counted by worn wheels, which may be the larger ones.
    """
    varies = unit.wheel_varies_share * (1.0 + unit.wheel_error_share)
    own.varies_share = min(varies, unit.wheel_error_share)
    own.worn_share = unit.wheel_error_share - own.varies_share


def _state_rails(own: CurvatureRow, given: Curvature, mounting: Mounting, *, measured: bool) -> None:
    """What rails as stated leave in the run's curvature behind bogies and filter, and in a map that was measured."""
    waves_radpm = np.linspace(2.0 * math.pi / LONGEST_M, 2.0 * math.pi / SHORTEST_M, WAVES)
    body = np.zeros(WAVES, dtype=np.complex128)
    for share, weight in SIMPSON:
        body += weight * np.exp(-1j * waves_radpm * share * mounting.bogie_base_m)
    left = np.abs(body)
    if given.filter is not Filter.OFF:
        left = left * filter_gain(2.0 * math.pi / waves_radpm)
    both = 2.0 if measured else 1.0
    heading = both * heading_density(waves_radpm, given.rails) * left**2
    curvature = heading * waves_radpm**2
    own.rail_level = both * math.pi * float(np.max(heading_density(waves_radpm, given.rails)))
    own.rail_peak = math.pi * float(np.max(curvature))
    own.rail_variance_per_m2 = float(np.trapezoid(curvature, waves_radpm))
    slopes = float(np.trapezoid(curvature * waves_radpm**2, waves_radpm))
    own.map_slope2_per_m = slopes / both if measured else 0.0
    own.rail_heading_rad = math.sqrt(float(np.trapezoid(heading, waves_radpm)))
