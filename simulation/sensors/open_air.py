"""Light and weather of an open-air line, and the exposure that a camera takes for them.

Oda studies lit underground lines and leaves the open air to be looked into (sections 3.1 and 5.2). Light is told by the
illuminance of an upright face towards the train (lux). In a picture 1.0 is what a white face there gives; sky, ground
and glare are told in the same measure. Figures are of the textbooks' order of magnitude, and assumed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from simulation.settings import Light


@dataclass(frozen=True, slots=True)
class Sun:
    """A low sun before the train: where it stands (rad, from the track ahead) and how strong it is (lux, face on)."""

    elevation_rad: float
    azimuth_rad: float
    lux: float


@dataclass(frozen=True, slots=True)
class OpenAir:
    """One kind of light and weather. `face_lux` falls on the sign's face, `ground_share` times that on the ground."""

    face_lux: float
    ground_share: float
    sky_low: float  # luminance of the sky over the horizon, of a white face there
    sky_high: float  # and half a radian above
    visibility_m: float = 2.0e4  # where 5 % of the contrast is left (Koschmieder)
    face_spread: float = 0.15  # from picture to picture: clouds, the sign's age and dirt
    drops_per_mpx: float = 0.0  # on the pane, between two strokes of the wiper
    streaks_per_mpx: float = 0.0  # drops that fall before it, as lines
    film_rad: float = 0.0  # by which water on the pane shifts the picture, standard deviation
    film_px: float = 0.0  # by which it widens an edge
    veil_share: float = 0.0  # of the sky's light that a wet pane scatters over everything
    sun: Sun | None = None

    @property
    def extinction_per_m(self) -> float:
        """Share of the contrast lost per metre of air."""
        return math.log(20.0) / self.visibility_m

    @property
    def glare_deg2(self) -> float:
        """Veiling luminance of the sun times the square of the angle from it (deg^2), white faces."""
        if self.sun is None:
            return 0.0
        return GLARE_CD_PER_LUX_DEG2 * self.sun.lux * math.pi / self.face_lux


# Veiling luminance of a lens and a clean pane: 10 E / angle^2 is the eye's (Holladay, Stiles), half of it assumed.
GLARE_CD_PER_LUX_DEG2: Final = 5.0

_RAIN: Final = OpenAir(
    face_lux=1500.0,  # assumed: a dark overcast sky
    ground_share=1.6,
    sky_low=0.9,
    sky_high=1.4,
    visibility_m=2000.0,  # assumed: some 20 mm/h
    drops_per_mpx=250.0,  # assumed: 5 % of the pane
    streaks_per_mpx=60.0,
    film_rad=3e-4,
    film_px=1.0,
    veil_share=0.12,
)
OPEN_AIR: Final = {
    # a bright hazy or overcast day: a uniform sky gives an upright face half of what it gives the ground
    Light.DAYLIGHT: OpenAir(face_lux=10_000.0, ground_share=1.6, sky_low=0.9, sky_high=1.5),
    # just after sunset (400 lux on the level at sunset, 3 at the end of civil twilight)
    Light.DUSK: OpenAir(face_lux=100.0, ground_share=1.3, sky_low=1.6, sky_high=0.9),
    Light.RAIN: _RAIN,
    Light.RAIN_AT_DUSK: replace(_RAIN, face_lux=30.0, ground_share=1.3, sky_low=1.2, sky_high=0.8),
    # a winter's afternoon: the sign's face lies in the shade, the sun hangs over the track behind it
    Light.BACKLIGHT: OpenAir(
        face_lux=4000.0,
        ground_share=2.0,
        sky_low=2.5,
        sky_high=1.5,
        sun=Sun(math.radians(7.0), math.radians(3.0), 35_000.0),
    ),
}


@dataclass(frozen=True, slots=True)
class Chip:
    """An image sensor: what light frees in it, and what it can hold. `white_e_per_lux_s` is of a white face."""

    # A 3.75 um pixel behind f/1.8: 1.4e-11 m^2 * 0.9 / (4 * 1.8^2) * 4.1e15 photons/(lm s) * 0.5, a third a colour
    white_e_per_lux_s: float = 670.0
    full_well_e: float = 10_000.0  # assumed: ordinary, as the next three
    read_e: float = 5.0
    gain_max: float = 32.0
    exposure_min_s: float = 2e-5
    exposure_max_s: float = 4e-3  # assumed: 4 cm run at 10 m/s


CHIP: Final = Chip()
METERED_GREY: Final = 0.42  # what the exposure control makes of the picture's lower half, of full scale


@dataclass(frozen=True, slots=True)
class CameraExposure:
    """What the control came to: time (s), gain, picture value of a white face, and the noise of a pixel.

    Its variance (grey levels of 255, squared) is `read_grey`^2 and `shot_grey` times the pixel's grey.
    """

    time_s: float
    gain: float
    scale: float
    read_grey: float
    shot_grey: float


def exposure(air: OpenAir, metered: float, chip: Chip = CHIP) -> CameraExposure:
    """Exposure for a picture whose lower half has the mean `metered` (white faces): time first, then gain.

    Where both end the picture stays dark.
    """
    per_second = chip.white_e_per_lux_s * air.face_lux / chip.full_well_e  # full scales of a white face
    wanted = METERED_GREY / metered
    time_s = min(max(wanted / per_second, chip.exposure_min_s), chip.exposure_max_s)
    gain = min(max(wanted / (per_second * time_s), 1.0), chip.gain_max)
    grey_per_e = 255.0 * gain / chip.full_well_e
    return CameraExposure(time_s, gain, per_second * time_s * gain, chip.read_e * grey_per_e, grey_per_e)
