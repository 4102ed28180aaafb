"""The driver's camera and what it sees of the approach: a model, a renderer, and an error model that replaces it.

The camera looks level along a straight track with the sign beside it: in a lit box tunnel (Oda studies underground
lines, section 3.1), or in the open air (`open_air`). Rows are exposed one after the other (rolling shutter), so a
moving train sees lower rows from further on. Distances run from the train's front; the lens stands `setback_m`
behind it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from onboard.localisation.vision import Image, ImageWindow
from radio.chance import generator
from simulation.sensors.camera_pixels import BLUE, RED, draw_board, draw_tunnel, expose_image
from simulation.sensors.camera_surroundings import (
    TEXTURE_CELLS,
    Floats,
    Singles,
    ceiling_texture,
    floor_texture,
    grass_texture,
    skyline,
    wall_texture,
)
from simulation.sensors.camera_weather import add_drops, add_glare, add_streaks, draw_open
from simulation.sensors.open_air import OPEN_AIR, CameraExposure, OpenAir, exposure
from simulation.settings import Light

NOISE_BANK: Final = 1 << 22
TUNNEL_AIR: Final = 0.35  # what mist in a tunnel shows
METER_EVERY_PX: Final = 8  # of the rows and columns on which the exposure is metered
NO_MOTION: Final = 0.0
CREEP_MPS: Final = 1e-6  # moving, so vibrating, but not far enough to blur


@dataclass(frozen=True, slots=True)
class CameraModel:
    """A camera and its place on the train, `PAPER_CAMERA` where nothing is said.

    `length_scale` sizes the surroundings (1 real, 0.1 the model track).
    """

    width_px: int = 1280
    height_px: int = 960
    focal_length_m: float = 3.4e-3
    pixel_m: float = 3.75e-6
    lens_height_m: float = 0.359  # above the ground
    setback_m: float = 0.244  # of the lens behind the train's front
    frame_rate_hz: float = 52.0
    readout_s: float = 1.0 / 52.0  # from the first row's exposure to the last row's (rolling shutter)
    exposure_s: float = 0.005
    noise_grey: float = 4.0  # standard deviation of a pixel, grey levels of 255
    edge_px: float = 1.5  # width of a sharp edge in the image: the lens's blur
    vibration_rad: float = 3e-4  # standard deviation of pitch from frame to frame while moving
    trial_rad: float = 4.2e-4  # and from one trial to another of a train that stands
    length_scale: float = 0.1

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
    def whole(self) -> ImageWindow:
        """The whole image."""
        return ImageWindow(0, 0, self.width_px, self.height_px)

    @property
    def row_s(self) -> float:
        """From one row's exposure to the next one's, s."""
        return self.readout_s / self.height_px

    def axis_of(self, pitch_rad: float) -> tuple[float, float]:
        """Row and column of the track's vanishing point while the camera pitches up by `pitch_rad`."""
        return self.axis_px[0] + self.focal_px * math.tan(pitch_rad), self.axis_px[1]

    def exposed_after_s(self, row_px: float, exposure_s: float | None = None) -> float:
        """Middle of a row's exposure after the start of the frame, s."""
        return self.row_s * row_px + (self.exposure_s if exposure_s is None else exposure_s) / 2.0


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
# The pitch between trials "apart in time" is fitted to the scatter of table 2: 0.41 px, of which writing half pixels
# makes 0.14.
PAPER_CAMERA: Final = CameraModel()
# right: assumed, clear of the car
PAPER_SIGN: Final = Sign(diameter_m=0.018, right_m=0.20, up_m=0.359 - 0.189)

# Each 0.1 m to 2.8 m before the stop with the sign 0.5 m beyond it (3.3.2, 3.3.3); nearer than 0.5 m for overruns
# and for table 2's places.
PAPER_TABLE_M: Final = tuple(round(0.1 * k, 1) for k in range(2, 34))

# right of and below the axis: all a sign on the right can reach
SIGN_QUARTER: Final = ImageWindow(640, 480, 1280, 960)

# The same sensor for a real line, assumed: the paper's lens sees a 0.18 m sign to some 30 m only; 8 mm reach 70 m.
LINE_CAMERA: Final = replace(
    PAPER_CAMERA,
    focal_length_m=8e-3,
    lens_height_m=2.8,
    setback_m=0.5,
    exposure_s=0.002,
    trial_rad=0.0,
    length_scale=1.0,
)
LINE_SIGN: Final = Sign(diameter_m=0.18, right_m=2.2, up_m=1.0)


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
    lighting: Lighting | OpenAir = field(default_factory=Lighting)

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


