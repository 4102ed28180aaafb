"""The camera that looks for stop signs (停止位置目標), in line runs: sampled frames instead of rendered ones.

The figures of the error model were fitted to the renderer (`simulation.sensors.camera.fit_sighting_model`, 60 images a
place at rest and as many vibrating); a test compares them with it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final, Protocol

import numpy as np

from onboard.board import SensedRow
from onboard.localisation.sighting import SIGN_BEYOND_MARK_M
from simulation.sensors.noise import normal, source_of, uniform
from simulation.sensors.scene import SceneRow
from vehicle.compiled import compiled

if TYPE_CHECKING:
    from simulation.setup import Setup

# distance m, share seen, bias m, sigma m at rest, sigma m moving, exposed after s: LINE_CAMERA and LINE_SIGN
LINE_SIGHTINGS: Final = (
    (9.0, 1.0, 0.002, 0.001, 0.015, 0.0187),
    (12.0, 1.0, -0.002, 0.001, 0.026, 0.0168),
    (15.0, 1.0, 0.001, 0.003, 0.044, 0.0156),
    (21.0, 1.0, -0.003, 0.006, 0.073, 0.0142),
    (30.0, 1.0, 0.014, 0.015, 0.148, 0.0131),
    (39.0, 1.0, 0.046, 0.019, 0.299, 0.0126),
    (48.0, 1.0, 0.032, 0.048, 0.423, 0.0122),
    (60.0, 1.0, 0.002, 0.129, 0.619, 0.0119),
    (69.0, 1.0, -0.079, 0.117, 0.759, 0.0117),
    (78.0, 1.0, 0.040, 0.352, 0.834, 0.0116),
    (87.0, 0.983, 0.156, 0.322, 1.290, 0.0115),
)
SEEN_FROM_M: Final = LINE_SIGHTINGS[-1][0]
PLACES: Final = len(LINE_SIGHTINGS)
PAST_MARK_M: Final = (
    SIGN_BEYOND_MARK_M / 2.0
)  # nearer than this the front is well past the mark: nothing to look for


class SignCameraRow(Protocol):
    """One train's camera; its error model by distance."""

    every_steps: Annotated[int, "a frame each so many steps of the day; 0: no camera"]
    source: Annotated[int, "of the noise in its frames"]
    seen_source: Annotated[int, "of whether a frame shows the sign at all"]
    distance_m: Annotated[list[float], PLACES]
    seen_share: Annotated[list[float], PLACES]
    bias_m: Annotated[list[float], PLACES]
    sigma_m: Annotated[list[float], PLACES, "at rest"]
    moving_sigma_m: Annotated[list[float], PLACES, "with the train's vibration too"]
    exposed_after_s: Annotated[list[float], PLACES, "until the sign's row is exposed"]


def fit(own: SignCameraRow, setup: Setup, stock_id: str) -> None:
    """A camera where the scenario has signs."""
    if not setup.vision.wanted:
        return
    own.every_steps = setup.steps_of(1.0 / setup.vision.rate_hz)
    own.source = source_of(setup.seed, "camera", stock_id, *setup.today)
    own.seen_source = source_of(setup.seed, "camera sees", stock_id, *setup.today)
    columns = np.array(LINE_SIGHTINGS).T
    own.distance_m[:], own.seen_share[:], own.bias_m[:] = columns[0], columns[1], columns[2]
    own.sigma_m[:], own.moving_sigma_m[:], own.exposed_after_s[:] = columns[3], columns[4], columns[5]


@compiled
def sign_camera(own: SignCameraRow, _sensors: Any, scene: SceneRow, sensed: SensedRow) -> None:  # noqa: ANN401
    """Take a frame if one is due while the sign is in range: the distance that it shows, +inf where it shows none."""
    shown = sensed.readings.sign
    shown.taken = 0
    ahead_m = scene.sign_ahead_m
    if own.every_steps == 0 or scene.step % own.every_steps != 0:
        return
    if not PAST_MARK_M <= ahead_m <= SEEN_FROM_M:
        return
    shown.taken = 1
    shown.distance_m = np.inf
    near = ahead_m < own.distance_m[0]
    if near or uniform(own.seen_source, scene.step) >= between(own.distance_m, own.seen_share, ahead_m):
        return
    sigmas = own.moving_sigma_m if scene.speed_mps > 0.0 else own.sigma_m
    error_m = between(own.distance_m, own.bias_m, ahead_m)
    error_m += between(own.distance_m, sigmas, ahead_m) * normal(own.source, scene.step)
    exposed_m = scene.speed_mps * between(own.distance_m, own.exposed_after_s, ahead_m)
    shown.distance_m = ahead_m + error_m - exposed_m


@compiled
def between(places_m: Any, values: Any, at_m: float) -> float:  # noqa: ANN401 - fields of a row
    """The value at a distance between the places of the model, by proportion."""
    upper = 1
    while upper < PLACES - 1 and places_m[upper] < at_m:
        upper += 1
    share = (at_m - places_m[upper - 1]) / (places_m[upper] - places_m[upper - 1])
    share = min(max(share, 0.0), 1.0)
    return float(values[upper - 1] + share * (values[upper] - values[upper - 1]))
