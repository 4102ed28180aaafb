"""The driver's camera and what it sees of the approach: a model, a renderer, and an error model that replaces it.

The camera looks level along a straight track in a box tunnel (Oda studies underground lines, section 3.1) with
the sign beside the track. Rows are exposed one after the other (rolling shutter), so a moving train sees lower
rows from further on. Distances run from the train's front; the lens stands `setback_m` behind it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from onboard.localisation.vision import Image, SightTable, Window, largest_cluster, sight
from radio.chance import generator
from simulation.sensors.camera_pixels import draw_board, draw_tunnel, expose

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

NOISE_BANK: Final = 1 << 22
TEXTURE_CELLS: Final = 600
NO_MOTION: Final = 0.0
CREEP_MPS: Final = 1e-6  # moving, so vibrating, but not far enough to blur


@dataclass(frozen=True, slots=True)
class CameraModel:
    """A camera and its place on the train; `length_scale` sizes the surroundings (1 real, 0.1 the model track)."""

    width_px: int
    height_px: int
    focal_length_m: float
    pixel_m: float
    lens_height_m: float  # above the ground
    setback_m: float  # of the lens behind the train's front
    frame_rate_hz: float
    readout_s: float  # from the first row's exposure to the last row's (rolling shutter)
    exposure_s: float
    noise_grey: float  # standard deviation of a pixel, grey levels of 255
    edge_px: float  # width of a sharp edge in the image: the lens's blur
    vibration_rad: float  # standard deviation of pitch from frame to frame while moving
    length_scale: float = 1.0

    @property
    def focal_px(self) -> float:
        """Focal length in pixels."""
        return self.focal_length_m / self.pixel_m

    @property
    def axis_px(self) -> tuple[float, float]:
        """Row and column where the optical axis meets the image."""
        return self.height_px / 2.0, self.width_px / 2.0

    @property
    def size_px(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.height_px, self.width_px

    @property
    def whole(self) -> Window:
        """The whole image."""
        return Window(0, 0, self.width_px, self.height_px)

    def exposed_after_s(self, row_px: float) -> float:
        """Middle of a row's exposure after the start of the frame, s."""
        return self.readout_s * row_px / self.height_px + self.exposure_s / 2.0


@dataclass(frozen=True, slots=True)
class Sign:
    """The stop sign: a disc on a post beside the track; `right_m` < 0 stands on the left."""

    diameter_m: float
    right_m: float
    up_m: float  # of its centre above the ground
    bgr: tuple[float, float, float] = (0.62, 0.61, 0.10)  # hue 180, as the camera sees it under lamps

    def offset_px(self, camera: CameraModel, distance_m: float) -> float:
        """Rows below the optical axis at which a pinhole sees its centre, `distance_m` (m) before the front."""
        return camera.focal_px * (camera.lens_height_m - self.up_m) / (distance_m + camera.setback_m)


# Oda, 3.2.2, but for: setback, and the sign's height, fitted to table 2 (a level pinhole meets all six rows
# within 0.6 px); readout, exposure, noise, edge, vibration: assumed, an ordinary CMOS camera under tube lamps.
PAPER_CAMERA: Final = CameraModel(
    width_px=1280,
    height_px=960,
    focal_length_m=3.4e-3,
    pixel_m=3.75e-6,
    lens_height_m=0.359,
    setback_m=0.244,
    frame_rate_hz=52.0,
    readout_s=1.0 / 52.0,
    exposure_s=0.005,
    noise_grey=4.0,
    edge_px=1.5,
    vibration_rad=3e-4,
    length_scale=0.1,
)
PAPER_SIGN: Final = Sign(
    diameter_m=0.018, right_m=0.20, up_m=0.359 - 0.189
)  # right: assumed, clear of the car

# Each 0.1 m to 2.8 m before the stop with the sign 0.5 m beyond it (3.3.2, 3.3.3); nearer than 0.5 m for overruns
# and for table 2's places.
PAPER_TABLE_M: Final = tuple(round(0.1 * k, 1) for k in range(2, 34))

SIGN_QUARTER: Final = Window(
    640, 480, 1280, 960
)  # right of and below the axis: all a sign on the right can reach

