"""The committed error model against images rendered anew, place by place, within what samples differ by."""

import math

import numpy as np
import pytest

from documents.sightings import IMAGES, fitted_model
from simulation.sensors import line_sightings as module
from simulation.sensors.camera import LINE_CAMERA, Renderer
from simulation.sensors.line_sightings import LIGHTS, PLACES_M, line_sightings
from simulation.settings import Light
from tests.nightly import others_nightly
from vehicle.compiled import INTERPRETED

COUNT = 40
FRESH_PLACES_M = (15.0, 48.0, 87.0)
SIGMAS = 4.0


def objections(light: Light, renderer: Renderer) -> list[str]:
    """Which committed figures fresh images contradict by more than four standard errors of both samples."""
    fresh = fitted_model(renderer, light, 8, COUNT, FRESH_PLACES_M)
    kept = line_sightings()[light]
    found: list[str] = []
    for index, place_m in enumerate(FRESH_PLACES_M):
        at = PLACES_M.index(place_m)
        share = (kept.seen_share[at] * IMAGES + fresh.probability[index] * COUNT) / (IMAGES + COUNT)
        both = 1.0 / (2 * IMAGES) + 1.0 / (2 * COUNT)
        if abs(kept.seen_share[at] - fresh.probability[index]) > SIGMAS * math.sqrt(
            max(share * (1.0 - share), 0.01) * both
        ):
            found.append(f"seen at {place_m:g} m")
        if min(kept.seen_share[at], fresh.probability[index]) < 0.5:
            continue
        sigma_m = max(float(kept.moving_sigma_m[at]), float(kept.sigma_m[at]), 0.005)
        if abs(kept.bias_m[at] - fresh.bias_m[index]) > SIGMAS * sigma_m * math.sqrt(both):
            found.append(f"bias at {place_m:g} m")
        # the logarithm of a sample's sigma scatters by 1 / sqrt(2 n); drops give longer tails than normal ones
        apart = SIGMAS * 1.5 * math.sqrt(1.0 / (2 * IMAGES) + 1.0 / (2 * COUNT))
        if abs(math.log(kept.moving_sigma_m[at] / fresh.moving_sigma_m[index])) > apart:
            found.append(f"sigma at {place_m:g} m")
        if abs(kept.exposed_after_s[at] - fresh.exposed_after_s[index]) > 1e-4:
            found.append(f"exposure at {place_m:g} m")
    return found


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer(LINE_CAMERA, 7)


@pytest.mark.skipif(INTERPRETED, reason="it renders: interpreted an image takes a minute")
@pytest.mark.parametrize("light", others_nightly(LIGHTS, [Light.RAIN]))
def test_the_figures_are_what_the_renderer_gives(light: Light, renderer: Renderer) -> None:
    assert objections(light, renderer) == []


@pytest.mark.skipif(INTERPRETED, reason="it renders")
def test_figures_of_another_light_are_noticed(monkeypatch: pytest.MonkeyPatch, renderer: Renderer) -> None:
    kept = dict(line_sightings())
    kept[Light.BACKLIGHT] = kept[Light.DAYLIGHT]
    monkeypatch.setattr(f"{__name__}.line_sightings", lambda: kept)
    assert objections(Light.BACKLIGHT, renderer)


def test_every_light_has_every_figure() -> None:
    assert set(line_sightings()) == set(Light)
    for figures in line_sightings().values():
        for column in module.COLUMNS:
            values = getattr(figures, column)
            assert values.shape == (len(PLACES_M),)
            assert np.isfinite(values).all()
        assert (figures.seen_share + figures.false_share <= 1.0).all()


def test_what_light_and_weather_cost() -> None:
    """A low sun and rain cost sight, rain costs accuracy too, and where there is no light nothing is seen."""
    sights = line_sightings()
    reach = {light: sights[light].reach_m for light in Light}
    assert reach[Light.LIT_TUNNEL] >= reach[Light.DAYLIGHT] > reach[Light.BACKLIGHT] > 30.0
    assert reach[Light.RAIN_AT_DUSK] == 0.0
    for at in range(len(PLACES_M)):
        assert sights[Light.RAIN].seen_share[at] <= sights[Light.DAYLIGHT].seen_share[at] + 0.1
        assert sights[Light.RAIN].sigma_m[at] > sights[Light.DAYLIGHT].sigma_m[at]
