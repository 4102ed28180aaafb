"""What the camera and its pipeline make of a sign, measured on rendered images: the table of rows, the error model.

`record_table` puts the train at known places, as the paper does (3.3.3); `fit_sighting_model` takes images of every
place in one kind of light, and what it finds stands for camera and pipeline wherever nothing is rendered.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from onboard.localisation.vision import ImageWindow, SightTable, largest_cluster, search_window, sight
from radio.chance import generator
from simulation.sensors.camera import CREEP_MPS, NO_MOTION, Renderer, Scene, Shot, Sign, light_of
from simulation.sensors.camera_surroundings import Floats
from simulation.settings import Light


def record_table(
    renderer: Renderer,
    sign: Sign,
    distances_m: Sequence[float],
    seed: int,
    repeats: int = 4,
    window: ImageWindow | None = None,
    light: Light = Light.LIT_TUNNEL,
    *,
    around: bool = False,
) -> SightTable:
    """The table from row to distance as the paper records it (3.3.3): the train put at known places, images taken.

    `around`: only what lies about the sign is looked through. Distances rise; raises ValueError naming the distance
    from which the sign is not found.
    """
    rows: list[Floats] = []
    row_axis, column_axis = renderer.camera.axis_px
    for distance in distances_m:
        view = window_around(renderer, sign, distance) if around else window or renderer.camera.whole
        rng = generator(seed, "camera", "table", f"{distance:.6f}")
        seen: list[tuple[float, float, float]] = []
        for _ in range(repeats):
            scene = Scene(sign, sign_m=distance, lighting=light_of(light, rng))
            image = renderer.render(scene, Shot(0.0), rng, view)
            cluster = largest_cluster(image, view.left, view.top)
            if cluster is not None:
                seen.append((cluster.row_px - row_axis, cluster.column_px - column_axis, cluster.area_px))
        if not seen:
            raise ValueError(f"the sign is not found at {distance:g} m")
        rows.append(np.mean(seen, axis=0))
    offset, column, area = np.array(rows).T
    return SightTable(np.array(distances_m, dtype=np.float64), offset, column, area)


@dataclass(frozen=True, slots=True, eq=False)
class SightingModel:
    """Sampled errors that stand for camera and pipeline in line runs; fitted to the renderer by distance (m).

    `sigma_m` is that of a standing train, `moving_sigma_m` has the vibration too; `exposed_after_s` adds the way
    run until the sign's row is exposed, which shortens the distance seen. `false_share` of the pictures show
    something else as the sign, which is counted neither in the errors nor in `probability`.
    """

    distance_m: Floats
    probability: Floats
    bias_m: Floats
    sigma_m: Floats
    moving_sigma_m: Floats
    exposed_after_s: Floats
    false_share: Floats

    @property
    def range_m(self) -> float:
        """Detection range: the farthest distance (m) at which at least every second image shows the sign."""
        seen = self.distance_m[self.probability >= 0.5]
        return float(seen[-1]) if seen.size else 0.0

    def sample(self, distance_m: float, speed_mps: float, rng: np.random.Generator) -> float | None:
        """Distance (m) that one frame gives of a sign `distance_m` before the front; None: not seen."""
        chance, error = float(rng.random()), float(rng.standard_normal())
        if not self.distance_m[0] <= distance_m <= self.distance_m[-1]:
            return None
        if chance >= np.interp(distance_m, self.distance_m, self.probability):
            return None
        spread = self.moving_sigma_m if speed_mps > 0.0 else self.sigma_m
        bias, sigma, after_s = (
            float(np.interp(distance_m, self.distance_m, column))
            for column in (self.bias_m, spread, self.exposed_after_s)
        )
        return distance_m + bias + sigma * error - speed_mps * after_s


def window_around(renderer: Renderer, sign: Sign, distance_m: float) -> ImageWindow:
    """The part of the image about a sign at a distance (m) in which nothing else is looked for."""
    camera = renderer.camera
    row = min(camera.axis_px[0] + sign.offset_px(camera, distance_m), camera.height_px - 1.0)
    column = camera.axis_px[1] + camera.focal_px * sign.right_m / (distance_m + camera.setback_m)
    around = int(24 + camera.focal_px * sign.diameter_m / (distance_m + camera.setback_m))
    return ImageWindow(
        max(int(column) - around, 0),
        max(int(row) - around, 0),
        min(int(column) + around, camera.width_px),
        min(int(row) + around, camera.height_px),
    )


def sighted_distances(
    renderer: Renderer,
    sign: Sign,
    table: SightTable,
    distance_m: float,
    speed_mps: float,
    count: int,
    rng: np.random.Generator,
    light: Light = Light.LIT_TUNNEL,
    search_m: float | None = None,
    standing_rad: float = 0.0,
) -> Floats:
    """What the pipeline makes of `count` images at one distance; only those in which it found the sign, m.

    `standing_rad`: pitch between images of a train that stands. It looks in a small window, or wherever a train can
    see the sign that is sure of its place to `search_m` only.
    """
    camera = renderer.camera
    window = window_around(renderer, sign, distance_m)
    if search_m is not None:
        window = search_window(table, distance_m, search_m, camera.axis_px, camera.size_px) or window
    found: list[float] = []
    for _ in range(count):
        # within a pixel's worth of distance any place is as likely, or rounding to pixels would hide
        jitter_m = float(rng.uniform(-0.5, 0.5)) * table.slope_m_per_px(distance_m)
        pitch = float(rng.normal(0.0, camera.vibration_rad if speed_mps > 0.0 else standing_rad))
        scene = Scene(sign, sign_m=distance_m + jitter_m, lighting=light_of(light, rng))
        image = renderer.render(scene, Shot(0.0, speed_mps, pitch), rng, window)
        sighting = sight(image, table, camera.axis_px, window.left, window.top)
        if sighting is not None:
            found.append(sighting.distance_m - jitter_m)
    return np.array(found)


@dataclass(frozen=True, slots=True)
class SignSearch:
    """How a unit looks for a sign: sure of its place to `within_m`, and what it takes for one frame's error, m."""

    within_m: float
    wrong_by_m: Callable[[float], float]