# The same sensor for a real line, assumed: the paper's lens sees a 0.18 m sign to some 30 m only; 8 mm reach 70 m.
LINE_CAMERA: Final = CameraModel(
    width_px=1280,
    height_px=960,
    focal_length_m=8e-3,
    pixel_m=3.75e-6,
    lens_height_m=2.8,
    setback_m=0.5,
    frame_rate_hz=52.0,
    readout_s=1.0 / 52.0,
    exposure_s=0.002,
    noise_grey=4.0,
    edge_px=1.5,
    vibration_rad=3e-4,
)
LINE_SIGN: Final = Sign(diameter_m=0.18, right_m=2.2, up_m=1.0)
LINE_SIGN_BEYOND_MARK_M: Final = 10.0


@dataclass(frozen=True, slots=True)
class Board:
    """Something flat that faces the camera; places from the ground and the track's middle, m."""

    along_m: float
    right_m: float
    up_m: float
    width_m: float
    height_m: float
    bgr: tuple[float, float, float]
    is_round: bool = False

    def row(self) -> tuple[float, ...]:
        """As the compiled pixels take it."""
        half_width, half_height = self.width_m / 2.0, self.height_m / 2.0
        shape = float(self.is_round)
        return (self.along_m, self.right_m, self.up_m, half_width, half_height, *self.bgr, shape)


@dataclass(frozen=True, slots=True)
class Lighting:
    """Lamps and air: `level` 1 is the light the exposure is set for, tube lamps flicker at twice the mains."""

    level: float = 1.0
    flicker_share: float = 0.03
    flicker_hz: float = 100.0
    phase_rad: float = 0.0
    visibility_m: float = math.inf  # where 5 % of the contrast is left (Koschmieder)

    @property
    def extinction_per_m(self) -> float:
        """Share of the contrast lost per metre of air."""
        return math.log(20.0) / self.visibility_m


@dataclass(frozen=True, slots=True)
class Scene:
    """What stands on the track side and how it is lit. `sign_m` is the sign's place along the track; None: no sign."""

    sign: Sign | None = None
    sign_m: float = 0.0
    boards: tuple[Board, ...] = ()
    lighting: Lighting = field(default_factory=Lighting)

    def board_rows(self) -> Floats:
        """Boards, the sign's post and the sign, the farthest first."""
        rows = [board.row() for board in self.boards]
        if self.sign is not None:
            sign = self.sign
            size, along = sign.diameter_m, self.sign_m
            post = (0.42, 0.43, 0.43)
            rows.append(
                Board(along + 1e-4, sign.right_m, sign.up_m / 2, 0.2 * size, sign.up_m, post).row(),
            )
            rows.append(Board(along, sign.right_m, sign.up_m, size, size, sign.bgr, is_round=True).row())
        return np.array(sorted(rows, key=lambda row: -row[0]), dtype=np.float64).reshape(-1, 9)


@dataclass(frozen=True, slots=True)
class Shot:
    """Where the front is along the track (m) when the frame begins, speed through it (m/s), pitch (rad, up)."""

    front_m: float
    speed_mps: float = NO_MOTION
    pitch_rad: float = 0.0


def lamplight(rng: np.random.Generator) -> Lighting:
    """Lamps as they are met: level within 15 %, flicker of 3 % at any phase (assumed)."""
    return Lighting(level=float(rng.uniform(0.85, 1.15)), phase_rad=float(rng.uniform(0.0, 2.0 * math.pi)))


