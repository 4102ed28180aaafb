"""The camera that looks for stop signs (停止位置目標), in line runs: sampled frames instead of rendered ones.

What a frame shows follows the figures that were fitted to the renderer for the light of the hour (`line_sightings`).
"""

from __future__ import annotations

from typing import Annotated, Any, Final, Protocol

import numpy as np

from onboard.board import SensedRow
from onboard.localisation.sighting import SIGN_BEYOND_MARK_M, SignReading
from simulation.sensors.line_sightings import COLUMNS, LIGHTS, PLACES_M, line_sightings
from simulation.sensors.noise import normal, source_of, uniform
from simulation.sensors.scene import SceneRow
from simulation.setup import Setup
from vehicle.compiled import compiled, compiled_when_called

PLACES: Final = len(PLACES_M)
FIGURES: Final = len(LIGHTS) * PLACES
NEAREST_M: Final = PLACES_M[0]
SEEN_FROM_M: Final = PLACES_M[-1]
HOURS_MAX: Final = 8
# nearer than this the front is well past the mark: nothing to look for
PAST_MARK_M: Final = SIGN_BEYOND_MARK_M / 2.0


class SignCameraRow(Protocol):
    """One train's camera; its error model by light and distance, light after light."""

    every_steps: Annotated[int, "a frame each so many steps of the day; 0: no camera"]
    source: Annotated[int, "of the noise in its frames"]
    seen_source: Annotated[int, "of whether a frame shows the sign at all, or something else"]
    false_source: Annotated[int, "of where something else is"]
    hidden_beyond_m: Annotated[float, "a curve or a building hides signs that are further off"]
    taken_falsely: Annotated[
        float, "share of all frames that show something else, beyond what the figures have"
    ]
    light: Annotated[int, "where no hours are given"]
    from_s: Annotated[list[float], HOURS_MAX]
    to_s: Annotated[list[float], HOURS_MAX, "0: none"]
    light_then: Annotated[list[int], HOURS_MAX]
    seen_share: Annotated[list[float], FIGURES]
    false_share: Annotated[list[float], FIGURES]
    bias_m: Annotated[list[float], FIGURES]
    sigma_m: Annotated[list[float], FIGURES, "at rest"]
    moving_sigma_m: Annotated[list[float], FIGURES, "with the train's vibration too"]
    exposed_after_s: Annotated[list[float], FIGURES, "until the sign's row is exposed"]


PLACES_AT: Final = np.array(PLACES_M)


def fit(own: SignCameraRow, setup: Setup, stock_id: str) -> None:
    """A camera where the scenario has signs."""
    vision = setup.vision
    if not vision.wanted:
        return
    own.every_steps = setup.steps_of(1.0 / vision.rate_hz)
    own.source = source_of(setup.seed, "camera", stock_id, *setup.today)
    own.seen_source = source_of(setup.seed, "camera sees", stock_id, *setup.today)
    own.false_source = source_of(setup.seed, "camera is deceived", stock_id, *setup.today)
    own.hidden_beyond_m, own.taken_falsely = vision.hidden_beyond_m, vision.false_share
    own.light = LIGHTS.index(vision.light)
    for index, hours in enumerate(vision.hours):
        own.from_s[index], own.to_s[index] = hours.from_s, hours.to_s
        own.light_then[index] = LIGHTS.index(hours.light)
    figures = line_sightings()
    for column in COLUMNS:
        getattr(own, column)[:] = np.concatenate([getattr(figures[light], column) for light in LIGHTS])


@compiled
def light_at(own: SignCameraRow, now_s: float) -> int:
    """The light of that moment, s since midnight: that of the first hours that hold it."""
    for i in range(HOURS_MAX):
        if own.from_s[i] <= now_s < own.to_s[i]:
            return int(own.light_then[i])
    return int(own.light)


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
    take_frame(own, scene, shown, ahead_m)


@compiled_when_called
def take_frame(own: SignCameraRow, scene: SceneRow, shown: SignReading, ahead_m: float) -> None:
    """See the sign in this frame, or none, or something else."""
    first = light_at(own, scene.now_s) * PLACES
    deceived = own.taken_falsely + figure_at(own.false_share, first, ahead_m)
    chance = uniform(own.seen_source, scene.step)
    if chance < deceived:
        shown.distance_m = NEAREST_M + (SEEN_FROM_M - NEAREST_M) * uniform(own.false_source, scene.step)
        return
    visible = NEAREST_M <= ahead_m <= own.hidden_beyond_m
    if not visible or chance >= deceived + figure_at(own.seen_share, first, ahead_m):
        return
    sigmas = own.moving_sigma_m if scene.speed_mps > 0.0 else own.sigma_m
    error_m = figure_at(own.bias_m, first, ahead_m)
    error_m += figure_at(sigmas, first, ahead_m) * normal(own.source, scene.step)
    exposed_m = scene.speed_mps * figure_at(own.exposed_after_s, first, ahead_m)
    shown.distance_m = ahead_m + error_m - exposed_m


@compiled
def figure_at(values: Any, first: int, at_m: float) -> float:  # noqa: ANN401 - a field of a row
    """The value at a distance between the places of the light whose figures begin at `first`, by proportion."""
    upper = 1
    while upper < PLACES - 1 and PLACES_AT[upper] < at_m:
        upper += 1
    share = (at_m - PLACES_AT[upper - 1]) / (PLACES_AT[upper] - PLACES_AT[upper - 1])
    share = min(max(share, 0.0), 1.0)
    return float(values[first + upper - 1] + share * (values[first + upper] - values[first + upper - 1]))
