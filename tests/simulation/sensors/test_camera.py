"""The rendered camera against the paper's measurements and plain optics, and the error model against the renderer."""

import math
from dataclasses import replace

import numpy as np
import pytest

from onboard.localisation.sighting import SIGN_BEYOND_MARK_M
from onboard.localisation.vision import Cluster, ImageWindow, SightTable, frame_rate_error_m, largest_cluster
from radio.chance import generator
from simulation.sensors.camera import (
    LINE_CAMERA,
    LINE_SIGN,
    PAPER_CAMERA,
    PAPER_SIGN,
    PAPER_TABLE_M,
    Board,
    Lighting,
    Renderer,
    Scene,
    Shot,
)
from simulation.sensors.sighting_model import (
    SightingModel,
    fit_sighting_model,
    record_table,
    sighted_distances,
)
from tests.nightly import others_nightly
from vehicle.compiled import INTERPRETED

# Rendering goes pixel by pixel: interpreted, an image takes a minute.
pytestmark = pytest.mark.skipif(INTERPRETED, reason="the renderer is no law; interpreted it takes hours")

QUARTER = ImageWindow(640, 480, 1280, 960)  # below and right of the axis, where the sign always is
TABLE_2_PX = {0.25: 346.9, 0.30: 315.1, 0.35: 288.5, 0.40: 266.1, 0.45: 247.5, 0.50: 230.0}


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer(PAPER_CAMERA, 7)


@pytest.fixture(scope="module")
def table(renderer: Renderer) -> SightTable:
    return record_table(renderer, PAPER_SIGN, PAPER_TABLE_M, 7, window=QUARTER)


@pytest.fixture(scope="module")
def model(renderer: Renderer, table: SightTable) -> SightingModel:
    return fit_sighting_model(renderer, PAPER_SIGN, table, 7, count=100)


def seen(renderer: Renderer, scene: Scene, shot: Shot | None = None) -> Cluster | None:
    rng = generator(7, "test camera")
    image = renderer.render(scene, shot or Shot(0.0), rng, QUARTER)
    return largest_cluster(image, QUARTER.left, QUARTER.top)


def test_the_papers_lens() -> None:
    assert PAPER_CAMERA.focal_px == pytest.approx(3.4e-3 / 3.75e-6)
    # 3.2.2: 35 deg
    assert math.degrees(math.atan(640 / PAPER_CAMERA.focal_px)) == pytest.approx(35.0, abs=0.5)


@pytest.mark.parametrize("distance_m", TABLE_2_PX)
def test_pinhole_and_image_meet_table_2(renderer: Renderer, distance_m: float) -> None:
    assert PAPER_SIGN.offset_px(PAPER_CAMERA, distance_m) == pytest.approx(TABLE_2_PX[distance_m], abs=1.0)
    cluster = seen(renderer, Scene(PAPER_SIGN, distance_m))
    assert cluster is not None
    assert cluster.row_px - 480.0 == pytest.approx(TABLE_2_PX[distance_m], abs=1.0)


@pytest.mark.parametrize("distance_m", [0.3, 0.8, 1.7, 2.6, 3.3])
def test_the_sign_stands_where_optics_put_it(renderer: Renderer, distance_m: float) -> None:
    cluster = seen(renderer, Scene(PAPER_SIGN, distance_m))
    assert cluster is not None
    depth_m = distance_m + PAPER_CAMERA.setback_m
    assert cluster.row_px == pytest.approx(480.0 + PAPER_SIGN.offset_px(PAPER_CAMERA, distance_m), abs=0.5)
    assert cluster.column_px == pytest.approx(
        640.0 + PAPER_CAMERA.focal_px * PAPER_SIGN.right_m / depth_m, abs=0.5
    )
    diameter_px = PAPER_CAMERA.focal_px * PAPER_SIGN.diameter_m / depth_m
    assert cluster.area_px == pytest.approx(math.pi / 4.0 * diameter_px**2, rel=0.35)


def test_no_sign_no_cluster(renderer: Renderer) -> None:
    boards = tuple(Board(0.4 + 0.3 * k, 0.1 * k - 0.2, 0.2, 0.1, 0.1, (0.1, 0.1, 0.1 * k)) for k in range(8))
    assert seen(renderer, Scene()) is None
    assert seen(renderer, Scene(boards=boards)) is None


def test_something_in_front_hides_the_sign(renderer: Renderer) -> None:
    screen = Board(0.9, 0.2, 0.17, 0.3, 0.3, (0.3, 0.3, 0.3))
    assert seen(renderer, Scene(PAPER_SIGN, 1.0, (screen,))) is None
    assert seen(renderer, Scene(PAPER_SIGN, 0.8, (screen,))) is not None


def test_same_seed_same_image(renderer: Renderer) -> None:
    scene, shot = Scene(PAPER_SIGN, 0.7), Shot(0.1, 0.5)
    small = ImageWindow(700, 500, 1000, 800)
    one = renderer.render(scene, shot, generator(1, "x"), small)
    same = Renderer(PAPER_CAMERA, 7).render(scene, shot, generator(1, "x"), small)
    other = renderer.render(scene, shot, generator(2, "x"), small)
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_a_window_is_a_part_of_the_whole_image() -> None:
    still = Renderer(replace(PAPER_CAMERA, noise_grey=0.0), 7)
    scene, shot = Scene(PAPER_SIGN, 0.7, lighting=Lighting(phase_rad=1.0)), Shot(0.1, 1.0, 1e-3)
    window = ImageWindow(800, 600, 900, 720)
    part = still.render(scene, shot, generator(1, "x"), window)
    whole = still.render(scene, shot, generator(1, "x"))
    assert whole.shape == (960, 1280, 3)
    assert np.array_equal(part, whole[window.top : window.bottom, window.left : window.right])