class Renderer:
    """Renders what a camera sees. Surroundings and noise are drawn once from `seed`; a shot draws from its own rng."""

    def __init__(self, camera: CameraModel, seed: int) -> None:
        self.camera: Final = camera
        self._half_width_m: Final = 6.0 * camera.length_scale
        self._ceiling_m: Final = 7.0 * camera.length_scale
        self._cell_m: Final = 2.0 * self._half_width_m / TEXTURE_CELLS
        rng = generator(seed, "camera", "surroundings")
        self._floor: Final = _floor_texture(rng, self._cell_m / camera.length_scale)
        self._wall: Final = _wall_texture(rng)
        self._ceiling: Final = _ceiling_texture(rng)
        noise = generator(seed, "camera", "noise").standard_normal(NOISE_BANK, dtype=np.float32)
        self._noise: Final[Singles] = noise

    def render(
        self, scene: Scene, shot: Shot, rng: np.random.Generator, window: Window | None = None
    ) -> Image:
        """The BGR image (rows, columns, 3), or only a window of it. `rng` draws this shot's noise."""
        camera, light = self.camera, scene.lighting
        left, top, right, bottom = window or camera.whole
        rows_s = np.arange(top, bottom, dtype=np.float64) * (camera.readout_s / camera.height_px)
        lens_m: Floats = shot.front_m - camera.setback_m + shot.speed_mps * rows_s
        axis_row = camera.axis_px[0] + camera.focal_px * math.tan(shot.pitch_rad)
        axis_column = camera.axis_px[1]
        air = 0.35
        image = np.empty((bottom - top, right - left, 3), dtype=np.float32)
        draw_tunnel(
            image,
            left,
            top,
            lens_m,
            camera.focal_px,
            axis_row,
            axis_column,
            camera.lens_height_m,
            self._half_width_m,
            self._ceiling_m,
            self._floor,
            self._wall,
            self._ceiling,
            self._cell_m,
            light.extinction_per_m,
            air,
        )
        for board in scene.board_rows():
            draw_board(
                image,
                left,
                top,
                lens_m,
                shot.speed_mps * camera.exposure_s,
                camera.focal_px,
                axis_row,
                axis_column,
                camera.lens_height_m,
                board,
                camera.edge_px,
                light.extinction_per_m,
                air,
            )
        out = np.empty(image.shape, dtype=np.uint8)
        flicker = np.cos(2.0 * math.pi * light.flicker_hz * rows_s + light.phase_rad)
        factor = light.level * (1.0 + light.flicker_share * flicker)
        expose(image, factor, self._noise, int(rng.integers(NOISE_BANK)), camera.noise_grey, out)
        return out


def _with_mean(texture: Floats) -> Singles:
    """A texture with its mean along the track as an extra last row."""
    return np.concatenate([texture, texture.mean(axis=0, keepdims=True)]).clip(0.0, 1.0).astype(np.float32)


def _floor_texture(rng: np.random.Generator, cell_m: float) -> Singles:
    """Ballast, sleepers each 0.6 m, rails of 1067 mm gauge on the middle, concrete beside (full-size metres)."""
    n = TEXTURE_CELLS
    along = (np.arange(n) * cell_m)[:, None]
    across = np.abs((np.arange(n) + 0.5) * cell_m - n * cell_m / 2.0)[None, :]
    grain = rng.normal(0.0, 0.07, (n, n))
    texture = 0.36 + np.stack([grain * 0.9, grain, grain * 1.1], axis=-1)
    concrete = np.broadcast_to(across > 1.7, (n, n))
    texture[concrete] = (0.47, 0.49, 0.50) + 0.15 * grain[concrete][:, None]
    sleeper = (along % 0.6 < 0.22) & (across < 1.0)
    texture[sleeper] = (0.20, 0.25, 0.30) + 0.3 * grain[sleeper][:, None]
    rail = np.broadcast_to(np.abs(across - 1.067 / 2.0) < 0.04, (n, n))
    texture[rail] = (0.62, 0.62, 0.61)
    return _with_mean(texture)


