"""The cameras of line runs: the shipped error figures against the renderer, and frames while a sign is in range."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from onboard.board import SENSED
from radio.chance import generator
from simulation.sensors.camera import LINE_CAMERA, LINE_SIGN, Renderer, record_table, sighted_distances
from simulation.sensors.scene import SCENE
from simulation.sensors.sign_camera import (
    LINE_SIGHTINGS,
    PAST_MARK_M,
    SEEN_FROM_M,
    SignCameraRow,
    fit,
    sign_camera,
)
from simulation.sensors.table import SENSORS_ROW
from simulation.settings import Vision
from simulation.setup import Setup
from vehicle.compiled import INTERPRETED

PLACES_M = tuple(row[0] for row in LINE_SIGHTINGS)


def camera_of(setup: Setup, rate_hz: float = 5.0, stock_id: str = "K1") -> SignCameraRow:
    row: SignCameraRow = np.zeros(1, SENSORS_ROW["sign_camera"]).view(np.recarray)[0]
    fit(row, replace(setup, vision=Vision(rate_hz=rate_hz)), stock_id)
    return row


def shown(camera: SignCameraRow, ahead_m: float, step: int, speed_mps: float = 0.0) -> float | None:
    """What one step shows: None no frame, +inf a frame without a sign."""
    scene: Any = np.zeros(1, SCENE).view(np.recarray)[0]
    sensed: Any = np.zeros(1, SENSED).view(np.recarray)[0]
    scene.sign_ahead_m, scene.step, scene.speed_mps = ahead_m, step, speed_mps
    sign_camera(camera, None, scene, sensed)
    return float(sensed.readings.sign.distance_m) if sensed.readings.sign.taken else None


@pytest.mark.skipif(INTERPRETED, reason="it renders: interpreted an image takes a minute")
@pytest.mark.parametrize("distance_m", [15.0, 30.0])
def test_the_figures_are_those_of_the_renderer(distance_m: float) -> None:
    """Spread of 60 rendered images within a third: that of a sample's own sigma is 9 %."""
    renderer = Renderer(LINE_CAMERA, 7)
    table = record_table(renderer, LINE_SIGN, [float(d) for d in range(8, 37, 2)], 7, repeats=2)
    rng = generator(7, "test", f"{distance_m:g}")
    rendered = sighted_distances(renderer, LINE_SIGN, table, distance_m, 1e-6, 60, rng) - distance_m
    sigma_m = float(np.interp(distance_m, PLACES_M, [row[4] for row in LINE_SIGHTINGS]))
    assert rendered.size == 60
    assert rendered.std(ddof=1) == pytest.approx(sigma_m, rel=0.35)
    assert abs(rendered.mean()) < 2.0 * sigma_m


def test_a_frame_each_so_many_steps_while_the_sign_is_in_range(rtri_setup: Setup) -> None:
    camera = camera_of(rtri_setup, rate_hz=5.0)
    assert [step for step in range(10) if shown(camera, 30.0, step) is not None] == [0, 2, 4, 6, 8]
    for ahead_m in (SEEN_FROM_M + 0.1, PAST_MARK_M - 0.1, -5.0, math.inf):
        assert shown(camera, ahead_m, 0) is None
    assert shown(camera, PLACES_M[0] - 0.5, 0) == math.inf  # taken, but the sign is out of the picture


def test_a_train_without_signs_on_its_way_takes_no_frame(rtri_setup: Setup) -> None:
    camera: SignCameraRow = np.zeros(1, SENSORS_ROW["sign_camera"]).view(np.recarray)[0]
    fit(camera, rtri_setup, "K1")
    assert all(shown(camera, 30.0, step) is None for step in range(20))


@pytest.mark.parametrize(("speed_mps", "column"), [(0.0, 3), (8.0, 4)])
def test_the_errors_are_those_of_the_figures(rtri_setup: Setup, speed_mps: float, column: int) -> None:
    """At 30 m, 4000 frames: mean and spread within four standard errors; moving, the way run shortens it."""
    camera, places = camera_of(rtri_setup), {row[0]: row for row in LINE_SIGHTINGS}
    _, _, bias_m, _, _, after_s = places[30.0]
    sigma_m = places[30.0][column]
    seen = np.array([shown(camera, 30.0, 2 * frame, speed_mps) for frame in range(4000)]) - 30.0
    assert abs(seen.mean() - (bias_m - speed_mps * after_s)) < 4.0 * sigma_m / math.sqrt(4000)
    assert abs(seen.std() - sigma_m) < 4.0 * sigma_m / math.sqrt(8000)


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
    """0.983 of them do at 87 m: of 4000 within four standard errors."""
    camera = camera_of(rtri_setup)
    blind = sum(shown(camera, SEEN_FROM_M, 2 * frame) == math.inf for frame in range(4000))
    assert abs(blind - 4000 * 0.017) < 4.0 * math.sqrt(4000 * 0.017 * 0.983)