def fit_sighting_model(
    renderer: Renderer,
    sign: Sign,
    table: SightTable,
    seed: int,
    count: int = 100,
    places_m: Sequence[float] | None = None,
    light: Light = Light.LIT_TUNNEL,
    search: SignSearch | None = None,
) -> SightingModel:
    """Measure probability, bias and spread with `count` rendered images a place, those of the table if none are given.

    As many again, at a creep, measure what vibration adds. With a `search`, what is further off than it allows
    counts as false.
    """
    camera = renderer.camera
    exposure_s = renderer.exposure_s(light_of(light, generator(seed, "camera", "exposure")))
    distances = table.distance_m[1:-1] if places_m is None else np.array(places_m)
    columns: list[tuple[float, ...]] = []
    for distance in (float(place) for place in distances):
        rng = generator(seed, "camera", "sighting model", light.value, f"{distance:.6f}")
        within_m = None if search is None else search.within_m
        wrong_by_m = np.inf if search is None else search.wrong_by_m(distance)
        shown = [
            sighted_distances(renderer, sign, table, distance, speed_mps, count, rng, light, within_m)
            - distance
            for speed_mps in (NO_MOTION, CREEP_MPS)
        ]
        at_rest, creeping = (errors[np.abs(errors) <= wrong_by_m] for errors in shown)
        seen = np.concatenate([at_rest, creeping])
        wrong = sum(errors.size for errors in shown) - seen.size
        row = camera.axis_px[0] + sign.offset_px(camera, distance)
        columns.append(
            (
                seen.size / (2 * count),
                float(seen.mean()) if seen.size else 0.0,
                float(at_rest.std(ddof=1)) if at_rest.size > 1 else 0.0,
                float(creeping.std(ddof=1)) if creeping.size > 1 else 0.0,
                camera.exposed_after_s(row, exposure_s),
                wrong / (2 * count),
            )
        )
    return SightingModel(np.array(distances), *np.array(columns).T)