def _wall_texture(rng: np.random.Generator) -> Singles:
    """Concrete panels with seams and a dark cable duct."""
    n = TEXTURE_CELLS
    texture = np.full((n, n, 3), (0.50, 0.54, 0.57)) + rng.normal(0.0, 0.015, (n, n, 1))
    texture[:: n // 4] *= 0.7
    texture[:, n // 8 : n // 8 + 6] = (0.22, 0.22, 0.24)
    return _with_mean(texture)


def _ceiling_texture(rng: np.random.Generator) -> Singles:
    """Concrete with two rows of tube lamps."""
    n = TEXTURE_CELLS
    texture = np.full((n, n, 3), (0.40, 0.42, 0.44)) + rng.normal(0.0, 0.015, (n, n, 1))
    for side in (n // 3, 2 * n // 3):
        texture[: n // 4, side - 8 : side + 8] = 1.0
        texture[n // 2 : 3 * n // 4, side - 8 : side + 8] = 1.0
    return _with_mean(texture)


def record_table(
    renderer: Renderer,
    sign: Sign,
    distances_m: Sequence[float],
    seed: int,
    repeats: int = 4,
    window: Window | None = None,
) -> SightTable:
    """The table from row to distance as the paper records it (3.3.3): the train put at known places, images taken.

    Distances rise; raises ValueError naming the distance from which the sign is not found.
    """
    rows: list[Floats] = []
    row_axis, column_axis = renderer.camera.axis_px
    view = window or renderer.camera.whole
    for distance in distances_m:
        rng = generator(seed, "camera", "table", f"{distance:.6f}")
        seen: list[tuple[float, float, float]] = []
        for _ in range(repeats):
            scene = Scene(sign, sign_m=distance, lighting=lamplight(rng))
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
    run until the sign's row is exposed, which shortens the distance seen.
    """

    distance_m: Floats
    probability: Floats
    bias_m: Floats
    sigma_m: Floats
    moving_sigma_m: Floats
    exposed_after_s: Floats

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


def sighted_distances(
    renderer: Renderer,
    sign: Sign,
    table: SightTable,
    distance_m: float,
    speed_mps: float,
    count: int,
    rng: np.random.Generator,
) -> Floats:
    """What the pipeline makes of `count` images at one distance; only those in which it found the sign, m."""
    camera = renderer.camera
    row = min(camera.axis_px[0] + sign.offset_px(camera, distance_m), camera.height_px - 1.0)
    column = camera.axis_px[1] + camera.focal_px * sign.right_m / (distance_m + camera.setback_m)
    around = int(24 + camera.focal_px * sign.diameter_m / (distance_m + camera.setback_m))
    window = Window(
        max(int(column) - around, 0),
        max(int(row) - around, 0),
        min(int(column) + around, camera.width_px),
        min(int(row) + around, camera.height_px),
    )
    found: list[float] = []
    for _ in range(count):
        # within a pixel's worth of distance any place is as likely, or rounding to pixels would hide
        jitter_m = float(rng.uniform(-0.5, 0.5)) * table.slope_m_per_px(distance_m)
        pitch = float(rng.normal(0.0, camera.vibration_rad)) if speed_mps > 0.0 else 0.0
        scene = Scene(sign, sign_m=distance_m + jitter_m, lighting=lamplight(rng))
        image = renderer.render(scene, Shot(0.0, speed_mps, pitch), rng, window)
        sighting = sight(image, table, camera.axis_px, window.left, window.top)
        if sighting is not None:
            found.append(sighting.distance_m - jitter_m)
    return np.array(found)


def fit_sighting_model(
    renderer: Renderer, sign: Sign, table: SightTable, seed: int, count: int = 100, every: int = 1
) -> SightingModel:
    """Measure probability, bias and spread with `count` rendered images at every `every`-th entry of the table.

    As many again, at a creep, measure what vibration adds.
    """
    camera = renderer.camera
    distances = table.distance_m[1:-1:every]
    columns: list[tuple[float, float, float, float, float]] = []
    for distance in distances:
        rng = generator(seed, "camera", "sighting model", f"{distance:.6f}")
        at_rest, creeping = (
            sighted_distances(renderer, sign, table, float(distance), speed_mps, count, rng) - distance
            for speed_mps in (NO_MOTION, CREEP_MPS)
        )
        seen = np.concatenate([at_rest, creeping])
        row = camera.axis_px[0] + sign.offset_px(camera, float(distance))
        columns.append(
            (
                seen.size / (2 * count),
                float(seen.mean()) if seen.size else 0.0,
                float(at_rest.std(ddof=1)) if at_rest.size > 1 else 0.0,
                float(creeping.std(ddof=1)) if creeping.size > 1 else 0.0,
                camera.exposed_after_s(row),
            )
        )
    return SightingModel(np.array(distances), *np.array(columns).T)
