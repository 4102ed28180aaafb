"""The cameras of line runs: frames while a sign is in range, by the figures of the light of the hour."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from onboard.board import SENSED
from simulation.sensors.line_sightings import PLACES_M, line_sightings
from simulation.sensors.scene import SCENE
from simulation.sensors.sign_camera import PAST_MARK_M, SEEN_FROM_M, SignCameraRow, fit, sign_camera
from simulation.sensors.table import SENSORS_ROW
from simulation.settings import Light, LightHours, Vision
from simulation.setup import Setup

LIT = line_sightings()[Light.LIT_TUNNEL]


def camera_of(setup: Setup, vision: Vision | None = None, stock_id: str = "K1") -> SignCameraRow:
    row: SignCameraRow = np.zeros(1, SENSORS_ROW["sign_camera"]).view(np.recarray)[0]
    fit(row, replace(setup, vision=vision or Vision()), stock_id)
    return row


def shown(
    camera: SignCameraRow, ahead_m: float, step: int, speed_mps: float = 0.0, now_s: float = 0.0
) -> float | None:
    """What one step shows: None no frame, +inf a frame without a sign."""
    scene: Any = np.zeros(1, SCENE).view(np.recarray)[0]
    sensed: Any = np.zeros(1, SENSED).view(np.recarray)[0]
    scene.sign_ahead_m, scene.step, scene.speed_mps = ahead_m, step, speed_mps
    scene.now_s = now_s
    sign_camera(camera, None, scene, sensed)
    return float(sensed.readings.sign.distance_m) if sensed.readings.sign.taken else None


def test_a_frame_each_so_many_steps_while_the_sign_is_in_range(rtri_setup: Setup) -> None:
    camera = camera_of(rtri_setup, Vision(rate_hz=5.0))
    assert [step for step in range(10) if shown(camera, 30.0, step) is not None] == [0, 2, 4, 6, 8]
    for ahead_m in (SEEN_FROM_M + 0.1, PAST_MARK_M - 0.1, -5.0, math.inf):
        assert shown(camera, ahead_m, 0) is None
    assert shown(camera, PLACES_M[0] - 0.5, 0) == math.inf  # taken, but the sign is out of the picture


def test_a_train_without_signs_on_its_way_takes_no_frame(rtri_setup: Setup) -> None:
    camera: SignCameraRow = np.zeros(1, SENSORS_ROW["sign_camera"]).view(np.recarray)[0]
    fit(camera, rtri_setup, "K1")
    assert all(shown(camera, 30.0, step) is None for step in range(20))


@pytest.mark.parametrize("light", [Light.LIT_TUNNEL, Light.RAIN])
@pytest.mark.parametrize(("speed_mps", "column"), [(0.0, "sigma_m"), (8.0, "moving_sigma_m")])
def test_the_errors_are_those_of_the_figures(
    rtri_setup: Setup, light: Light, speed_mps: float, column: str
) -> None:
    """At 30 m, 4000 frames: mean and spread within four standard errors; moving, the way run shortens it."""
    camera, figures, at = (
        camera_of(rtri_setup, Vision(light=light)),
        line_sightings()[light],
        PLACES_M.index(30.0),
    )
    sigma_m = getattr(figures, column)[at]
    frames = np.array([shown(camera, 30.0, 2 * frame, speed_mps) for frame in range(4000)])
    seen = frames[np.isfinite(frames)] - 30.0
    assert abs(seen.size / 4000 - figures.seen_share[at]) < 4.0 * math.sqrt(0.25 / 4000)
    mean_m = figures.bias_m[at] - speed_mps * figures.exposed_after_s[at]
    assert abs(seen.mean() - mean_m) < 4.0 * sigma_m / math.sqrt(seen.size)
    assert abs(seen.std() - sigma_m) < 4.0 * sigma_m / math.sqrt(2 * seen.size)


def test_each_train_and_each_day_has_noise_of_its_own(rtri_setup: Setup) -> None:
    course = {
        (stock_id, day): tuple(
            shown(camera_of(replace(rtri_setup, day=day), stock_id=stock_id), 48.0, step)
            for step in range(0, 20, 2)
        )
        for stock_id in ("K1", "K2")
        for day in (1, 2)
    }
    assert len(set(course.values())) == 4


def test_at_the_edge_some_frames_show_no_sign(rtri_setup: Setup) -> None:
    """As many as the figures say: of 4000 within four standard errors."""
    camera, share = camera_of(rtri_setup), float(LIT.seen_share[-1])
    assert 0.5 < share < 1.0
    blind = sum(shown(camera, SEEN_FROM_M, 2 * frame) == math.inf for frame in range(4000))
    assert abs(blind - 4000 * (1.0 - share)) < 4.0 * math.sqrt(4000 * share * (1.0 - share))


def test_a_curve_hides_the_sign_and_frames_go_on(rtri_setup: Setup) -> None:
    camera = camera_of(rtri_setup, Vision(hidden_beyond_m=20.0))
    assert [shown(camera, 20.5, step) for step in range(0, 20, 2)] == [math.inf] * 10
    assert all(abs((shown(camera, 19.5, step) or 0.0) - 19.5) < 1.0 for step in range(0, 20, 2))


def test_the_light_is_that_of_the_hour(rtri_setup: Setup) -> None:
    """By day a sign 69 m off is seen nearly always, by rain at dusk never; the first hours that hold it count."""
    hours = (
        LightHours.model_validate({"from": "17:00", "to": "19:00", "light": "rain_at_dusk"}),
        LightHours.model_validate({"from": "16:00", "to": "24:00", "light": "daylight"}),
    )
    camera = camera_of(rtri_setup, Vision(light=Light.RAIN_AT_DUSK, hours=hours))

    def seen(hour: float) -> int:
        frames = [shown(camera, 69.0, 2 * frame, now_s=3600.0 * hour) for frame in range(50)]
        return sum(frame is not None and math.isfinite(frame) for frame in frames)

    assert [seen(hour) for hour in (15.9, 17.0, 18.9)] == [0, 0, 0]
    assert min(seen(hour) for hour in (16.5, 19.0, 23.9)) > 45


def test_some_frames_show_something_else(rtri_setup: Setup) -> None:
    """A share of all frames, anywhere in range, where the sign is hidden too: of 4000 within four standard errors."""
    camera = camera_of(rtri_setup, Vision(false_share=0.1, hidden_beyond_m=0.0))
    frames = np.array([shown(camera, 60.0, 2 * frame) for frame in range(4000)])
    false = frames[np.isfinite(frames)]
    assert abs(false.size - 400) < 4.0 * math.sqrt(4000 * 0.1 * 0.9)
    assert abs(false.mean() - (PLACES_M[0] + SEEN_FROM_M) / 2.0) < 4.0 * false.std() / math.sqrt(false.size)