@dataclass(frozen=True, slots=True)
class _BoardSight:
    """How boards are seen: contrast lost per metre, towards what, width of an edge, exposure."""

    extinction_per_m: float
    air: float
    edge_px: float
    exposure_s: float


def lamplight(rng: np.random.Generator) -> Lighting:
    """Lamps as they are met: level within 15 %, flicker of 3 % at any phase (assumed)."""
    return Lighting(level=float(rng.uniform(0.85, 1.15)), phase_rad=float(rng.uniform(0.0, 2.0 * math.pi)))


def light_of(light: Light, rng: np.random.Generator) -> Lighting | OpenAir:
    """Lamps, or light and weather, of one picture as they are met."""
    return lamplight(rng) if light is Light.LIT_TUNNEL else OPEN_AIR[light]


class Renderer:
    """Renders what a camera sees. Surroundings and noise are drawn once from `seed`; a shot draws from its own rng."""

    def __init__(self, camera: CameraModel, seed: int) -> None:
        self.camera: Final = camera
        self._half_width_m: Final = 6.0 * camera.length_scale
        self._ceiling_m: Final = 7.0 * camera.length_scale
        self._cell_m: Final = 2.0 * self._half_width_m / TEXTURE_CELLS
        rng = generator(seed, "camera", "surroundings")
        self._floor: Final = floor_texture(rng, self._cell_m / camera.length_scale)
        self._wall: Final = wall_texture(rng)
        self._ceiling: Final = ceiling_texture(rng)
        outside = generator(seed, "camera", "open air")
        self._grass: Final = grass_texture(outside)
        self._skyline: Final = skyline(outside)
        self._exposures: Final[dict[OpenAir, CameraExposure]] = {}
        noise = generator(seed, "camera", "noise").standard_normal(NOISE_BANK, dtype=np.float32)
        self._noise: Final[Singles] = noise

    def render(
        self, scene: Scene, shot: Shot, rng: np.random.Generator, window: ImageWindow | None = None
    ) -> Image:
        """The BGR image (rows, columns, 3), or only a window of it. `rng` draws this shot's noise and weather."""
        camera, light = self.camera, scene.lighting
        view = window or camera.whole
        if isinstance(light, OpenAir):
            exposed = self.exposure(light)
            image = self._outside(scene, light, shot, rng, view, exposed.time_s)
            factor = np.full(image.shape[0], exposed.scale)
            read_grey, shot_grey = exposed.read_grey, exposed.shot_grey
        else:
            image = self._inside(scene, light, shot, view)
            rows_s = np.arange(view.top, view.bottom, dtype=np.float64) * camera.row_s
            flicker = np.cos(2.0 * math.pi * light.flicker_hz * rows_s + light.phase_rad)
            factor = light.level * (1.0 + light.flicker_share * flicker)
            read_grey, shot_grey = camera.noise_grey, 0.0
        out = np.empty(image.shape, dtype=np.uint8)
        expose_image(image, factor, self._noise, int(rng.integers(NOISE_BANK)), read_grey, shot_grey, out)
        return out

    def exposure(self, air: OpenAir) -> CameraExposure:
        """What the exposure control comes to in this light: metered once, on the picture's lower half."""
        if air not in self._exposures:
            camera, rng = self.camera, generator(0, "camera", "metering")
            half = ImageWindow(0, camera.height_px // 2, camera.width_px, camera.height_px)
            image = self._outside(Scene(lighting=air), air, Shot(0.0), rng, half, 0.0)
            metered = float(image[::METER_EVERY_PX, ::METER_EVERY_PX].mean())
            self._exposures[air] = exposure(air, metered)
        return self._exposures[air]

    def exposure_s(self, light: Lighting | OpenAir) -> float:
        """How long a row is exposed, s."""
        return self.exposure(light).time_s if isinstance(light, OpenAir) else self.camera.exposure_s

    def _inside(self, scene: Scene, light: Lighting, shot: Shot, view: ImageWindow) -> Singles:
        """The tunnel and what stands in it, in full light."""
        camera = self.camera
        axis_row, axis_column = camera.axis_of(shot.pitch_rad)
        image = np.empty((view.bottom - view.top, view.right - view.left, 3), dtype=np.float32)
        lens_m = self._lens_m(shot, view)
        draw_tunnel(
            image,
            view.left,
            view.top,
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
            TUNNEL_AIR,
        )
        seen = _BoardSight(light.extinction_per_m, TUNNEL_AIR, camera.edge_px, camera.exposure_s)
        self._draw_boards(image, scene.board_rows(), shot, view, lens_m, (axis_row, axis_column), seen)
        return image

    def _outside(
        self,
        scene: Scene,
        air: OpenAir,
        shot: Shot,
        rng: np.random.Generator,
        view: ImageWindow,
        exposure_s: float,
    ) -> Singles:
        """The open line, its weather and what stands beside it, in white faces."""
        camera = self.camera
        axis_row, axis_column = camera.axis_of(shot.pitch_rad)
        if air.film_rad > 0.0:
            axis_row += camera.focal_px * float(rng.normal(0.0, air.film_rad))
            axis_column += camera.focal_px * float(rng.normal(0.0, air.film_rad))
        image = np.empty((view.bottom - view.top, view.right - view.left, 3), dtype=np.float32)
        lens_m = self._lens_m(shot, view)
        draw_open(
            image,
            view.left,
            view.top,
            lens_m,
            camera.focal_px,
            axis_row,
            axis_column,
            camera.lens_height_m,
            self._half_width_m,
            self._floor,
            self._grass,
            self._cell_m,
            air.ground_share,
            air.sky_low,
            air.sky_high,
            self._skyline,
            air.extinction_per_m,
        )
        boards = scene.board_rows()
        boards[:, BLUE : RED + 1] *= float(np.exp(rng.normal(0.0, air.face_spread)))
        seen = _BoardSight(air.extinction_per_m, air.sky_low, camera.edge_px + air.film_px, exposure_s)
        self._draw_boards(image, boards, shot, view, lens_m, (axis_row, axis_column), seen)
        if air.sun is not None:
            sun = air.sun
            add_glare(
                image,
                view.left,
                view.top,
                camera.focal_px,
                axis_row,
                axis_column,
                sun.elevation_rad,
                sun.azimuth_rad,
                air.glare_deg2,
            )
        if air.drops_per_mpx > 0.0:
            self._wet(image, air, rng)
        return image

    def _wet(self, image: Singles, air: OpenAir, rng: np.random.Generator) -> None:
        """Rain: drops that fall, drops on the pane, and what the wet pane scatters."""
        size, margin = image.shape[:2], 20.0
        area_mpx = (size[0] + 2.0 * margin) * (size[1] + 2.0 * margin) * 1e-6

        def scattered(per_mpx: float) -> tuple[int, Floats, Floats]:
            count = int(rng.poisson(per_mpx * area_mpx, 1)[0])
            rows = rng.uniform(-margin, size[0] + margin, count)
            return count, rows, rng.uniform(-margin, size[1] + margin, count)

        count, row, column = scattered(air.streaks_per_mpx)
        lean: Floats = rng.normal(0.0, 0.1, count)
        long_px: Floats = rng.uniform(15.0, 60.0, count)
        cover: Floats = rng.uniform(0.05, 0.25, count)
        add_streaks(image, np.array([row, column, long_px, lean, cover]).T, air.sky_low)
        count, row, column = scattered(air.drops_per_mpx)
        radius_px: Floats = 2.0 * rng.standard_gamma(4.0, count)
        add_drops(image, np.array([row, column, radius_px]).T, air.sky_low)
        image *= np.float32(1.0 - air.veil_share)
        image += np.float32(air.veil_share * air.sky_low)

    def _lens_m(self, shot: Shot, view: ImageWindow) -> Floats:
        """The lens's place along the track when each row of the window begins to be exposed."""
        rows_s = np.arange(view.top, view.bottom, dtype=np.float64) * self.camera.row_s
        lens_m: Floats = shot.front_m - self.camera.setback_m + shot.speed_mps * rows_s
        return lens_m

    def _draw_boards(
        self,
        image: Singles,
        boards: Floats,
        shot: Shot,
        view: ImageWindow,
        lens_m: Floats,
        axis_px: tuple[float, float],
        seen: _BoardSight,
    ) -> None:
        """Everything that stands beside the track, the farthest first."""
        camera = self.camera
        for board in boards:
            draw_board(
                image,
                view.left,
                view.top,
                lens_m,
                shot.speed_mps * seen.exposure_s,
                camera.focal_px,
                *axis_px,
                camera.lens_height_m,
                board,
                seen.edge_px,
                seen.extinction_per_m,
                seen.air,
            )
