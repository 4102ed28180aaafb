"""Light and weather of the open air: the exposure's arithmetic, and what pictures show of it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from onboard.localisation.vision import ImageWindow
from radio.chance import generator
from simulation.sensors.camera import LINE_CAMERA, LINE_SIGN, Board, Renderer, Scene, Shot
from simulation.sensors.open_air import CHIP, METERED_GREY, OPEN_AIR, OpenAir, Sun, exposure
from simulation.settings import Light
from vehicle.compiled import INTERPRETED

renders = pytest.mark.skipif(INTERPRETED, reason="the renderer is no law; interpreted it takes hours")
NEAR_M = 15.0
LOWER = ImageWindow(0, 480, 1280, 960)
FLAT = OpenAir(face_lux=1e4, ground_share=1.0, sky_low=1.0, sky_high=1.0, face_spread=0.0)


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer(LINE_CAMERA, 7)


def picture(
    renderer: Renderer, air: OpenAir, window: ImageWindow = LOWER, scene: Scene | None = None
) -> NDArray[np.float64]:
    shown = replace(scene or Scene(), lighting=air)
    return renderer.render(shown, Shot(0.0), generator(1, "open air"), window).astype(np.float64)


@given(face_lux=st.floats(1e-3, 2e5), metered=st.floats(0.05, 20.0))
def test_exposure_is_time_first_then_gain_then_darkness(face_lux: float, metered: float) -> None:
    """The electrons that a white face frees are those of its light, time and the chip; never too bright."""
    found = exposure(replace(FLAT, face_lux=face_lux), metered)
    assert CHIP.exposure_min_s <= found.time_s <= CHIP.exposure_max_s
    assert 1.0 <= found.gain <= CHIP.gain_max
    electrons = CHIP.white_e_per_lux_s * face_lux * found.time_s
    assert found.scale == pytest.approx(electrons * found.gain / CHIP.full_well_e)
    wanted = METERED_GREY / metered
    if found.time_s > CHIP.exposure_min_s:
        assert found.scale <= wanted * (1.0 + 1e-9)
    if found.scale < wanted * (1.0 - 1e-9):
        assert (found.time_s, found.gain) == (CHIP.exposure_max_s, CHIP.gain_max)
    if found.gain > 1.0 + 1e-9:
        assert found.time_s == CHIP.exposure_max_s
    # a Poisson number's variance is its mean: at full scale 255 grey levels of `full well / gain` electrons
    at_full = found.read_grey**2 + found.shot_grey * 255.0
    held_e = CHIP.full_well_e / found.gain
    assert at_full == pytest.approx((255.0 / held_e) ** 2 * (CHIP.read_e**2 + held_e))


@renders
def test_less_light_is_more_noise(renderer: Renderer) -> None:
    """Against the variance of the same patch without any: that of electrons counted, and of reading them."""
    patch = ImageWindow(600, 900, 680, 950)
    for light in (Light.DAYLIGHT, Light.DUSK):
        air = replace(OPEN_AIR[light], face_spread=0.0)
        pair = [
            renderer.render(Scene(lighting=air), Shot(0.0), generator(k, "n"), patch).astype(float)
            for k in (1, 2)
        ]
        found = float(np.var(pair[0] - pair[1])) / 2.0
        exposed = renderer.exposure(air)
        expected = exposed.read_grey**2 + exposed.shot_grey * float(pair[0].mean()) + 1.0 / 12.0
        assert found == pytest.approx(expected, rel=0.1)
    day, dusk = (renderer.exposure(OPEN_AIR[light]) for light in (Light.DAYLIGHT, Light.DUSK))
    assert dusk.shot_grey > 10.0 * day.shot_grey


@renders
def test_a_white_face_is_as_bright_as_the_exposure_says(renderer: Renderer) -> None:
    white = Scene(boards=(Board(NEAR_M, 0.0, 1.5, 2.0, 1.0, (0.5, 0.5, 0.5)),))
    row = int(480 + LINE_CAMERA.focal_px * (2.8 - 1.5) / (NEAR_M + LINE_CAMERA.setback_m))
    patch = ImageWindow(630, row - 10, 650, row + 10)
    found = picture(renderer, FLAT, patch, white).mean()
    assert found == pytest.approx(255.0 * 0.5 * renderer.exposure(FLAT).scale, rel=0.02)


@renders
def test_mist_takes_the_contrast_by_koschmieders_law(renderer: Renderer) -> None:
    """A black board before a horizon of 1: what is lost at 100 m with a visibility of 100 m is 95 %."""
    misty = replace(FLAT, visibility_m=100.0)
    black = Scene(boards=(Board(100.0, 0.0, 2.8, 8.0, 4.0, (0.0, 0.0, 0.0)),))
    shown = picture(renderer, misty, ImageWindow(630, 470, 650, 490), black).mean() / 255.0
    clear = math.exp(-math.log(20.0) * (100.0 + LINE_CAMERA.setback_m) / 100.0)
    assert shown == pytest.approx((1.0 - clear) * renderer.exposure(misty).scale, rel=0.03)


@renders
def test_glare_falls_with_the_square_of_the_angle(renderer: Renderer) -> None:
    """Veils at 5 and 10 degrees below the sun, each less the same picture without it: one to four."""
    low = replace(FLAT, sun=Sun(0.0, 0.0, 30_000.0))
    scale = renderer.exposure(low).scale
    black = Scene(boards=(Board(5.0, 0.0, 2.0, 20.0, 10.0, (0.0, 0.0, 0.0)),))

    def veil(degrees: float) -> float:
        row = int(480 + LINE_CAMERA.focal_px * math.tan(math.radians(degrees)))
        return (
            float(picture(renderer, low, ImageWindow(638, row - 2, 642, row + 2), black).mean())
            / 255.0
            / scale
        )

    assert veil(5.0) / veil(10.0) == pytest.approx(4.0, rel=0.05)
    # Holladay and Stiles with half the eye's constant: 5 E / angle^2 cd/m^2, a white face being lux / pi
    assert veil(10.0) == pytest.approx(5.0 * 30_000.0 / 100.0 / (1e4 / math.pi), rel=0.05)


@renders
def test_the_sun_in_the_picture_is_white(renderer: Renderer) -> None:
    sun = OPEN_AIR[Light.BACKLIGHT].sun
    assert sun is not None
    row = int(480 - LINE_CAMERA.focal_px * math.tan(sun.elevation_rad))
    column = int(640 + LINE_CAMERA.focal_px * math.tan(sun.azimuth_rad))
    disc = picture(renderer, OPEN_AIR[Light.BACKLIGHT], ImageWindow(column - 3, row - 3, column + 3, row + 3))
    assert disc.min() == 255.0


@renders
def test_rain_lowers_contrast_and_differs_from_picture_to_picture(renderer: Renderer) -> None:
    rain, day = OPEN_AIR[Light.RAIN], OPEN_AIR[Light.DAYLIGHT]

    def contrast(air: OpenAir) -> float:
        shown = picture(renderer, air)
        return float(np.percentile(shown, 90) - np.percentile(shown, 10)) / float(shown.mean())

    assert contrast(rain) < 0.9 * contrast(day)
    shots = [
        renderer.render(Scene(lighting=rain), Shot(0.0), generator(k, "rain"), LOWER).astype(float)
        for k in (1, 2)
    ]
    changed = float(np.mean(np.abs(shots[0] - shots[1]).max(axis=2) > 25.0))
    assert 0.02 < changed < 0.2  # drops on some 5 % of the pane in each


@renders
def test_rain_at_dusk_is_too_dark_for_any_gain(renderer: Renderer) -> None:
    exposed = renderer.exposure(OPEN_AIR[Light.RAIN_AT_DUSK])
    assert (exposed.time_s, exposed.gain) == (CHIP.exposure_max_s, CHIP.gain_max)
    assert max(LINE_SIGN.bgr) * exposed.scale < 0.27  # the paper's least value of the sign's colour (3.2.2)