def test_noise_is_as_strong_as_stated(renderer: Renderer) -> None:
    scene, shot, window = (
        Scene(lighting=Lighting(flicker_share=0.0)),
        Shot(0.0),
        ImageWindow(1150, 500, 1250, 560),
    )
    noisy = [renderer.render(scene, shot, generator(k, "noise"), window).astype(float) for k in range(2)]
    assert np.std(noisy[0] - noisy[1]) / math.sqrt(2.0) == pytest.approx(PAPER_CAMERA.noise_grey, rel=0.05)


def test_rolling_shutter_shortens_the_distance_within_equation_1(
    renderer: Renderer, table: SightTable
) -> None:
    speed_mps = 4.0 / 3.6  # 3.3.2
    found = sighted_distances(renderer, PAPER_SIGN, table, 0.5, speed_mps, 60, generator(3, "moving"))
    short_m = 0.5 - float(found.mean())
    assert 0.0 < short_m <= frame_rate_error_m(speed_mps, PAPER_CAMERA.frame_rate_hz)
    row_px = 480.0 + PAPER_SIGN.offset_px(PAPER_CAMERA, 0.5)
    assert short_m == pytest.approx(speed_mps * PAPER_CAMERA.exposed_after_s(row_px), abs=1e-3)


def test_a_global_shutter_has_no_such_error(table: SightTable) -> None:
    still = Renderer(replace(PAPER_CAMERA, readout_s=0.0, exposure_s=0.0, vibration_rad=0.0), 7)
    found = sighted_distances(still, PAPER_SIGN, table, 0.5, 4.0 / 3.6, 60, generator(3, "moving"))
    assert float(found.mean()) == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("distance_m", [0.30, 0.35, 0.40, 0.45])
def test_scatter_at_most_that_of_table_3(renderer: Renderer, table: SightTable, distance_m: float) -> None:
    found = sighted_distances(renderer, PAPER_SIGN, table, distance_m, 0.0, 100, generator(5, "scatter"))
    assert found.size == 100
    assert 3.0 * float(found.std(ddof=1)) <= 3.1e-3


def test_poor_light_and_poor_sight_end_the_detection(renderer: Renderer) -> None:
    assert seen(renderer, Scene(PAPER_SIGN, 0.5, lighting=Lighting(level=0.35))) is None  # V below 27 %
    mist = Lighting(visibility_m=4.0)
    assert seen(renderer, Scene(PAPER_SIGN, 0.5, lighting=mist)) is not None
    assert seen(renderer, Scene(PAPER_SIGN, 3.0, lighting=mist)) is None


def test_the_table_says_from_where_the_sign_is_lost(renderer: Renderer) -> None:
    with pytest.raises(ValueError, match="8 m"):
        record_table(renderer, PAPER_SIGN, (3.0, 8.0), 7, window=QUARTER)


@pytest.mark.parametrize("speed_mps", others_nightly([0.0, 0.5], [0.5]))
@pytest.mark.parametrize("distance_m", [0.5, 1.05, 1.9])
def test_the_sampled_model_has_the_renderers_moments(
    renderer: Renderer, table: SightTable, model: SightingModel, distance_m: float, speed_mps: float
) -> None:
    images = sighted_distances(
        renderer, PAPER_SIGN, table, distance_m, speed_mps, 200, generator(99, "fresh")
    )
    rng = generator(99, "draws")
    draws = [model.sample(distance_m, speed_mps, rng) for _ in range(1000)]
    sampled = np.array([draw for draw in draws if draw is not None])
    assert sampled.size / 1000 == pytest.approx(images.size / 200, abs=0.05)
    quarter_pixel_m = 0.25 * table.slope_m_per_px(distance_m)
    assert float(sampled.mean()) == pytest.approx(float(images.mean()), abs=quarter_pixel_m + 3e-4)
    assert 0.6 < float(sampled.std()) / float(images.std()) < 1.7


def test_the_model_sees_nothing_out_of_range(model: SightingModel) -> None:
    rng = generator(1, "range")
    assert model.sample(model.range_m + 0.2, 0.0, rng) is None
    assert model.sample(0.05, 0.0, rng) is None
    assert model.range_m > 2.8  # the paper's table reaches to 2.8 m before the mark


def test_a_model_that_detects_half_the_time() -> None:
    ends = np.array([0.5, 2.5])
    model = SightingModel(ends, np.array([1.0, 0.0]), *(np.zeros(2) for _ in range(5)))
    rng = generator(4, "half")
    found = sum(model.sample(1.5, 0.0, rng) is not None for _ in range(2000))
    assert found / 2000 == pytest.approx(0.5, abs=0.05)
    assert model.range_m == 0.5


def test_the_line_camera_sees_its_sign_at_the_mark_and_at_60_m() -> None:
    line = Renderer(LINE_CAMERA, 7)
    for distance_m in (SIGN_BEYOND_MARK_M, 60.0):
        cluster = seen(line, Scene(LINE_SIGN, distance_m))
        assert cluster is not None
        assert cluster.row_px == pytest.approx(480.0 + LINE_SIGN.offset_px(LINE_CAMERA, distance_m), abs=0.6)
